//! `tamis plan`: the commands that render a picture in slices, for whatever runs jobs on several machines.

mod shell;

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches};
use serde_json::{Value, json};

use crate::args::{PlanArgs, RenderArgs, command};
use crate::failure::{Verdict, usage};
use crate::output::check_format;
use crate::render::{Plan, load_named};
use crate::stdout::print_line;
use shell::{line, text};

/// Flags that a slice does not get as they are: it is told by others what to take and where to put it.
const NOT_FOR_SLICES: [&str; 9] =
    ["scene", "slices", "spp", "uniform", "no_denoise", "output", "aov", "exposure", "json"];

/// Flags that merging takes, too. Settings are recorded in the slices.
const FOR_MERGING: [&str; 5] = ["aov", "exposure", "threads", "quiet", "verbose"];

/// Runs the command.
pub fn run(args: &PlanArgs, matches: &ArgMatches) -> Result<Verdict> {
    let jobs = Jobs::new(args, matches)?;
    if args.render.report.json {
        print_line(jobs.json())?;
    } else {
        jobs.slices
            .iter()
            .map(|slice| &slice.command)
            .chain([&jobs.merge])
            .try_for_each(|job| print_line(line(job)))?;
    }
    Ok(Verdict::Done)
}

/// Everything there is to run.
struct Jobs {
    slices: Vec<Slice>,
    outputs: Vec<String>,
    merge: Vec<String>,
}

/// A part of the samples.
struct Slice {
    samples: Range<u32>,
    output: String,
    command: Vec<String>,
}

impl Jobs {
    fn new(args: &PlanArgs, matches: &ArgMatches) -> Result<Self> {
        let spp = samples_per_pixel(&args.render, matches)?;
        if args.slices > spp {
            return Err(usage(format!("--slices {}: {spp} samples per pixel make at most {spp} slices", args.slices)));
        }
        let outputs = args.render.output.files(&args.render.stem());
        outputs.iter().try_for_each(|file| check_format(file))?;
        let slices = ranges(spp, args.slices).zip(1..).map(|(samples, number)| {
            let output = path(&slice_of(&outputs[0], number))?;
            let range = format!("{}..{}", samples.start, samples.end);
            let mut command: Vec<String> = ["tamis", "render"].map(String::from).to_vec();
            command.push(path(&args.render.scene)?);
            command.extend(flags(matches, |flag| !NOT_FOR_SLICES.contains(&flag))?);
            // The sum is reconstructed, not its parts.
            command.extend(["--samples", &range, "--no-denoise", "--aov", "inputs", "-o", &output].map(String::from));
            Ok(Slice { samples, output, command })
        });
        let slices = slices.collect::<Result<Vec<_>>>()?;
        let outputs = outputs.iter().map(|file| path(file)).collect::<Result<Vec<_>>>()?;
        let mut merge: Vec<String> = ["tamis", "merge"].map(String::from).to_vec();
        merge.extend(slices.iter().map(|slice| slice.output.clone()));
        merge.extend(flags(matches, |flag| FOR_MERGING.contains(&flag))?);
        merge.extend(outputs.iter().flat_map(|file| ["-o".into(), file.clone()]));
        Ok(Self { slices, outputs, merge })
    }

    fn json(&self) -> Value {
        let slice = |slice: &Slice| {
            json!({
                "first": slice.samples.start, "end": slice.samples.end, "output": slice.output,
                "arguments": slice.command, "command": line(&slice.command),
            })
        };
        json!({
            "slices": self.slices.iter().map(slice).collect::<Vec<_>>(),
            "merge": {"output": self.outputs, "arguments": self.merge, "command": line(&self.merge)},
        })
    }
}

/// Samples of every pixel, once all flags were checked, so that not every job finds the same mistake.
fn samples_per_pixel(args: &RenderArgs, matches: &ArgMatches) -> Result<u32> {
    let without = [
        ("--samples", args.samples.is_some()),
        ("--time", args.time.is_some()),
        ("--target-error", args.target_error.is_some()),
        ("--no-denoise", args.no_denoise),
        ("--guide", args.guide.is_some()),
    ];
    if let Some((flag, _)) = without.into_iter().find(|(_, given)| *given) {
        return Err(usage(format!(
            "{flag} does not go with a plan, which divides --spp samples and reconstructs their sum"
        )));
    }
    // Scenes may be large: they are read only where they have a say.
    let scene = match args.spp {
        None => load_named(&args.scene)?.render,
        Some(_) if args.scene.is_file() => None,
        Some(_) => return Err(usage(format!("{}: no such file", args.scene.display()))),
    };
    let spp = Plan::new(args, matches, scene.as_ref())?.budget.spp;
    spp.ok_or_else(|| usage("--spp: expected a number of samples per pixel"))
}

/// `spp` samples in `slices` parts whose lengths differ by one at most.
fn ranges(spp: u32, slices: u32) -> impl Iterator<Item = Range<u32>> {
    let start = move |number: u32| (u64::from(spp) * u64::from(number) / u64::from(slices)) as u32;
    (0..slices).map(move |number| start(number)..start(number + 1))
}

/// Where slice `number` of what `output` will be is written.
fn slice_of(output: &Path, number: u32) -> PathBuf {
    output.with_extension(format!("{number:04}.exr"))
}

/// A path as an argument that is not taken for a flag.
fn path(path: &Path) -> Result<String> {
    let text = text(path.as_os_str())?;
    Ok(if text.starts_with('-') { format!("./{text}") } else { text.into() })
}

/// The flags of the command line that are `wanted`, as they were given.
fn flags(matches: &ArgMatches, wanted: impl Fn(&str) -> bool) -> Result<Vec<String>> {
    let command = command();
    let all = command.find_subcommand("plan").into_iter().flat_map(|plan| plan.get_arguments());
    let is_given = |arg: &&Arg| {
        let is_flag = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append | ArgAction::SetTrue);
        is_flag && wanted(arg.get_id().as_str()) && matches.value_source(arg.get_id().as_str()) == given()
    };
    let mut flags = Vec::new();
    for arg in all.filter(is_given) {
        let Some(long) = arg.get_long() else { continue };
        if matches!(arg.get_action(), ArgAction::SetTrue) {
            flags.push(format!("--{long}"));
            continue;
        }
        for value in matches.get_raw(arg.get_id().as_str()).into_iter().flatten() {
            match text(value)? {
                value if value.starts_with('-') => flags.push(format!("--{long}={value}")),
                value => flags.extend([format!("--{long}"), value.into()]),
            }
        }
    }
    Ok(flags)
}

const fn given() -> Option<ValueSource> {
    Some(ValueSource::CommandLine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_divided_without_gaps_and_evenly() {
        for (spp, slices) in [(10, 3), (8, 8), (100, 1), (7, 4), (u32::MAX, 1000)] {
            let all: Vec<Range<u32>> = ranges(spp, slices).collect();
            assert_eq!((all.len(), all[0].start, all[all.len() - 1].end), (slices as usize, 0, spp));
            assert!(all.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert!(all.iter().all(|range| (range.len() as u32).abs_diff(spp / slices) <= 1 && !range.is_empty()));
        }
    }

    #[test]
    fn slices_stand_beside_the_output() {
        assert_eq!(slice_of(Path::new("out/a.b.exr"), 7), Path::new("out/a.b.0007.exr"));
        assert_eq!(path(Path::new("-a.obj")).unwrap(), "./-a.obj");
    }
}
