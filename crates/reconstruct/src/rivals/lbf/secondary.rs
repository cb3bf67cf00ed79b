//! What the network is told about a pixel: the paper's secondary features (its section 4.2).
//!
//! Of the paper's kinds there are all but the statistics of single samples, which no stack holds: deviations (of the
//! mean, as the buckets tell), spreads in blocks, gradients, distances from a block's mean, median absolute deviations,
//! and the sampling rate. All are relative (colours to the block's brightness, places to the step between neighbours) and
//! logarithmic, so that neither exposure nor the scene's size matters.

use super::primary::{ALBEDO, FEATURES, PLACE, Primary, VISIBILITY};
use super::statistics::{distance_from_mean, gradient, median_deviation, spread, squared_step};
use crate::box_filter::box_mean;

/// Values of colours alone.
const OF_COLOUR: usize = 10;
/// Values of each kind of feature.
const OF_FEATURE: usize = 6;
/// Secondary features of a pixel.
pub const INPUTS: usize = OF_COLOUR + FEATURES * OF_FEATURE + 2;
/// The secondary features of one pixel.
pub type Inputs = [f32; INPUTS];

/// Radius of the small and of the large block.
const BLOCKS: [usize; 2] = [1, 3];
/// Relative values below this are all the same.
const LEAST: f32 = 1e-3;

/// The secondary features of every pixel.
pub fn secondary(primary: &Primary) -> Vec<Inputs> {
    let mut planes = of_colour(primary);
    for kind in 0..FEATURES {
        planes.extend(of_feature(primary, kind));
    }
    planes.push(mean_of(&primary.features[ALBEDO], primary.size.pixels()));
    planes.push(mean_of(&primary.features[VISIBILITY], primary.size.pixels()));
    (0..primary.size.pixels()).map(|pixel| std::array::from_fn(|i| planes[i][pixel])).collect()
}

/// Relative to the brightness of 7×7 pixels: deviation of the mean, in the pixel and in 7×7; spread in 3×3 and in 7×7;
/// gradient; distance from the mean of 3×3 and of 7×7; median absolute deviation. Then that brightness relative to the
/// picture's, and the sampling rate.
fn of_colour(primary: &Primary) -> Vec<Vec<f32>> {
    let (size, colour) = (primary.size, &primary.colour);
    let whole = mean_of(colour, size.pixels());
    let average = whole.iter().map(|v| f64::from(*v)).sum::<f64>() / size.pixels().max(1) as f64;
    let average = (average as f32).max(f32::MIN_POSITIVE);
    let brightness: Vec<f32> = box_mean(&whole, size, BLOCKS[1]).iter().map(|v| v.max(LEAST * average)).collect();
    let noise = &primary.colour_variance;
    let roots = |variance: &[f32]| variance.iter().map(|v| v.sqrt()).collect::<Vec<_>>();
    let relative = |plane: Vec<f32>| logarithms(&plane, Some(&brightness));
    let planes = vec![
        relative(roots(noise)),
        relative(roots(&box_mean(noise, size, BLOCKS[1]))),
        relative(spread(colour, size, BLOCKS[0])),
        relative(spread(colour, size, BLOCKS[1])),
        relative(gradient(colour, size)),
        relative(distance_from_mean(colour, size, BLOCKS[0])),
        relative(distance_from_mean(colour, size, BLOCKS[1])),
        relative(median_deviation(colour, size)),
        brightness.iter().map(|b| (b / average + LEAST).ln()).collect(),
        primary.samples.iter().map(|n| n.max(1.0).ln()).collect(),
    ];
    debug_assert_eq!(planes.len(), OF_COLOUR);
    planes
}

/// Deviation of the mean before filtering; spread in 3×3 and 7×7, gradient, distance from the mean of 7×7 and median
/// absolute deviation of the filtered feature. Zeros when the stack has not that kind.
fn of_feature(primary: &Primary, kind: usize) -> Vec<Vec<f32>> {
    let (size, planes) = (primary.size, &primary.features[kind]);
    if planes.is_empty() {
        return vec![vec![0.0; size.pixels()]; OF_FEATURE];
    }
    let noise = primary.feature_variance[kind].iter().map(|v| v.sqrt()).collect();
    let steps: Option<Vec<f32>> =
        (kind == PLACE).then(|| squared_step(planes, size).iter().map(|s| (s + 1e-8).sqrt()).collect());
    let found: [Vec<f32>; OF_FEATURE] = [
        noise,
        spread(planes, size, BLOCKS[0]),
        spread(planes, size, BLOCKS[1]),
        gradient(planes, size),
        distance_from_mean(planes, size, BLOCKS[1]),
        median_deviation(planes, size),
    ];
    found.iter().map(|plane| logarithms(plane, steps.as_deref())).collect()
}

/// ln(v/unit + a least value) of each value.
fn logarithms(plane: &[f32], unit: Option<&[f32]>) -> Vec<f32> {
    match unit {
        Some(unit) => plane.iter().zip(unit).map(|(v, unit)| (v / unit + LEAST).ln()).collect(),
        None => plane.iter().map(|v| (v + LEAST).ln()).collect(),
    }
}

/// Mean of planes, zeros when there are none.
fn mean_of(planes: &[Vec<f32>], pixels: usize) -> Vec<f32> {
    let share = 1.0 / planes.len().max(1) as f32;
    (0..pixels).map(|pixel| planes.iter().map(|plane| plane[pixel]).sum::<f32>() * share).collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_scene::{noisy_stack, primary_of};
    use super::*;

    #[test]
    fn exposure_does_not_matter() {
        let stack = noisy_stack(0.2, 5);
        let (dark, bright) = (secondary(&primary_of(&stack, 1.0)), secondary(&primary_of(&stack, 64.0)));
        for (a, b) in dark.iter().zip(&bright) {
            for i in 0..INPUTS {
                assert!((a[i] - b[i]).abs() < 1e-3, "input {i}: {} {}", a[i], b[i]);
            }
        }
    }

    #[test]
    fn more_noise_is_seen_in_colours_and_not_in_features() {
        let [calm, noisy] = [0.05, 0.5].map(|sigma| secondary(&primary_of(&noisy_stack(sigma, 5), 1.0)));
        let mean = |of: &[Inputs], i: usize| of.iter().map(|inputs| inputs[i]).sum::<f32>() / of.len() as f32;
        assert!(mean(&noisy, 0) > mean(&calm, 0) + 1.0, "ten times the deviation is ln 10 more");
        assert_eq!(mean(&noisy, OF_COLOUR + OF_FEATURE), mean(&calm, OF_COLOUR + OF_FEATURE));
    }
}
