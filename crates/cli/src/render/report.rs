//! The JSON that `render` and `denoise` print.

use reconstruct::adaptive::estimated_rmse as relative_mse;
use serde_json::{Map, Value, json};
use stack::Image;
use tracer::scene::Scene;

use super::{Finished, Plan, View};
use crate::memory;
use crate::output::{Outputs, Written};
use crate::progress::Progress;

/// Seconds of the steps that are no stage of the loop.
pub struct Clock {
    pub load: f64,
    pub build: f64,
    pub write: f64,
    pub total: f64,
}

/// What the stack lacked and what was used in its stead, a line each.
pub fn lacks(written: &Written<'_>) -> Vec<String> {
    written.reconstruction.iter().flat_map(|found| &found.lacks).map(ToString::to_string).collect()
}

/// The object `render --json` prints. Unknown values are `null`.
pub fn render(
    outputs: &Outputs,
    written: &Written<'_>,
    plan: &Plan,
    finished: &Finished,
    clock: &Clock,
    progress: &Progress,
    view: &View,
) -> Value {
    let size = written.stack.size();
    let (mean, min, max) = written.stack.samples.mean_min_max();
    let trace = progress.seconds("trace");
    // From 0 on: the sum of nothing is -0.
    let reconstruct = progress.stage_seconds().iter().fold(0.0, |sum, (_, seconds)| sum + seconds) - trace;
    let iterations: Vec<Value> = finished
        .rounds
        .iter()
        .map(|round| json!({"spp": round.spp, "estimated_rmse": round.estimated_rmse, "seconds": round.seconds}))
        .collect();
    json!({
        "output": outputs.files(),
        "width": size.width,
        "height": size.height,
        "spp": {"mean": mean, "min": min, "max": max},
        "samples": finished.samples,
        "rays": finished.rays,
        "not_finite": finished.not_finite,
        "triangles": triangles(&view.scene),
        "textures_missing": view.missing_textures,
        "seconds": {
            "load": clock.load, "build": clock.build, "trace": trace, "reconstruct": reconstruct,
            "write": clock.write, "total": clock.total,
        },
        "stages": stages(progress),
        "estimated_rmse": estimated_rmse(written),
        "energy": energy(mean_radiance(&written.stack.beauty()), written.picture),
        "iterations": iterations,
        "peak_bytes": memory::peak_bytes(),
        "seed": plan.settings.trace.seed,
        "preset": plan.preset,
        "settings": plan.settings.to_json(),
    })
}

/// How many triangles there are, counting those of every instance, how many are stored, and how many were left out because
/// they have no area or coordinates that are not finite.
fn triangles(scene: &Scene) -> Value {
    let dropped = scene.dropped();
    json!({
        "total": scene.triangles(), "stored": scene.stored_triangles(),
        "degenerate": dropped.degenerate, "not_finite": dropped.not_finite,
    })
}

/// Seconds per stage of the reconstruction.
pub fn stages(progress: &Progress) -> Value {
    let stages = progress.stage_seconds().into_iter().filter(|(name, _)| *name != "trace");
    Value::Object(stages.map(|(name, seconds)| (name.to_string(), json!(seconds))).collect::<Map<_, _>>())
}

/// Estimated relative MSE of the picture, when it was reconstructed.
pub fn estimated_rmse(written: &Written<'_>) -> Option<f64> {
    written.reconstruction.map(|r| relative_mse(&r.mse, &r.picture))
}

/// Mean radiance of the noisy picture and of the result.
pub fn energy(noisy: f64, result: &Image) -> Value {
    json!({"noisy": noisy, "result": mean_radiance(result)})
}

/// Mean of all values.
pub fn mean_radiance(image: &Image) -> f64 {
    let sum: f64 = image.channels().iter().flatten().map(|v| f64::from(*v)).sum();
    sum / (3 * image.pixels()) as f64
}
