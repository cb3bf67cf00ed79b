//! What denoising a stack takes of memory, and how it stays within what there is.

use std::str::FromStr;

use anyhow::Result;
use reconstruct::MethodSettings;
use reconstruct::best::MOST_PARTS;
use stack::file::{Survey, memory_limit};
use stack::{FeatureStack, Size};

use crate::failure::usage;
use crate::large_blocks::KEPT_BLOCK;

// As `peak_bytes` of `tamis denoise --json` told for two megapixels (docs/performance.md); in bytes a pixel but for the first.

/// What the program itself takes, in bytes.
const PROGRAM: f64 = 6e7;

/// Between planes that are no larger than what is kept when it is freed.
const HOLES: f64 = 110.0;

/// Beside the stack while its features are freed of noise, …
const PREPARING: f64 = 100.0;
/// … while it is written again with what was made of it …
const WRITING: f64 = 120.0;
/// … and while a guide is mixed in.
const GUIDED: f64 = 430.0;
/// Once the stack is freed, where the second pass is made of the whole picture at once …
const WHOLE: f64 = 500.0;
/// … and before it, beside what each independent part of the light takes.
const REBUILDING: f64 = 430.0;
const PART: f64 = 21.0;
/// For each pass that is rebuilt beside the picture.
const PASS: f64 = 85.0;
/// In a second pass by bands: what is there of the whole picture …
const KEPT: f64 = 395.0;
/// … and what of the rows that are made at once, which are copied.
const AT_ONCE: f64 = 380.0;
/// Rows around those, about.
const MARGIN: f64 = 96.0;

/// A number of bytes: `800M`, `24G`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bytes {
    number: u64,
    /// As it was given, for messages.
    text: String,
}

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let unit = match &text[digits.len()..].to_ascii_uppercase()[..] {
            "" | "B" => 1.0,
            "K" | "KB" | "KIB" => 1024.0,
            "M" | "MB" | "MIB" => 1024.0 * 1024.0,
            "G" | "GB" | "GIB" => 1024.0 * 1024.0 * 1024.0,
            _ => return Err(EXPECTED.into()),
        };
        match digits.parse::<f64>() {
            Ok(number) if number > 0.0 && number.is_finite() => {
                Ok(Self { number: (number * unit) as u64, text: text.into() })
            }
            _ => Err(EXPECTED.into()),
        }
    }
}

const EXPECTED: &str = "expected a number of bytes, as in 800M or 24G";

/// The most rows of the second pass of `method` that may be made at once, so that a stack is denoised in `limit` bytes, or
/// in three quarters of the machine's memory, with what `then` needs of it. The picture does not depend on it.
///
/// # Errors
/// When a limit was given that cannot be kept.
pub fn rows_at_once(limit: Option<&Bytes>, stack: Need, method: MethodSettings, then: Afterwards) -> Result<usize> {
    if !method.is_collaborative() {
        let told = "--max-memory goes with --preset best and fast: other methods hold all they have at once";
        return if limit.is_some() { Err(usage(told)) } else { Ok(usize::MAX) };
    }
    let most = limit.map(|limit| limit.number as f64).or_else(|| Some(0.75 * physical_memory()? as f64));
    stack.rows(most.unwrap_or(f64::INFINITY), then).map_or_else(
        |least| match limit {
            Some(Bytes { text, .. }) => Err(usage(format!(
                "--max-memory {text}: this stack of {} takes about {} at least",
                stack.size,
                in_words(least)
            ))),
            None => Ok(1),
        },
        Ok,
    )
}

/// What needs the stack when the picture is rebuilt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Afterwards {
    /// It is written again.
    pub output: bool,
    /// A guide is judged by it.
    pub guide: bool,
}

/// A number of bytes that the flag would take.
fn in_words(bytes: f64) -> String {
    let mega = bytes / (1024.0 * 1024.0);
    if mega < 1024.0 { format!("{:.0}M", mega.ceil()) } else { format!("{:.1}G", (mega / 102.4).ceil() / 10.0) }
}

/// What a stack takes, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Need {
    size: Size,
    stack: f64,
    /// See [`FeatureStack::staying_bytes`].
    stays: f64,
    /// The most while it is read.
    reading: f64,
    buckets: usize,
    /// Passes that are rebuilt beside the picture.
    passes: usize,
}

impl From<&FeatureStack> for Need {
    fn from(stack: &FeatureStack) -> Self {
        Self {
            size: stack.size(),
            stack: stack.bytes() as f64,
            stays: stack.staying_bytes() as f64,
            // It is there.
            reading: 0.0,
            buckets: stack.samples.dealing.buckets(),
            passes: 0,
        }
    }
}

