//! How good a picture is, against one or two references.

mod average;
mod energy_ratio;
mod flip;
mod judged;
mod mse;
mod nan_pixels;
mod psnr;
mod rmse;
mod rmse_cross;
mod srgb;
mod ssim;

use serde::Serialize;
use stack::{Fault, Image, Size};

pub use energy_ratio::energy_ratio;
pub use flip::{flip, flip_hdr};
pub use judged::judged_pixels;
pub use mse::mse;
pub use nan_pixels::nan_pixels;
pub use psnr::psnr;
pub use rmse::{rmse, rmse_trimmed};
pub use rmse_cross::{rmse_cross, rmse_cross_trimmed};
pub use ssim::ssim;

/// What a picture is compared with, and how.
#[derive(Clone, Copy, Debug)]
pub struct Reference<'a> {
    /// The reference.
    pub image: &'a Image,
    /// A second one, with independent noise.
    pub second: Option<&'a Image>,
    /// ε of the relative measures; the paper's is 0.001.
    pub epsilon: f32,
    /// One value per pixel; `false` leaves the pixel out.
    pub mask: Option<&'a [bool]>,
}

impl<'a> Reference<'a> {
    /// All pixels against one reference, with the paper's ε.
    pub const fn new(image: &'a Image) -> Self {
        Self { image, second: None, epsilon: 0.001, mask: None }
    }
}

/// All measures of one picture. What cannot be computed is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// Relative mean squared error, the paper's.
    pub rmse: Option<f64>,
    /// The same without the worst 0.1 % of pixels.
    pub rmse_trimmed: Option<f64>,
    /// Relative mean squared error against two references, free of their noise.
    pub rmse_cross: Option<f64>,
    /// The same without the worst 0.1 % of pixels.
    pub rmse_cross_trimmed: Option<f64>,
    /// Mean squared error.
    pub mse: Option<f64>,
    /// Peak signal-to-noise ratio of the displayed pictures, in decibel; infinite when they are equal.
    pub psnr: Option<f64>,
    /// Structural similarity of the displayed pictures' luma.
    pub ssim: Option<f64>,
    /// Mean LDR-FLIP of the displayed pictures, 0 … 1.
    pub flip: Option<f64>,
    /// Mean HDR-FLIP, over exposures that suit the reference, 0 … 1.
    pub flip_hdr: Option<f64>,
    /// Sum of the picture over the sum of the reference.
    pub energy_ratio: Option<f64>,
    /// Pixels that are not finite; in all other measures they count as black.
    pub nan_pixels: u64,
}

/// Two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ComparisonError {
    /// Their sizes differ.
    #[error("{what} is {found} pixels large where the reference is {expected}: compare pictures of one size")]
    Size {
        /// Which of them.
        what: &'static str,
        /// Size of the reference.
        expected: Size,
        /// Its own size.
        found: Size,
    },
    /// One is not a colour picture.
    #[error("{what} has {found} channels where 3 are expected: compare colour pictures")]
    Channels {
        /// Which of them.
        what: &'static str,
        /// How many it has.
        found: usize,
    },
    /// The mask covers another picture.
    #[error("the mask has {found} pixels where the reference has {expected}: give a mask of the same size")]
    Mask {
        /// Pixels of the reference.
        expected: usize,
        /// Pixels of the mask.
        found: usize,
    },
}

impl ComparisonError {
    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        Fault::Input
    }
}

/// Measures `image` against `reference`. Pixels that the mask leaves out, or where a reference is not finite, are not
/// judged.
///
/// # Errors
/// When sizes differ or something is not a picture of three channels.
pub fn compare(image: &Image, reference: &Reference) -> Result<Comparison, ComparisonError> {
    check(image, reference)?;
    let (epsilon, truth) = (reference.epsilon, reference.image);
    let references: Vec<&Image> = std::iter::once(truth).chain(reference.second).collect();
    let pixels = judged_pixels(&references, reference.mask);
    let pair = reference.second.map(|second| [truth, second]);
    Ok(Comparison {
        rmse: rmse(image, truth, &pixels, epsilon),
        rmse_trimmed: rmse_trimmed(image, truth, &pixels, epsilon),
        rmse_cross: pair.and_then(|pair| rmse_cross(image, pair, &pixels, epsilon)),
        rmse_cross_trimmed: pair.and_then(|pair| rmse_cross_trimmed(image, pair, &pixels, epsilon)),
        mse: mse(image, truth, &pixels),
        psnr: psnr(image, truth, &pixels),
        ssim: ssim(image, truth, &pixels),
        flip: flip(image, truth, &pixels),
        flip_hdr: flip_hdr(image, truth, &pixels),
        energy_ratio: energy_ratio(image, truth, &pixels),
        nan_pixels: nan_pixels(image, &pixels),
    })
}

