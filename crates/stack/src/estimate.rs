//! A measured image and what is known about its noise.

use rayon::prelude::*;

use crate::{GroupCounts, Image, SampleCounts};

/// What is known about the noise of an estimate.
#[derive(Clone, Debug, PartialEq)]
pub enum Noise {
    /// Independent partial means of the same picture, two or more. Two of them are the *half-buffers* A and B of the
    /// literature; more derive halves by summing even and odd ones.
    Buckets(Vec<Image>),
    /// Variance of the mean, per channel.
    VarianceOfMean(Image),
    /// Nothing.
    Unknown,
}

/// The mean of a plane's samples, and what is known about its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Mean over all samples of a pixel.
    pub mean: Image,
    /// Its noise.
    pub noise: Noise,
}

impl Estimate {
    /// The estimate that `buckets` (at least one) add up to, weighted by how many samples each holds. One bucket alone
    /// says nothing about noise.
    ///
    /// # Panics
    /// When `buckets` is empty.
    pub fn from_buckets(mut buckets: Vec<Image>, counts: &SampleCounts) -> Self {
        if buckets.len() == 1 {
            return Self { mean: buckets.remove(0), noise: Noise::Unknown };
        }
        Self { mean: weighted_mean(&buckets, counts), noise: Noise::Buckets(buckets) }
    }

    /// What its planes take, in bytes.
    pub fn bytes(&self) -> usize {
        let noise = match &self.noise {
            Noise::Buckets(buckets) => &buckets[..],
            Noise::VarianceOfMean(variance) => std::slice::from_ref(variance),
            Noise::Unknown => &[],
        };
        let planes = noise.iter().chain([&self.mean]).flat_map(Image::channels);
        planes.map(|plane| std::mem::size_of_val(&plane[..])).sum()
    }

    /// Half-buffers A (even buckets) and B (odd ones), when there are buckets. A half without samples holds zeros.
    pub fn halves(&self, counts: &SampleCounts) -> Option<[Image; 2]> {
        let Noise::Buckets(buckets) = &self.noise else { return None };
        Some([0, 1].map(|half| group_mean(buckets, counts, half, 2)))
    }

    /// Buckets `b` with the same `b % groups` made into one, when there are buckets; no more groups than buckets. A group
    /// without samples holds zeros.
    pub fn groups(&self, counts: &SampleCounts, groups: usize) -> Option<Vec<Image>> {
        let Noise::Buckets(buckets) = &self.noise else { return None };
        let groups = groups.clamp(1, buckets.len());
        Some((0..groups).map(|group| group_mean(buckets, counts, group, groups)).collect())
    }

    /// Variance of the mean, per channel, when the noise is known. A pixel with samples in fewer than two buckets has
    /// **unknown** variance, written as NaN.
    pub fn variance_of_mean(&self, counts: &SampleCounts) -> Option<Image> {
        match &self.noise {
            Noise::Buckets(_) => self.bucket_variance(counts, |_, value| value),
            Noise::VarianceOfMean(variance) => Some(variance.clone()),
            Noise::Unknown => None,
        }
    }

    /// Variance of the mean from the spread of all buckets, per channel: Σ n_b (x_b − m)²/((B − 1) n) over the B that hold
    /// n_b samples, after `map` was applied to the values of each channel. For two halves that is n_A n_B (A − B)²/n², and
    /// (A − B)²/4 when they are equal (Rousselle et al. 2012, section 5); more buckets are less noisy. NaN where fewer than
    /// two hold samples. `None` when the noise does not come in buckets.
    pub fn bucket_variance(&self, counts: &SampleCounts, map: impl Fn(usize, f32) -> f32 + Sync) -> Option<Image> {
        let Noise::Buckets(buckets) = &self.noise else { return None };
        let mut variance = Image::zeros(self.mean.size(), self.mean.channels().len());
        let counts = counts.grouped(buckets.len());
        in_pieces(&mut variance, |first, piece| {
            let counts = PieceCounts::new(&counts, 0..buckets.len(), first, piece[0].len());
            for (c, out) in piece.iter_mut().enumerate() {
                counts.spread(|number| &buckets[number].channels()[c][first..], |value| map(c, value), out);
            }
        });
        Some(variance)
    }
}

/// Pixels that one task works on.
const PIECE: usize = 1024;

/// Calls `fill` with every piece of consecutive pixels: the number of its first, and all its channels.
fn in_pieces(image: &mut Image, fill: impl Fn(usize, &mut [&mut [f32]]) + Sync) {
    let mut pieces: Vec<Vec<&mut [f32]>> = Vec::new();
    pieces.resize_with(image.size().pixels().div_ceil(PIECE), Vec::new);
    for plane in image.channels_mut() {
        pieces.iter_mut().zip(plane.chunks_mut(PIECE)).for_each(|(piece, plane)| piece.push(plane));
    }
    pieces.par_iter_mut().enumerate().for_each(|(number, piece)| fill(number * PIECE, piece));
}

