//! The two layers of a picture that has no buckets: split by its neighbours alone, halves drawn from its variance.

use rayon::prelude::*;
use stack::{Image, Size};

use super::settings::AloneSettings;
use super::split::{Events, LEAST_VARIANCE, Layers};
use crate::recorruption::{coin, evenly_recorrupted_halves, recorrupted_halves};
use crate::variance::{known_everywhere, steadied};

/// Least luminance that anything is cut at.
const LEAST_CAP: f32 = 1e-4;

/// Splits `mean`, of the given `variance`. There are no buckets that a firefly could be missing from, so a pixel is cut
/// where it exceeds a multiple of what its neighbours reach without it. Each event belongs to one half, by lot, as it
/// would if the samples had been dealt to halves.
pub fn split_alone(mean: &Image, variance: &Image, settings: &AloneSettings) -> Layers {
    let size = mean.size();
    let luminance: Vec<f32> = (0..size.pixels()).map(|pixel| mean.mean_at(pixel).max(0.0)).collect();
    let kept: Vec<f32> = (0..size.pixels())
        .into_par_iter()
        .map(|pixel| (cap(&luminance, size, pixel, settings) / luminance[pixel].max(1e-9)).min(1.0))
        .collect();
    let scaled = |image: &Image, factor: &dyn Fn(usize) -> f32| {
        let planes = image.channels().iter().map(|plane| plane.iter().enumerate().map(|(i, v)| v * factor(i)).collect());
        Image::from_channels(size, planes.collect())
    };
    let low = scaled(mean, &|i| kept[i]);
    let variance = known_everywhere(variance.clone(), mean);
    let variance = scaled(&variance, &|i| kept[i] * kept[i]);
    let energy: Vec<f32> = (0..size.pixels()).map(|i| 3.0 * (1.0 - kept[i]) * luminance[i]).collect();
    Layers {
        halves: if settings.even { evenly_recorrupted_halves(&low, &variance) } else { recorrupted_halves(&low, &variance) },
        variance: steadied(scaled(&variance, &|_| 2.0), LEAST_VARIANCE),
        events: Events {
            light: [true, false].map(|side| scaled(mean, &|i| if coin(i as u64) == side { 1.0 - kept[i] } else { 0.0 })),
            squares: energy.iter().map(|e| e * e).collect(),
            energy,
        },
    }
}

/// Luminance above which a pixel is cut.
fn cap(luminance: &[f32], size: Size, pixel: usize, settings: &AloneSettings) -> f32 {
    let (x, y, radius) = (pixel % size.width, pixel / size.width, settings.radius);
    let mut around = Vec::with_capacity((2 * radius + 1).pow(2));
    for row in y.saturating_sub(radius)..(y + radius + 1).min(size.height) {
        for column in x.saturating_sub(radius)..(x + radius + 1).min(size.width) {
            if [column, row] != [x, y] {
                around.push(luminance[size.index(column, row)]);
            }
        }
    }
    if around.is_empty() {
        return f32::INFINITY;
    }
    let rank = ((around.len() - 1) as f32 * settings.quantile) as usize;
    let (_, reached, _) = around.select_nth_unstable_by(rank, f32::total_cmp);
    (settings.factor * *reached).max(LEAST_CAP)
}
