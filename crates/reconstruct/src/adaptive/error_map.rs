//! Where more samples would help: the error reduction to expect per pixel (the paper's section 5).

use rayon::prelude::*;
use stack::{Image, SampleCounts, Size};

/// What a reconstruction says about its own error, and what it was made from.
#[derive(Clone, Copy, Debug)]
pub struct ErrorEstimate<'a> {
    /// Estimated mean squared error (eq. 7), mean over RGB, one value per pixel.
    pub mse: &'a [f32],
    /// The reconstruction α̂, three channels.
    pub picture: &'a Image,
    /// Rank k of the reduced feature space, one value per pixel; `None` where the error falls as 1/n.
    pub rank: Option<&'a [f32]>,
    /// Samples taken so far.
    pub counts: &'a SampleCounts,
}

/// Mean squared error of pixel `index` relative to its squared luminance (mean over RGB): MSE/(α̂² + ε).
pub fn relative_error(mse: &[f32], picture: &Image, epsilon: f32, index: usize) -> f64 {
    let luminance = f64::from(picture.mean_at(index));
    f64::from(mse[index]) / (luminance * luminance + f64::from(epsilon))
}

/// ΔrMSE per pixel: MSE·n^(−4/(k+4)) relative to α̂² + `epsilon`, n the samples taken (at least 1). Finite and ≥ 0: what
/// is not finite counts as the largest finite one.
pub fn expected_reduction(estimate: &ErrorEstimate, epsilon: f32) -> Vec<f64> {
    let reduction = |i: usize| {
        let n = f64::from(estimate.counts.total[i].max(1));
        let rank = estimate.rank.map_or(0.0, |rank| f64::from(rank[i].max(0.0)));
        let exponent = -4.0 / (rank + 4.0);
        relative_error(estimate.mse, estimate.picture, epsilon, i) * n.powf(exponent)
    };
    let mut reductions: Vec<f64> = (0..estimate.mse.len()).into_par_iter().map(reduction).collect();
    replace_non_finite(&mut reductions);
    reductions.iter_mut().for_each(|r| *r = r.max(0.0));
    reductions
}

/// Gives every value that is not finite the largest finite one, or 1 when none is.
pub fn replace_non_finite(values: &mut [f64]) {
    let largest = values.iter().copied().filter(|v| v.is_finite()).reduce(f64::max).unwrap_or(1.0);
    values.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = largest);
}

/// Smooths `times` by the 3×3 binomial kernel.
pub fn smoothed(values: Vec<f64>, size: Size, times: u32) -> Vec<f64> {
    (0..times).fold(values, |values, _| smooth(&values, size))
}

/// Smooths by the 3×3 binomial kernel (1 2 1)/4 in both directions, a Gaussian of σ ≈ 0.7 pixels. At the borders the part
/// inside the image counts for all.
fn smooth(values: &[f64], size: Size) -> Vec<f64> {
    let across: Vec<f64> = (0..values.len())
        .into_par_iter()
        .map(|i| {
            let x = i % size.width;
            let left = (x > 0).then(|| values[i - 1]);
            let right = (x + 1 < size.width).then(|| values[i + 1]);
            binomial(left, values[i], right)
        })
        .collect();
    (0..values.len())
        .into_par_iter()
        .map(|i| {
            let above = i.checked_sub(size.width).map(|j| across[j]);
            binomial(above, across[i], across.get(i + size.width).copied())
        })
        .collect()
}

fn binomial(before: Option<f64>, here: f64, after: Option<f64>) -> f64 {
    let sides: f64 = before.iter().chain(&after).sum();
    let weight = 2.0 + before.iter().chain(&after).count() as f64;
    (2.0 * here + sides) / weight
}

/// Cuts values off at their `quantile` (0 … 1): a few outliers must not take all samples.
pub fn cap_at_quantile(values: &mut [f64], quantile: f64) {
    if values.is_empty() {
        return;
    }
    let rank = (quantile * values.len() as f64).ceil() as usize;
    let mut ordered = values.to_vec();
    let (_, cap, _) = ordered.select_nth_unstable_by(rank.clamp(1, values.len()) - 1, f64::total_cmp);
    values.iter_mut().for_each(|v| *v = v.min(*cap));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reduction_follows_the_formula() {
        let picture = Image::from_channels(Size::new(3, 1), vec![vec![2.0, 0.0, 1.0]; 3]);
        let mut counts = SampleCounts::uniform(3, vec![16]);
        counts.total[1] = 0;
        let estimate = ErrorEstimate {
            mse: &[0.5, 0.002, f32::NAN],
            picture: &picture,
            rank: Some(&[0.0, 4.0, 2.0]),
            counts: &counts,
        };
        let reductions = expected_reduction(&estimate, 0.001);
        assert!((reductions[0] - 0.5 / 4.001 / 16.0).abs() < 1e-8, "k = 0: n⁻¹");
        assert!((reductions[1] - 2.0).abs() < 1e-6, "without samples n counts as 1");
        assert_eq!(reductions[2], reductions[1], "the largest finite one");
        let of_rank_4 = ErrorEstimate { rank: Some(&[4.0; 3]), ..estimate };
        assert!((expected_reduction(&of_rank_4, 0.001)[0] - 0.5 / 4.001 / 4.0).abs() < 1e-8, "k = 4: n^(−½)");
    }

    #[test]
    fn smoothing_spreads_an_impulse_and_keeps_a_constant() {
        let size = Size::new(4, 3);
        let mut impulse = vec![0.0; 12];
        impulse[size.index(1, 1)] = 16.0;
        let smooth_impulse = smooth(&impulse, size);
        assert_eq!(smooth_impulse[size.index(1, 1)], 4.0);
        assert_eq!(smooth_impulse[size.index(2, 1)], 2.0);
        assert_eq!(smooth_impulse[size.index(3, 1)], 0.0);
        assert_eq!(smooth_impulse[size.index(2, 2)], 2.0 * 2.0 / 3.0, "one row of the kernel is outside");
        assert_eq!(smooth(&[3.0; 12], size), [3.0; 12]);
        assert_eq!(smooth(&[3.0], Size::new(1, 1)), [3.0]);
    }

    #[test]
    fn the_cap_is_the_quantile() {
        let mut values: Vec<f64> = (0..100).rev().map(f64::from).collect();
        cap_at_quantile(&mut values, 0.95);
        assert_eq!(values[..6], [94.0; 6]);
        assert_eq!(values[6..8], [93.0, 92.0]);
        let mut single = [7.0];
        cap_at_quantile(&mut single, 0.0);
        assert_eq!(single, [7.0]);
    }
}
