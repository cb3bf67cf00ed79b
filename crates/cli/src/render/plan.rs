//! What a render shall do, resolved from flags, the scene's `[render]` table and defaults.

use std::time::Duration;

use anyhow::Result;
use clap::builder::PossibleValue;
use clap::{ArgMatches, ValueEnum};
use stack::{Knobs, Size, Window};
use tracer::scene::{RawRender, nearest_name};

use super::Budget;
use crate::args::RenderArgs;
use crate::failure::usage;
use crate::options::PictureSize;
use crate::settings::{Preset, Settings};

/// Size of a picture when neither flag nor scene says.
const SIZE: Size = Size::new(512, 512);

/// Mean samples per pixel when nothing bounds the work.
const SPP: u32 = 32;

/// A validated render.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Size of the whole film.
    pub size: Size,
    /// The part of it to trace.
    pub window: Window,
    /// When to stop.
    pub budget: Budget,
    /// Whether to reconstruct.
    pub reconstruct: bool,
    /// Where the settings started.
    pub preset: Preset,
    /// Everything else.
    pub settings: Settings,
}

impl Plan {
    /// Resolves flags over the scene's own wishes over defaults.
    ///
    /// # Errors
    /// A value that cannot be read, is out of range, or a crop outside the picture.
    pub fn new(args: &RenderArgs, matches: &ArgMatches, scene: Option<&RawRender>) -> Result<Self> {
        let preset = args.picture.preset.or(scene_preset(scene)?).unwrap_or_default();
        let mut settings = Settings::of(preset);
        let wishes = Wishes::read(scene, &mut settings)?;
        settings.override_by(matches)?;
        let size = args.size.map(|s| s.0).or(wishes.size).unwrap_or(SIZE);
        let window = match args.crop {
            Some(crop) => inside(crop.0, size)?,
            None => Window::whole(size),
        };
        let mut budget = budget(args, wishes.spp)?;
        // What is not reconstructed has no error to go by.
        budget.uniform |= args.no_denoise;
        Ok(Self { size, window, budget, reconstruct: !args.no_denoise, preset, settings })
    }
}

fn inside(crop: Window, size: Size) -> Result<Window> {
    let fits = |start: i32, length: usize, whole: usize| start as usize + length <= whole;
    if fits(crop.x, crop.size.width, size.width) && fits(crop.y, crop.size.height, size.height) {
        return Ok(crop);
    }
    Err(usage(format!("--crop: the rectangle reaches outside the picture of {size}")))
}

fn budget(args: &RenderArgs, scene_spp: Option<u32>) -> Result<Budget> {
    // What a scene says of samples is a default: a time or an error that was asked for takes its place.
    let bounded = args.time.is_some() || args.target_error.is_some();
    let spp = args.spp.or((!bounded).then_some(scene_spp.unwrap_or(SPP)));
    let (first, spp) = args.samples.map_or((0, spp), |slice| (slice.first, Some(slice.count)));
    Ok(Budget {
        first,
        spp,
        time: args.time.unwrap_or(Duration::MAX),
        target_error: args.target_error,
        uniform: args.uniform || args.samples.is_some(),
    })
}

/// Refuses a picture without samples.
fn at_least_one(spp: u32) -> Result<u32, String> {
    if spp == 0 { Err("expected at least 1 sample per pixel, found 0".into()) } else { Ok(spp) }
}

/// The preset that the scene starts from.
fn scene_preset(scene: Option<&RawRender>) -> Result<Option<Preset>> {
    let Some(table) = scene else { return Ok(None) };
    let Some(entry) = table.entries.iter().find(|entry| entry.key == "preset") else { return Ok(None) };
    let known: Vec<_> = Preset::value_variants().iter().filter_map(ValueEnum::to_possible_value).collect();
    let names: Vec<&str> = known.iter().map(PossibleValue::get_name).collect();
    let wrong = || {
        let (file, line, text) = (table.file.display(), entry.line, &entry.text);
        usage(format!("{file}:{line}: preset: expected {}, found '{text}'", names.join(", ")))
    };
    Preset::from_str(&entry.text, false).map(Some).map_err(|_| wrong())
}

/// What the scene's `[render]` table asks for beside settings.
#[derive(Default)]
struct Wishes {
    size: Option<Size>,
    spp: Option<u32>,
}

impl Wishes {
    fn read(scene: Option<&RawRender>, settings: &mut Settings) -> Result<Self> {
        let mut wishes = Self::default();
        let Some(table) = scene else { return Ok(wishes) };
        for entry in &table.entries {
            let place = |message: String| usage(format!("{}:{}: {message}", table.file.display(), entry.line));
            match entry.key.as_str() {
                "size" => wishes.size = Some(entry.text.parse::<PictureSize>().map_err(place)?.0),
                "spp" => {
                    let wrong = || place(format!("expected a whole number, found '{}'", entry.text));
                    wishes.spp = Some(at_least_one(entry.text.parse().map_err(|_| wrong())?).map_err(place)?);
                }
                // Read before all others, which override it.
                "preset" => {}
                key => match settings.set(&key.replace('_', "-"), &entry.text) {
                    Some(outcome) => outcome.map_err(|error| place(error.to_string()))?,
                    None => return Err(place(unknown(key))),
                },
            }
        }
        Ok(wishes)
    }
}

fn unknown(key: &str) -> String {
    let known = Settings::describe().into_iter().map(|knob| knob.flag.replace('-', "_"));
    let known: Vec<String> = known.chain(["size", "spp", "preset"].map(String::from)).collect();
    match nearest_name(key, known.iter().map(String::as_str)) {
        Some(nearest) => format!("unknown key '{key}' in [render]; the nearest known one is '{nearest}'"),
        None => format!("unknown key '{key}' in [render]"),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Task};

    #[test]
    fn a_time_or_an_error_takes_the_place_of_the_samples_a_scene_asks_for() {
        let spp = |flags: &str| {
            let line = ["tamis", "render", "s.obj"].into_iter().chain(flags.split_whitespace());
            let Task::Render(args) = Cli::parse_from(line).command else { panic!("another command") };
            budget(&args, Some(24)).unwrap().spp
        };
        assert_eq!(["", "--spp 3", "--time 5s --spp 3"].map(spp), [Some(24), Some(3), Some(3)]);
        assert_eq!(["--time 5s", "--target-error 1e-3"].map(spp), [None, None]);
    }
}
