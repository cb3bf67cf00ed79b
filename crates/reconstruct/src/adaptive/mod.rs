//! Samples where the estimated error is largest (the paper's section 5).

mod budget;
mod error_map;

use stack::{Image, SampleMap};

use crate::exposure::typical_brightness;

pub use error_map::ErrorEstimate;
use error_map::{cap_at_quantile, expected_reduction, relative_error, replace_non_finite, smoothed};

/// The paper's ε, which keeps errors relative to black finite.
const EPSILON: f32 = 0.001;

stack::knobs! {
    /// How samples are distributed.
    pub struct AdaptiveSettings("adaptive") {
        /// Added to the squared luminance that errors are divided by (section 5): less of it sends more samples into
        /// the dark.
        epsilon: f32 = EPSILON, 1e-8..=1.0;
        /// Brightness, in the geometric mean over blocks of pixels, of the picture that this is meant for: a darker one is
        /// shown brighter, and its shadows are seen. 0 means it for all pictures (section 5).
        exposed: f32 = 0.15, 0.0..=1000.0;
        /// Errors are cut off at this quantile of all pixels (section 5: 0.95), 0 to 1.
        quantile: f32 = 0.99, 0.0..=1.0;
        /// Times the map is smoothed by a 3×3 Gaussian (section 5: once).
        smoothing: u32 = 1, 0..=256;
        /// Times it is smoothed then to give every pixel at least what is wanted around it: by chance an error may seem small
        /// where few samples are, and a wide filter shares them (section 5: 0).
        around: u32 = 16, 0..=256;
        /// Power of the map that samples are proportional to (section 5: 1). The sum of errors that fall as 1/n is least
        /// where n is proportional to the root.
        power: f32 = 1.0, 0.0..=4.0;
        /// Whether all samples taken, not those of one round, shall be proportional to the map; no reduction is expected
        /// then, the map is the error of one sample, MSE·n.
        totals: bool = false, ..;
        /// Share of the samples that every pixel gets alike, 0 to 1.
        alike: f32 = 0.2, 0.0..=1.0;
        /// Most samples a pixel can get in a round, as a multiple of the round's mean (section 5).
        most: f32 = 8.0, 1.0..=1000.0;
    }
}

impl AdaptiveSettings {
    /// The paper's.
    pub const PAPER: Self = Self { quantile: 0.95, exposed: 0.0, around: 0, alike: 0.0, ..Self::DEFAULT };

    /// What is added to the squared luminance of this picture.
    fn epsilon_for(&self, picture: &Image) -> f32 {
        if self.exposed == 0.0 {
            return self.epsilon;
        }
        let darker = |brightness: f64| (brightness as f32 / self.exposed).powi(2);
        self.epsilon * typical_brightness(picture).map_or(1.0, darker)
    }
}

/// Which samples to take next: `budget` of them (all pixels together), distributed by the error reduction to expect,
/// ΔMSE = MSE·n^(−4/(k+4)) relative to α̂² + ε, where α̂ is the luminance, the mean over RGB. The map is smoothed by a 3×3
/// Gaussian, raised to what is wanted around a pixel and cut off at a quantile; samples are proportional to it, but for
/// those that all pixels get alike, rounded up, and handed out from the largest error down until the budget is gone. Every
/// pixel goes on where its samples ended.
///
/// The counts add up to exactly `budget`, unless the picture is empty.
pub fn sample_map(estimate: &ErrorEstimate, budget: u64, settings: &AdaptiveSettings) -> SampleMap {
    let counts = estimate.counts;
    let first = counts.total.iter().map(|n| counts.first + n).collect();
    let size = estimate.picture.size();
    let epsilon = settings.epsilon_for(estimate.picture);
    let map = if settings.totals { error_of_one(estimate, epsilon) } else { expected_reduction(estimate, epsilon) };
    let mut map = smoothed(map, size, settings.smoothing);
    let around = smoothed(map.clone(), size, settings.around);
    map.iter_mut().zip(around).for_each(|(own, around)| *own = own.max(around));
    cap_at_quantile(&mut map, settings.quantile.into());
    map.iter_mut().for_each(|v| *v = v.powf(settings.power.into()));
    mix_alike(&mut map, settings.alike.into());
    if settings.totals {
        map = missing(&map, &counts.total, budget);
    }
    SampleMap { first, count: budget::hand_out(&map, budget, most_per_pixel(budget, map.len(), settings)) }
}

