//! How many samples a stack's pixels have, as far as its files say.

use super::alias::ANYBODY;
use super::found::FoundSpp;
use super::layers::Layers;
use super::recognise::Recognised;
use super::role::Role;

/// No pixel is believed to have more samples.
const MOST: u32 = 1 << 24;

/// Samples per pixel, and where the number stood.
#[derive(Clone, Debug)]
pub struct Spp {
    /// Of every pixel.
    pub total: Vec<u32>,
    /// Who said so.
    pub from: String,
}

impl Spp {
    /// Mean over the picture, at least 1.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.total.iter().map(|n| f64::from(*n)).sum();
        (sum / self.total.len().max(1) as f64).max(1.0)
    }

    /// Whether all pixels have as many.
    pub fn is_uniform(&self) -> bool {
        self.total.iter().all(|n| *n == self.total[0])
    }

    /// For the report.
    pub fn found(&self) -> FoundSpp {
        let (min, max) = (self.total.iter().min(), self.total.iter().max());
        let or_0 = |n: Option<&u32>| n.copied().unwrap_or(0);
        FoundSpp { mean: self.mean(), min: or_0(min), max: or_0(max), from: self.from.clone() }
    }
}

/// Takes the sample counts out of `layers`: `given` on the command line, else a layer of counts, else an attribute. A layer
/// of fractions (Cycles) counts with the number that says what 1 is; where nothing does, and another wrote it, 1 everywhere is one sample.
pub fn take_spp(layers: &mut Layers, recognised: &Recognised, given: Option<u32>) -> Option<Spp> {
    let pixels = layers.window.size.pixels();
    let number = given.map(|n| (f64::from(n), "--spp".to_string())).or_else(|| attribute(layers, recognised));
    let plane = recognised.mean(Role::Samples).and_then(|found| layers.take_scalar(&found.channels[0]));
    let layer = || recognised.mean(Role::Samples).map_or_else(String::new, |found| found.channels[0].clone());
    let is_fraction = plane.as_ref().is_some_and(|plane| plane.iter().all(|v| *v <= 1.0));
    match (plane, number) {
        (Some(plane), Some((number, from))) if is_fraction => {
            Some(Spp { total: rounded(&plane, number), from: format!("{} × {from}", layer()) })
        }
        (Some(plane), _) if !is_fraction && given.is_none() => Some(Spp { total: rounded(&plane, 1.0), from: layer() }),
        (Some(plane), None) if recognised.renderer.name != "Cycles" && plane.iter().all(|v| *v == 1.0) => {
            Some(Spp { total: rounded(&plane, 1.0), from: layer() })
        }
        (_, Some((number, from))) => Some(Spp { total: vec![number.round().max(1.0) as u32; pixels], from }),
        (_, None) => None,
    }
}

/// A plane of counts in units of `scale`, no more than can be believed.
pub fn rounded(plane: &[f32], scale: f64) -> Vec<u32> {
    plane.iter().map(|v| ((f64::from(*v) * scale).round() as u32).min(MOST)).collect()
}

fn attribute(layers: &Layers, recognised: &Recognised) -> Option<(f64, String)> {
    let names = recognised.renderer.spp.iter().chain(ANYBODY.spp);
    names.into_iter().find_map(|(start, end)| {
        // Of several view layers each may have its own number.
        let own = format!("{start}{}{end}", view_layer(recognised));
        let number = layers.carried.number((&own, "")).or_else(|| layers.carried.number((start, end)));
        let number = number.filter(|n| *n >= 1.0 && *n <= f64::from(MOST))?;
        let gap = if end.is_empty() { "" } else { "…" };
        Some((number, format!("attribute {start}{gap}{end}")))
    })
}

/// The view layer that the colour is of.
fn view_layer(recognised: &Recognised) -> &str {
    let colour = recognised.mean(Role::Colour).and_then(|found| found.channels.first());
    let layer = colour.and_then(|channel| channel.rsplit_once('.')).map_or("", |(layer, _)| layer);
    let parent = layer.rsplit_once('.').map_or("", |(parent, _)| parent);
    parent.rsplit('.').next().unwrap_or_default()
}
