//! Features brought to [−1, 1], with their noise, and mended where they are not numbers (the paper's section 6).

use stack::{Feature, FeatureRole, Image, Noise, SampleCounts};

use super::VarianceSource;
use crate::box_filter::fill_unknown;
use crate::per_pixel::plane;
use crate::variance::half_variance;

/// Distances from here on mean that nothing was hit: some renderers write 10¹⁰ or more there.
const NOWHERE: f32 = 1e9;

/// The map of one feature to [−1, 1]: v ↦ (v − centre)·scale, cut off at both ends. Infinite values, which stand for
/// misses, end up at the ends, too.
#[derive(Clone, Debug, PartialEq)]
struct Normalisation {
    /// Per channel.
    centre: Vec<f32>,
    scale: f32,
}

impl Normalisation {
    /// The map for `feature`. Positions and depths fill the box of their own finite values; one scale serves all three
    /// axes, so that distances keep their proportions. The others have ranges of their own.
    fn of(feature: &Feature) -> Self {
        let channels = feature.estimate.mean.channels();
        match feature.role {
            FeatureRole::Albedo | FeatureRole::Visibility | FeatureRole::Proximity | FeatureRole::Lit => {
                Self { centre: vec![0.5; channels.len()], scale: 2.0 }
            }
            FeatureRole::Normal => Self { centre: vec![0.0; channels.len()], scale: 1.0 },
            FeatureRole::Position | FeatureRole::Depth => {
                let extents: Vec<(f32, f32)> = channels.iter().map(|channel| extent(channel)).collect();
                let longest = extents.iter().map(|(low, high)| high - low).fold(0.0, f32::max);
                let centre = extents.iter().map(|(low, high)| 0.5 * (low + high)).collect();
                Self { centre, scale: if longest > 0.0 { 2.0 / longest } else { 0.0 } }
            }
        }
    }

    fn apply(&self, channel: usize, value: f32) -> f32 {
        self.within(1.0, channel, value)
    }

    /// The mapped value cut to ±`limit`.
    fn within(&self, limit: f32, channel: usize, value: f32) -> f32 {
        ((value - self.centre[channel]) * self.scale).clamp(-limit, limit)
    }
}

/// Least and greatest of the values that are positions of something; (0, 0) when there are none.
fn extent(values: &[f32]) -> (f32, f32) {
    let near = values.iter().copied().filter(|v| v.abs() < NOWHERE);
    let (low, high) = near.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// A feature in [−1, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct NormalisedFeature {
    /// One plane per channel, nothing in them NaN.
    pub planes: Vec<Vec<f32>>,
    /// Variance of the mean on the same scale, NaN where it is unknown; `None` where nothing is known.
    pub variance: Option<Image>,
}

/// Maps `feature` to [−1, 1], and its noise by the same map. A value that is not a number is taken from its neighbours.
pub fn normalised(feature: &Feature, counts: &SampleCounts, source: VarianceSource) -> NormalisedFeature {
    let map = Normalisation::of(feature);
    let mean = &feature.estimate.mean;
    let planes = mean.channels().iter().enumerate().map(|(c, channel)| {
        let mut plane = plane(channel.len(), |pixel| map.apply(c, channel[pixel]));
        fill_unknown(&mut plane, mean.size());
        plane.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
        plane
    });
    NormalisedFeature { planes: planes.collect(), variance: normalised_variance(feature, counts, source, &map) }
}

/// Both halves of `feature` mapped like its mean, see [`normalised`]; where one holds no sample, it has the mean's value.
/// `None` when it does not come in buckets.
pub fn normalised_halves(feature: &Feature, counts: &SampleCounts) -> Option<[Vec<Vec<f32>>; 2]> {
    let (map, halves) = (Normalisation::of(feature), feature.estimate.halves(counts)?);
    let (limit, counts) = (partial_limit(feature.role), counts.grouped(2));
    let planes = |half: usize| {
        let channels = halves[half].channels().iter().zip(feature.estimate.mean.channels()).enumerate();
        let mapped = channels.map(|(c, (part, mean))| {
            let filled = |pixel: usize| if counts.of(pixel, half) > 0 { part[pixel] } else { mean[pixel] };
            let mut plane = plane(mean.len(), |pixel| map.within(limit, c, filled(pixel)));
            fill_unknown(&mut plane, feature.estimate.mean.size());
            plane.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
            plane
        });
        mapped.collect()
    };
    Some([planes(0), planes(1)])
}

fn normalised_variance(
    feature: &Feature,
    counts: &SampleCounts,
    source: VarianceSource,
    map: &Normalisation,
) -> Option<Image> {
    let apply = |channel, value| map.within(partial_limit(feature.role), channel, value);
    match (&feature.estimate.noise, source) {
        (Noise::Unknown, _) => None,
        (Noise::VarianceOfMean(variance), _) => Some(scaled_variance(variance, map.scale)),
        (Noise::Buckets(_), VarianceSource::Halves) => half_variance(&feature.estimate, counts, apply),
        (Noise::Buckets(_), VarianceSource::Buckets) => feature.estimate.bucket_variance(counts, apply),
    }
}

/// How far from 0 the mapped mean of *some* of a pixel's samples may lie. The box of positions is that of whole means:
/// parts reach beyond it, and cutting them off there would hide noise.
fn partial_limit(role: FeatureRole) -> f32 {
    match role {
        FeatureRole::Position | FeatureRole::Depth => 3.0,
        _ => 1.0,
    }
}

