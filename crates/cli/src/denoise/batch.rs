//! `tamis denoise` of many pictures: goes on after a bad one, and says at the end which those were.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::ArgMatches;
use serde_json::{Value, json};
use stack::file::{Inputs, Source, is_one_stack};

use super::task::{Task, Wishes};
use crate::args::{DenoiseArgs, OutputArgs, ReportArgs};
use crate::failure::{Verdict, usage};
use crate::interrupt;
use crate::progress::Progress;
use crate::stderr::say_line;
use crate::stdout::print_line;
use crate::threads::start_threads;

/// One picture of many.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    /// Its files.
    pub sources: Vec<Source>,
    /// Where it is written.
    pub outputs: Vec<PathBuf>,
}

/// The pictures that are asked for, when they are many: an output is a folder, or inputs and outputs have `#` for the
/// number of a frame.
///
/// # Errors
/// When a pattern fits no file, two pictures would be written to one place, or one to where an input is.
pub fn jobs(args: &DenoiseArgs) -> Result<Option<Vec<Job>>> {
    let outputs = &args.rebuild.output.output;
    let sources: Vec<Source> = args.input.iter().map(|text| Source::parse(text)).collect();
    let many_out = |path: &PathBuf| is_folder(path) || has_number(path);
    if sources.is_empty() || !(sources.iter().any(|source| is_pattern(&source.path)) || outputs.iter().any(many_out)) {
        return Ok(None);
    }
    if let Some(single) = outputs.iter().find(|path| !many_out(path)) {
        let what = "expected a folder, or a name with #### for the number of the frame";
        return Err(usage(format!("-o {}: {what}", single.display())));
    }
    let mut jobs: Vec<Job> = Vec::new();
    for (sources, number) in stacks(sources)? {
        let outputs = outputs.iter().map(|output| place(output, &sources, &number)).collect::<Result<Vec<_>>>()?;
        if let Some(other) = jobs.iter().find(|job| job.outputs == outputs) {
            let [a, b] = [&other.sources, &sources].map(|s| s[0].path.display().to_string());
            return Err(usage(format!("{a} and {b} would both be written to {}", outputs[0].display())));
        }
        jobs.push(Job { sources, outputs });
    }
    spare_inputs(&jobs)?;
    Ok(Some(jobs))
}

/// Refuses outputs that would replace an input, be it another picture's: nobody names them one by one.
fn spare_inputs(jobs: &[Job]) -> Result<()> {
    let sources = jobs.iter().flat_map(|job| &job.sources);
    let inputs: HashSet<PathBuf> = sources.filter_map(|source| source.path.canonicalize().ok()).collect();
    let is_input = |output: &&PathBuf| output.canonicalize().is_ok_and(|output| inputs.contains(&output));
    match jobs.iter().flat_map(|job| &job.outputs).find(is_input) {
        Some(output) => Err(usage(format!(
            "-o: {} is an input, which would be replaced; give another folder or another name",
            output.display()
        ))),
        None => Ok(()),
    }
}

fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().ends_with('/')
}

/// Whether a file's own name leaves a number open; folders may be called anything.
fn has_number(path: &Path) -> bool {
    !is_folder(path) && path.file_name().is_some_and(|name| name.to_string_lossy().contains('#'))
}

/// Whether an input stands for the frames of a sequence.
pub fn is_pattern(path: &Path) -> bool {
    has_number(path) && !path.exists()
}

/// The files of each stack, with the number of its frame where there is one.
fn stacks(sources: Vec<Source>) -> Result<Vec<(Vec<Source>, String)>> {
    if sources.iter().all(|source| is_pattern(&source.path)) {
        let mut frames = Vec::new();
        for number in numbers(&sources[0].path)? {
            let filled = |source: &Source| Source { path: fill(&source.path, &number), ..source.clone() };
            frames.push((sources.iter().map(filled).collect(), number));
        }
        return Ok(frames);
    }
    if is_one_stack(&sources) {
        return Ok(vec![(sources, String::new())]);
    }
    Ok(sources.into_iter().map(|source| (vec![source], String::new())).collect())
}

/// The numbers that files of a pattern have, in rising order.
fn numbers(pattern: &Path) -> Result<Vec<String>> {
    let name = pattern.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (start, end) = (name.find('#').unwrap_or(name.len()), name.rfind('#').map_or(name.len(), |at| at + 1));
    let (before, after, width) = (&name[..start], &name[end..], end - start);
    let entries = std::fs::read_dir(folder).map_err(|e| usage(format!("{}: {e}", folder.display())))?;
    let number = |file: String| {
        let digits = file.strip_prefix(before)?.strip_suffix(after)?;
        let fits = digits.len() >= width && digits.bytes().all(|b| b.is_ascii_digit());
        fits.then(|| digits.to_string())
    };
    let files = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut numbers: Vec<String> = files.filter_map(number).collect();
    numbers.sort_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    if numbers.is_empty() {
        return Err(usage(format!("{}: no file has a number there", pattern.display())));
    }
    Ok(numbers)
}

/// The path with `number` in place of its name's row of `#`.
fn fill(pattern: &Path, number: &str) -> PathBuf {
    let name = pattern.file_name().unwrap_or_default().to_string_lossy();
    match (name.find('#'), name.rfind('#')) {
        (Some(start), Some(end)) => pattern.with_file_name(format!("{}{number}{}", &name[..start], &name[end + 1..])),
        _ => pattern.into(),
    }
}

