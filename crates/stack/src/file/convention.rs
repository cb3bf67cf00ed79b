//! Every kind of variance made into the variance of the mean.

use super::role::Convention;
use crate::Image;

/// CIE luminance of linear sRGB.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Why a variance is of no use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Useless {
    /// It is that of a sample, and nobody knows how many there were.
    SamplesUnknown,
    /// Nobody knows what it is a variance of.
    KindUnknown,
}

/// A measure of noise as it stands in a file.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its values.
    pub values: Image,
    /// What they are.
    pub convention: Convention,
    /// Of second moments: the mean they belong to, where it is not the role's own.
    pub mean: Option<Image>,
}

/// Whether `convention` can be made the variance of the mean.
pub fn usable(convention: Convention, spp_known: bool) -> Result<(), Useless> {
    match convention {
        Convention::Unsaid => Err(Useless::KindUnknown),
        Convention::Sample | Convention::SecondMoment if !spp_known => Err(Useless::SamplesUnknown),
        _ => Ok(()),
    }
}

/// Variance of the mean, per channel, of an estimate with `mean`; `total` holds its samples per pixel, where known. What
/// cannot be known (one sample) is NaN.
pub fn of_the_mean(measured: &Measured, mean: &Image, total: Option<&[u32]>) -> Image {
    let n = |pixel: usize| total.map_or(f32::NAN, |total| total[pixel] as f32);
    match measured.convention {
        Convention::Sample => map(&measured.values, |_, pixel, v| v / n(pixel)),
        Convention::StandardError => map(&measured.values, |_, _, v| v * v),
        Convention::SecondMoment => of_second_moment(measured, mean, n),
        Convention::Mean | Convention::HalfDifference | Convention::Unsaid => measured.values.clone(),
    }
}

/// (m₂ − m²)/(n − 1). Moments of CIE XYZ (Mitsuba) say nothing about covariances, so the noise of red, green and blue is
/// taken to be that of luminance Y, in proportion: var(c) = var(Y) (c/Y)².
fn of_second_moment(measured: &Measured, mean: &Image, n: impl Fn(usize) -> f32) -> Image {
    let of = measured.mean.as_ref().unwrap_or(mean);
    let planes = of.channels();
    let own = map(&measured.values, |c, pixel, m2| {
        let spread = (m2 - planes[c][pixel].powi(2)).max(0.0);
        if n(pixel) > 1.0 { spread / (n(pixel) - 1.0) } else { f32::NAN }
    });
    if mean.channels().len() != 3 || same_space(of, mean) {
        return own;
    }
    map(mean, |_, pixel, value| {
        let (y, variance) = (planes[1][pixel], own.channels()[1][pixel]);
        if y > 0.0 { variance * (value / y).powi(2) } else { variance }
    })
}

/// Whether both are the same picture channel by channel, and not one as CIE XYZ of the other.
fn same_space(of: &Image, mean: &Image) -> bool {
    let far = |c: usize, value: &dyn Fn(usize) -> f32| {
        (0..mean.pixels()).map(|pixel| f64::from((of.channels()[c][pixel] - value(pixel)).abs())).sum::<f64>()
    };
    let to_green = far(1, &|pixel| mean.channels()[1][pixel]);
    let to_luminance = far(1, &|pixel| (0..3).map(|c| LUMINANCE[c] * mean.channels()[c][pixel]).sum());
    to_green <= to_luminance
}

fn map(image: &Image, f: impl Fn(usize, usize, f32) -> f32) -> Image {
    let plane = |(c, plane): (usize, &Vec<f32>)| plane.iter().enumerate().map(|(i, v)| f(c, i, *v)).collect();
    Image::from_channels(image.size(), image.channels().iter().enumerate().map(plane).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Size;

    fn flat(values: [f32; 3]) -> Image {
        Image::from_channels(Size::new(1, 1), values.map(|v| vec![v]).to_vec())
    }

    /// Four samples of a pixel; every convention says the same about them.
    #[test]
    fn all_conventions_agree_about_the_same_samples() {
        let samples = [1.0_f32, 2.0, 4.0, 9.0];
        let n = samples.len() as f32;
        let mean = samples.iter().sum::<f32>() / n;
        let moment = samples.iter().map(|x| x * x).sum::<f32>() / n;
        let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / (n - 1.0);
        let expected = variance / n;
        for (convention, value) in [
            (Convention::Sample, variance),
            (Convention::Mean, expected),
            (Convention::SecondMoment, moment),
            (Convention::StandardError, expected.sqrt()),
        ] {
            let measured = Measured { values: flat([value; 3]), convention, mean: None };
            let got = of_the_mean(&measured, &flat([mean; 3]), Some(&[4])).channels()[0][0];
            assert!((got - expected).abs() < 1e-5 * expected, "{convention}: {got} {expected}");
        }
        assert_eq!(usable(Convention::Sample, false), Err(Useless::SamplesUnknown));
        assert_eq!(usable(Convention::Unsaid, true), Err(Useless::KindUnknown));
    }

    #[test]
    fn moments_of_xyz_keep_the_relative_noise_of_luminance() {
        let rgb = [1.0, 2.0, 0.5];
        let xyz = [1.2, LUMINANCE[0] * rgb[0] + LUMINANCE[1] * rgb[1] + LUMINANCE[2] * rgb[2], 0.7];
        let moments = xyz.map(|m| m * m * 1.09);
        let measured = Measured { values: flat(moments), convention: Convention::SecondMoment, mean: Some(flat(xyz)) };
        let got = of_the_mean(&measured, &flat(rgb), Some(&[10]));
        for c in 0..3 {
            let expected = 0.09 * rgb[c] * rgb[c] / 9.0;
            assert!((got.channels()[c][0] - expected).abs() < 1e-4 * expected, "{c}");
        }
    }
}