/// Sample counts of consecutive pixels.
struct PieceCounts {
    /// For each of the buckets asked for its number, and its samples of every pixel.
    buckets: Vec<(usize, Vec<f32>)>,
    /// Samples of every pixel in them together.
    total: Vec<f32>,
    /// How many of them hold samples of each pixel.
    filled: Vec<f32>,
}

impl PieceCounts {
    /// Those in the buckets `numbers` of `pixels` pixels from number `first` on.
    fn new(counts: &GroupCounts, numbers: impl Iterator<Item = usize>, first: usize, pixels: usize) -> Self {
        let of = |number: usize| (first..first + pixels).map(|pixel| counts.of(pixel, number) as f32).collect();
        let buckets: Vec<(usize, Vec<f32>)> = numbers.map(|number| (number, of(number))).collect();
        let (mut total, mut filled) = (vec![0.0; pixels], vec![0.0; pixels]);
        for (_, counts) in &buckets {
            for ((total, filled), n) in total.iter_mut().zip(&mut filled).zip(counts) {
                *total += n;
                *filled += if *n > 0.0 { 1.0 } else { 0.0 };
            }
        }
        Self { buckets, total, filled }
    }

    /// Mean of the buckets' `values` after `map`, weighted by their counts; zero where none has a sample.
    fn mean<'a>(&self, values: impl Fn(usize) -> &'a [f32], map: impl Fn(f32) -> f32, out: &mut [f32]) {
        for (number, counts) in &self.buckets {
            for ((sum, n), value) in out.iter_mut().zip(counts).zip(values(*number)) {
                // What a bucket without samples holds may be anything.
                *sum += if *n > 0.0 { n * map(*value) } else { 0.0 };
            }
        }
        out.iter_mut().zip(&self.total).for_each(|(sum, n)| *sum = if *n > 0.0 { *sum / n } else { 0.0 });
    }

    /// Variance of the mean of the buckets' `values` after `map`; NaN where fewer than two hold samples.
    fn spread<'a>(&self, values: impl Fn(usize) -> &'a [f32], map: impl Fn(f32) -> f32, out: &mut [f32]) {
        let mut mean = vec![0.0; out.len()];
        self.mean(&values, &map, &mut mean);
        for (number, counts) in &self.buckets {
            for (((sum, mean), n), value) in out.iter_mut().zip(&mean).zip(counts).zip(values(*number)) {
                let difference = map(*value) - mean;
                *sum += if *n > 0.0 { n * (difference * difference) } else { 0.0 };
            }
        }
        for ((out, filled), total) in out.iter_mut().zip(&self.filled).zip(&self.total) {
            *out = if *filled < 2.0 { f32::NAN } else { *out / ((filled - 1.0) * total) };
        }
    }
}

/// Mean of those `buckets` whose `numbers` are given, weighted by their counts; zero where none has a sample.
fn weighted_mean_of(
    buckets: &[Image],
    counts: &SampleCounts,
    numbers: impl Iterator<Item = usize> + Clone + Sync,
) -> Image {
    let mut image = Image::zeros(buckets[0].size(), buckets[0].channels().len());
    let counts = counts.grouped(buckets.len());
    in_pieces(&mut image, |first, piece| {
        let counts = PieceCounts::new(&counts, numbers.clone(), first, piece[0].len());
        for (c, out) in piece.iter_mut().enumerate() {
            counts.mean(|number| &buckets[number].channels()[c][first..], |value| value, out);
        }
    });
    image
}

fn weighted_mean(buckets: &[Image], counts: &SampleCounts) -> Image {
    weighted_mean_of(buckets, counts, 0..buckets.len())
}

