//! A picture in parts: slices add up to one render, and a render goes on from what there is.

mod support;

use std::process::Command;

use serde_json::Value;
use stack::file::{Layers, ReadStack, read_stack};
use stack::{Dealing, Estimate, FeatureStack, Image, Noise};
use support::Workplace;

const RENDER: &str = "render box.obj --size 48x32 --seed 3 --no-denoise --quiet";
const MERGE: &str = "merge --method ld --quiet";

fn slice(workplace: &Workplace, samples: &str, file: &str) {
    workplace.must(&format!("{RENDER} --samples {samples} -o {file}"));
}

fn read(workplace: &Workplace, file: &str) -> ReadStack {
    read_stack(&workplace.path(file)).unwrap()
}

/// Demands that two stacks hold the same counts, and the same samples but for rounding; light is gathered anew.
fn hold_the_same(a: &FeatureStack, b: &FeatureStack) {
    assert_eq!(a.samples, b.samples);
    let light = |stack: &FeatureStack| -> Vec<Estimate> {
        let components = stack.components.iter().map(|c| &c.radiance).chain(&stack.indirect);
        components.chain(stack.features.iter().map(|f| &f.estimate)).cloned().collect()
    };
    let (a, b) = (light(a), light(b));
    assert_eq!((a.len(), b.len()), (10, 10));
    for (a, b) in a.iter().zip(&b) {
        near(&a.mean, &b.mean);
        let (Noise::Buckets(a), Noise::Buckets(b)) = (&a.noise, &b.noise) else { panic!("no buckets") };
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).for_each(|(a, b)| near(a, b));
    }
}

fn near(a: &Image, b: &Image) {
    for (a, b) in a.channels().iter().flatten().zip(b.channels().iter().flatten()) {
        assert!((a - b).abs() <= 1e-5 * (1e-2 + b.abs()), "{a} {b}");
    }
}

/// Runs `line` and demands exit code 2, one line with each of `words`, and that files stay as they are.
fn refused(workplace: &Workplace, line: &str, words: &[&str]) {
    let before = workplace.files();
    let run = workplace.tamis(line);
    assert_eq!((run.code(), run.errors().len()), (Some(2), 1), "tamis {line}\n{}", run.stderr());
    words.iter().for_each(|word| assert!(run.errors()[0].contains(word), "'{word}' is not in: {}", run.errors()[0]));
    assert_eq!(workplace.files().len(), before.len(), "tamis {line} left a file behind");
}

#[test]
fn slices_hold_what_one_render_holds_in_any_order() {
    let workplace = Workplace::new();
    slice(&workplace, "0..21", "whole.exr");
    workplace.must(&format!("{RENDER} --uniform --spp 21 -o plain.exr"));
    assert!(workplace.bytes("whole.exr") == workplace.bytes("plain.exr"), "a slice of everything is a render");
    for (samples, file) in [("0..5", "a.exr"), ("5..16", "b.exr"), ("16..21", "c.exr")] {
        slice(&workplace, samples, file);
    }
    workplace.must(&format!("{MERGE} a.exr b.exr c.exr -o abc.exr"));
    workplace.must(&format!("{MERGE} c.exr a.exr b.exr -o cab.exr --threads 1"));
    assert!(workplace.bytes("abc.exr") == workplace.bytes("cab.exr"), "the order counts");
    let (merged, whole) = (read(&workplace, "abc.exr"), read(&workplace, "whole.exr"));
    hold_the_same(&merged.stack, &whole.stack);
    let (merged, whole) = (merged.header.unwrap(), whole.header.unwrap());
    assert_eq!((merged.record, merged.per_bucket), (whole.record, None), "it can be merged further");
    workplace.must("denoise abc.exr -o again.exr --method ld --quiet");
    assert!(workplace.bytes("abc.exr") == workplace.bytes("again.exr"), "what is written is what was reconstructed");
    let said = workplace.must("info abc.exr b.exr").stdout();
    assert!(said.contains("samples 0..21 of seed 3") && said.contains("samples 5..16 of seed 3"), "{said}");
}

