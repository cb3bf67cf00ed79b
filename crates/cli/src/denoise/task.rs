//! One stack, from its files to what is written.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use clap::ArgMatches;
use reconstruct::{Extras, Reconstruction, reconstruct_freeing};
use serde_json::{Value, json};
use stack::file::{
    FileError, Found, Inputs, Pass, ReadOptions, ReadStack, Role, StackHeader, Survey, read_inputs, survey,
};
use stack::{FeatureStack, GATHERED, INDIRECT, Image, Noise};

use super::empty_pixels::EmptyPixels;
use crate::args::{DenoiseArgs, OutputArgs, RebuildArgs};
use crate::exposure::Lit;
use crate::failure::usage;
use crate::guide::{Followed, Guide};
use crate::memory::{self, Afterwards, Need, rows_at_once};
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::report::{self, done_in, mean_radiance};
use crate::settings::{Preset, Settings};

/// What reads a stack anew.
type ReadAgain<'a> = &'a dyn Fn() -> Result<ReadStack, FileError>;

/// One stack to denoise.
pub struct Task<'a> {
    pub rebuild: &'a RebuildArgs,
    pub matches: &'a ArgMatches,
    pub inputs: Inputs,
    pub output: OutputArgs,
    pub wishes: Wishes<'a>,
}

/// What `denoise` may be asked for beside, and `merge` is not.
#[derive(Clone, Debug, Default)]
pub struct Wishes<'a> {
    /// What their files are, where these do not say.
    pub reading: ReadOptions,
    /// What must be there (`--require`).
    pub require: &'a [String],
    /// Another denoiser's picture, and what the user calls it.
    pub guide: Option<(&'a Path, &'a Path)>,
    /// Layers of light to rebuild, too.
    pub also: &'a [String],
}

impl<'a> Wishes<'a> {
    /// Those of `denoise` but for the guide.
    pub fn of(args: &'a DenoiseArgs) -> Self {
        Self { reading: args.reading.options(), require: &args.require, guide: None, also: &args.also }
    }
}

impl Task<'_> {
    /// Checks the outputs before any work is done.
    ///
    /// # Errors
    /// An unknown format or layer, or a place that cannot be written to.
    pub fn prepare(&self) -> Result<Outputs> {
        Outputs::prepare(&self.output, "denoised")
    }

    /// Reads, reconstructs and writes, and returns what `--json` prints.
    ///
    /// # Errors
    /// When a step fails, or something that is required is not there.
    pub fn run(&self, outputs: &Outputs, progress: &Progress) -> Result<Value> {
        let start = Instant::now();
        let told = survey(&self.inputs, &self.wishes.reading)?;
        refuse_finished(&told)?;
        let settings = resolve(self.rebuild.picture.preset, self.matches, told.header.as_ref(), progress)?;
        let leave_out = unneeded(&settings, outputs);
        let options = ReadOptions { leave_out, ..self.wishes.reading.clone() };
        let then = Afterwards { output: outputs.need_inputs(), guide: self.wishes.guide.is_some() };
        let rows = |need: Need| {
            rows_at_once(
                self.rebuild.max_memory.as_ref(),
                need.with_passes(self.wishes.also.len()),
                settings.method,
                then,
            )
        };
        // What is too large is refused before a pixel is read.
        let told = if options.leave_out.is_empty() { told } else { survey(&self.inputs, &options)? };
        rows(Need::from(&told))?;
        let read_all = || read_inputs(&self.inputs, &options);
        let mut read = read_all()?;
        read.notes.iter().for_each(|note| progress.say(note));
        let loaded = start.elapsed().as_secs_f64();
        require(self.wishes.require, &read)?;
        let guide = self.wishes.guide.map(|names| Guide::read(names, read.stack.size())).transpose()?;
        let header = header_of(&read, &settings);
        let rows = rows(Need::from(&read.stack))?;
        let again: Option<ReadAgain> = if then.output || then.guide { Some(&read_all) } else { None };
        let Rebuilt { mut reconstruction, noisy, lit, empty } =
            self.reconstruct((&mut read.stack, again), &settings, rows, progress)?;
        let mix = |guide: Guide| guide.mix(&read.stack, &mut reconstruction, &settings, progress);
        let followed = guide.map(mix).transpose()?;
        empty.blacken(&mut reconstruction.picture);
        progress.finish();
        let written = Written {
            picture: &reconstruction.picture,
            stack: &read.stack,
            reconstruction: Some(&reconstruction),
            header: &header,
            carried: &read.carried,
        };
        let writing = Instant::now();
        outputs.write(&written, &lit, progress)?;
        let [write, total] = [writing, start].map(|since| since.elapsed().as_secs_f64());
        let seconds = Clock { load: loaded, write, total };
        say_what_was_done(progress, &reconstruction, total);
        // A file of ours records settings, but not where they began.
        let preset = self.rebuild.picture.preset.or(read.header.is_none().then(Preset::default));
        let outcome = Outcome {
            outputs,
            written: &written,
            noisy,
            found: &read.found,
            preset,
            seconds,
            guide: followed.as_ref(),
        };
        Ok(outcome.json(progress))
    }

    /// Rebuilds `stack`, `rows` at once in the second pass. It is freed meanwhile; where something needs it then, it is read
    /// `again`, with the passes that were rebuilt in the place of the noisy ones.
    fn reconstruct(
        &self,
        (stack, again): (&mut FeatureStack, Option<ReadAgain<'_>>),
        settings: &reconstruct::Settings,
        rows: usize,
        progress: &Progress,
    ) -> Result<Rebuilt> {
        let passes = passes(self.wishes.also, stack)?;
        let (images, mended): (Vec<Image>, Vec<usize>) = passes.iter().map(|pass| pass.image(stack)).unzip();
        for (pass, mended) in passes.iter().zip(mended).filter(|(_, mended)| *mended > 0) {
            progress
                .say(&format!("{}: mended {mended} values that are no numbers (median of the neighbours)", pass.name));
        }
        let beauty = stack.beauty();
        let (noisy, lit) = (mean_radiance(&beauty), Lit::of(&beauty));
        let empty = EmptyPixels::of(stack, &beauty, &images);
        drop(beauty);
        let mut reconstruction = reconstruct_freeing(stack, settings, Extras { rows, passes: &images }, progress)?;
        drop(images);
        if let Some(read) = again.filter(|_| settings.method.is_collaborative()) {
            *stack = read_again(read, stack, noisy)?;
        }
        let mut rebuilt = std::mem::take(&mut reconstruction.passes);
        for (pass, lit) in passes.iter().zip(empty.restore_passes(&mut rebuilt)).filter(|(_, lit)| *lit > 0) {
            progress
                .say(&format!("{}: {lit} pixels where the picture is empty keep their light as it came", pass.name));
        }
        passes.iter().zip(rebuilt).for_each(|(pass, rebuilt)| pass.replace(stack, rebuilt));
        Ok(Rebuilt { reconstruction, noisy, lit, empty })
    }
}

