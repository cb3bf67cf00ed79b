//! Variances made fit for use: smoothed, and known everywhere.

use rayon::prelude::*;
use stack::{Estimate, GroupCounts, Image, SampleCounts, Size};

use crate::box_filter::{box_mean, fill_unknown};

/// Variance of the mean from the two half-buffers alone, per channel: n_A n_B (A − B)²/n², which is (A − B)²/4 when
/// they are equal (Rousselle et al. 2012, section 5; the paper, section 4.2). `map` is applied to both halves first.
/// NaN where a half is empty. `None` when the noise does not come in buckets.
pub fn half_variance(estimate: &Estimate, counts: &SampleCounts, map: impl Fn(usize, f32) -> f32) -> Option<Image> {
    let [a, b] = estimate.halves(counts)?;
    let counts = counts.grouped(2);
    let shares: Vec<f32> = (0..a.pixels()).map(|pixel| share_of_halves(&counts, pixel)).collect();
    let mut variance = a;
    for (c, (a, b)) in variance.channels_mut().iter_mut().zip(b.channels()).enumerate() {
        for ((a, b), share) in a.iter_mut().zip(b).zip(&shares) {
            *a = share * (map(c, *a) - map(c, *b)).powi(2);
        }
    }
    Some(variance)
}

/// n_A n_B / n² of one pixel; NaN when a half is empty.
fn share_of_halves(counts: &GroupCounts, pixel: usize) -> f32 {
    let [a, b] = [0, 1].map(|half| counts.of(pixel, half) as f32);
    if a > 0.0 && b > 0.0 { a * b / ((a + b) * (a + b)) } else { f32::NAN }
}

/// Smooths every channel over (2·`radius` + 1)² windows. Unknown values (NaN) are left out and then taken from their
/// neighbours. `None` when a channel knows nothing at all. Finite and ≥ 0 when the known values are.
pub fn smoothed(variance: &Image, radius: usize) -> Option<Image> {
    let size = variance.size();
    let channels = variance.channels().iter().map(|channel| {
        let mut smooth = box_mean(channel, size, radius);
        fill_unknown(&mut smooth, size);
        smooth
    });
    let channels: Vec<Vec<f32>> = channels.collect();
    let known = channels.iter().all(|channel| channel.iter().all(|v| !v.is_nan()));
    known.then(|| Image::from_channels(size, channels))
}

/// ½ of each value and ½ of the mean of 3×3 around it, plus `least`: a variance from few buckets is noisy itself.
pub fn steadied(mut variance: Image, least: f32) -> Image {
    let size = variance.size();
    for plane in variance.channels_mut() {
        let smooth = box_mean(plane, size, 1);
        plane.par_iter_mut().zip(&smooth).for_each(|(v, s)| *v = 0.5 * *v + 0.5 * s + least);
    }
    variance
}

/// `variance` without unknown values (NaN): they are taken from their neighbours, or, when nothing at all is known (one
/// sample a pixel), from how much the `mean` differs within 3×3 pixels. The latter takes detail for noise.
pub fn known_everywhere(mut variance: Image, mean: &Image) -> Image {
    let size = variance.size();
    for (channel, mean) in variance.channels_mut().iter_mut().zip(mean.channels()) {
        fill_unknown(channel, size);
        if channel.iter().any(|v| v.is_nan()) {
            *channel = local_spread(mean, size);
        }
    }
    variance
}

/// Unbiased variance of the values in each 3×3 block.
fn local_spread(plane: &[f32], size: Size) -> Vec<f32> {
    let mean = box_mean(plane, size, 1);
    let squares: Vec<f32> = plane.iter().map(|v| v * v).collect();
    let squares = box_mean(&squares, size, 1);
    squares.iter().zip(&mean).map(|(square, mean)| (9.0 / 8.0 * (square - mean * mean)).max(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Dealing;

    fn row(values: &[f32]) -> Image {
        Image::from_channels(Size::new(values.len(), 1), vec![values.to_vec()])
    }

    /// 13, 4 and 1 samples in eight buckets whose values are their numbers.
    fn thirteen_four_one() -> (Estimate, SampleCounts) {
        let dealing = Dealing::Numbered { sequences: 8, buckets: 8 };
        let counts = SampleCounts { first: 0, total: vec![13, 4, 1], dealing };
        (Estimate::from_buckets((0..8).map(|b| row(&[b as f32; 3])).collect(), &counts), counts)
    }

    #[test]
    fn halves_follow_the_closed_form() {
        let (estimate, counts) = thirteen_four_one();
        let variance = half_variance(&estimate, &counts, |_, x| x).unwrap();
        // Even buckets hold 2 2 2 1 samples, odd ones 2 2 1 1.
        let (a, b) = ((2.0 * 2.0 + 2.0 * 4.0 + 6.0) / 7.0, (2.0 + 2.0 * 3.0 + 5.0 + 7.0) / 6.0);
        let expected: f32 = 42.0 / 169.0 * (a - b) * (a - b);
        assert!((variance.channels()[0][0] - expected).abs() < 1e-5);
        assert_eq!(variance.channels()[0][1], 0.25, "(1 − 2)²/4 from the buckets 0 2 | 1 3");
        assert!(variance.channels()[0][2].is_nan());
    }

    #[test]
    fn variance_is_known_everywhere() {
        let mended = known_everywhere(row(&[f32::NAN, 4.0, 2.0, 3.0]), &row(&[0.0; 4]));
        assert_eq!(mended.channels()[0], [4.0, 4.0, 2.0, 3.0]);
        let guessed = known_everywhere(row(&[f32::NAN; 4]), &row(&[1.0, 1.0, 4.0, 4.0]));
        assert_eq!(guessed.channels()[0][0], 0.0);
        assert!((guessed.channels()[0][1] - 9.0 / 8.0 * 2.0).abs() < 1e-5, "values 1 1 4 have a variance of 2");
    }

    #[test]
    fn smoothing_fills_what_is_unknown() {
        let variance = row(&[f32::NAN, 4.0, 2.0, f32::NAN, f32::NAN, f32::NAN]);
        let smooth = smoothed(&variance, 1).unwrap();
        assert_eq!(smooth.channels()[0][..4], [4.0, 3.0, 3.0, 2.0]);
        assert!(smooth.channels()[0].iter().all(|v| *v >= 2.0 && *v <= 4.0));
        assert!(smoothed(&row(&[f32::NAN; 3]), 1).is_none());
    }
}