impl From<&Survey> for Need {
    fn from(survey: &Survey) -> Self {
        Self {
            size: survey.size,
            stack: survey.bytes as f64,
            stays: survey.staying_bytes as f64,
            reading: survey.reading_bytes as f64,
            buckets: survey.buckets,
            passes: 0,
        }
    }
}

impl Need {
    /// With so many passes rebuilt beside the picture.
    pub fn with_passes(self, passes: usize) -> Self {
        Self { passes, ..self }
    }

    /// The rows for `most` bytes, or the least that is needed.
    fn rows(self, most: f64, then: Afterwards) -> Result<usize, f64> {
        let pixels = self.size.pixels() as f64;
        let holes = if pixels * 4.0 <= KEPT_BLOCK as f64 { HOLES * pixels } else { 0.0 };
        let apart = PROGRAM + holes;
        let most = most - apart;
        let passes = PASS * self.passes as f64;
        // What knows nothing of its noise is taken apart in two.
        let rebuilding = REBUILDING + PART * self.buckets.clamp(2, MOST_PARTS) as f64 + passes;
        let beside = match then {
            Afterwards { guide: true, .. } => GUIDED,
            Afterwards { output: true, .. } => WRITING,
            _ => PREPARING,
        };
        let least = (self.stack + pixels * beside).max(self.stays + pixels * rebuilding).max(self.reading);
        if least > most {
            return Err(least + apart);
        }
        let whole = (WHOLE + passes).max(rebuilding);
        if self.stays + pixels * whole <= most {
            return Ok(usize::MAX);
        }
        let share = ((most - self.stays) / pixels - KEPT - passes) / AT_ONCE;
        Ok((share * self.size.height as f64 - MARGIN).max(1.0) as usize)
    }
}

/// Memory of this machine, or of the container this runs in, where the system tells.
fn physical_memory() -> Option<u64> {
    told_in("/proc/meminfo", "MemTotal:").into_iter().chain(memory_limit()).min()
}

/// Largest memory the process has held, where the system tells.
pub fn peak_bytes() -> Option<u64> {
    told_in("/proc/self/status", "VmHWM:")
}

/// Bytes that the line `key` of one of the system's lists tells, which are in kilobytes.
fn told_in(list: &str, key: &str) -> Option<u64> {
    let list = std::fs::read_to_string(list).ok()?;
    let line = list.lines().find(|line| line.starts_with(key))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_bytes_have_units() {
        let bytes = |text: &str| text.parse::<Bytes>().map(|bytes| bytes.number);
        assert_eq!(bytes("800M"), Ok(800 << 20));
        assert_eq!(bytes("1.5g"), Ok(3 << 29));
        assert_eq!(bytes("77"), Ok(77));
        for wrong in ["", "M", "-1G", "12 parsecs", "0"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn less_memory_cuts_bands_and_then_is_refused() {
        let need =
            Need { size: Size::new(1000, 10_000), stack: 1e7 * 364.0, stays: 0.0, reading: 0.0, buckets: 2, passes: 0 };
        let nothing = Afterwards { output: false, guide: false };
        let rows = |need: Need, bytes_per_pixel: f64, then| need.rows(1e7 * bytes_per_pixel, then);
        assert_eq!(rows(need, 520.0, nothing), Ok(usize::MAX));
        let bands = rows(need, 495.0, nothing).unwrap();
        assert!((1000..5000).contains(&bands), "{bands}");
        assert!(rows(need, 400.0, nothing).unwrap_err() > 1e7 * 450.0);
        // What is written again is not there meanwhile.
        let output = Afterwards { output: true, guide: false };
        assert_eq!(rows(need, 520.0, output), Ok(usize::MAX));
        let more = Need { stack: 1e7 * 592.0, ..need };
        assert!(rows(more, 700.0, nothing).is_ok() && rows(more, 700.0, output).is_err());
        let guided = Afterwards { guide: true, ..output };
        assert!(rows(need, 810.0, guided).is_ok() && rows(need, 780.0, guided).is_err());
        // Smaller planes leave holes.
        let small = Need { size: Size::new(1000, 2000), stack: 2e6 * 364.0, ..need };
        assert_ne!(small.rows(2e6 * 600.0, nothing), Ok(usize::MAX));
        assert_eq!(small.rows(2e6 * 650.0, nothing), Ok(usize::MAX));
        // So does adding slices up.
        let merged = Need { reading: 1e7 * 900.0, ..need };
        assert!(rows(merged, 800.0, output).unwrap_err() > 1e7 * 900.0 && rows(merged, 1000.0, output).is_ok());
        // Passes take more.
        let passes = |passes| rows(need.with_passes(passes), 700.0, output);
        assert_eq!(passes(0), Ok(usize::MAX));
        assert!(passes(3).is_err());
    }
}