fn group_mean(buckets: &[Image], counts: &SampleCounts, group: usize, groups: usize) -> Image {
    weighted_mean_of(buckets, counts, (group..buckets.len()).step_by(groups))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dealing, Size};

    fn flat(value: f32) -> Image {
        Image::from_channels(Size::new(1, 1), vec![vec![value]])
    }

    fn numbered(total: u32) -> SampleCounts {
        SampleCounts { first: 0, total: vec![total], dealing: Dealing::Numbered { sequences: 8, buckets: 8 } }
    }

    #[test]
    fn unequal_halves_follow_the_closed_form() {
        let counts = SampleCounts::uniform(1, vec![3, 1]);
        let estimate = Estimate::from_buckets(vec![flat(2.0), flat(6.0)], &counts);
        assert_eq!(estimate.mean.channels()[0][0], 3.0);
        assert_eq!(estimate.variance_of_mean(&counts).unwrap().channels()[0][0], 3.0 * 16.0 / 16.0);
    }

    #[test]
    fn the_variance_of_buckets_follows_the_formula_and_respects_the_map() {
        let buckets: Vec<Image> = (0..8).map(|bucket| flat(bucket as f32)).collect();
        let estimate = Estimate::from_buckets(buckets.clone(), &numbered(13));
        // Two samples in each of five buckets, one in each of three.
        let mean = 38.0 / 13.0;
        let squares: f32 = (0..8).map(|b| if b < 5 { 2.0 } else { 1.0 } * (b as f32 - mean).powi(2)).sum();
        let variance = estimate.variance_of_mean(&numbered(13)).unwrap();
        assert!((variance.channels()[0][0] - squares / (7.0 * 13.0)).abs() < 1e-5);
        let estimate = Estimate::from_buckets(buckets, &numbered(4));
        let clamped = estimate.bucket_variance(&numbered(4), |_, value| value.min(1.0)).unwrap();
        // Buckets 0 to 3 hold a sample each: 0 1 1 1.
        assert!((clamped.channels()[0][0] - 0.75 / (3.0 * 4.0)).abs() < 1e-6);
    }

    /// Numbers from −1 to 1, of variance ⅓.
    fn uniform(key: u64) -> f32 {
        let mut z = key.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((z ^ (z >> 27)) >> 40) as f32 / 8_388_608.0 - 1.0
    }

    #[test]
    fn adaptive_halves_are_weighed_pixel_by_pixel() {
        let pixels = 20_000;
        let planes: [Vec<u32>; 2] = [7, 5].map(|most| (0..pixels).map(|pixel| 1 + pixel * 31 % most).collect());
        let counts = SampleCounts::per_pixel(planes.to_vec());
        let (mut halves, mut whole) = ([Vec::new(), Vec::new()], Vec::new());
        for pixel in 0..pixels as usize {
            let n = [planes[0][pixel], planes[1][pixel]].map(|n| n as usize);
            let samples: Vec<f32> = (0..n[0] + n[1]).map(|i| 3.0 + uniform((16 * pixel + i) as u64 + 1)).collect();
            let mean = |samples: &[f32]| samples.iter().sum::<f32>() / samples.len() as f32;
            halves[0].push(mean(&samples[..n[0]]));
            halves[1].push(mean(&samples[n[0]..]));
            whole.push(mean(&samples));
        }
        let size = Size::new(pixels as usize, 1);
        let halves = halves.map(|half| Image::from_channels(size, vec![half]));
        let estimate = Estimate::from_buckets(halves.to_vec(), &counts);
        let mean = &estimate.mean.channels()[0];
        assert!(mean.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 1e-5), "what all samples together give");
        let variance = estimate.variance_of_mean(&counts).unwrap();
        // For each pair of counts of its own.
        for (a, b) in [(1, 1), (7, 1), (1, 5), (7, 5), (3, 2)] {
            let these = (0..pixels as usize).filter(|p| planes[0][*p] == a && planes[1][*p] == b);
            let values: Vec<f32> = these.map(|pixel| variance.channels()[0][pixel]).collect();
            let ratio = values.iter().sum::<f32>() / values.len() as f32 * 3.0 * (a + b) as f32;
            assert!((ratio - 1.0).abs() < 0.15, "{a} and {b} samples: {ratio} of the true variance");
        }
    }

    #[test]
    fn one_sample_leaves_the_variance_unknown() {
        let counts = numbered(1);
        let mut buckets = vec![flat(0.0); 8];
        buckets[0] = flat(5.0);
        let estimate = Estimate::from_buckets(buckets, &counts);
        assert_eq!(estimate.mean.channels()[0][0], 5.0);
        assert!(estimate.variance_of_mean(&counts).unwrap().channels()[0][0].is_nan());
    }

    #[test]
    fn thirteen_samples_in_eight_buckets_average_to_the_plain_mean() {
        let counts = numbered(13);
        let values: Vec<f32> = (0..13).map(|i| (i * i) as f32).collect();
        let buckets = (0..8)
            .map(|b| {
                let own: Vec<f32> = values.iter().copied().skip(b).step_by(8).collect();
                flat(own.iter().sum::<f32>() / own.len() as f32)
            })
            .collect();
        let estimate = Estimate::from_buckets(buckets, &counts);
        let mean = values.iter().sum::<f32>() / 13.0;
        assert!((estimate.mean.channels()[0][0] - mean).abs() < 1e-4);
        let [a, b] = estimate.halves(&counts).unwrap();
        let recombined = (7.0 * a.channels()[0][0] + 6.0 * b.channels()[0][0]) / 13.0;
        assert!((recombined - mean).abs() < 1e-4);
    }

    #[test]
    fn empty_buckets_are_left_out() {
        let counts = numbered(4);
        let mut buckets: Vec<Image> = (0..8).map(|b| flat(b as f32)).collect();
        buckets[6] = flat(f32::NAN);
        let estimate = Estimate::from_buckets(buckets, &counts);
        assert_eq!(estimate.mean.channels()[0][0], 1.5);
        let variance = estimate.variance_of_mean(&counts).unwrap().channels()[0][0];
        assert!((variance - 5.0 / 12.0).abs() < 1e-6);
    }
}