#[test]
fn a_gap_may_be_filled_later_and_seeds_may_differ() {
    let workplace = Workplace::new();
    for (samples, file) in [("0..21", "whole.exr"), ("0..5", "a.exr"), ("5..16", "b.exr"), ("16..21", "c.exr")] {
        slice(&workplace, samples, file);
    }
    workplace.must(&format!("{MERGE} a.exr c.exr -o outer.exr"));
    let outer = read(&workplace, "outer.exr").stack;
    assert_eq!(outer.samples.dealing, Dealing::PerBucket(vec![2, 2, 2, 2, 2, 0, 0, 0]));
    workplace.must("denoise outer.exr -o again.exr --method ld --quiet");
    assert!(workplace.bytes("outer.exr") == workplace.bytes("again.exr"));
    let run = workplace.must("merge b.exr outer.exr --method ld -o all.exr");
    assert!(run.stderr().contains("2 files add up to samples 0..21 of seed 3"), "{}", run.stderr());
    hold_the_same(&read(&workplace, "all.exr").stack, &read(&workplace, "whole.exr").stack);
    refused(&workplace, "merge all.exr b.exr -o x.exr", &["b.exr", "5..16", "all.exr", "0..21"]);

    workplace.must("render box.obj --size 48x32 --seed 4 --spp 6 --quiet -o other.exr");
    workplace.must(&format!("{MERGE} a.exr other.exr -o seeds.exr"));
    let [a, other, both] = ["a.exr", "other.exr", "seeds.exr"].map(|file| read(&workplace, file).stack);
    assert!(!other.samples.is_uniform(), "adaptive renders can be added, too");
    let mixed = |pixel: usize| {
        let [n, m] = [&a, &other].map(|stack| stack.samples.total[pixel] as f32);
        (n * a.beauty().mean_at(pixel) + m * other.beauty().mean_at(pixel)) / (n + m)
    };
    let beauty = both.beauty();
    assert!((0..48 * 32).all(|pixel| (beauty.mean_at(pixel) - mixed(pixel)).abs() <= 1e-5 * (1e-2 + mixed(pixel))));
    refused(&workplace, "merge seeds.exr other.exr -o x.exr", &["other.exr", "seed 4"]);
}

#[test]
fn what_does_not_belong_together_is_not_merged() {
    let workplace = Workplace::new();
    slice(&workplace, "0..4", "a.exr");
    slice(&workplace, "3..6", "overlap.exr");
    refused(&workplace, "merge a.exr overlap.exr -o x.exr", &["overlap.exr", "3..6", "0..4", "seed 3"]);
    refused(&workplace, "merge a.exr a.exr -o x.exr", &["a.exr", "0..4"]);
    refused(&workplace, "merge a.exr", &["-o"]);
    let others = [
        ("--max-depth 2", "trace.max-depth: expected 32 as in a.exr, found 2"),
        ("--fov 50", "camera.fov"),
        ("--env 1,1,2", "scene.sky"),
        ("--buckets 4 --sequences 4", "trace.sequences"),
        ("--size 32x48", "expected 48x32 as in a.exr, found 32x48"),
        ("--crop 0,0,20,10", "expected 48x32 as in a.exr, found 20x10"),
    ];
    for (flags, word) in others {
        let size = if flags.contains("--size") { "" } else { "--size 48x32" };
        let line = format!("render box.obj {size} --seed 3 --samples 4..6 --no-denoise --quiet {flags} -o other.exr");
        workplace.must(&line);
        refused(&workplace, "merge a.exr other.exr -o x.exr", &["other.exr", word]);
    }
    workplace.must(&format!("{RENDER} --samples 4..6 --aov none -o empty.exr"));
    refused(&workplace, "merge a.exr empty.exr -o x.exr", &["empty.exr", "inputs"]);
    let mut layers = Layers::read(&workplace.path("a.exr")).unwrap();
    layers.metadata.as_mut().and_then(Value::as_object_mut).unwrap().remove("record");
    layers.write(&workplace.path("old.exr")).unwrap();
    refused(&workplace, "merge a.exr old.exr -o x.exr", &["old.exr", "which samples"]);
    layers.metadata = None;
    layers.write(&workplace.path("stranger.exr")).unwrap();
    refused(&workplace, "merge stranger.exr a.exr -o x.exr", &["stranger.exr", "--buckets"]);
    // The lamp is as bright, but the walls are not the same.
    workplace
        .write("box.mtl", "newmtl white\nKd .7 .7 .6\nnewmtl red\nKd .6 .1 .1\nnewmtl lamp\nKd .5 .5 .5\nKe 12 11 9\n");
    slice(&workplace, "4..6", "other.exr");
    refused(&workplace, "merge a.exr other.exr -o x.exr", &["other.exr", "scene.materials"]);
    let run = workplace.tamis("render box.obj --samples 0..4 --spp 4 -o x.exr");
    assert!(run.code() == Some(2) && run.stderr().contains("--samples <A..B>"), "{}", run.stderr());
}

