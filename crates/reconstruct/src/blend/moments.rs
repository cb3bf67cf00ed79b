//! Second moments of what sets picture, other picture and noisy picture apart, smoothed.

use stack::{Image, Size};

use super::noisy_picture::NoisyPicture;
use crate::best::edge_avoiding::EdgeAvoidingKernel;
use crate::box_filter::box_mean;
use crate::per_pixel;
use crate::reconstruction::Reconstruction;

/// Moments of a pixel.
const MOMENTS: usize = 12;
/// Scales on which they are smoothed.
pub const LEVELS: usize = 3;

/// Scale of the differences between features that separate surfaces.
const FEATURE_SCALE: f32 = 0.3;
/// Weight of a squared difference in the logarithm of the picture against one in features.
const BRIGHTNESS: f32 = 0.2;
/// Dilations of the kernel, one after the other.
const DILATIONS: [usize; LEVELS] = [1, 2, 4];
/// Weight of noise against error: what noisy pixels say counts less.
const PRECISION: f32 = 6.0;

/// Moments of one pixel or of many, with x the picture, g the other one, y the noisy picture, d = g − x, r = y − x, and ′ for a
/// value less the mean of its four neighbours: variance, d², d r, r², estimated error of x, d′², d′ r′, x′², g′², d times
/// the mean of r over the four neighbours, all weighted and mean over RGB; luminance of x, of g, times the root of the
/// weight.
pub type Moment = [f32; MOMENTS];

/// Moments on every scale.
pub struct Moments {
    /// As they are, the finest first, then smoothed on each scale. Plane by plane.
    scales: Vec<Vec<Vec<f32>>>,
    /// Mean over the picture.
    pub whole: Moment,
    /// Of every pixel as it is, times the root of the weight: luminance of d, of r, of events.
    single: [Vec<f32>; 3],
}

impl Moments {
    /// Those of what was `rebuilt` and the `other` picture.
    pub fn new(noisy: &NoisyPicture, rebuilt: &Reconstruction, other: &Image) -> Self {
        let picture = &rebuilt.picture;
        let weights = weights(picture, &noisy.variance);
        let task = Task { noisy, rebuilt, other, weights: &weights };
        let planes: [Vec<f32>; MOMENTS] = per_pixel::planes(picture.pixels(), |pixel| task.moments(pixel));
        let whole = planes.each_ref().map(|plane| mean(plane));
        let kernel =
            EdgeAvoidingKernel::on_surfaces_of_like_brightness(&noisy.features, picture, FEATURE_SCALE, BRIGHTNESS);
        let mut scales = vec![planes.to_vec()];
        for (finer, dilation) in DILATIONS.into_iter().enumerate() {
            scales.push(kernel.smooth(&scales[finer], dilation));
        }
        Self { scales, whole, single: per_pixel::planes(picture.pixels(), |pixel| task.single(pixel)) }
    }

    /// Pixels.
    pub fn pixels(&self) -> usize {
        self.single[0].len()
    }

    /// Moments of `pixel` on a scale: 0 as they are, 1 to [`LEVELS`] smoothed.
    pub fn at(&self, scale: usize, pixel: usize) -> Moment {
        std::array::from_fn(|moment| self.scales[scale][moment][pixel])
    }

    /// d, r and events of `pixel`, not squared.
    pub fn single(&self, pixel: usize) -> [f32; 3] {
        self.single.each_ref().map(|plane| plane[pixel])
    }
}

/// What a squared difference counts at each pixel: n/(1 + 6 n v), n = 1/(luminance² + 0.01) with the mean over 3×3 pixels,
/// v the variance of the mean.
fn weights(picture: &Image, variance: &Image) -> Vec<f32> {
    let square: Vec<f32> = (0..picture.pixels()).map(|pixel| picture.mean_at(pixel).powi(2)).collect();
    let around = box_mean(&square, picture.size(), 1);
    let weight = |(pixel, square): (usize, &f32)| {
        let relative = 1.0 / (square + 1e-2);
        relative / (1.0 + PRECISION * relative * variance.mean_at(pixel))
    };
    around.iter().enumerate().map(weight).collect()
}

