//! What the network may learn from a guide: inputs of some pixels, and what a weight there costs.

use std::path::Path;

use anyhow::{Context, Result};
use reconstruct::blend::Pair;
use stack::Image;

/// Pixels that are kept of a picture, about.
const PIXELS: usize = 1000;
/// Share of pixels that are left out of mean errors.
const WORST: f64 = 2e-3;

/// Writes `file`: numbers of four bytes, the lower first, and a row for each of some pixels. A row is what the network is
/// told, what is at stake there, then ⟨d, t − x⟩, ⟨d, d⟩ and ⟨x − r₁, x − r₂⟩ at the pixel, and the mean error of the better
/// picture, but no less than a tenth of that of x. All are relative to r² + 0.001, r the mean of the references; x is the first of
/// `pictures`, d what the guide, the second, exceeds it by, t = r.
///
/// # Errors
/// When it cannot be written.
pub fn write_lesson(file: &Path, pair: &Pair, pictures: [&Image; 2], references: &[Image; 2]) -> Result<()> {
    let pixels = pictures[0].pixels();
    let costs: Vec<[f32; 3]> = (0..pixels).map(|pixel| costs(pictures, references, pixel)).collect();
    let better = better(&costs);
    // A prime step does not keep to columns.
    let step = (pixels / PIXELS).max(1) | 1;
    let mut bytes = Vec::new();
    for pixel in (0..pixels).step_by(step) {
        let row = pair.told(pixel).into_iter().chain([pair.stake(pixel)]).chain(costs[pixel]).chain([better]);
        bytes.extend(row.flat_map(f32::to_le_bytes));
    }
    std::fs::write(file, bytes).with_context(|| format!("{}: cannot write", file.display()))
}

/// ⟨d, t − x⟩, ⟨d, d⟩ and the error of x, mean over RGB.
fn costs([x, g]: [&Image; 2], [first, second]: &[Image; 2], pixel: usize) -> [f32; 3] {
    let [x, g, first, second] = [x, g, first, second].map(|image| image.rgb(pixel));
    let mut sums = [0.0; 3];
    for c in 0..3 {
        let (r, d) = (0.5 * (first[c] + second[c]), g[c] - x[c]);
        let scale = 1.0 / (3.0 * (r * r + 1e-3));
        let of_channel = [d * (r - x[c]), d * d, (x[c] - first[c]) * (x[c] - second[c])];
        sums.iter_mut().zip(of_channel).for_each(|(sum, cost)| *sum += scale * cost);
    }
    sums
}

/// Mean error of the better of picture and guide, without the worst pixels.
fn better(costs: &[[f32; 3]]) -> f32 {
    let mut errors: Vec<[f32; 2]> = costs.iter().map(|[n, d, e]| [*e, e + d - 2.0 * n]).collect();
    errors.sort_by(|a, b| (a[0].abs() + a[1].abs()).total_cmp(&(b[0].abs() + b[1].abs())));
    let kept = errors.len() - (errors.len() as f64 * WORST) as usize;
    let mean = |which: usize| errors[..kept].iter().map(|e| e[which]).sum::<f32>() / kept.max(1) as f32;
    mean(0).min(mean(1)).max(0.1 * mean(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn costs_are_those_of_the_mixture() {
        let flat = |v: f32| Image::from_channels(Size::new(1, 1), vec![vec![v]; 3]);
        let (x, g, truth) = (flat(1.0), flat(2.0), flat(1.5));
        let [n, d, e] = costs([&x, &g], &[truth.clone(), truth], 0);
        let at = |w: f32| e + w * w * d - 2.0 * w * n;
        assert!((at(0.0) - 0.25 / 2.251).abs() < 1e-6 && (at(1.0) - at(0.0)).abs() < 1e-6 && at(0.5).abs() < 1e-6);
        assert!((better(&[[n, d, e]]) - e).abs() < 1e-6);
    }
}
