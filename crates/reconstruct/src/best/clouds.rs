//! Clouds taken off: noise that is wider than any window of the regressions. On large smooth surfaces it is what one sees.

use stack::{Cancelled, Image, Monitor};

use super::cascade::{Parts, Scrutiny, add_significant_residual, relative_to};
use super::edge_avoiding::Taps;
use super::settings::CloudSettings;

/// The `mean` of both `halves` of a picture without wide differences that only one of them shows; `taps` are those of a
/// kernel, so many pixels apart. Reports the stage `cascade`.
///
/// # Errors
/// When `monitor` cancels.
pub fn without_clouds(
    mean: Image,
    halves: &[Image; 2],
    taps: impl FnMut(usize) -> Taps,
    settings: &CloudSettings,
    monitor: &dyn Monitor,
) -> Result<Image, Cancelled> {
    let CloudSettings { levels, trusted, significance, gain } = *settings;
    if levels == 0 {
        return Ok(mean);
    }
    let scrutiny = Scrutiny { levels, trusted, significance, gain };
    let (mut clear, relative) = (Image::zeros(mean.size(), 3), relative_to(&mean));
    drop(mean);
    add_significant_residual(&mut clear, Parts::halves(halves), relative, taps, scrutiny, monitor)?;
    Ok(clear)
}

#[cfg(test)]
mod tests {
    use stack::{Silent, Size};

    use super::super::edge_avoiding::EdgeAvoidingKernel;
    use super::super::halves::mean_of;
    use super::super::test_scene::{error, flat, image, two_halves};
    use super::*;
    use crate::box_filter::box_mean;
    use crate::test_noise::TestNoise;

    const SIZE: Size = Size::new(96, 80);

    /// Noise as wide as what a window leaves, of the given deviation.
    fn cloudy(clean: &Image, deviation: f32, noise: &mut TestNoise) -> Image {
        let white = noise.normals(SIZE.pixels(), 0.0, 15.0 * deviation);
        let wide = box_mean(&box_mean(&white, SIZE, 7), SIZE, 3);
        image(SIZE, |x, y, c| clean.rgb(SIZE.index(x, y))[c] + wide[SIZE.index(x, y)])
    }

    fn clear(halves: &[Image; 2], settings: &CloudSettings) -> Image {
        let (features, mean) = (two_halves(SIZE), mean_of(halves));
        let kernel = EdgeAvoidingKernel::on_surfaces_of_like_brightness(&features, &mean, 0.3, 0.3);
        without_clouds(mean.clone(), halves, |step| kernel.taps(step), settings, &Silent).unwrap()
    }

    fn errors(clean: &Image) -> [f32; 2] {
        let mut noise = TestNoise(31);
        let halves = [(); 2].map(|()| cloudy(clean, 0.05, &mut noise));
        let clear = clear(&halves, &CloudSettings::default());
        [error(&mean_of(&halves), clean), error(&clear, clean)]
    }

    #[test]
    fn clouds_on_a_wall_go() {
        let [before, after] = errors(&flat(SIZE, 1.0));
        assert!(after < 0.5 * before, "{after} of {before}");
    }

    #[test]
    fn shadows_that_no_feature_tells_stay() {
        let shadow = |x: usize, y: usize| (x.abs_diff(24).pow(2) + y.abs_diff(40).pow(2)) < 144;
        let [before, after] = errors(&image(SIZE, |x, y, _| if shadow(x, y) { 0.4 } else { 1.0 }));
        assert!(after < before, "{after} of {before}");
    }

    #[test]
    fn without_levels_nothing_changes() {
        let halves = [flat(SIZE, 1.0), image(SIZE, |x, _, _| x as f32)];
        let off = CloudSettings { levels: 0, ..CloudSettings::default() };
        assert_eq!(clear(&halves, &off), mean_of(&halves));
    }
}
