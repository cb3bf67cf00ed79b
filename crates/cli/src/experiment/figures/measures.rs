//! What the figures measure.

use stack::Image;

use super::features::{surfaces_error, visibility_error};
use super::outcome::Outcome;
use super::subject::Subject;

/// A number about an outcome; `None` when it is not known.
pub struct Measure {
    /// Title of its column.
    pub head: &'static str,
    /// How it is found.
    pub of: fn(&Outcome, &Subject) -> Option<f64>,
}

pub const ERROR: Measure = Measure { head: "cross rMSE", of: |o, _| o.comparison.rmse_cross };
pub const TRIMMED: Measure = Measure { head: "trimmed", of: |o, _| o.comparison.rmse_cross_trimmed };
pub const SSIM: Measure = Measure { head: "SSIM", of: |o, _| o.comparison.ssim };
pub const ENERGY: Measure = Measure { head: "energy", of: |o, _| o.comparison.energy_ratio };

pub const SECONDS: Measure = Measure { head: "seconds in all", of: |o, _| Some(o.seconds()) };
pub const SPIKE_SECONDS: Measure = Measure { head: "seconds for spikes", of: |o, _| o.seconds_of("spikes") };
pub const PREFILTER_SECONDS: Measure = Measure { head: "for the prefilter", of: |o, _| o.seconds_of("prefilter") };
pub const REDUCE_SECONDS: Measure = Measure { head: "for the reduction", of: |o, _| o.seconds_of("reduce") };
pub const BANDWIDTH_SECONDS: Measure = Measure { head: "for the bandwidth", of: |o, _| o.seconds_of("bandwidth") };
pub const CURVATURE_SECONDS: Measure = Measure { head: "for the curvature", of: |o, _| o.seconds_of("curvature") };
pub const REGRESSION_SECONDS: Measure = Measure { head: "for the regression", of: |o, _| o.seconds_of("regression") };

pub const RANK: Measure = Measure { head: "mean k", of: |o, _| Some(mean(o.found.rank.as_ref()?)) };
pub const BANDWIDTH_LOW: Measure = Measure { head: "h, 10 %", of: |o, _| quantile(o.found.bandwidth.as_ref()?, 0.1) };
pub const BANDWIDTH_MEDIAN: Measure =
    Measure { head: "h, 50 %", of: |o, _| quantile(o.found.bandwidth.as_ref()?, 0.5) };
pub const BANDWIDTH_HIGH: Measure = Measure { head: "h, 90 %", of: |o, _| quantile(o.found.bandwidth.as_ref()?, 0.9) };

/// Pixels that were replaced.
pub const MARKED: Measure = Measure {
    head: "replaced, %",
    of: |o, _| {
        let replaced = replaced(o.found.spikes.as_ref()?);
        Some(100.0 * replaced.len() as f64 / o.found.mse.len() as f64)
    },
};

/// Of the replaced pixels, those that were no brighter than twice what is right: signal or ordinary noise.
pub const SIGNAL: Measure = Measure {
    head: "of them below twice the truth, %",
    of: |o, subject| {
        let replaced = replaced(o.found.spikes.as_ref()?);
        let noisy = subject.case.stack.beauty();
        let below = replaced.iter().filter(|pixel| noisy.mean_at(**pixel) <= 2.0 * truth(subject, **pixel));
        (!replaced.is_empty()).then(|| 100.0 * below.count() as f64 / replaced.len() as f64)
    },
};

/// Pixels more than three times as bright as anything right within 3×3 pixels.
pub const TOO_BRIGHT: Measure = Measure {
    head: "far too bright, ‰",
    of: |o, subject| {
        let picture = &o.found.picture;
        let is_bright = |pixel: &usize| picture.mean_at(*pixel) > 3.0 * brightest_around(subject, *pixel) + 0.01;
        Some(1000.0 * (0..picture.pixels()).filter(is_bright).count() as f64 / picture.pixels() as f64)
    },
};

/// Mean squared error of the prefiltered visibility, 0 … 1.
pub const VISIBILITY_ERROR: Measure = Measure { head: "MSE of visibility", of: visibility_error };
/// Mean squared error of the prefiltered normals and albedo.
pub const SURFACES_ERROR: Measure = Measure { head: "MSE of normals and albedo", of: surfaces_error };

fn replaced(spikes: &Image) -> Vec<usize> {
    (0..spikes.pixels()).filter(|pixel| spikes.rgb(*pixel) != [0.0; 3]).collect()
}

/// Luminance of both references.
fn truth(subject: &Subject, pixel: usize) -> f32 {
    let [a, b] = &subject.case.references;
    0.5 * (a.mean_at(pixel) + b.mean_at(pixel))
}

fn brightest_around(subject: &Subject, pixel: usize) -> f32 {
    let size = subject.case.references[0].size();
    let (x, y) = (pixel % size.width, pixel / size.width);
    let columns = x.saturating_sub(1)..(x + 2).min(size.width);
    let rows = y.saturating_sub(1)..(y + 2).min(size.height);
    let block = rows.flat_map(|y| columns.clone().map(move |x| size.index(x, y)));
    block.map(|pixel| truth(subject, pixel)).fold(0.0, f32::max)
}

fn mean(plane: &[f32]) -> f64 {
    plane.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.len().max(1) as f64
}

/// The value that the share `share` of `plane` does not exceed.
fn quantile(plane: &[f32], share: f64) -> Option<f64> {
    let mut sorted = plane.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted.get((sorted.len().saturating_sub(1) as f64 * share) as usize).map(|v| f64::from(*v))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        let plane = [5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!([0.0, 0.5, 1.0].map(|share| quantile(&plane, share)), [Some(1.0), Some(3.0), Some(5.0)]);
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(mean(&plane), 3.0);
    }
}
