//! What the JSON of `render` and of `denoise` have in common.

use reconstruct::adaptive::estimated_rmse as relative_mse;
use serde_json::{Map, Value, json};
use stack::Image;

use crate::output::Written;
use crate::progress::Progress;

/// What the stack lacked and what was used in its stead, a line each.
pub fn lacks(written: &Written<'_>) -> Vec<String> {
    written.reconstruction.iter().flat_map(|found| &found.lacks).map(ToString::to_string).collect()
}

/// How long it took in all, and the stages that took long enough to be named.
pub fn done_in(seconds: f64, progress: &Progress) -> String {
    let stages = progress.stage_seconds().into_iter().filter(|(_, s)| *s >= SHORTEST);
    let stages: Vec<String> = stages.map(|(name, s)| format!("{name} {s:.1} s")).collect();
    let stages = if stages.is_empty() { String::new() } else { format!(" ({})", stages.join(", ")) };
    format!("done in {seconds:.1} s{stages}")
}

/// Seconds that are not written as 0.0.
const SHORTEST: f64 = 0.05;

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

/// A number of things, of which one is called `thing`.
pub fn counted(number: usize, thing: &str) -> String {
    if number == 1 { format!("1 {thing}") } else { format!("{number} {thing}s") }
}

/// Mean of all values.
pub fn mean_radiance(image: &Image) -> f64 {
    let sum: f64 = image.channels().iter().flatten().map(|v| f64::from(*v)).sum();
    sum / (3 * image.pixels()) as f64
}