/// Relative error that one sample would leave, where errors fall as 1/n: MSE·n/(α̂² + ε). Finite and ≥ 0.
fn error_of_one(estimate: &ErrorEstimate, epsilon: f32) -> Vec<f64> {
    let counts = &estimate.counts.total;
    let error =
        |i: usize| relative_error(estimate.mse, estimate.picture, epsilon, i).max(0.0) * f64::from(counts[i].max(1));
    let mut errors: Vec<f64> = (0..counts.len()).map(error).collect();
    replace_non_finite(&mut errors);
    errors
}

/// Mixes a map with a constant one of the same mean.
fn mix_alike(map: &mut [f64], share: f64) {
    let mean = map.iter().sum::<f64>() / map.len().max(1) as f64;
    map.iter_mut().for_each(|v| *v = (1.0 - share) * *v + share * mean);
}

/// What pixels lack of totals proportional to `map`, after `taken`, so that `budget` more samples fill them up.
fn missing(map: &[f64], taken: &[u32], budget: u64) -> Vec<f64> {
    let lack = |level: f64| map.iter().zip(taken).map(move |(m, n)| (m * level - f64::from(*n)).max(0.0));
    let sum: f64 = map.iter().sum();
    if sum <= 0.0 {
        return vec![1.0; map.len()];
    }
    let all = budget as f64 + taken.iter().map(|n| f64::from(*n)).sum::<f64>();
    // At this level even pixels without samples lack at most what they deserve, so that the sum of lacks is no less
    // than the budget; at 0 nothing is lacking.
    let (mut low, mut high) = (0.0, all / sum);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if lack(middle).sum::<f64>() < budget as f64 { low = middle } else { high = middle }
    }
    lack(high).collect()
}

/// At most `most` times the round's mean, in whole samples; at least one.
fn most_per_pixel(budget: u64, pixels: usize, settings: &AdaptiveSettings) -> u32 {
    let mean = budget as f64 / pixels.max(1) as f64;
    (f64::from(settings.most) * mean).floor().max(mean.ceil()).max(1.0) as u32
}

/// How many samples the next round may take: the `rounds` that are left share equally what is left of `total` samples
/// after the `taken` ones.
pub fn round_budget(total: u64, taken: u64, rounds: u64) -> u64 {
    total.saturating_sub(taken).div_ceil(rounds.max(1))
}

