//! `tamis info`: what a scene or stack holds, as Tamis reads it.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use stack::file::{ReadStack, read_stack};
use stack::{Estimate, Noise};
use tracer::material::Surface;
use tracer::scene::{Loaded, load};

use crate::args::InfoArgs;
use crate::failure::Verdict;
use crate::output::ending;

/// Runs the command.
pub fn run(args: &InfoArgs) -> Result<Verdict> {
    let mut reports = Vec::new();
    for file in &args.files {
        let report = describe(file)?;
        if !args.json {
            print(file, &report);
        }
        reports.push(report);
    }
    if args.json {
        println!("{}", Value::Array(reports));
    }
    Ok(Verdict::Done)
}

fn describe(file: &Path) -> Result<Value> {
    match ending(file).as_str() {
        "exr" => Ok(describe_stack(file, &read_stack(file)?)),
        _ => Ok(describe_scene(file, &load(file)?)),
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
        "sky": scene.environment.map(|sky| sky.to_array()),
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
        Surface::Conductor { .. } => "rough metal",
        Surface::Coated { .. } => "coated",
    }
}

fn describe_stack(file: &Path, read: &ReadStack) -> Value {
    let stack = &read.stack;
    let size = stack.size();
    let (mean, min, max) = stack.samples.mean_min_max();
    let estimate = |name: &str, estimate: &Estimate| json!({"layer": name, "noise": noise(estimate)});
    json!({
        "file": file,
        "size": [size.width, size.height],
        "spp": if read.header.is_some() { json!({"mean": mean, "min": min, "max": max}) } else { Value::Null },
        "components": stack.components.iter().map(|c| estimate(c.role.layer(), &c.radiance)).collect::<Vec<_>>(),
        "features": stack.features.iter().map(|f| estimate(f.role.layer(), &f.estimate)).collect::<Vec<_>>(),
        "passthrough": stack.passthrough.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
        "settings": read.header.as_ref().map(|header| &header.settings),
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
fn print(file: &Path, report: &Value) {
    println!("{}", file.display());
    let list = |key: &str| report[key].as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), String::from);
    if report["triangles"].is_number() {
        println!("  {} triangles, {} dropped, {} emit", report["triangles"], report["dropped"], report["emitters"]);
        println!("  bounds {} to {}", report["bounds"][0], report["bounds"][1]);
        println!("  {} materials, sky {}, {} cameras", list("materials").len(), report["sky"], list("cameras").len());
        list("materials").iter().for_each(|m| println!("    {}: {}", text(&m["name"]), text(&m["surface"])));
    } else {
        println!("  {}x{} pixels, samples per pixel {}", report["size"][0], report["size"][1], report["spp"]);
        for part in ["components", "features"] {
            for layer in list(part) {
                println!("  {} {}: noise {}", &part[..part.len() - 1], text(&layer["layer"]), text(&layer["noise"]));
            }
        }
        list("passthrough").iter().for_each(|name| println!("  carried along: {}", text(name)));
        println!("  settings {}", report["settings"]);
    }
    list("notes").iter().for_each(|note| println!("  {}", text(note)));
}
