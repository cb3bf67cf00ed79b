//! `tamis denoise`: reconstructs an existing stack.

use std::time::Instant;

use anyhow::Result;
use clap::ArgMatches;
use reconstruct::{Reconstruction, reconstruct};
use serde_json::{Value, json};
use stack::file::{ReadStack, StackHeader, read_buckets, read_stack};
use stack::{Dealing, FeatureRole, FeatureStack};

use crate::args::{DenoiseArgs, Method};
use crate::failure::{Verdict, usage};
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::settings::Settings;
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
    let read = read(args)?;
    for note in &read.notes {
        progress.say(note);
    }
    let loaded = start.elapsed().as_secs_f64();
    require(args, &read.stack)?;
    let settings = resolve(args, matches, read.header.as_ref())?;
    let reconstruction = match args.picture.method {
        Method::Ours => Some(reconstruct(&read.stack, &settings.reconstruction, &progress)?),
        Method::Ld => None,
    };
    progress.finish();
    let beauty = read.stack.beauty();
    let picture = reconstruction.as_ref().map_or(&beauty, |r| &r.picture);
    let header = read.header.unwrap_or_else(|| foreign_header(&read.stack, &settings));
    let written = Written { picture, stack: &read.stack, reconstruction: reconstruction.as_ref(), header: &header };
    let writing = Instant::now();
    outputs.write(&written, &progress)?;
    let seconds =
        [("load", loaded), ("write", writing.elapsed().as_secs_f64()), ("total", start.elapsed().as_secs_f64())];
    say_what_was_done(&progress, reconstruction.as_ref(), seconds[2].1);
    if args.report.json {
        let outcome = Outcome { outputs: &outputs, written: &written, settings: &settings, seconds: &seconds };
        println!("{}", outcome.json(&progress));
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

/// Settings: those recorded in a file of ours, else the preset's, overridden by flags.
fn resolve(args: &DenoiseArgs, matches: &ArgMatches, header: Option<&StackHeader>) -> Result<Settings> {
    let recorded = header.and_then(|header| serde_json::from_value::<Settings>(header.settings.clone()).ok());
    let mut settings = recorded.unwrap_or_else(|| Settings::of(args.picture.preset));
    settings.override_by(matches)?;
    Ok(settings)
}

fn foreign_header(stack: &FeatureStack, settings: &Settings) -> StackHeader {
    let (sequences, buckets) = match stack.samples.dealing {
        Dealing::Numbered { sequences, buckets } => (sequences, buckets),
        Dealing::PerBucket(ref counts) => (counts.len() as u32, counts.len() as u32),
    };
    StackHeader { first: 0, sequences, buckets, settings: settings.to_json() }
}

fn say_what_was_done(progress: &Progress, reconstruction: Option<&Reconstruction>, seconds: f64) {
    if let Some(reconstruction) = reconstruction {
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
            "estimated_rmse": render::report::estimated_rmse(self.written),
            "energy": render::report::energy(self.written),
            "peak_bytes": render::report::peak_bytes(),
            "settings": self.settings.to_json(),
        })
    }
}