fn check(image: &Image, reference: &Reference) -> Result<(), ComparisonError> {
    let expected = reference.image.size();
    let pictures = [
        ("the picture", Some(image)),
        ("the reference", Some(reference.image)),
        ("the second reference", reference.second),
    ];
    for (what, picture) in pictures {
        let Some(picture) = picture else { continue };
        if picture.size() != expected {
            return Err(ComparisonError::Size { what, expected, found: picture.size() });
        }
        if picture.channels().len() != 3 {
            return Err(ComparisonError::Channels { what, found: picture.channels().len() });
        }
    }
    match reference.mask {
        Some(mask) if mask.len() != expected.pixels() => {
            Err(ComparisonError::Mask { expected: expected.pixels(), found: mask.len() })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(23, 17);

    /// Pictures that differ a little, from whole numbers so that any program can make the same.
    fn picture(k: usize) -> Image {
        let value = |i: usize, c: usize| {
            let base = ((i * 7919 + c * 104_729 + 17) % 1009) as f32 / 400.0;
            let error = (((i * (31 + k) + c * 7 + k) % 13) as f32 - 6.0) / 50.0;
            (base + error).max(0.0)
        };
        let channels = (0..3).map(|c| (0..SIZE.pixels()).map(|i| value(i, c)).collect()).collect();
        Image::from_channels(SIZE, channels)
    }

    /// The figures come from a few lines of numpy in double precision, with SSIM's windows summed one by one.
    #[test]
    fn all_measures_agree_with_numpy() {
        let (image, first, second) = (picture(0), picture(1), picture(2));
        let found = compare(&image, &Reference { second: Some(&second), ..Reference::new(&first) }).unwrap();
        let expected = [
            (found.rmse, 0.323_572_191_772_797_6),
            (found.rmse_trimmed, 0.288_479_241_678_089_75),
            (found.rmse_cross, 0.192_867_453_335_113_57),
            (found.rmse_cross_trimmed, 0.166_078_279_597_368_37),
            (found.mse, 0.012_542_530_318_441_847),
            (found.psnr, 22.205_644_688_383_55),
            (found.ssim, 0.919_321_965_634_666_1),
            (found.energy_ratio, 0.999_812_301_603_790_1),
        ];
        for (found, expected) in expected {
            assert!((found.unwrap() / expected - 1.0).abs() < 1e-9, "{found:?} {expected}");
        }
        assert_eq!(found.nan_pixels, 0);
    }

    /// The figures come from the authors' program, as those in `flip/tests.rs` do.
    #[test]
    fn flip_is_the_authors() {
        let found = compare(&picture(0), &Reference::new(&picture(1))).unwrap();
        assert!((found.flip.unwrap() / 0.084_456_826_9 - 1.0).abs() < 1e-5, "{found:?}");
        assert!((found.flip_hdr.unwrap() / 0.086_486_365 - 1.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn a_mask_leaves_pixels_out_of_every_measure() {
        let reference = picture(1);
        let mut image = reference.clone();
        image.channels_mut()[0][200] = f32::NAN;
        image.channels_mut()[1][201] = 1e6;
        let mask: Vec<bool> = (0..SIZE.pixels()).map(|i| i != 200 && i != 201).collect();
        let found = compare(&image, &Reference { mask: Some(&mask), ..Reference::new(&reference) }).unwrap();
        let same = (Some(0.0), Some(0.0), Some(1.0), Some(f64::INFINITY), 0);
        assert_eq!((found.rmse, found.mse, found.energy_ratio, found.psnr, found.nan_pixels), same);
        assert_eq!((found.flip, found.flip_hdr), (Some(0.0), Some(0.0)));
        let found = compare(&image, &Reference::new(&reference)).unwrap();
        assert_eq!(found.nan_pixels, 1);
        assert!(found.rmse.unwrap() > 1.0 && found.rmse.unwrap().is_finite());
        let nothing = compare(&image, &Reference { mask: Some(&[false; 391]), ..Reference::new(&reference) }).unwrap();
        assert_eq!(nothing, Comparison::default());
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let (image, reference) = (Image::zeros(Size::new(2, 2), 3), Image::zeros(Size::new(2, 3), 3));
        let error = compare(&image, &Reference::new(&reference)).unwrap_err();
        assert!(error.to_string().contains("2x2") && error.to_string().contains("2x3"));
        let grey = Image::zeros(Size::new(2, 2), 1);
        let error = compare(&image, &Reference::new(&grey)).unwrap_err();
        assert_eq!(error, ComparisonError::Channels { what: "the reference", found: 1 });
        let error = compare(&image, &Reference { mask: Some(&[true; 3]), ..Reference::new(&image) }).unwrap_err();
        assert_eq!((error.fault(), error), (Fault::Input, ComparisonError::Mask { expected: 4, found: 3 }));
    }
}