/// What a stack was rebuilt to.
struct Rebuilt {
    reconstruction: Reconstruction,
    /// Mean radiance before.
    noisy: f64,
    /// Where there was light before.
    lit: Lit,
    empty: EmptyPixels,
}

/// The stack that `read` reads once more, for what is written of it or judged by it; `before` is as large, and its mean radiance
/// was `noisy`. It takes more memory than all that is rebuilt, so it is freed meanwhile.
fn read_again(read: ReadAgain<'_>, before: &FeatureStack, noisy: f64) -> Result<FeatureStack> {
    let stack = read()?.stack;
    if stack.size() != before.size() || mean_radiance(&stack.beauty()).to_bits() != noisy.to_bits() {
        return Err(usage("the input is no longer what it was when it was denoised: leave it as it is until the end"));
    }
    Ok(stack)
}

/// Refuses a file of ours that holds the picture alone.
fn refuse_finished(told: &Survey) -> Result<()> {
    let Some(file) = &told.without_inputs else { return Ok(()) };
    Err(usage(format!(
        "{}: holds a finished picture, and not the samples it was made of; render it with --aov inputs, or denoise the file \
         it came from",
        file.display()
    )))
}

/// Layers of light that neither the method nor an output needs.
fn unneeded(settings: &reconstruct::Settings, outputs: &Outputs) -> Vec<&'static str> {
    if outputs.need_inputs() {
        Vec::new()
    } else if !settings.method.is_collaborative() {
        vec![INDIRECT, GATHERED]
    } else if !settings.best.light.gathered {
        vec![GATHERED]
    } else {
        Vec::new()
    }
}

/// The layers of `stack` that are called `names`.
fn passes(names: &[String], stack: &FeatureStack) -> Result<Vec<Pass>> {
    let mut passes: Vec<Pass> = Vec::new();
    for name in names {
        let pass = Pass::find(stack, name)?;
        if !passes.contains(&pass) {
            passes.push(pass);
        }
    }
    Ok(passes)
}

/// Demands what `--require` lists.
fn require(names: &[String], read: &ReadStack) -> Result<()> {
    let noise = read.stack.components.first().map(|component| &component.radiance.noise);
    for name in names {
        let there = match name.as_str() {
            "noise" => !matches!(noise, Some(Noise::Unknown) | None),
            "variance" => matches!(noise, Some(Noise::VarianceOfMean(_))),
            "buckets" => matches!(noise, Some(Noise::Buckets(_))),
            "samples" => read.found.spp.is_some(),
            role if Role::ALL.iter().any(|known| known.name() == role) => {
                read.found.roles.iter().any(|found| found.role == role)
            }
            _ => return Err(usage(format!("--require: '{name}' is no role; {EXPECTED}"))),
        };
        if !there {
            return Err(usage(format!("required '{name}' is not in the stack; {}", read.found.lines().join("; "))));
        }
    }
    Ok(())
}

/// What may stand in `--require`.
const EXPECTED: &str = "expected position, albedo, normal, visibility, depth, proximity, lit, emission, alpha, samples, noise, \
                        variance or buckets";