#[test]
fn the_lines_of_a_plan_make_the_picture() {
    let workplace = Workplace::new();
    std::fs::copy(workplace.path("box.obj"), workplace.path("it's a box.obj")).unwrap();
    let plan = |more: &[&str]| {
        let mut command = workplace.command("plan --slices 3 --spp 7 --size 48x32 --eye -.1,1,3.5 --seed 3 --quiet");
        command.arg("it's a box.obj").args(more).output().unwrap()
    };
    let lines = String::from_utf8(plan(&["-o", "the picture.exr", "--method", "ld"]).stdout).unwrap();
    assert_eq!(lines.lines().count(), 4, "{lines}");
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_tamis"));
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    for line in lines.lines() {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(line).current_dir(workplace.path(".")).env("PATH", &path);
        assert!(shell.status().unwrap().success(), "{line}");
    }
    let mut whole =
        workplace.command("render --size 48x32 --eye=-.1,1,3.5 --seed 3 --uniform --spp 7 --quiet -o whole.exr");
    assert!(whole.args(["it's a box.obj", "--method", "ld"]).status().unwrap().success());
    hold_the_same(&read(&workplace, "the picture.exr").stack, &read(&workplace, "whole.exr").stack);
    let settings = ["the picture.exr", "whole.exr"].map(|file| read(&workplace, file).header.unwrap().settings);
    assert_eq!(settings[0], settings[1], "the settings of slices are those of the sum");

    let report: Value = serde_json::from_slice(&plan(&["--json"]).stdout).unwrap();
    assert_eq!(report["slices"][1]["output"], "it's a box.0002.exr");
    assert_eq!((report["slices"][1]["first"].as_u64(), report["slices"][1]["end"].as_u64()), (Some(2), Some(4)));
    assert_eq!(report["merge"]["output"], serde_json::json!(["it's a box.exr", "it's a box.png"]));
    assert_eq!(report["merge"]["arguments"].as_array().map(Vec::len), Some(2 + 3 + 1 + 4));
}

#[test]
fn a_plan_finds_mistakes_before_its_jobs_do() {
    let workplace = Workplace::new();
    for (flags, word) in [
        ("--slices 9 --spp 8", "at most 8"),
        ("--slices 2 --time 5m", "--time"),
        ("--slices 2 --spp 8 --size 48x32 --crop 40,0,9,9", "--crop"),
        ("--slices 2 --spp 8 --spike-tile-size 1", "--spike-tile-size"),
        ("--slices 2 --spp 8 -o a.gif", "a.gif"),
    ] {
        refused(&workplace, &format!("plan box.obj {flags}"), &[word]);
    }
    refused(&workplace, "plan absent.obj --slices 2 --spp 4", &["absent.obj"]);
    workplace.write(
        "a.toml",
        "[render]\nspp = 6\n[camera]\neye = [0, 1, 4]\nlook_at = [0, 1, 0]\n[[geometry]]\nfile = \"box.obj\"\n",
    );
    let lines = workplace.must("plan a.toml --slices 2").stdout();
    assert!(lines.contains("--samples 0..3 ") && lines.contains("--samples 3..6 "), "the scene's number: {lines}");
    let lines = workplace.must("plan a.toml --slices 1 --camera=-x --resume --threads 2 --aov all").stdout();
    assert!(lines.contains("--camera=-x --resume --threads 2 --samples 0..6 "), "flags go on as they are: {lines}");
    assert!(lines.ends_with("tamis merge a.0001.exr --aov all --threads 2 -o a.exr -o a.png\n"), "{lines}");
}

#[test]
fn a_resumed_render_holds_what_one_render_holds() {
    let workplace = Workplace::new();
    let run = workplace.must("render box.obj --size 48x32 --seed 3 --spp 5 --uniform --no-denoise --resume -o a.exr");
    assert!(run.stderr().contains("nothing to resume from"), "{}", run.stderr());
    workplace.must(&format!("{RENDER} --uniform --spp 5 -o small.exr"));
    workplace.must(&format!("{RENDER} --uniform --spp 21 -o large.exr"));
    assert!(workplace.bytes("a.exr") == workplace.bytes("small.exr"), "without a file it is a plain render");
    let resume = format!("{RENDER} --uniform --spp 21 --resume --json -o a.exr");
    let report: Value = serde_json::from_str(&workplace.must(&resume).stdout()).unwrap();
    assert_eq!(report["samples"].as_u64(), Some(48 * 32 * 16), "only what was missing");
    assert_eq!(report["spp"]["mean"].as_f64(), Some(21.0));
    let [resumed, large] = ["a.exr", "large.exr"].map(|file| read(&workplace, file));
    hold_the_same(&resumed.stack, &large.stack);
    assert_eq!(resumed.header, large.header);

    let finished = workplace.bytes("a.exr");
    let run = workplace.must(&resume.replace(" --quiet", ""));
    let report: Value = serde_json::from_str(&run.stdout()).unwrap();
    assert!(run.stderr().contains("nothing is missing in a.exr") && report["samples"].as_u64() == Some(0));
    assert!(report["seconds"]["reconstruct"].is_null(), "{}", run.stdout());
    assert!(workplace.bytes("a.exr") == finished);
    workplace.must(&format!("{resume} -o a.png"));
    assert!(workplace.path("a.png").exists() && workplace.bytes("a.exr") == finished, "what is missing is written");
    let judged = resume.replace("--no-denoise", "--method ld");
    assert_eq!(workplace.tamis(&format!("{judged} --target-error 1e-12")).code(), Some(1), "a target is looked at");

    // What an interrupted run left: with samples missing, and without.
    for (spp, from, file) in [(21, "small", "b"), (5, "large", "c")] {
        let partial = format!("{file}.partial.exr");
        std::fs::copy(workplace.path(&format!("{from}.exr")), workplace.path(&partial)).unwrap();
        workplace.must(&format!("{RENDER} --uniform --spp {spp} --resume -o {file}.exr"));
        assert!(!workplace.files().contains(&partial));
        hold_the_same(&read(&workplace, &format!("{file}.exr")).stack, &large.stack);
    }
}

