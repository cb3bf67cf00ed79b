//! `tamis info`: what a scene or stack holds, as Tamis reads it.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use stack::file::{Inputs, ReadStack, Source, extension, is_one_stack, read_inputs};
use stack::{Estimate, GATHERED, INDIRECT, Noise};
use tracer::material::Surface;
use tracer::scene::Loaded;

use crate::args::InfoArgs;
use crate::compare::changed_settings;
use crate::failure::{Verdict, usage};
use crate::render::load_named;
use crate::report::counted;
use crate::spool::Spool;
use crate::stdout::print_line;

/// Runs the command.
pub fn run(args: &InfoArgs) -> Result<Verdict> {
    let mut spool = Spool::default();
    let files = args.files.iter().map(|file| spool.text(file)).collect::<Result<Vec<_>>>()?;
    spool.naming(run_on_files(args, &files))
}

fn run_on_files(args: &InfoArgs, files: &[String]) -> Result<Verdict> {
    let mut reports = Vec::new();
    let called = |file: &String| files.iter().position(|f| f == file).map_or(file, |at| &args.files[at]).clone();
    for files in groups(files) {
        let name = files.iter().map(called).collect::<Vec<_>>().join(" ");
        let report = describe(&files, &name, args)?;
        if !args.json {
            print_line(as_text(&name, &report))?;
        }
        reports.push(report);
    }
    if args.json {
        print_line(Value::Array(reports))?;
    }
    Ok(Verdict::Done)
}

/// Files that are one stack together, as one group; else each by itself.
fn groups(files: &[String]) -> Vec<Vec<String>> {
    let sources: Vec<Source> = files.iter().map(|file| Source::parse(file)).collect();
    if sources.iter().all(|source| is_picture(&source.path)) && is_one_stack(&sources) {
        return vec![files.to_vec()];
    }
    files.iter().map(|file| vec![file.clone()]).collect()
}

fn is_picture(file: &Path) -> bool {
    ["exr", "pfm", "phm"].contains(&extension(file).as_str())
}

fn is_scene(file: &Path) -> bool {
    ["obj", "gltf", "glb", "toml"].contains(&extension(file).as_str())
}

fn describe(files: &[String], name: &str, args: &InfoArgs) -> Result<Value> {
    let sources: Vec<Source> = files.iter().map(|file| Source::parse(file)).collect();
    match &sources[..] {
        [only] if !is_picture(&only.path) && !is_scene(&only.path) => {
            Err(usage(format!("{name}: expected a scene (.obj, .gltf, .glb, .toml) or a stack (.exr, .pfm, .phm)")))
        }
        [only] if !is_picture(&only.path) => Ok(describe_scene(&only.path, &load_named(&only.path)?)),
        _ => Ok(describe_stack(name, &read_inputs(&Inputs::Files(sources), &args.reading.options())?)),
    }
}

fn describe_scene(file: &Path, loaded: &Loaded) -> Value {
    let scene = &loaded.scene;
    let bounds = scene.bounds();
    let surfaces: Vec<Value> =
        scene.materials.iter().map(|m| json!({"name": m.name, "surface": surface(&m.surface)})).collect();
    json!({
        "file": file,
        "triangles": loaded.triangles,
        "dropped": loaded.dropped.degenerate + loaded.dropped.not_finite,
        "materials": surfaces,
        "emitters": scene.emitters.len(),
        "sky": scene.environment.as_ref().map(|sky| sky.mean().to_array()),
        "bounds": [bounds.min.to_array(), bounds.max.to_array()],
        "cameras": loaded.cameras.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        "notes": loaded.notes,
    })
}

const fn surface(surface: &Surface) -> &'static str {
    match surface {
        Surface::Diffuse { .. } => "diffuse",
        Surface::Mirror { .. } => "mirror",
        Surface::Glass { .. } => "glass",
        Surface::ThinGlass { .. } => "thin glass",
        Surface::Conductor { .. } => "rough metal",
        Surface::Coated { .. } => "coated",
    }
}