/// Settings of the reconstruction: those of the preset that was asked for, else those recorded in a file of ours, else the
/// default's; flags override them. That recorded ones cannot be used is said.
fn resolve(
    preset: Option<Preset>,
    matches: &ArgMatches,
    header: Option<&StackHeader>,
    progress: &Progress,
) -> Result<reconstruct::Settings> {
    let mut settings = match (preset, header) {
        (Some(preset), _) => Settings::of(preset),
        (None, None) => Settings::default(),
        (None, Some(header)) => Settings::recorded(&header.settings).unwrap_or_else(|why| {
            progress.say(&format!("the settings recorded in the file are not used, but those of --preset best: {why}"));
            Settings::default()
        }),
    };
    settings.override_by(matches)?;
    Ok(settings.reconstruction)
}

/// What the file says about itself, with the settings it is rebuilt with now. How its samples were taken stays as it is
/// recorded, be it by another version; of those of another renderer nothing is known.
fn header_of(read: &ReadStack, settings: &reconstruct::Settings) -> StackHeader {
    let rebuilt = Settings { reconstruction: *settings, ..Settings::default() }.to_json()[RECONSTRUCTION].take();
    match &read.header {
        Some(header) => {
            let mut recorded = header.settings.as_object().cloned().unwrap_or_default();
            recorded.insert(RECONSTRUCTION.into(), rebuilt);
            StackHeader { settings: recorded.into(), ..header.clone() }
        }
        None => {
            let header = StackHeader::of(&read.stack, json!({ RECONSTRUCTION: rebuilt }));
            StackHeader { samples_unknown: read.found.spp.is_none(), ..header }
        }
    }
}

/// Where the settings of the reconstruction are recorded.
const RECONSTRUCTION: &str = "reconstruction";

fn say_what_was_done(progress: &Progress, reconstruction: &Reconstruction, seconds: f64) {
    if reconstruction.spikes.is_some() {
        progress.say(&format!("{} pixels marked as spikes", reconstruction.marked));
    }
    progress.say(&done_in(seconds, progress));
}

/// Seconds of the steps that are no stage of the reconstruction.
struct Clock {
    load: f64,
    write: f64,
    total: f64,
}

struct Outcome<'a> {
    outputs: &'a Outputs,
    written: &'a Written<'a>,
    /// Mean radiance of the noisy picture.
    noisy: f64,
    found: &'a Found,
    /// The preset that the settings began with, where that is known.
    preset: Option<Preset>,
    seconds: Clock,
    guide: Option<&'a Followed>,
}

impl Outcome<'_> {
    fn json(&self, progress: &Progress) -> Value {
        let size = self.written.stack.size();
        // A value that a file does not record is null.
        let settings = &self.written.header.settings;
        let counts = self.written.stack.samples.total.iter();
        let samples = self.found.spp.as_ref().map(|_| counts.map(|&n| u64::from(n)).sum::<u64>());
        json!({
            "output": self.outputs.files(),
            "width": size.width,
            "height": size.height,
            "found": self.found,
            "samples": samples,
            "rays": null,
            "iterations": null,
            "seed": settings["trace"]["seed"],
            "preset": self.preset,
            "spp": self.found.spp.as_ref().map(|spp| json!({"mean": spp.mean, "min": spp.min, "max": spp.max})),
            "seconds": {
                "load": self.seconds.load, "build": null, "trace": null, "reconstruct": progress.total_seconds(),
                "write": self.seconds.write, "total": self.seconds.total,
            },
            "stages": report::stages(progress),
            "lacks": report::lacks(self.written),
            "guide": self.guide.map(Followed::json),
            "estimated_rmse": report::estimated_rmse(self.written),
            "energy": report::energy(self.noisy, self.written.picture),
            "peak_bytes": memory::peak_bytes(),
            "settings": settings,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_read_apart_only_where_a_method_or_an_output_needs_it() {
        let folder = tempfile::tempdir().unwrap();
        let unneeded = |file: &str, aov: &str, change: &dyn Fn(&mut reconstruct::Settings)| {
            let args = OutputArgs { output: vec![folder.path().join(file)], aov: aov.into(), exposure: None };
            let mut settings = Settings::default().reconstruction;
            change(&mut settings);
            super::unneeded(&settings, &Outputs::prepare(&args, "").unwrap())
        };
        let nfor = |settings: &mut reconstruct::Settings| settings.method.method = reconstruct::Method::Nfor;
        assert_eq!(unneeded("a.png", "inputs", &nfor), [INDIRECT, GATHERED]);
        assert_eq!(unneeded("a.exr", "none", &nfor), [INDIRECT, GATHERED]);
        assert!(unneeded("a.exr", "inputs", &nfor).is_empty(), "it is written again");
        assert!(unneeded("a.png", "inputs", &|_| ()).is_empty(), "best rebuilds it apart");
        assert_eq!(unneeded("a.png", "inputs", &|settings| settings.best.light.gathered = false), [GATHERED]);
    }
}
