//! What is wrong with other renderers' pixels, mended and counted.

mod neighbours;
mod spaces;
#[cfg(test)]
mod tests;

use serde::Serialize;

use super::alias::FAR_AWAY;
use super::role::Role;
use crate::{FeatureRole, Image};
use neighbours::{mean_around, median_around};

pub use spaces::{Oriented, to_world_space};

/// Something that was mended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mended {
    /// What it was and what became of it.
    pub what: String,
    /// How many there were.
    pub count: usize,
}

/// Light above this is not worked with: the square of its noise is no number any more.
const BRIGHTEST: f32 = 1e18;

/// Adds `count` things of a kind to a list, unless there are none.
pub fn note(list: &mut Vec<Mended>, what: String, count: usize) {
    match list.iter_mut().find(|mended| mended.what == what) {
        Some(mended) => mended.count += count,
        None if count > 0 => list.push(Mended { what, count }),
        None => {}
    }
}

/// Mends all images of one role (its mean and halves, or its buckets), which must agree about what is far away.
pub fn mend_role(role: Role, images: &mut [&mut Image], list: &mut Vec<Mended>) {
    match role {
        Role::Colour | Role::Emission => {
            smooth_over(role, images, list);
            clamp(role, images, (0.0, BRIGHTEST), list);
        }
        Role::Feature(FeatureRole::Albedo | FeatureRole::Visibility | FeatureRole::Proximity | FeatureRole::Lit) => {
            smooth_over(role, images, list);
            clamp(role, images, (0.0, 1.0), list);
        }
        Role::Feature(FeatureRole::Normal) => {
            let count = replace_pixels(images, |v| !v.is_finite(), &[0.0; 3]);
            note(list, "pixels whose normal is no number (set to 0)".into(), count);
        }
        Role::Feature(FeatureRole::Position | FeatureRole::Depth) => {
            let far = |v: f32| v.is_nan() || v.abs() >= FAR_AWAY;
            let farthest = farthest(images, far);
            let count = replace_pixels(images, far, &farthest);
            note(list, format!("pixels whose {} is infinite (set to the farthest there is)", role.name()), count);
        }
        Role::Alpha | Role::Samples => {}
    }
}

/// Replaces what is no finite number by the median of its finite neighbours.
fn smooth_over(role: Role, images: &mut [&mut Image], list: &mut Vec<Mended>) {
    let count = images.iter_mut().map(|image| make_finite(image)).sum();
    note(list, format!("values of {} that are no numbers (median of the neighbours)", role.name()), count);
}

/// The same for one image; how many values there were.
pub fn make_finite(image: &mut Image) -> usize {
    let (size, mut count) = (image.size(), 0);
    for plane in image.channels_mut() {
        let bad: Vec<usize> = (0..plane.len()).filter(|i| !plane[*i].is_finite()).collect();
        let better: Vec<f32> = bad.iter().map(|i| median_around(plane, size, *i)).collect();
        count += bad.len();
        bad.into_iter().zip(better).for_each(|(i, value)| plane[i] = value);
    }
    count
}

fn clamp(role: Role, images: &mut [&mut Image], (least, most): (f32, f32), list: &mut Vec<Mended>) {
    let (mut below, mut above) = (0, 0);
    for value in images.iter_mut().flat_map(|image| image.channels_mut()).flatten() {
        if *value < least {
            below += 1;
            *value = least;
        } else if *value > most {
            above += 1;
            *value = most;
        }
    }
    note(list, format!("values of {} below 0 (set to 0)", role.name()), below);
    // Debug writes large numbers with an exponent, and whole ones as 1.0.
    let most = format!("{most:?}");
    let most = most.trim_end_matches(".0");
    note(list, format!("values of {} above {most} (set to {most})", role.name()), above);
}

/// Gives pixels in which a channel is `bad` the value `new`, and counts them.
fn replace_pixels(images: &mut [&mut Image], bad: impl Fn(f32) -> bool, new: &[f32]) -> usize {
    let mut count = 0;
    for image in images {
        for pixel in 0..image.pixels() {
            if image.channels().iter().any(|plane| bad(plane[pixel])) {
                count += 1;
                image.channels_mut().iter_mut().zip(new).for_each(|(plane, v)| plane[pixel] = *v);
            }
        }
    }
    count
}

/// The pixel farthest from 0 among those that are not `bad`; zeros when there is none.
fn farthest(images: &[&mut Image], bad: impl Fn(f32) -> bool) -> Vec<f32> {
    let mut best = vec![0.0; images.first().map_or(1, |image| image.channels().len())];
    let mut distance = -1.0;
    for image in images {
        for pixel in 0..image.pixels() {
            let values = image.channels().iter().map(|plane| plane[pixel]);
            let d: f64 = values.clone().map(|v| f64::from(v).powi(2)).sum();
            if d > distance && !values.clone().any(&bad) {
                distance = d;
                best = values.collect();
            }
        }
    }
    best
}

/// Replaces variances that are not known (NaN, infinite or negative) by the mean of those around that are, and says
/// whether there was any that is.
pub fn mend_variance(role: Role, variance: &mut Image, list: &mut Vec<Mended>) -> bool {
    let size = variance.size();
    let unknown = |v: f32| !(v.is_finite() && v >= 0.0);
    let mut count = 0;
    for plane in variance.channels_mut() {
        let bad: Vec<usize> = (0..plane.len()).filter(|i| unknown(plane[*i])).collect();
        if bad.is_empty() {
            continue;
        }
        if bad.len() == plane.len() {
            return false;
        }
        let overall = overall_mean(plane, unknown);
        let better: Vec<f32> = bad.iter().map(|i| mean_around(plane, size, *i, unknown).unwrap_or(overall)).collect();
        count += bad.len();
        bad.into_iter().zip(better).for_each(|(i, value)| plane[i] = value);
    }
    note(list, format!("values of the variance of {} that are unknown (mean of those around)", role.name()), count);
    true
}

fn overall_mean(plane: &[f32], unknown: impl Fn(f32) -> bool) -> f32 {
    let known = plane.iter().filter(|v| !unknown(**v));
    let (sum, n) = known.fold((0.0, 0.0), |(sum, n): (f64, f64), v| (sum + f64::from(*v), n + 1.0));
    (sum / n.max(1.0)) as f32
}
