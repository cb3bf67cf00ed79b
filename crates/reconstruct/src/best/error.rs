//! The picture's own estimate of its squared error.

use stack::Image;

use super::edge_avoiding::EdgeAvoidingKernel;
use super::halves::luminance;
use super::settings::ErrorSettings;
use crate::box_filter::box_mean;
use crate::per_pixel::plane;

/// Dilations of the kernel, one after the other.
const DILATIONS: [usize; 2] = [1, 2];

/// Estimated squared error of `picture`, the mean of the `halves` plus spread events of the given variance; mean over RGB.
///
/// Two terms, each smoothed by `kernel` relative to the squared luminance around it, so that bright pixels do not lend
/// their error to dark ones: a multiple of (A − B)²/4 between the halves, which is the variance of their mean, and a
/// multiple of the events' variance. The multiples stand for what the halves share, weights and bias.
pub fn estimated_error(
    halves: &[Image; 2],
    events: &[f32],
    picture: &Image,
    kernel: &EdgeAvoidingKernel,
    settings: &ErrorSettings,
) -> Vec<f32> {
    let around = box_mean(&luminance(picture), picture.size(), 1);
    let scale = |pixel: usize| around[pixel] * around[pixel] + 1e-3;
    let between = variance_of_mean(halves);
    let relative = |pixel: usize| (settings.halves * between[pixel] + settings.events * events[pixel]) / scale(pixel);
    let mut error = vec![plane(picture.pixels(), relative)];
    for dilation in DILATIONS {
        error = kernel.smooth(&error, dilation);
    }
    plane(picture.pixels(), |pixel| error[0][pixel] * scale(pixel))
}

/// (A − B)²/4, mean over RGB.
fn variance_of_mean([a, b]: &[Image; 2]) -> Vec<f32> {
    let square = |pixel: usize| {
        let (a, b) = (a.rgb(pixel), b.rgb(pixel));
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>() / 12.0
    };
    plane(a.pixels(), square)
}

/// Share of the noise around it that a pixel is given which saw none itself.
const UNSEEN: f32 = 0.001;

/// Gives pixels that saw no noise in directly seen light a little of that within 3×3 pixels: beside the edge of a lamp a
/// pixel may be an edge too that no sample hit. That is rare, and far too much of the error lies in the few where it is
/// so: the share ranks such pixels above their surroundings without drowning those in what is not there.
pub fn share_unseen(mse: &mut [f32], variance: &Image) {
    let noise = luminance(variance);
    let around = box_mean(&noise, variance.size(), 1);
    for ((mse, noise), around) in mse.iter_mut().zip(noise).zip(around) {
        if noise == 0.0 {
            *mse += UNSEEN * around;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use stack::Size;

    const SIZE: Size = Size::new(64, 64);

    fn image(noise: &mut TestNoise, mean: f32, deviation: f32) -> Image {
        Image::from_channels(SIZE, (0..3).map(|_| noise.normals(SIZE.pixels(), mean, deviation)).collect())
    }

    fn average(values: &[f32]) -> f32 {
        values.iter().sum::<f32>() / values.len() as f32
    }

    #[test]
    fn independent_noise_of_the_halves_is_the_error_of_their_mean() {
        let mut noise = TestNoise(5);
        let halves = [image(&mut noise, 1.0, 0.2), image(&mut noise, 1.0, 0.2)];
        let picture = Image::from_channels(SIZE, vec![vec![1.0; SIZE.pixels()]; 3]);
        let kernel = EdgeAvoidingKernel::new(SIZE, Vec::new(), 1.0);
        let settings = ErrorSettings { halves: 1.0, events: 1.0 };
        let found = estimated_error(&halves, &vec![0.0; SIZE.pixels()], &picture, &kernel, &settings);
        let truth: f32 = (0..3)
            .flat_map(|c| halves[0].channels()[c].iter().zip(&halves[1].channels()[c]))
            .map(|(a, b)| (0.5 * (a + b) - 1.0).powi(2))
            .sum::<f32>()
            / (3 * SIZE.pixels()) as f32;
        assert!((average(&found) / truth - 1.0).abs() < 0.1, "{} {truth}", average(&found));
        let with_events = estimated_error(&halves, &vec![0.5; SIZE.pixels()], &picture, &kernel, &settings);
        assert!((average(&with_events) - average(&found) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn bright_pixels_do_not_lend_their_error_to_dark_ones() {
        let mut noise = TestNoise(6);
        let left = |i: usize| i % SIZE.width < 32;
        let halves = [0, 1].map(|_| {
            let mut half = image(&mut noise, 0.0, 1.0);
            for plane in half.channels_mut() {
                plane.iter_mut().enumerate().for_each(|(i, v)| *v *= if left(i) { 10.0 } else { 0.01 });
            }
            half
        });
        let plane: Vec<f32> = (0..SIZE.pixels()).map(|i| if left(i) { 100.0 } else { 0.1 }).collect();
        let picture = Image::from_channels(SIZE, vec![plane; 3]);
        let kernel = EdgeAvoidingKernel::new(SIZE, Vec::new(), 1.0);
        let settings = ErrorSettings { halves: 1.0, events: 1.0 };
        let found = estimated_error(&halves, &vec![0.0; SIZE.pixels()], &picture, &kernel, &settings);
        let dark: Vec<f32> = (0..SIZE.pixels()).filter(|i| i % SIZE.width > 33).map(|i| found[i]).collect();
        assert!(
            average(&dark) < 0.01 * 0.01,
            "variance 0.5e-4, and no more than the kernel's tails: {}",
            average(&dark)
        );
    }

    #[test]
    fn a_pixel_beside_an_edge_ranks_above_those_farther_away() {
        let mut variance = Image::zeros(Size::new(5, 1), 3);
        variance.channels_mut().iter_mut().for_each(|plane| plane[0] = 9.0);
        let mut mse = vec![4.0, 0.0, 0.0, 0.0, 0.0];
        share_unseen(&mut mse, &variance);
        assert_eq!(mse[0], 4.0);
        assert!(mse[1] > 0.0 && mse[1] < 0.01 && mse[2..] == [0.0; 3]);
    }
}
