//! FLIP: how different two pictures look when one is flipped to the other in place.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild, *FLIP: a difference evaluator
//! for alternating images*, 2020; the same first three and P. Shirley, *Visualizing errors in rendered high dynamic range
//! images*, 2021.

mod colour;
mod colour_difference;
mod convolution;
mod exposures;
mod feature_difference;

use rayon::prelude::*;
use stack::{Image, Size};

use super::average::mean;
use super::judged::value;
use colour::to_ycxcz;

/// Resolution on the retina: a display 0.7 m wide of 3840 pixels, seen from 0.7 m.
const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * std::f64::consts::PI / 180.0;

/// Weights of the luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Mean LDR-FLIP over `pixels` of the pictures cut off to 0 … 1: from 0, equal, to 1. All other pixels count as equal.
/// `None` without pixels.
///
/// # Panics
/// When an image has fewer than three channels.
pub fn flip(image: &Image, reference: &Image, pixels: &[usize]) -> Option<f64> {
    let shown = |linear: f64| linear.clamp(0.0, 1.0) as f32;
    average(&error_map(image, reference, pixels, shown), pixels)
}

/// Mean HDR-FLIP over `pixels`: of the exposures that suit the reference, each pixel's largest LDR-FLIP of the pictures
/// tone-mapped by ACES; from 0 to 1. All other pixels count as equal. `None` without pixels and for a black reference.
///
/// # Panics
/// When an image has fewer than three channels.
pub fn flip_hdr(image: &Image, reference: &Image, pixels: &[usize]) -> Option<f64> {
    let luminance = |pixel: &usize| (0..3).map(|c| LUMINANCE[c] * radiance(reference, c, *pixel)).sum();
    let mut largest: Option<Vec<f32>> = None;
    for stops in exposures::exposures(pixels.iter().map(luminance).collect()) {
        let errors = error_map(image, reference, pixels, |linear| exposures::tone_map(linear, stops));
        largest = Some(match largest {
            None => errors,
            Some(largest) => largest.iter().zip(errors).map(|(a, b)| a.max(b)).collect(),
        });
    }
    average(&largest?, pixels)
}

fn average(errors: &[f32], pixels: &[usize]) -> Option<f64> {
    mean(&pixels.iter().map(|pixel| f64::from(errors[*pixel])).collect::<Vec<_>>())
}

/// Radiance as FLIP takes it: neither negative nor infinite.
fn radiance(image: &Image, channel: usize, pixel: usize) -> f64 {
    value(&image.channels()[channel], pixel).max(0.0)
}

/// FLIP at every pixel, of the two pictures as `shown` displays linear radiance, in 0 … 1. Pixels that are not judged are
/// the reference's in both, since neighbours see them too.
fn error_map(image: &Image, reference: &Image, pixels: &[usize], shown: impl Fn(f64) -> f32 + Sync) -> Vec<f32> {
    let size = reference.size();
    let planes = opponents(reference, size, &shown);
    let mut others = planes.clone();
    let tested = opponents(image, size, &shown);
    for (other, tested) in others.iter_mut().zip(&tested) {
        pixels.iter().for_each(|pixel| other[*pixel] = tested[*pixel]);
    }
    let colours = [&planes, &others].map(|planes| colour_difference::seen(planes, size));
    let [first, second] = [&planes, &others].map(|planes| feature_difference::features(&planes[0], size));
    let largest = colour_difference::largest();
    let error = |pixel: usize| {
        let colour = colour_difference::difference(colours[0][pixel], colours[1][pixel], largest);
        colour.powf(1.0 - feature_difference::difference(&first, &second, pixel))
    };
    (0..size.pixels()).into_par_iter().map(error).collect()
}

/// Planes Y, Cx, Cz of a picture as it is shown.
fn opponents(image: &Image, size: Size, shown: &(impl Fn(f64) -> f32 + Sync)) -> [Vec<f32>; 3] {
    let colour = |pixel: usize| to_ycxcz([0, 1, 2].map(|channel| shown(radiance(image, channel, pixel))));
    let colours: Vec<[f32; 3]> = (0..size.pixels()).into_par_iter().map(colour).collect();
    [0, 1, 2].map(|channel: usize| colours.iter().map(|colour| colour[channel]).collect())
}

#[cfg(test)]
mod tests;
