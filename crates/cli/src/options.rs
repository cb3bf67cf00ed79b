//! Values of flags, read from text and checked.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use stack::{Size, Window};

/// Three numbers: `x,y,z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple(pub [f32; 3]);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = numbers::<f32>(text, ',')?;
        match numbers[..] {
            [x, y, z] if numbers.iter().all(|n| n.is_finite()) => Ok(Self([x, y, z])),
            _ => Err("expected three finite numbers, as in 1,2.5,-3".into()),
        }
    }
}

/// When the shutter opens and closes: `a,b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter(pub [f32; 2]);

impl FromStr for Shutter {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers::<f32>(text, ',')?[..] {
            [open, close] if (0.0..=close).contains(&open) && close <= 1.0 => Ok(Self([open, close])),
            _ => Err("expected two moments in order, from 0 to 1, as in 0.25,0.75".into()),
        }
    }
}

/// A sky: `r,g,b`, or a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same radiance everywhere.
    Constant([f32; 3]),
    /// A latitude-longitude map.
    Map(PathBuf),
}

impl FromStr for Sky {
    type Err = String;

    /// What is made of digits and commas alone is meant as a radiance; all else is a file.
    fn from_str(text: &str) -> Result<Self, String> {
        let numeric = !text.is_empty() && text.chars().all(|c| c.is_ascii_digit() || ",.+-eE ".contains(c));
        if !(numeric && text.contains(',')) {
            return Ok(Self::Map(text.into()));
        }
        let Triple(radiance) = text.parse()?;
        if radiance.iter().any(|c| *c < 0.0) {
            return Err("expected radiances of at least 0".into());
        }
        Ok(Self::Constant(radiance))
    }
}

/// Size of a picture: `WxH`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureSize(pub Size);

/// Longest side of a picture; a row must fit the file format and the memory of a machine.
const LONGEST_SIDE: usize = 1 << 16;

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers::<usize>(text, 'x').as_deref() {
            Ok(&[width, height]) if (1..=LONGEST_SIDE).contains(&width) && (1..=LONGEST_SIDE).contains(&height) => {
                Ok(Self(Size::new(width, height)))
            }
            _ => Err(format!("expected a width and a height from 1 to {LONGEST_SIDE}, as in 640x480")),
        }
    }
}

/// A rectangle of the picture: `x,y,w,h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop(pub Window);

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers::<i32>(text, ',')?[..] {
            [x, y, w, h] if x >= 0 && y >= 0 && w > 0 && h > 0 => {
                Ok(Self(Window { x, y, size: Size::new(w as usize, h as usize) }))
            }
            _ => Err("expected four whole numbers x,y,w,h with x and y from 0, w and h from 1".into()),
        }
    }
}

/// A range of sample numbers: `A..B`, B excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRange {
    pub first: u32,
    pub count: u32,
}

impl FromStr for SampleRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected two whole numbers A..B with A below B".to_string();
        let (a, b) = text.split_once("..").ok_or_else(wrong)?;
        let (first, end): (u32, u32) = (a.parse().map_err(|_| wrong())?, b.parse().map_err(|_| wrong())?);
        if first < end { Ok(Self { first, count: end - first }) } else { Err(wrong()) }
    }
}

/// Where the viewer tev listens by itself.
pub const TEV_ADDRESS: &str = "localhost:14158";

/// A host and a port: `HOST:PORT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address(pub String);

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sound = text.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
        if sound { Ok(Self(text.into())) } else { Err(format!("expected HOST:PORT, as in {TEV_ADDRESS}")) }
    }
}

/// A number that is neither infinite nor NaN.
pub fn finite<T: FromStr + Copy + Into<f64>>(text: &str) -> Result<T, String> {
    let number = text.parse().ok().filter(|number: &T| (*number).into().is_finite());
    number.ok_or_else(|| "expected a finite number".into())
}

/// A finite number of at least 0.
pub fn not_negative<T: FromStr + Copy + Into<f64>>(text: &str) -> Result<T, String> {
    let number = finite(text).ok().filter(|number: &T| (*number).into() >= 0.0);
    number.ok_or_else(|| "expected a finite number of at least 0".into())
}

/// A finite number above 0.
pub fn above_zero(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|number| *number > 0.0).ok_or_else(|| "expected a finite number above 0".into())
}

/// A time with its unit: `90s`, `5m`, `1h`.
pub fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a number and s, m or h, as in 90s".to_string();
    let seconds = match text.chars().last() {
        Some('s') => 1.0,
        Some('m') => 60.0,
        Some('h') => 3600.0,
        _ => return Err(wrong()),
    };
    let number: f64 = text[..text.len() - 1].parse().map_err(|_| wrong())?;
    Duration::try_from_secs_f64(number * seconds).map_err(|_| wrong())
}

fn numbers<T: FromStr>(text: &str, separator: char) -> Result<Vec<T>, String> {
    let number = |part: &str| part.trim().parse().map_err(|_| format!("'{part}' is not a number"));
    text.split(separator).map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_checked() {
        assert_eq!("640x480".parse(), Ok(PictureSize(Size::new(640, 480))));
        for wrong in ["0x10", "10", "10x", "axb", "-3x5", "10x20x30", "70000x1"] {
            assert!(wrong.parse::<PictureSize>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_are_finite() {
        assert_eq!((finite::<f32>("-1.5"), above_zero("1e-3")), (Ok(-1.5), Ok(1e-3)));
        for wrong in ["nan", "inf", "-inf", "1e99", "x", ""] {
            assert!(finite::<f32>(wrong).is_err() && above_zero(wrong).is_err(), "{wrong}");
        }
        assert!(above_zero("0").is_err() && above_zero("-1").is_err());
    }

    #[test]
    fn times_have_units() {
        assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
        for wrong in ["", "s", "5", "-3s", "1e400h", "5 parsecs"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_sky_is_a_radiance_or_a_file() {
        assert_eq!("1,2,.5".parse(), Ok(Sky::Constant([1.0, 2.0, 0.5])));
        for file in ["sky.hdr", "a,b.exr", "1", "../1,2,3.hdr"] {
            assert_eq!(file.parse(), Ok(Sky::Map(file.into())));
        }
        for wrong in ["1,2", "1,2,-3", "1,2,3,4", "1e99,0,0"] {
            assert!(wrong.parse::<Sky>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn triples_and_ranges_are_checked() {
        assert_eq!("-1,2,3.5".parse(), Ok(Triple([-1.0, 2.0, 3.5])));
        assert!("1,2".parse::<Triple>().is_err() && "1,2,nan".parse::<Triple>().is_err());
        assert_eq!("0,.5".parse(), Ok(Shutter([0.0, 0.5])));
        assert!(["1,0", "0,2", "-1,0", "0", "0,nan"].iter().all(|wrong| wrong.parse::<Shutter>().is_err()));
        assert_eq!("4..9".parse(), Ok(SampleRange { first: 4, count: 5 }));
        assert!("9..9".parse::<SampleRange>().is_err() && "9".parse::<SampleRange>().is_err());
    }

    #[test]
    fn addresses_have_a_host_and_a_port() {
        assert!(["localhost:14158", "10.0.0.7:1", "[::1]:80"].iter().all(|text| text.parse::<Address>().is_ok()));
        assert!(
            ["scene.obj", "localhost", ":80", "host:99999", ""].iter().all(|text| text.parse::<Address>().is_err())
        );
    }
}
