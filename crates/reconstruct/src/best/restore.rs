//! Light that the regressions lost, given back in proportion to what there is.

use stack::Image;

use super::guided_kernel::GuidedKernel;
use super::settings::RestoreSettings;

/// Brings `picture` to the local energy of the noisy image it was made from, `noisy`: fits that weigh residuals by
/// relative error shade bright pixels. Every value is multiplied by ΣK y / ΣK x over the pixels that `kernel` reaches
/// in some steps, each twice as wide as the one before. A factor, other than a sum, does not let light from bright
/// pixels into dark ones; the limit keeps it from following noise.
pub fn restore_energy(picture: &mut Image, noisy: &Image, kernel: &GuidedKernel, settings: &RestoreSettings) {
    let mut planes: Vec<Vec<f32>> = noisy.channels().iter().chain(picture.channels()).cloned().collect();
    for level in 0..settings.levels {
        planes = kernel.smooth(&planes, 1 << level);
    }
    let (noisy, rebuilt) = planes.split_at(3);
    for (plane, (noisy, rebuilt)) in picture.channels_mut().iter_mut().zip(noisy.iter().zip(rebuilt)) {
        for (value, (y, x)) in plane.iter_mut().zip(noisy.iter().zip(rebuilt)) {
            *value *= (y / x.max(1e-20)).clamp(1.0 / settings.limit, settings.limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scene::{energy, flat, image, two_halves};
    use super::*;
    use stack::Size;

    const SIZE: Size = Size::new(40, 30);

    fn restored(picture: &Image, noisy: &Image) -> Image {
        let mut restored = picture.clone();
        let features = two_halves(SIZE);
        let kernel = GuidedKernel::surfaces_and_brightness(&features, picture, 0.3, 0.2);
        restore_energy(&mut restored, noisy, &kernel, &RestoreSettings { limit: 1.2, ..RestoreSettings::default() });
        restored
    }

    #[test]
    fn a_shaded_bright_part_comes_back_and_the_dark_beside_it_stays() {
        let truth = image(SIZE, |x, _, _| if x < 20 { 5.0 } else { 0.01 });
        let shaded = image(SIZE, |x, _, _| if x < 20 { 4.5 } else { 0.01 });
        let after = restored(&shaded, &truth);
        assert!((energy(&after) / energy(&truth) - 1.0).abs() < 1e-3);
        assert!((after.rgb(SIZE.index(30, 10))[0] / 0.01 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn no_pixel_changes_by_more_than_the_limit() {
        let after = restored(&flat(SIZE, 1.0), &flat(SIZE, 9.0));
        assert!(after.channels().iter().flatten().all(|v| (v - 1.2).abs() < 1e-5));
        let black = restored(&flat(SIZE, 0.0), &flat(SIZE, 9.0));
        assert!(black.channels().iter().flatten().all(|v| *v == 0.0));
    }
}