/// The relative mean squared error the reconstruction believes to have: mean over pixels of MSE/(α̂² + 0.001), α̂ the
/// luminance (mean over RGB). Comparable to the paper's rMSE. What is not finite counts as the largest finite one.
pub fn estimated_rmse(mse: &[f32], picture: &Image) -> f64 {
    let mut errors: Vec<f64> = (0..mse.len()).map(|i| relative_error(mse, picture, EPSILON, i)).collect();
    replace_non_finite(&mut errors);
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use proptest::prelude::*;
    use stack::{SampleCounts, Size};

    fn map_of(mse: &[f32], picture: &Image, counts: &SampleCounts, budget: u64) -> SampleMap {
        let rank = vec![3.0; mse.len()];
        let estimate = ErrorEstimate { mse, picture, rank: Some(&rank), counts };
        sample_map(&estimate, budget, &AdaptiveSettings::PAPER)
    }

    #[test]
    fn uniform_error_gives_a_uniform_map_that_goes_on_where_samples_ended() {
        let picture = Image::from_channels(Size::new(9, 5), vec![vec![0.4; 45]; 3]);
        let counts = SampleCounts { first: 100, ..SampleCounts::uniform(45, vec![4]) };
        for mse in [0.3, 0.0, f32::NAN, f32::INFINITY] {
            let map = map_of(&[mse; 45], &picture, &counts, 45 * 6);
            assert_eq!(map, SampleMap { first: vec![104; 45], count: vec![6; 45] });
        }
    }

    #[test]
    fn totals_become_proportional_to_the_power_of_the_error_of_one_sample() {
        let picture = Image::from_channels(Size::new(2, 1), vec![vec![1.0; 2]; 3]);
        let counts = SampleCounts { total: vec![4, 12], ..SampleCounts::uniform(2, vec![4]) };
        // One sample leaves errors in proportion 1 : 9, so that roots are 1 : 3; what was taken is so already.
        let estimate = ErrorEstimate { mse: &[0.1, 0.3], picture: &picture, rank: None, counts: &counts };
        let settings =
            AdaptiveSettings { totals: true, power: 0.5, smoothing: 0, quantile: 1.0, ..AdaptiveSettings::PAPER };
        assert_eq!(sample_map(&estimate, 16, &settings).count, [4, 12]);
        let lop_sided = SampleCounts { total: vec![10, 2], ..counts.clone() };
        let estimate = ErrorEstimate { mse: &[0.01, 0.45], counts: &lop_sided, ..estimate };
        assert_eq!(sample_map(&estimate, 16, &settings).count, [0, 16], "7 of 28 it has already");
        let alike = AdaptiveSettings { alike: 1.0, ..settings };
        assert_eq!(sample_map(&estimate, 16, &alike).count, [4, 12], "up to 14 each");
    }

    #[test]
    fn samples_go_where_the_error_is_relative_to_brightness() {
        let size = Size::new(20, 20);
        let half = |a: f32, b: f32| (0..400).map(|i| if i % 20 < 10 { a } else { b }).collect::<Vec<_>>();
        let picture = Image::from_channels(size, vec![half(0.1, 1.0); 3]);
        let counts = SampleCounts::uniform(400, vec![4]);
        let map = map_of(&half(0.011, 1.001), &picture, &counts, 4000);
        assert!(map.count.iter().all(|n| *n == 10), "equal relative errors");
        let map = map_of(&half(0.033, 1.001), &picture, &counts, 4000);
        assert_eq!(map.count[45], 15);
        let right: u32 = (0..400).filter(|i| i % 20 >= 10).map(|i| map.count[i]).sum();
        assert!((right as f32 / 1000.0 - 1.0).abs() < 0.1, "a quarter, but for rounding: {right}");
    }

    #[test]
    fn pixels_whose_error_seems_small_get_what_those_around_them_get() {
        let size = Size::new(60, 60);
        let hole = |i: usize| (28..32).contains(&(i % 60)) && (28..32).contains(&(i / 60));
        let peak = size.index(10, 10);
        let error = |i: usize| match i {
            i if i == peak => 8.0,
            i if hole(i) || i / 60 > 20 && i / 60 < 24 || i / 60 > 40 => 0.0,
            _ => 1.0,
        };
        let mse: Vec<f32> = (0..size.pixels()).map(error).collect();
        let picture = Image::from_channels(size, vec![vec![1.0; size.pixels()]; 3]);
        let counts = SampleCounts::uniform(size.pixels(), vec![4]);
        let estimate = ErrorEstimate { mse: &mse, picture: &picture, rank: None, counts: &counts };
        // A third of the pixels wants nothing: rounding takes from those.
        let settings = AdaptiveSettings { quantile: 1.0, alike: 0.0, most: 100.0, ..AdaptiveSettings::DEFAULT };
        let [raised, as_it_is, smoother] = [(1, settings.around), (1, 0), (17, 0)].map(|(smoothing, around)| {
            sample_map(&estimate, 200_000, &AdaptiveSettings { smoothing, around, ..settings }).count
        });
        let middle = size.index(29, 29);
        assert!(raised[middle] > 20 && as_it_is[middle] == 0, "{}", raised[middle]);
        assert!(raised[peak] > 2 * smoother[peak], "{}", raised[peak]);
    }

    #[test]
    fn the_same_scene_in_other_units_gets_the_same_samples() {
        let size = Size::new(32, 32);
        let mut noise = TestNoise(9);
        let light: Vec<f32> = (0..1024).map(|i| 0.003 * (1 + i % 32) as f32).collect();
        let error: Vec<f32> = light.iter().map(|v| (0.1 * v * noise.uniform() as f32).powi(2)).collect();
        let counts = SampleCounts::uniform(1024, vec![4]);
        let map = |units: f32, settings: AdaptiveSettings| {
            let picture = Image::from_channels(size, vec![light.iter().map(|v| v * units).collect(); 3]);
            let mse: Vec<f32> = error.iter().map(|v| v * units * units).collect();
            let estimate = ErrorEstimate { mse: &mse, picture: &picture, rank: None, counts: &counts };
            sample_map(&estimate, 16 * 1024, &settings).count
        };
        assert_eq!(map(1.0, AdaptiveSettings::DEFAULT), map(32.0, AdaptiveSettings::DEFAULT));
        let of_dark = |counts: Vec<u32>| (0..1024).filter(|i| i % 32 < 4).map(|i| counts[i]).sum::<u32>();
        let [of_default, of_paper] = [AdaptiveSettings::DEFAULT, AdaptiveSettings::PAPER].map(|s| of_dark(map(0.1, s)));
        assert!(of_default > 3 * of_paper, "shadows of a dark scene: {of_default} {of_paper}");
    }

    #[test]
    fn the_estimated_error_is_the_mean_of_relative_errors() {
        let picture = Image::from_channels(Size::new(3, 1), vec![vec![0.0, 3.0, 0.0], vec![0.0; 3], vec![0.0; 3]]);
        let error = estimated_rmse(&[0.002, 1.001, f32::NAN], &picture);
        assert!((error - (2.0 + 1.0 + 2.0) / 3.0).abs() < 1e-6);
        assert_eq!(estimated_rmse(&[], &Image::zeros(Size::new(0, 0), 3)), 0.0);
    }

    #[test]
    fn rounds_share_what_is_left_equally_and_use_it_up() {
        let mut taken = 400;
        for rounds in [3, 2, 1] {
            taken += round_budget(1001, taken, rounds);
        }
        assert_eq!(taken, 1001);
        assert_eq!(round_budget(100, 200, 3), 0);
    }

    proptest! {
        #[test]
        fn the_budget_and_the_cap_are_kept(
            seed in any::<u64>(), width in 1_usize..30, height in 1_usize..30, per_pixel in 0.0_f64..20.0,
        ) {
            let pixels = width * height;
            let mut noise = TestNoise(seed);
            let mse: Vec<f32> = (0..pixels).map(|_| match noise.uniform() {
                u if u < 0.02 => f32::NAN,
                u if u < 0.6 => 0.0,
                _ => noise.normal().powi(6) as f32,
            }).collect();
            let channels = (0..3).map(|_| noise.normals(pixels, 0.5, 0.3)).collect();
            let picture = Image::from_channels(Size::new(width, height), channels);
            let counts = SampleCounts::uniform(pixels, vec![4]);
            let budget = (per_pixel * pixels as f64) as u64;
            let map = map_of(&mse, &picture, &counts, budget);
            prop_assert_eq!(map.samples(), budget);
            let most = (8.0 * budget as f64 / pixels as f64).max(1.0);
            prop_assert!(map.count.iter().all(|n| f64::from(*n) <= most));
            prop_assert_eq!(map, map_of(&mse, &picture, &counts, budget));
        }
    }
}
