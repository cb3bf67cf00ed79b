//! What a layer is, by its values: for a renderer whose names are the user's.

use super::layer_list::LayerNames;
use super::{Layers, Passthrough};
use crate::FeatureRole;

/// Pixels looked at.
const LOOKED_AT: usize = 4096;

/// Share of the vectors of a normal that have unit length or none: at edges several surfaces share a pixel.
const UNIT_SHARE: f64 = 0.6;

/// Those of the `free` layers of `layers` whose values fit `feature`; none where a value tells nothing about it.
pub fn by_value<'a>(
    layers: &Layers,
    free: impl Iterator<Item = &'a LayerNames>,
    feature: FeatureRole,
) -> Vec<&'a LayerNames> {
    match feature {
        FeatureRole::Normal => free.filter(|layer| has_unit_vectors(layers, layer) == Some(true)).collect(),
        FeatureRole::Position => free.filter(|layer| has_unit_vectors(layers, layer) == Some(false)).collect(),
        FeatureRole::Depth => free.filter(|layer| layer.has(&["T"])).collect(),
        FeatureRole::Albedo => {
            // A picture in parts has many layers of colours between 0 and 1: only one alone is taken for reflectance.
            let all: Vec<_> = free.filter(|layer| is_reflectance(layers, layer)).collect();
            if all.len() == 1 { all } else { Vec::new() }
        }
        FeatureRole::Visibility | FeatureRole::Proximity | FeatureRole::Lit => Vec::new(),
    }
}

/// Whether a layer of X, Y and Z holds unit vectors; `None` when it is none, or all zero.
fn has_unit_vectors(layers: &Layers, layer: &LayerNames) -> Option<bool> {
    let vectors = samples(layers, layer, &["X", "Y", "Z"])?;
    let lengths = vectors.iter().map(|v| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt());
    let lengths: Vec<f64> = lengths.filter(|length| *length > 0.0).collect();
    let unit = lengths.iter().filter(|length| (*length - 1.0).abs() < 0.01).count() as f64;
    let within = lengths.iter().all(|length| *length < 1.01);
    (!lengths.is_empty()).then_some(within && unit >= UNIT_SHARE * lengths.len() as f64)
}

fn is_reflectance(layers: &Layers, layer: &LayerNames) -> bool {
    let between = |v: &f32| (0.0..=1.001).contains(v);
    !layer.has(&["A"])
        && samples(layers, layer, &["R", "G", "B"]).is_some_and(|colours| colours.iter().flatten().all(between))
}

/// Values of up to [`LOOKED_AT`] pixels spread over the picture.
fn samples(layers: &Layers, layer: &LayerNames, suffixes: &[&str]) -> Option<Vec<[f32; 3]>> {
    let names = layer.has(suffixes).then(|| layer.triple())??;
    let channels: Option<Vec<&Passthrough>> =
        names.iter().map(|name| layers.channels.iter().find(|channel| channel.name == *name)).collect();
    let channels = channels?;
    let pixels = layers.window.size.pixels();
    let step = pixels.div_ceil(LOOKED_AT).max(1);
    Some((0..pixels).step_by(step).map(|pixel| [0, 1, 2].map(|c| channels[c].value(pixel))).collect())
}
