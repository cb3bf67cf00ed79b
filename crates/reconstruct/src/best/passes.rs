//! Passes: parts of the light (diffuse and specular, groups of lights), rebuilt with the weights of the whole so that they
//! still add up to it.
//!
//! Everything that is linear is done to each pass as to the whole: the share of the low layer, both regressions, the
//! mixture of candidates. What is not (spread events, energy given back, light below zero) is shared out in proportion.
//! What the whole has beside the passes is rebuilt as a pass more, or the others would get its light.

use std::ops::Range;

use stack::{Cancelled, Image, Monitor, Size};

use super::first_pass::first_pass;
use super::given::Given;
use super::halves::mean_of;
use super::settings::FitSettings;
use crate::bands::image_rows;
use crate::box_filter::box_mean;

/// Light that a pass counts for where none of them has any, relative to its mean.
const LEAST_SHARE: f32 = 1e-4;

/// One pass on its way.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Its part of the low layer.
    pub low: Image,
    /// What the first pass of regressions makes of it.
    pub first: Image,
}

impl Pass {
    /// Some `rows` of it.
    pub fn rows(&self, rows: &Range<usize>) -> Self {
        Self { low: image_rows(&self.low, rows), first: image_rows(&self.first, rows) }
    }
}

/// The parts of the layer `low` that the `passes` of `whole` make up, and last the rest of it. What was cut off the whole
/// is taken first from what sticks out of a pass: a lamp's reflection is no hole in the light of the sky.
pub fn low_layers(passes: &[Image], whole: &Image, low: &Image) -> Vec<Image> {
    let size = low.size();
    let mut parts = passes.to_vec();
    parts.push(rest_of(whole, passes));
    for c in 0..3 {
        let mut excess: Vec<Vec<f32>> = parts.iter().map(|part| sticking_out(&part.channels()[c], size)).collect();
        for (pixel, (whole, low)) in whole.channels()[c].iter().zip(&low.channels()[c]).enumerate() {
            let cut = whole - low;
            let all: f32 = excess.iter().map(|excess| excess[pixel]).sum();
            let taken = if all > 0.0 { (cut / all).clamp(0.0, 1.0) } else { 0.0 };
            excess.iter_mut().for_each(|excess| excess[pixel] *= taken);
            let left = whole - taken * all;
            let kept = if left == 0.0 { 0.0 } else { low / left };
            for (part, excess) in parts.iter_mut().zip(&excess) {
                let value = &mut part.channels_mut()[c][pixel];
                *value = kept * (*value - excess[pixel]);
            }
        }
    }
    parts
}

/// What `whole` has beside its `passes`.
fn rest_of(whole: &Image, passes: &[Image]) -> Image {
    let mut rest = whole.clone();
    for pass in passes {
        for (rest, part) in rest.channels_mut().iter_mut().zip(pass.channels()) {
            rest.iter_mut().zip(part).for_each(|(rest, part)| *rest -= part);
        }
    }
    rest
}

/// How far values stick out of the mean of 5×5 pixels; no more than there is.
fn sticking_out(plane: &[f32], size: Size) -> Vec<f32> {
    let around = box_mean(plane, size, 2);
    plane.iter().zip(around).map(|(v, around)| (v - around).clamp(0.0, v.max(0.0))).collect()
}

/// Rebuilds the layers `low` as the first pass of regressions rebuilds the halves.
///
/// # Errors
/// When `monitor` cancels.
pub fn through_first_pass(
    low: Vec<Image>,
    given: &Given,
    settings: &FitSettings,
    monitor: &dyn Monitor,
) -> Result<Vec<Pass>, Cancelled> {
    low.into_iter()
        .map(|low| {
            let halves = first_pass(&[low.clone(), low.clone()], given, settings, monitor)?;
            Ok(Pass { low, first: mean_of(&halves) })
        })
        .collect()
}