#[test]
fn a_slice_and_an_adaptive_render_are_resumed_as_well() {
    let workplace = Workplace::new();
    slice(&workplace, "4..19", "whole.exr");
    slice(&workplace, "4..9", "part.exr");
    workplace.must(&format!("{RENDER} --samples 4..19 --resume -o part.exr"));
    hold_the_same(&read(&workplace, "part.exr").stack, &read(&workplace, "whole.exr").stack);
    refused(&workplace, &format!("{RENDER} --spp 19 --resume -o part.exr"), &["samples", "0..15", "4..19"]);

    let adaptive = "render box.obj --size 48x32 --seed 3 --quiet --json --method ld -o b.exr";
    workplace.must(&format!("{adaptive} --spp 6"));
    let before = read(&workplace, "b.exr").stack.samples;
    let report: Value =
        serde_json::from_str(&workplace.must(&format!("{adaptive} --spp 10 --resume")).stdout()).unwrap();
    let after = read(&workplace, "b.exr").stack.samples;
    assert_eq!(report["samples"].as_u64(), Some(48 * 32 * 4));
    assert!(before.total.iter().zip(&after.total).all(|(before, after)| after >= before));
    assert_eq!((after.mean_min_max().0, after.is_uniform()), (10.0, false));
    assert_eq!(report["iterations"][0]["spp"].as_f64(), Some(6.0), "rounds begin with what there is");
    workplace.must(&format!("{adaptive} --spp 8 --uniform --resume"));
    assert!(
        read(&workplace, "b.exr").stack.samples.total.iter().zip(&after.total).all(|(now, then)| *now == *then.max(&8))
    );
}

#[test]
fn another_render_is_not_resumed() {
    let workplace = Workplace::new();
    workplace.must(&format!("{RENDER} --uniform --spp 2 -o a.exr"));
    let finished = workplace.bytes("a.exr");
    let resume = |flags: &str| {
        let rest = RENDER.split(' ').collect::<Vec<_>>().join(" ");
        let mut line = format!("{rest} --uniform --spp 4 --resume -o a.exr");
        let flag = flags.split(' ').next().unwrap();
        if let Some(at) = line.find(flag) {
            let end = line[at + flag.len() + 1..].find(' ').map_or(line.len(), |end| at + flag.len() + 1 + end);
            line.replace_range(at..end, "");
        }
        format!("{line} {flags}")
    };
    for (flags, words) in [
        ("--seed 4", ["seed: expected 4, found 3", "a.exr"]),
        ("--size 32x48", ["size: expected 32x48, found 48x32", "a.exr"]),
        ("--crop 1,2,8,8", ["crop: expected 1,2 8x8, found 0,0 48x32", "a.exr"]),
        ("--fov 50", ["camera.fov: expected 50", "a.exr"]),
        ("--max-depth 5", ["trace.max-depth: expected 5, found 32", "a.exr"]),
        ("--env 0,0,1", ["scene.sky", "a.exr"]),
    ] {
        refused(&workplace, &resume(flags), &words);
    }
    slice(&workplace, "4..6", "c.exr");
    workplace.must(&format!("{MERGE} a.exr c.exr -o gap.exr"));
    refused(
        &workplace,
        &format!("{RENDER} --spp 9 --resume -o gap.exr"),
        &["gap.exr", "0..2 of seed 3, 4..6 of seed 3"],
    );
    workplace.must(&format!("{RENDER} --uniform --spp 2 --aov none -o empty.exr"));
    refused(&workplace, &format!("{RENDER} --spp 9 --resume -o empty.exr"), &["empty.exr", "inputs"]);
    workplace.write("box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    refused(&workplace, &resume("--eye 0,1,3"), &["scene.geometry"]);
    assert!(workplace.bytes("a.exr") == finished);
}
