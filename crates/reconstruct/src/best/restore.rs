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
