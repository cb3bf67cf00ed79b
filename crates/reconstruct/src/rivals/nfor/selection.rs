//! Which bandwidth is better where (section 5.3).

use stack::{Cancelled, Image, Monitor};

use super::{ColourHalves, comparison};
use crate::nl_means::{Guide, nl_means, units};
use crate::patch_distance::NoisyPlanes;

/// Radius of the patches that smooth errors and choices.
const PATCH_RADIUS: usize = 1;
/// Radius of their window.
const RADIUS: usize = 9;
/// Their bandwidth.
const BANDWIDTH: f32 = 1.0;

/// Both halves rebuilt with one bandwidth.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// A, then B.
    pub(crate) halves: [Image; 2],
}

/// What was chosen.
#[derive(Clone, Debug)]
pub(crate) struct Selected {
    /// Both halves, mixed from the candidates.
    pub(crate) halves: [Image; 2],
    /// Estimated mean squared error of the halves' mean, mean over RGB.
    pub(crate) mse: Vec<f32>,
}

/// Mixes two `candidates` for `colour` by the share of each pixel's surroundings where the second has the smaller error.
/// Errors and shares are averaged by non-local means of the colour. Reports the stage `selection`.
///
/// # Errors
/// When `monitor` cancels.
pub(crate) fn select(
    candidates: &[Candidate],
    colour: &ColourHalves,
    monitor: &dyn Monitor,
) -> Result<Selected, Cancelled> {
    let size = colour.variance.size();
    let (mean, _) = super::combined(&colour.halves);
    let variance: Vec<Vec<f32>> =
        colour.variance.channels().iter().map(|plane| plane.iter().map(|v| 0.5 * v).collect()).collect();
    let planes = NoisyPlanes { size, values: mean.channels(), variances: &variance };
    let guide = Guide { planes, comparison: comparison(PATCH_RADIUS), radius: RADIUS };
    monitor.begin("selection", 2 * units(size));
    let noisy: Vec<Vec<f32>> = candidates.iter().map(|candidate| noisy_error(candidate, colour)).collect();
    let errors = nl_means(&guide, BANDWIDTH, &noisy, monitor)?;
    let (first, last) = (&errors[0], &errors[errors.len() - 1]);
    let better = first.iter().zip(last).map(|(a, b)| if a < b { 0.0 } else { 1.0 }).collect();
    let share = nl_means(&guide, BANDWIDTH, &[better], monitor)?.remove(0);
    let mse = mixed(first, last, &share).into_iter().map(|e| e.max(0.0)).collect();
    let halves = [0, 1].map(|half: usize| {
        let [a, b] = [0, candidates.len() - 1].map(|i| candidates[i].halves[half].channels());
        Image::from_channels(size, a.iter().zip(b).map(|(a, b)| mixed(a, b, &share)).collect())
    });
    Ok(Selected { halves, mse })
}

fn mixed(a: &[f32], b: &[f32], share: &[f32]) -> Vec<f32> {
    a.iter().zip(b).zip(share).map(|((a, b), share)| a + share * (b - a)).collect()
}

/// Unbiased estimate of the squared error of the mean of both halves, mean over RGB: each half's against the other's
/// input, less that one's variance; less what the mean of two halves is better than one.
fn noisy_error(candidate: &Candidate, colour: &ColourHalves) -> Vec<f32> {
    let error = |pixel: usize| {
        let v = colour.variance.rgb(pixel);
        let [x_a, x_b] = [0, 1].map(|half: usize| candidate.halves[half].rgb(pixel));
        let [y_a, y_b] = [0, 1].map(|half: usize| colour.halves[half].rgb(pixel));
        let of = |c: usize| {
            let crossed = 0.5 * ((y_b[c] - x_a[c]).powi(2) + (y_a[c] - x_b[c]).powi(2)) - v[c];
            crossed - 0.25 * (x_a[c] - x_b[c]).powi(2)
        };
        (of(0) + of(1) + of(2)) / 3.0
    };
    (0..colour.variance.pixels()).map(error).collect()
}

#[cfg(test)]
mod tests {
    use stack::{Silent, Size};

    use super::*;
    use crate::test_noise::TestNoise;

    const SIZE: Size = Size::new(40, 30);

    /// Truth 1 with unit-variance halves; the first candidate is off by `bias`, the second noisy by `sigma`.
    fn scene(bias: f32, sigma: f32) -> (Vec<Candidate>, ColourHalves) {
        let mut noise = TestNoise(1);
        let mut image = |mean: f32, sigma: f32| {
            Image::from_channels(SIZE, (0..3).map(|_| noise.normals(SIZE.pixels(), mean, sigma)).collect())
        };
        let halves = [image(1.0, 1.0), image(1.0, 1.0)];
        let biased = Candidate { halves: [image(1.0 + bias, 0.0), image(1.0 + bias, 0.0)] };
        let noisy = Candidate { halves: [image(1.0, sigma), image(1.0, sigma)] };
        let variance = Image::from_channels(SIZE, vec![vec![1.0; SIZE.pixels()]; 3]);
        (vec![biased, noisy], ColourHalves { halves, variance })
    }

    #[test]
    fn errors_are_those_of_the_mean_of_both_halves() {
        let (candidates, colour) = scene(0.5, 0.6);
        let mean = |candidate: &Candidate| noisy_error(candidate, &colour).iter().sum::<f32>() / SIZE.pixels() as f32;
        assert!((mean(&candidates[0]) - 0.25).abs() < 0.06);
        assert!((mean(&candidates[1]) - 0.36 / 2.0).abs() < 0.06);
    }

    #[test]
    fn the_smaller_error_is_chosen() {
        for (bias, sigma, expected) in [(1.0, 0.2, 1.0), (0.1, 1.5, 1.1)] {
            let (candidates, colour) = scene(bias, sigma);
            let found = select(&candidates, &colour, &Silent).unwrap();
            let off: f32 = found.halves[0].channels()[0].iter().map(|v| (v - expected).powi(2)).sum();
            assert!(off / (SIZE.pixels() as f32) < 0.1, "{off}");
        }
    }
}