/// The variance of values multiplied by `scale`, and cut to [−1, 1], where no variance exceeds 1.
fn scaled_variance(variance: &Image, scale: f32) -> Image {
    let rescale = |v: &f32| if v.is_finite() { (v * scale * scale).clamp(0.0, 1.0) } else { f32::NAN };
    let channels = variance.channels().iter().map(|channel| channel.iter().map(rescale).collect());
    Image::from_channels(variance.size(), channels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::{Estimate, Size};

    fn row(role: FeatureRole, channels: &[&[f32]], noise: Noise) -> Feature {
        let size = Size::new(channels[0].len(), 1);
        let mean = Image::from_channels(size, channels.iter().map(|c| c.to_vec()).collect());
        Feature { role, estimate: Estimate { mean, noise } }
    }

    fn planes(feature: &Feature) -> Vec<Vec<f32>> {
        normalised(feature, &SampleCounts::uniform(4, vec![1]), VarianceSource::Halves).planes
    }

    #[test]
    fn positions_fill_the_box_of_their_finite_values_and_keep_their_proportions() {
        let x: &[f32] = &[10.0, 30.0, f32::INFINITY, 20.0];
        let y: &[f32] = &[0.0, 5.0, 1e10, f32::NEG_INFINITY];
        let position = row(FeatureRole::Position, &[x, y, &[7.0; 4]], Noise::Unknown);
        assert_eq!(planes(&position), [[-1.0, 1.0, 1.0, 0.0], [-0.25, 0.25, 1.0, -1.0], [0.0; 4]]);
    }

    #[test]
    fn features_with_a_range_of_their_own_use_all_of_it() {
        let values: &[f32] = &[0.0, 0.25, 1.0, 86.0];
        let albedo = row(FeatureRole::Albedo, &[values; 3], Noise::Unknown);
        assert_eq!(planes(&albedo), [[-1.0, -0.5, 1.0, 1.0]; 3]);
        let normal = row(FeatureRole::Normal, &[values; 3], Noise::Unknown);
        assert_eq!(planes(&normal)[0], [0.0, 0.25, 1.0, 1.0]);
    }

    #[test]
    fn what_is_not_a_number_is_mended() {
        let depth = row(FeatureRole::Depth, &[&[f32::NAN, 2.0, 4.0, f32::NAN]], Noise::Unknown);
        assert_eq!(planes(&depth), [[-1.0, -1.0, 1.0, 1.0]]);
        let lost = row(FeatureRole::Depth, &[&[f32::NAN; 4]], Noise::Unknown);
        assert_eq!(planes(&lost), [[0.0; 4]]);
        let flat = row(FeatureRole::Depth, &[&[3.0, 3.0, f32::INFINITY, 3.0]], Noise::Unknown);
        assert_eq!(planes(&flat), [[0.0; 4]]);
    }

    #[test]
    fn halves_go_through_the_same_map() {
        let half = |v: &[f32]| Image::from_channels(Size::new(2, 1), vec![v.to_vec()]);
        let counts = SampleCounts::uniform(2, vec![1, 1]);
        let buckets = vec![half(&[0.0, 4.0]), half(&[2.0, 6.0])];
        let depth = Feature { role: FeatureRole::Depth, estimate: Estimate::from_buckets(buckets, &counts) };
        // The means 1 and 5 become −1 and 1; halves reach beyond.
        assert_eq!(normalised_halves(&depth, &counts), Some([vec![vec![-1.5, 0.5]], vec![vec![-0.5, 1.5]]]));
        let unknown = Feature { estimate: Estimate { noise: Noise::Unknown, ..depth.estimate }, ..depth };
        assert_eq!(normalised_halves(&unknown, &counts), None);
    }

    #[test]
    fn noise_goes_through_the_same_map() {
        let half = |v: &[f32]| Image::from_channels(Size::new(2, 1), vec![v.to_vec()]);
        let counts = SampleCounts::uniform(2, vec![4, 4]);
        let buckets = vec![half(&[0.25, 50.0]), half(&[0.75, 150.0])];
        let visibility =
            Feature { role: FeatureRole::Visibility, estimate: Estimate::from_buckets(buckets.clone(), &counts) };
        for source in [VarianceSource::Halves, VarianceSource::Buckets] {
            // (2·0.25 − 2·0.75)²/4; both halves of the second pixel are cut off at 1.
            assert_eq!(normalised(&visibility, &counts, source).variance, Some(half(&[0.25, 0.0])));
        }
        // The box is 0.5 … 100, a scale of 2/99.5.
        let depth = Feature { role: FeatureRole::Depth, estimate: Estimate::from_buckets(buckets, &counts) };
        let variance = normalised(&depth, &counts, VarianceSource::Halves).variance.unwrap();
        assert!((variance.channels()[0][0] / (0.25 * (2.0_f32 * 0.5 / 99.5).powi(2)) - 1.0).abs() < 1e-3);

        let variance = Noise::VarianceOfMean(half(&[0.01, f32::NAN]));
        let foreign = row(FeatureRole::Visibility, &[&[0.5, 0.5]], variance);
        let scaled = normalised(&foreign, &counts, VarianceSource::Halves).variance.unwrap();
        assert_eq!(scaled.channels()[0][0], 0.04);
        assert!(scaled.channels()[0][1].is_nan());
    }
}
