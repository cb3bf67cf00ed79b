//! `tamis denoise`: reconstructs an existing stack.

use std::time::Instant;

use anyhow::Result;
use clap::ArgMatches;
use reconstruct::{Reconstruction, reconstruct, reconstruct_freeing};
use serde_json::{Value, json};
use stack::file::{ReadStack, StackHeader, read_buckets, read_stack};
use stack::{FeatureRole, FeatureStack};

use crate::args::DenoiseArgs;
use crate::failure::{Verdict, usage};
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::settings::Settings;
use crate::stdout::print_line;
use crate::{interrupt, render};

/// Runs the command.
pub fn run(args: &DenoiseArgs, matches: &ArgMatches) -> Result<Verdict> {
    let start = Instant::now();
    if args.output.output.is_empty() {
        return Err(usage("denoise needs an output file: -o FILE"));
    }
    let outputs = Outputs::prepare(&args.output, "denoised")?;
    render::start_threads(&args.report)?;
    interrupt::listen();
    let progress = Progress::new(&args.report);
    let mut read = read(args)?;
    for note in &read.notes {
        progress.say(note);
    }
    let loaded = start.elapsed().as_secs_f64();
    require(args, &read.stack)?;
    let settings = resolve(args, matches, read.header.as_ref())?;
    let reconstruction = if outputs.need_inputs() {
        reconstruct(&read.stack, &settings.reconstruction, &progress)?
    } else {
        reconstruct_freeing(&mut read.stack, &settings.reconstruction, &progress)?
    };
    progress.finish();
    let picture = &reconstruction.picture;
    let header = StackHeader { settings: settings.to_json(), ..header_of(&read) };
    let written = Written { picture, stack: &read.stack, reconstruction: Some(&reconstruction), header: &header };
    let writing = Instant::now();
    outputs.write(&written, &progress)?;
    let seconds =
        [("load", loaded), ("write", writing.elapsed().as_secs_f64()), ("total", start.elapsed().as_secs_f64())];
    say_what_was_done(&progress, &reconstruction, seconds[2].1);
    if args.report.json {
        let outcome = Outcome { outputs: &outputs, written: &written, settings: &settings, seconds: &seconds };
        print_line(outcome.json(&progress))?;
    }
    Ok(Verdict::Done)
}

fn read(args: &DenoiseArgs) -> Result<ReadStack> {
    match &args.input {
        Some(input) => Ok(read_stack(input)?),
        None => Ok(read_buckets(&args.buckets)?),
    }
}

fn require(args: &DenoiseArgs, stack: &FeatureStack) -> Result<()> {
    for name in &args.require {
        let role = FeatureRole::ALL.into_iter().find(|role| role.layer() == name);
        let role = role.ok_or_else(|| {
            usage(format!("--require: '{name}' is no role; expected position, albedo, normal, visibility or depth"))
        })?;
        if stack.feature(role).is_none() {
            return Err(usage(format!("required layer '{name}' is not in the stack")));
        }
    }
    Ok(())
}

/// Settings: those of the preset that was asked for, else those recorded in a file of ours, else the default's; flags
/// override them.
fn resolve(args: &DenoiseArgs, matches: &ArgMatches, header: Option<&StackHeader>) -> Result<Settings> {
    let recorded = || serde_json::from_value::<Settings>(header?.settings.clone()).ok();
    let mut settings = match args.picture.preset {
        Some(preset) => Settings::of(preset),
        None => recorded().unwrap_or_default(),
    };
    settings.override_by(matches)?;
    Ok(settings)
}

/// What the file says about itself; for another renderer's, what it is to us: as many sequences as buckets.
fn header_of(read: &ReadStack) -> StackHeader {
    let buckets = read.stack.samples.dealing.buckets() as u32;
    let foreign = || StackHeader { first: 0, sequences: buckets, buckets, settings: Value::Null };
    read.header.clone().unwrap_or_else(foreign)
}

fn say_what_was_done(progress: &Progress, reconstruction: &Reconstruction, seconds: f64) {
    if reconstruction.spikes.is_some() {
        progress.say(&format!("{} pixels marked as spikes", reconstruction.marked));
    }
    let stages: Vec<String> = progress.stage_seconds().iter().map(|(name, s)| format!("{name} {s:.1} s")).collect();
    progress.say(&format!("done in {seconds:.1} s ({})", stages.join(", ")));
}

struct Outcome<'a> {
    outputs: &'a Outputs,
    written: &'a Written<'a>,
    settings: &'a Settings,
    seconds: &'a [(&'a str, f64)],
}

impl Outcome<'_> {
    fn json(&self, progress: &Progress) -> Value {
        let size = self.written.stack.size();
        let (mean, min, max) = self.written.stack.samples.mean_min_max();
        json!({
            "output": self.outputs.files(),
            "width": size.width,
            "height": size.height,
            "spp": {"mean": mean, "min": min, "max": max},
            "seconds": self.seconds.iter().map(|(name, s)| (name.to_string(), json!(s))).collect::<serde_json::Map<_, _>>(),
            "stages": render::report::stages(progress),
            "lacks": render::report::lacks(self.written),
            "estimated_rmse": render::report::estimated_rmse(self.written),
            "energy": render::report::energy(self.written),
            "peak_bytes": render::report::peak_bytes(),
            "settings": self.settings.to_json(),
        })
    }
}
