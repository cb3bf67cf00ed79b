//! Spike noise taken out before the fit, its energy kept.

use rayon::prelude::*;
use stack::{Image, Size};

use crate::box_filter::box_mean;
use crate::spikes::replace::{replaced, source_of};

/// Radius of the neighbourhood that a spike stands out of.
const RADIUS: usize = 2;

/// A picture without outliers, and their energy.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parted {
    /// Radiance with every outlier replaced by the median of its neighbours.
    pub(crate) colour: Image,
    /// Variance of its mean.
    pub(crate) variance: Image,
    /// The energy taken out, spread evenly over a block.
    pub(crate) energy: Image,
    /// How many outliers there were.
    pub(crate) count: usize,
}

/// Parts `radiance` from its outliers: pixels brighter than the mean of their 5×5 neighbours by `deviations` standard
/// deviations of those, where the pixel's own noise can explain it. What replacing them takes away is spread over
/// (2·`radius` + 1)² pixels, so that the picture keeps its sum.
pub(crate) fn part(radiance: &Image, variance: &Image, deviations: f32, radius: usize) -> Parted {
    let (size, pixels) = (radiance.size(), radiance.pixels());
    let luminance: Vec<f32> = (0..pixels).map(|pixel| radiance.mean_at(pixel)).collect();
    let marked: Vec<bool> = (0..pixels)
        .into_par_iter()
        .map(|pixel| stands_out(pixel, &luminance, size, deviations, variance.mean_at(pixel)))
        .collect();
    let sources: Vec<Option<usize>> = (0..pixels).map(|pixel| source_of(pixel, radiance, &marked)).collect();
    let (colour, variance) = (replaced(radiance, &sources), replaced(variance, &sources));
    let taken = radiance.channels().iter().zip(colour.channels());
    let energy = taken.map(|(before, after)| {
        let taken: Vec<f32> = before.iter().zip(after).map(|(before, after)| before - after).collect();
        spread(&taken, size, radius)
    });
    let energy = Image::from_channels(size, energy.collect());
    Parted { colour, variance, energy, count: marked.iter().filter(|marked| **marked).count() }
}

/// Whether `pixel` is brighter than its neighbours by more than they differ, and by less than four times its own
/// standard deviation.
fn stands_out(pixel: usize, luminance: &[f32], size: Size, deviations: f32, variance: f32) -> bool {
    let (x, y) = (pixel % size.width, pixel / size.width);
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for row in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(size.height) {
        for column in x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(size.width) {
            let other = size.index(column, row);
            if other != pixel {
                sum += luminance[other];
                squares += luminance[other] * luminance[other];
                count += 1.0;
            }
        }
    }
    let mean = sum / f32::max(count, 1.0);
    let deviation = (squares / f32::max(count, 1.0) - mean * mean).max(0.0).sqrt();
    let excess = luminance[pixel] - mean;
    count > 0.0 && excess > deviations * deviation && excess * excess < 16.0 * variance
}

/// Every value spread evenly over the window around its pixel, as far as that lies inside the image.
fn spread(plane: &[f32], size: Size, radius: usize) -> Vec<f32> {
    let reach = |i: usize, length: usize| (i + radius + 1).min(length) - i.saturating_sub(radius);
    let covered = |i: usize| (reach(i % size.width, size.width) * reach(i / size.width, size.height)) as f32;
    let shares: Vec<f32> = plane.iter().enumerate().map(|(i, value)| value / covered(i)).collect();
    let means = box_mean(&shares, size, radius);
    means.iter().enumerate().map(|(i, mean)| mean * covered(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    const SIZE: Size = Size::new(30, 20);

    fn parted(spike: f32, variance: f32) -> (Image, Parted) {
        let mut plane = TestNoise(3).normals(SIZE.pixels(), 1.0, 0.02);
        plane[SIZE.index(2, 17)] = spike;
        let radiance = Image::from_channels(SIZE, vec![plane; 3]);
        let mut noise = vec![4e-4; SIZE.pixels()];
        noise[SIZE.index(2, 17)] = variance;
        let noise = Image::from_channels(SIZE, vec![noise; 3]);
        let parted = part(&radiance, &noise, 5.0, 4);
        (radiance, parted)
    }

    #[test]
    fn a_spike_is_replaced_and_no_energy_is_lost() {
        let (radiance, parted) = parted(90.0, 2500.0);
        assert_eq!(parted.count, 1);
        assert!((parted.colour.channels()[0][SIZE.index(2, 17)] - 1.0).abs() < 0.1);
        let sum = |image: &Image| image.channels()[0].iter().map(|v| f64::from(*v)).sum::<f64>();
        assert!((sum(&parted.colour) + sum(&parted.energy) - sum(&radiance)).abs() < 1e-2);
        assert!(parted.energy.channels()[0][SIZE.index(10, 17)] == 0.0, "it stays within its window");
    }

    #[test]
    fn detail_that_noise_cannot_explain_stays() {
        let (radiance, parted) = parted(3.0, 1e-4);
        assert_eq!((parted.count, parted.colour), (0, radiance));
    }
}