/// Gives the `passes` (the last is what the others leave of the whole) what they lack to add up to `picture`, in
/// proportion to the light that each has there; returns all but the last.
pub fn add_up_to(mut passes: Vec<Image>, picture: &Image) -> Vec<Image> {
    for c in 0..3 {
        let least: Vec<f32> = passes.iter().map(|pass| LEAST_SHARE * mean_size(&pass.channels()[c])).collect();
        for (pixel, whole) in picture.channels()[c].iter().enumerate() {
            let at = |pass: &Image| pass.channels()[c][pixel];
            let lack = whole - passes.iter().map(at).sum::<f32>();
            let share = |(pass, least): (&Image, &f32)| at(pass).abs() + least;
            let all: f32 = passes.iter().zip(&least).map(share).sum();
            if all > 0.0 {
                for (pass, least) in passes.iter_mut().zip(&least) {
                    let value = &mut pass.channels_mut()[c][pixel];
                    *value += lack * ((value.abs() + least) / all);
                }
            }
        }
    }
    passes.pop();
    passes
}

fn mean_size(plane: &[f32]) -> f32 {
    let sum: f64 = plane.iter().map(|v| f64::from(v.abs())).sum();
    (sum / plane.len().max(1) as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::super::test_scene::{flat, image};
    use super::*;
    use stack::Size;

    const SIZE: Size = Size::new(6, 5);

    #[test]
    fn layers_of_passes_and_their_rest_make_up_the_low_layer() {
        let whole = image(SIZE, |x, y, c| (1 + x * y + c) as f32);
        let low = image(SIZE, |x, y, c| (1 + x * y + c) as f32 * if x == 3 { 0.25 } else { 1.0 });
        let diffuse = image(SIZE, |x, y, c| 0.5 * (1 + x * y + c) as f32);
        let layers = low_layers(&[diffuse], &whole, &low);
        assert_eq!(layers.len(), 2);
        for i in 0..SIZE.pixels() {
            let [part, rest] = [0, 1].map(|pass: usize| layers[pass].rgb(i)[1]);
            assert!((part - 0.5 * low.rgb(i)[1]).abs() < 1e-6 && (part + rest - low.rgb(i)[1]).abs() < 1e-6);
        }
    }

    #[test]
    fn what_was_cut_off_a_highlight_leaves_no_hole_in_the_other_light() {
        let (size, lamp) = (Size::new(9, 9), 40);
        let sky = flat(size, 1.0);
        let mut whole = sky.clone();
        let mut low = sky.clone();
        whole.channels_mut().iter_mut().for_each(|plane| plane[lamp] = 100.0);
        low.channels_mut().iter_mut().for_each(|plane| plane[lamp] = 5.0);
        let layers = low_layers(&[sky], &whole, &low);
        assert_eq!(layers[0].rgb(lamp), [1.0; 3]);
        assert!((layers[1].rgb(lamp)[0] - 4.0).abs() < 1e-5);
    }

    #[test]
    fn what_is_lacking_is_shared_in_proportion() {
        let passes = vec![flat(SIZE, 3.0), flat(SIZE, 1.0), flat(SIZE, 0.0)];
        let found = add_up_to(passes, &flat(SIZE, 8.0));
        assert_eq!(found.len(), 2);
        assert!((found[0].rgb(4)[0] - 6.0).abs() < 1e-4 && (found[1].rgb(4)[0] - 2.0).abs() < 1e-4);
    }

    #[test]
    fn light_where_no_pass_has_any_goes_to_the_brighter_one() {
        let lit = |value: f32| image(SIZE, move |x, _, _| if x == 0 { 0.0 } else { value });
        let found = add_up_to(vec![lit(3.0), lit(1.0), flat(SIZE, 0.0)], &flat(SIZE, 4.0));
        assert!((found[0].rgb(0)[0] - 3.0).abs() < 1e-4 && (found[1].rgb(0)[0] - 1.0).abs() < 1e-4);
    }
}
