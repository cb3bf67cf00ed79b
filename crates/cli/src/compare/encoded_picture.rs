//! A picture as the page carries it: light beyond white and below black in pictures that any browser can read.
//!
//! A value is a code of 16 bits, the logarithm of its magnitude and a sign. The upper bytes of all codes are one 8-bit
//! picture, the lower bytes another; neither has alpha, with which a browser would multiply. Unlike a shared exponent,
//! a code keeps small channels beside large ones as exact as the relative error needs them.

use anyhow::Result;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use stack::{Image, Size};

/// Steps in which magnitudes double: no value is off by more than 0.07 %.
pub const STEPS_PER_OCTAVE: i32 = 512;

/// Powers of two below white that codes reach, and as many above it.
const OCTAVES: i32 = 32;

/// The sign bit; alone, where it would be a negative zero, it is a value that is not finite.
const NEGATIVE: u16 = 0x8000;

/// Which light the codes stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coding {
    /// Logarithm to base 2 of the magnitude of code 0, which itself stands for black.
    pub lowest: i32,
}

impl Coding {
    /// Codes for pictures that are lifted by `stops` to be seen, whatever their unit of light.
    pub fn around(stops: f32) -> Self {
        Self { lowest: -OCTAVES - stops.round() as i32 }
    }

    fn code(self, value: f32) -> u16 {
        if !value.is_finite() {
            return NEGATIVE;
        }
        let steps = (value.abs().log2() - self.lowest as f32) * STEPS_PER_OCTAVE as f32;
        let magnitude = steps.round().clamp(0.0, f32::from(NEGATIVE - 1)) as u16;
        if value < 0.0 && magnitude > 0 { magnitude | NEGATIVE } else { magnitude }
    }
}

/// A picture in codes.
#[derive(Clone, Debug)]
pub struct EncodedPicture {
    /// Upper bytes, as PNG.
    pub high: Vec<u8>,
    /// Lower bytes, as PNG.
    pub low: Vec<u8>,
    /// Sum of all codes, by which the page sees whether the browser hands them over as they are.
    pub sum: u32,
}

/// Encodes a picture of three channels.
///
/// # Errors
/// When it cannot be written as PNG.
pub fn encode(picture: &Image, coding: Coding) -> Result<EncodedPicture> {
    let codes: Vec<u16> =
        (0..picture.pixels()).flat_map(|pixel| picture.rgb(pixel).map(|value| coding.code(value))).collect();
    let bytes = |part: fn(u16) -> u8| -> Vec<u8> { codes.iter().map(|code| part(*code)).collect() };
    let png = |bytes: Vec<u8>| png(picture.size(), &bytes, ExtendedColorType::Rgb8);
    Ok(EncodedPicture {
        high: png(bytes(|code| (code >> 8) as u8))?,
        low: png(bytes(|code| code as u8))?,
        sum: codes.iter().fold(0, |sum, code| sum.wrapping_add(u32::from(*code))),
    })
}

/// The pixels that are judged, as a PNG: white.
///
/// # Errors
/// When it cannot be written.
pub fn encode_judged(size: Size, judged: &[bool]) -> Result<Vec<u8>> {
    let bytes: Vec<u8> = judged.iter().map(|judged| u8::from(*judged) * 255).collect();
    png(size, &bytes, ExtendedColorType::L8)
}

fn png(size: Size, bytes: &[u8], colour: ExtendedColorType) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Default, FilterType::Adaptive);
    encoder.write_image(bytes, size.width as u32, size.height as u32, colour)?;
    Ok(file)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    fn value(coding: Coding, code: u16) -> f32 {
        let magnitude = code & !NEGATIVE;
        let of = |magnitude: u16| (coding.lowest as f32 + f32::from(magnitude) / STEPS_PER_OCTAVE as f32).exp2();
        match (code & NEGATIVE != 0, magnitude) {
            (false, 0) => 0.0,
            (true, 0) => f32::NAN,
            (false, magnitude) => of(magnitude),
            (true, magnitude) => -of(magnitude),
        }
    }

    /// What a browser makes of the two PNGs.
    pub fn decode(high: &[u8], low: &[u8], coding: Coding) -> Image {
        let bytes = |png: &[u8]| image::load_from_memory_with_format(png, image::ImageFormat::Png).unwrap();
        let (high, low) = (bytes(high), bytes(low));
        assert_eq!((high.color(), low.color()), (image::ColorType::Rgb8, image::ColorType::Rgb8), "no alpha");
        let size = Size::new(high.width() as usize, high.height() as usize);
        let (high, low) = (high.into_rgb8(), low.into_rgb8());
        let codes: Vec<u16> =
            high.iter().zip(low.iter()).map(|(high, low)| u16::from_be_bytes([*high, *low])).collect();
        let plane = |c: usize| codes.iter().skip(c).step_by(3).map(|code| value(coding, *code)).collect();
        Image::from_channels(size, (0..3).map(plane).collect())
    }

    #[test]
    fn what_the_page_decodes_is_the_picture() {
        let size = Size::new(37, 29);
        // Twelve orders of magnitude, the channels far apart, of either sign.
        let value = |i: usize, c: usize| {
            let magnitude = 10_f32.powf(((i * 7919 + c * 104_729) % 1201) as f32 / 100.0 - 6.0);
            if (i + c).is_multiple_of(5) { -magnitude } else { magnitude }
        };
        let planes = (0..3).map(|c| (0..size.pixels()).map(|i| value(i, c)).collect()).collect();
        let mut picture = Image::from_channels(size, planes);
        picture.channels_mut()[0][..4].copy_from_slice(&[0.0, f32::NAN, f32::INFINITY, -0.0]);
        for stops in [-9.7, 0.0, 3.2] {
            let coding = Coding::around(stops);
            let encoded = encode(&picture, coding).unwrap();
            let found = decode(&encoded.high, &encoded.low, coding);
            assert_eq!(found.size(), size);
            assert_eq!(found.channels()[0][0], 0.0);
            assert!(found.channels()[0][1].is_nan() && found.channels()[0][2].is_nan());
            assert_eq!(found.channels()[0][3], 0.0);
            for (found, expected) in found.channels().iter().zip(picture.channels()) {
                for (found, expected) in found.iter().zip(expected).skip(4) {
                    assert!((found / expected - 1.0).abs() < 0.001, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn what_lies_beyond_the_codes_is_black_or_as_bright_as_can_be() {
        let coding = Coding::around(0.0);
        assert_eq!([1e-12, -1e-12, 0.0].map(|value| coding.code(value)), [0, 0, 0]);
        assert_eq!(coding.code(1e18), 0x7fff);
        assert_eq!(coding.code(-1e18), 0xffff);
        assert_eq!(coding.code(f32::NEG_INFINITY), 0x8000);
        assert_eq!(value(coding, coding.code(1.0)), 1.0);
    }

    #[test]
    fn the_sum_is_that_of_all_codes() {
        let picture = Image::from_channels(Size::new(1, 1), vec![vec![1.0], vec![2.0], vec![-1.0]]);
        let expected = 32 * 512 + 33 * 512 + 32 * 512 + 0x8000;
        assert_eq!(encode(&picture, Coding::around(0.0)).unwrap().sum, expected);
    }
}
