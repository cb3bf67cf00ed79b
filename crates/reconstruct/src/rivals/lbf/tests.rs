//! The filter and its slope against the equations as they stand, and promises of the method as a whole.

use stack::{FeatureRole, Image, Silent};

use super::filter::{RowFilter, RowGradient};
use super::kernel::TERMS;
use super::test_scene::{SIZE, noisy_stack, primary_of, reference};
use super::training::start;
use super::*;
use crate::components::variance_of;

const RADIUS: usize = 4;

/// The filtered colour of one pixel: equation 4 pixel by pixel, in double precision.
fn twin(primary: &Primary, bandwidths: &[f64; TERMS], pixel: usize) -> [f64; 3] {
    let (x, y) = (pixel % SIZE.width, pixel / SIZE.width);
    let (mut sums, mut weights) = ([0.0; 3], 0.0);
    for other in 0..SIZE.pixels() {
        let (dx, dy) = ((other % SIZE.width).abs_diff(x), (other / SIZE.width).abs_diff(y));
        if dx.max(dy) > RADIUS {
            continue;
        }
        let squares = |planes: &[Vec<f32>]| -> f64 {
            planes.iter().map(|plane| (f64::from(plane[pixel]) - f64::from(plane[other])).powi(2)).sum()
        };
        let noise = primary.colour_variance[pixel] + primary.colour_variance[other];
        let mut distances = vec![(dx * dx + dy * dy) as f64 / 16.0, squares(&primary.colour) / f64::from(3.0 * noise)];
        for kind in 0..FEATURES {
            let scale = primary.feature_scale[kind].get(pixel).copied().unwrap_or(1.0);
            distances.push(squares(&primary.features[kind]) / f64::from(scale));
        }
        let exponent: f64 = distances.iter().zip(bandwidths).map(|(d, gamma)| d / (2.0 * gamma * gamma)).sum();
        let weight = (-exponent).exp();
        weights += weight;
        (0..3).for_each(|c| sums[c] += weight * f64::from(primary.colour[c][other]));
    }
    sums.map(|sum| sum / weights)
}

/// Bandwidths that differ from pixel to pixel.
fn uneven(x: usize) -> Bandwidths {
    std::array::from_fn(|term| 0.8 + 0.2 * ((x + 3 * term) % 5) as f32)
}

#[test]
fn the_filter_is_the_equation() {
    let primary = primary_of(&noisy_stack(0.3, 1), 1.0);
    for y in [0, 8, SIZE.height - 1] {
        let bandwidths: Vec<Bandwidths> = (0..SIZE.width).map(uneven).collect();
        let filter = RowFilter { primary: &primary, radius: RADIUS, y, bandwidths: &bandwidths };
        let row = pulp::Arch::new().dispatch(filter);
        for x in 0..SIZE.width {
            let expected = twin(&primary, &bandwidths[x].map(f64::from), SIZE.index(x, y));
            (0..3).for_each(|c| assert!((f64::from(row.colour[c][x]) - expected[c]).abs() < 1e-5, "{x} {y}"));
        }
    }
}

#[test]
fn the_slope_is_that_of_finite_differences() {
    let primary = primary_of(&noisy_stack(0.3, 2), 1.0);
    let (y, pull) = (7, [1.0, -0.5, 2.0]);
    let bandwidths: Vec<Bandwidths> = (0..SIZE.width).map(uneven).collect();
    let filter = RowFilter { primary: &primary, radius: RADIUS, y, bandwidths: &bandwidths };
    let filtered = pulp::Arch::new().dispatch(filter);
    let slope = pull.map(|pull| vec![pull; SIZE.width]);
    let slopes = pulp::Arch::new().dispatch(RowGradient { filter, filtered: &filtered, slope: &slope });
    for (x, term) in (0..SIZE.width).flat_map(|x| (0..TERMS).map(move |term| (x, term))) {
        let error = |change: f64| -> f64 {
            let mut bandwidths = bandwidths[x].map(f64::from);
            bandwidths[term] += change;
            let found = twin(&primary, &bandwidths, SIZE.index(x, y));
            found.iter().zip(pull).map(|(c, pull)| c * f64::from(pull)).sum()
        };
        let expected = (error(1e-5) - error(-1e-5)) / 2e-5;
        let found = f64::from(slopes[x][term]);
        assert!((found - expected).abs() < 1e-4 + 1e-3 * expected.abs(), "{x}, term {term}: {found} {expected}");
    }
}

fn squared_error(found: &Image) -> f32 {
    let pairs = found.channels().iter().flatten().zip(reference().into_channels().into_iter().flatten());
    pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f32>() / (3 * SIZE.pixels()) as f32
}

#[test]
fn a_network_that_was_not_trained_is_the_fixed_filter() {
    let stack = noisy_stack(0.3, 4);
    let primary = primary_of(&stack, 1.0);
    let bandwidths = [0.5, 1.5, 3.0, 0.1, 20.0, 1.0];
    let network = start(secondary(&primary).iter(), bandwidths, 1);
    for found in chosen(&network, &primary) {
        (0..TERMS).for_each(|t| assert!((found[t] / bandwidths[t] - 1.0).abs() < 1e-5));
    }
}

fn rebuilt(stack: &FeatureStack) -> Reconstruction {
    let settings = Settings::default();
    let variance = variance_of(&stack.components[0], &stack.samples).unwrap();
    let radiance = &stack.components[0].radiance.mean;
    rebuild(stack, radiance, &variance, Tuning::Trained, &settings, &Silent).unwrap()
}

#[test]
fn the_trained_filter_takes_noise_off_and_knows_its_error() {
    let stack = noisy_stack(0.3, 6);
    let found = rebuilt(&stack);
    let (before, after) = (squared_error(&stack.components[0].radiance.mean), squared_error(&found.picture));
    assert!(after < 0.25 * before, "{after} {before}");
    let claimed = found.mse.iter().sum::<f32>() / found.mse.len() as f32;
    assert!(claimed > 0.3 * after && claimed < 3.0 * after, "{claimed} {after}");
}

#[test]
fn missing_features_and_broken_pixels_are_borne() {
    let mut stack = noisy_stack(0.3, 6);
    stack.features.retain(|feature| feature.role == FeatureRole::Normal);
    stack.components[0].radiance.mean.channels_mut()[1][40] = f32::NAN;
    let found = rebuilt(&stack);
    assert!(found.picture.channels().iter().flatten().all(|v| v.is_finite()));
    assert!(found.mse.iter().all(|v| v.is_finite() && *v >= 0.0));
    stack.features.clear();
    let variance = Image::zeros(SIZE, 3);
    let nothing = rebuild(&stack, &variance, &variance, Tuning::Trained, &Settings::default(), &Silent);
    assert!(matches!(nothing, Err(ReconstructError::Prefilter(_))));
}