/// Where the picture in `sources` goes: into a folder under its own name, or to a name with its number.
fn place(output: &Path, sources: &[Source], number: &str) -> Result<PathBuf> {
    let first = &sources[0].path;
    if !has_number(output) {
        return Ok(output.join(first.with_extension("exr").file_name().unwrap_or_default()));
    }
    if number.is_empty() {
        return Err(usage(format!("-o {}: its #### need inputs with ####", output.display())));
    }
    Ok(fill(output, number))
}

/// Denoises every picture, a line each.
///
/// # Errors
/// When the machine refuses threads or the user interrupts; a bad picture is none.
pub fn run(args: &DenoiseArgs, matches: &ArgMatches, jobs: &[Job]) -> Result<Verdict> {
    start_threads(&args.rebuild.report)?;
    interrupt::listen();
    let speaker = Progress::new(&args.rebuild.report);
    let (mut reports, mut failed) = (Vec::new(), Vec::new());
    for (nth, job) in jobs.iter().enumerate() {
        let place = format!("[{}/{}] {}", nth + 1, jobs.len(), job.outputs[0].display());
        if args.resume && job.outputs.iter().all(|output| output.exists()) {
            speaker.say(&format!("{place}: there already"));
            continue;
        }
        let start = Instant::now();
        match picture(args, matches, job) {
            Ok(report) => {
                speaker.say(&format!("{place}: done in {:.1} s", start.elapsed().as_secs_f64()));
                reports.push(report);
            }
            Err(error) if error.chain().any(|cause| cause.is::<stack::Cancelled>()) || interrupt::requested() => {
                return Err(error);
            }
            Err(error) => {
                speaker.say(&format!("{place}: {error:#}"));
                reports.push(json!({"output": job.outputs, "error": format!("{error:#}")}));
                let (name, said) = (job.sources[0].path.display().to_string(), format!("{error:#}"));
                // Most errors name the file themselves.
                failed.push(if said.starts_with(&name) { said } else { format!("{name}: {said}") });
            }
        }
    }
    if args.rebuild.report.json {
        print_line(Value::Array(reports))?;
    }
    if failed.is_empty() {
        return Ok(Verdict::Done);
    }
    say_line(format_args!("error: {} of {} pictures failed:\n  {}", failed.len(), jobs.len(), failed.join("\n  ")));
    Ok(Verdict::No)
}

fn picture(args: &DenoiseArgs, matches: &ArgMatches, job: &Job) -> Result<Value> {
    for folder in job.outputs.iter().filter_map(|output| output.parent()) {
        std::fs::create_dir_all(folder).map_err(|e| anyhow::anyhow!("{}: {e}", folder.display()))?;
    }
    let inputs = Inputs::Files(job.sources.clone());
    let rebuild = &args.rebuild;
    let output = OutputArgs { output: job.outputs.clone(), ..rebuild.output.clone() };
    let task = Task { rebuild, matches, inputs, output, wishes: Wishes::of(args) };
    let said = &rebuild.report;
    let quiet = ReportArgs { quiet: said.quiet || !said.verbose, ..said.clone() };
    task.run(&task.prepare()?, &Progress::new(&quiet))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|file| std::fs::write(folder.path().join(file), "").unwrap());
        folder
    }

    #[test]
    fn frames_are_found_in_order_and_keep_their_numbers() {
        let folder = folder(&["a0010.exr", "a0002.exr", "a10000.exr", "a12.exr", "ab003.exr", "a0002.png"]);
        let pattern = folder.path().join("a####.exr");
        assert_eq!(numbers(&pattern).unwrap(), ["0002", "0010", "10000"]);
        let found =
            stacks([&pattern, &pattern.with_extension("pfm")].map(|path| Source::from(&**path)).into()).unwrap();
        assert_eq!(found.len(), 3);
        assert_eq!(found[1].0[1].path, folder.path().join("a0010.pfm"));
        assert_eq!(place(Path::new("out/####.exr"), &found[1].0, "0010").unwrap(), Path::new("out/0010.exr"));
        assert!(numbers(&folder.path().join("z##.exr")).is_err());
    }

    #[test]
    fn role_files_are_one_picture_and_other_names_several() {
        let stacks = |list: &[&str]| stacks(list.iter().map(|name| Source::parse(name)).collect()).unwrap().len();
        assert_eq!((stacks(&["color.exr", "albedo.exr", "normal.exr"]), stacks(&["a.exr", "b.exr"])), (1, 2));
        let sources = [Source::parse("x/a.pfm")];
        assert_eq!(place(Path::new("out"), &sources, "").unwrap(), Path::new("out/a.exr"));
    }

    #[test]
    fn folders_may_be_called_anything() {
        let (output, sources) = (Path::new("p#1/out.####.exr"), [Source::parse("q#2/a.0007.exr")]);
        assert_eq!(place(output, &sources, "0007").unwrap(), Path::new("p#1/out.0007.exr"));
        assert!(!has_number(Path::new("p#1/x.exr")) && has_number(output));
        assert_eq!(place(Path::new("p#1/"), &sources, "").unwrap(), Path::new("p#1/a.0007.exr"));
    }
}