fn mean(plane: &[f32]) -> f32 {
    (plane.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.len().max(1) as f64) as f32
}

struct Task<'a> {
    noisy: &'a NoisyPicture,
    rebuilt: &'a Reconstruction,
    other: &'a Image,
    weights: &'a [f32],
}

impl Task<'_> {
    fn moments(&self, pixel: usize) -> Moment {
        let weight = self.weights[pixel];
        let mut sums = [0.0; MOMENTS];
        for c in 0..3 {
            let of_channel = self.of_channel(c, pixel);
            sums.iter_mut().zip(of_channel).for_each(|(sum, moment)| *sum += weight / 3.0 * moment);
        }
        sums[4] = weight * self.rebuilt.mse[pixel].max(0.0);
        sums[10] = weight.sqrt() * self.rebuilt.picture.mean_at(pixel);
        sums[11] = weight.sqrt() * self.other.mean_at(pixel);
        sums
    }

    fn of_channel(&self, c: usize, pixel: usize) -> Moment {
        let size = self.other.size();
        let [x, g, y, v] = [&self.rebuilt.picture, self.other, &self.noisy.picture, &self.noisy.variance]
            .map(|image| image.channels()[c].as_slice());
        let near = [x, g, y].map(|plane| mean_of_neighbours(plane, size, pixel));
        let (d, r) = (g[pixel] - x[pixel], y[pixel] - x[pixel]);
        let (near_d, near_r) = (near[1] - near[0], near[2] - near[0]);
        let [sharp_x, sharp_g] = [x[pixel] - near[0], g[pixel] - near[1]];
        let (sharp_d, sharp_r) = (d - near_d, r - near_r);
        let [squared_x, squared_g] = [sharp_x, sharp_g].map(|v| v * v);
        let sharp = [sharp_d * sharp_d, sharp_d * sharp_r, squared_x, squared_g];
        let [hd, hn, hx, hg] = sharp;
        [v[pixel], d * d, d * r, r * r, 0.0, hd, hn, hx, hg, d * near_r, 0.0, 0.0]
    }

    fn single(&self, pixel: usize) -> [f32; 3] {
        let root = self.weights[pixel].sqrt();
        let NoisyPicture { picture: noisy, events, .. } = self.noisy;
        let x = self.rebuilt.picture.mean_at(pixel);
        [root * (self.other.mean_at(pixel) - x), root * (noisy.mean_at(pixel) - x), root * events.mean_at(pixel)]
    }
}

/// Mean of the pixels left, right, above and below; beyond the border the pixel itself counts.
fn mean_of_neighbours(plane: &[f32], size: Size, pixel: usize) -> f32 {
    let (x, y) = (pixel % size.width, pixel / size.width);
    let left = plane[pixel - usize::from(x > 0)];
    let right = plane[pixel + usize::from(x + 1 < size.width)];
    let above = plane[if y > 0 { pixel - size.width } else { pixel }];
    let below = plane[if y + 1 < size.height { pixel + size.width } else { pixel }];
    0.25 * (left + right + above + below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_stop_at_the_border() {
        let plane = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        let size = Size::new(3, 2);
        assert_eq!(mean_of_neighbours(&plane, size, 0), 0.25 * (1.0 + 2.0 + 1.0 + 8.0));
        assert_eq!(mean_of_neighbours(&plane, size, 4), 0.25 * (8.0 + 32.0 + 2.0 + 16.0));
        assert_eq!(mean_of_neighbours(&[7.0], Size::new(1, 1), 0), 7.0);
    }

    #[test]
    fn noisy_and_bright_pixels_count_less() {
        let picture = Image::from_channels(Size::new(9, 1), vec![vec![1.0; 9]; 3]);
        let mut variance = Image::zeros(Size::new(9, 1), 3);
        variance.channels_mut().iter_mut().for_each(|plane| plane[8] = 0.5);
        let found = weights(&picture, &variance);
        assert!((found[0] - 1.0 / 1.01).abs() < 1e-6);
        assert!((found[8] - 1.0 / (1.01 + 3.0)).abs() < 1e-6);
    }
}
