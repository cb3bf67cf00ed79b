//! The JSON that `render` prints.

use serde_json::{Value, json};
use tracer::scene::Scene;

use super::{Finished, Plan, View};
use crate::guide::Followed;
use crate::memory;
use crate::output::{Outputs, Written};
use crate::progress::Progress;
use crate::report::{energy, estimated_rmse, mean_radiance, stages};

/// Seconds of the steps that are no stage of the loop.
pub struct Clock {
    pub load: f64,
    pub build: f64,
    pub write: f64,
    pub total: f64,
}

/// All that is told of a render.
pub struct Rendered<'a> {
    pub outputs: &'a Outputs,
    pub written: &'a Written<'a>,
    pub plan: &'a Plan,
    pub finished: &'a Finished,
    pub clock: Clock,
    pub progress: &'a Progress,
    pub view: &'a View,
}

impl Rendered<'_> {
    /// The object `render --json` prints. Unknown values are `null`.
    pub fn json(&self) -> Value {
        let Self { outputs, written, plan, finished, clock, progress, view } = self;
        let size = written.stack.size();
        let (mean, min, max) = written.stack.samples.mean_min_max();
        let trace = progress.seconds("trace");
        let reconstruct = written.reconstruction.map(|_| progress.total_seconds() - trace);
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
            "guide": finished.guide.as_ref().map(Followed::json),
            "peak_bytes": memory::peak_bytes(),
            "seed": plan.settings.trace.seed,
            "preset": plan.preset,
            "settings": plan.settings.to_json(),
        })
    }
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
