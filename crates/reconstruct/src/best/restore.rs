//! Light that the regressions lost, given back in proportion to what there is.

use std::array::from_fn;

use rayon::prelude::*;
use stack::Image;

use super::edge_avoiding::{EdgeAvoidingKernel, Taps};
use super::settings::RestoreSettings;

/// Light that a picture lacks against the noisy halves it was made from, over pixels ever farther away: fits that weigh
/// residuals by relative error shade bright pixels.
pub struct Loss<'a> {
    kernel: &'a EdgeAvoidingKernel<'a>,
    settings: &'a RestoreSettings,
    /// Both halves and the picture, smoothed so many times, each twice as wide as the one before.
    planes: Vec<Vec<f32>>,
    level: usize,
}

impl<'a> Loss<'a> {
    /// That of `picture` against `halves`, among pixels that are alike to `kernel`.
    pub fn new(
        picture: &Image,
        halves: &[Image; 2],
        kernel: &'a EdgeAvoidingKernel,
        settings: &'a RestoreSettings,
    ) -> Self {
        let images = halves.iter().chain([picture]).filter(|_| settings.levels > 0);
        let planes = images.flat_map(|image| image.channels()).cloned().collect();
        Self { kernel, settings, planes, level: 0 }
    }

    /// The kernel's taps `step` pixels apart. Weighing them takes longer than smoothing with them: where these are the next
    /// ones that it needs, it takes a look at them.
    pub fn taps(&mut self, step: usize) -> Taps {
        let taps = self.kernel.taps(step);
        if self.level < self.settings.levels && step == 1 << self.level {
            self.planes = taps.smooth(&self.planes);
            self.level += 1;
        }
        taps
    }

    /// Gives `picture` its light back: every value is multiplied by ΣK y / ΣK x, as far as both halves agree on it. A factor,
    /// other than a sum, does not let light from bright pixels into dark ones; agreement and the limit keep it from following
    /// noise.
    pub fn give_back(mut self, picture: &mut Image) {
        if self.settings.levels == 0 {
            return;
        }
        while self.level < self.settings.levels {
            self.taps(1 << self.level);
        }
        let Self { planes, settings, .. } = self;
        let lacking = |pixel| lacking(from_fn(|plane| planes[plane][pixel]), settings.limit);
        let lacking: Vec<[f32; 3]> = (0..picture.pixels()).into_par_iter().map(lacking).collect();
        for (c, plane) in picture.channels_mut().iter_mut().enumerate() {
            plane.par_iter_mut().zip(&lacking).for_each(|(value, lacking)| *value *= 1.0 + lacking[c]);
        }
    }
}

/// What the picture lacks at a pixel, relative to what it has, for each channel. `smooth` are both halves and the picture.
/// With a and b what either half says and m their mean, a b is m² on average but for noise: what counts is m Σab/Σm².
fn lacking(smooth: [f32; 9], limit: f32) -> [f32; 3] {
    let of_half =
        |half: usize, c: usize| (smooth[3 * half + c] / smooth[6 + c].max(1e-20)).clamp(1.0 / limit, limit) - 1.0;
    let [a, b]: [[f32; 3]; 2] = from_fn(|half| from_fn(|c| of_half(half, c)));
    let mean: [f32; 3] = from_fn(|c| 0.5 * (a[c] + b[c]));
    let agreed: f32 = (0..3).map(|c| a[c] * b[c]).sum();
    let square: f32 = mean.iter().map(|m| m * m).sum();
    let gain = (agreed / (square + 1e-9)).clamp(0.0, 1.0);
    mean.map(|m| gain * m)
}

#[cfg(test)]
mod tests {
    use super::super::test_scene::{energy, flat, image, two_halves};
    use super::*;
    use stack::Size;

    const SIZE: Size = Size::new(40, 30);

    fn restored(picture: &Image, halves: &[Image; 2]) -> Image {
        let mut restored = picture.clone();
        let features = two_halves(SIZE);
        let kernel = EdgeAvoidingKernel::on_surfaces_of_like_brightness(&features, picture, 0.3, 0.2);
        let settings = RestoreSettings { limit: 1.2, ..RestoreSettings::default() };
        Loss::new(picture, halves, &kernel, &settings).give_back(&mut restored);
        restored
    }

    #[test]
    fn a_shaded_bright_part_comes_back_and_the_dark_beside_it_stays() {
        let truth = image(SIZE, |x, _, _| if x < 20 { 5.0 } else { 0.01 });
        let shaded = image(SIZE, |x, _, _| if x < 20 { 4.5 } else { 0.01 });
        let after = restored(&shaded, &[truth.clone(), truth.clone()]);
        assert!((energy(&after) / energy(&truth) - 1.0).abs() < 1e-3);
        assert!((after.rgb(SIZE.index(30, 10))[0] / 0.01 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn no_pixel_changes_by_more_than_the_limit() {
        let after = restored(&flat(SIZE, 1.0), &[9.0, 9.0].map(|v| flat(SIZE, v)));
        assert!(after.channels().iter().flatten().all(|v| (v - 1.2).abs() < 1e-5));
        let black = restored(&flat(SIZE, 0.0), &[9.0, 9.0].map(|v| flat(SIZE, v)));
        assert!(black.channels().iter().flatten().all(|v| *v == 0.0));
    }
    #[test]
    fn what_halves_do_not_agree_on_stays_away() {
        let after = restored(&flat(SIZE, 1.0), &[1.15, 0.85].map(|v| flat(SIZE, v)));
        assert_eq!(after, flat(SIZE, 1.0), "all of it is noise");
        // a = 0.1, b = 0.04, m = 0.07: 0.07 · 0.004/0.0049.
        let after = restored(&flat(SIZE, 1.0), &[1.1, 1.04].map(|v| flat(SIZE, v)));
        let expected = 1.0 + 0.07 * 0.004 / 0.0049;
        assert!(after.channels().iter().flatten().all(|v| (v - expected).abs() < 1e-4));
    }
}