fn describe_stack(file: &str, read: &ReadStack) -> Value {
    let stack = &read.stack;
    let size = stack.size();
    let estimate = |name: &str, estimate: &Estimate| json!({"layer": name, "noise": noise(estimate)});
    json!({
        "file": file,
        "size": [size.width, size.height],
        "spp": read.found.spp.as_ref().map(|spp| json!({"mean": spp.mean, "min": spp.min, "max": spp.max})),
        "found": read.found,
        "components": stack.components.iter().map(|c| estimate(c.role.layer(), &c.radiance)).collect::<Vec<_>>(),
        "gathered": stack.gathered.as_ref().map(|gathered| estimate(GATHERED, gathered)),
        "indirect": stack.indirect.as_ref().map(|indirect| estimate(INDIRECT, indirect)),
        "features": stack.features.iter().map(|f| estimate(f.role.layer(), &f.estimate)).collect::<Vec<_>>(),
        "passthrough": stack.passthrough.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
        "settings": read.header.as_ref().map(|header| &header.settings),
        "held": read.header.as_ref().and_then(|header| header.record.as_ref()).map(|record| &record.held),
        "notes": read.notes,
    })
}

fn noise(estimate: &Estimate) -> String {
    match &estimate.noise {
        Noise::Buckets(buckets) => format!("{} buckets", buckets.len()),
        Noise::VarianceOfMean(_) => "variance of the mean".into(),
        Noise::Unknown => "unknown".into(),
    }
}

/// The report as text: a line for each thing that is there.
fn as_text(file: &str, report: &Value) -> String {
    let mut lines = vec![file.to_string()];
    lines.extend(if report["triangles"].is_number() { scene_lines(report) } else { stack_lines(report) });
    lines.extend(list(report, "notes").iter().map(|note| format!("  {}", text(note))));
    lines.join("\n")
}

fn scene_lines(report: &Value) -> Vec<String> {
    let (materials, cameras) = (list(report, "materials"), list(report, "cameras"));
    let number = |key: &str, thing: &str| counted(report[key].as_u64().unwrap_or_default() as usize, thing);
    let mut lines = vec![
        format!("  {}, {} dropped, {} emit", number("triangles", "triangle"), report["dropped"], report["emitters"]),
        format!("  bounds {} to {}", report["bounds"][0], report["bounds"][1]),
        format!(
            "  {}, sky {}, {}",
            counted(materials.len(), "material"),
            report["sky"],
            counted(cameras.len(), "camera")
        ),
    ];
    lines.extend(materials.iter().map(|m| format!("    {}: {}", text(&m["name"]), text(&m["surface"]))));
    lines
}

fn stack_lines(report: &Value) -> Vec<String> {
    let size = &report["size"];
    let mut lines =
        vec![format!("  {}x{} pixels, samples per pixel {}", size[0], size[1], spp_in_words(&report["spp"]))];
    for (part, name) in [("components", "component"), ("features", "feature")] {
        let layers = list(report, part);
        lines.extend(layers.iter().map(|l| format!("  {name} {}: noise {}", text(&l["layer"]), text(&l["noise"]))));
    }
    lines.extend(list(report, "passthrough").iter().map(|name| format!("  carried along: {}", text(name))));
    let range = |held: &Value| format!("  samples {}..{} of seed {}", held["first"], held["end"], held["seed"]);
    lines.extend(list(report, "held").iter().map(range));
    lines.extend(settings_lines(&report["settings"]));
    lines
}

fn spp_in_words(spp: &Value) -> String {
    match (spp["mean"].as_f64(), spp["min"].as_u64(), spp["max"].as_u64()) {
        (Some(mean), Some(min), Some(max)) if min < max => format!("{mean:.1} in the mean, {min} to {max}"),
        (Some(_), Some(all), _) => all.to_string(),
        _ => "unknown".into(),
    }
}

/// Recorded settings, as far as they are not the defaults. With `--json` there are all.
fn settings_lines(settings: &Value) -> Vec<String> {
    if settings.is_null() {
        return Vec::new();
    }
    let changed = changed_settings(settings);
    if changed.is_empty() {
        return vec!["  settings: the defaults".into()];
    }
    let line = |[key, value, usual]: &[Value; 3]| {
        format!("  setting {}: {}, by default {}", text(key), text(value), text(usual))
    };
    changed.iter().map(line).collect()
}

fn list(report: &Value, key: &str) -> Vec<Value> {
    report[key].as_array().cloned().unwrap_or_default()
}

fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}
