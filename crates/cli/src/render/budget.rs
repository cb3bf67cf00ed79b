//! When a render ends.

use std::time::Duration;

use stack::SampleCounts;

/// When to stop: at what is reached first.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Number of the first sample.
    pub first: u32,
    /// Mean samples per pixel, when that bounds the work.
    pub spp: Option<u32>,
    /// Time for tracing and reconstruction.
    pub time: Duration,
    /// Estimated relative MSE that is good enough.
    pub target_error: Option<f32>,
    /// The same number of samples everywhere.
    pub uniform: bool,
}

impl Budget {
    /// `spp` samples for every pixel.
    pub const fn uniform(spp: u32) -> Self {
        Self { first: 0, spp: Some(spp), time: Duration::MAX, target_error: None, uniform: true }
    }

    /// Whether `counts` are as many samples as may be taken.
    pub fn is_spent_by(&self, counts: &SampleCounts) -> bool {
        let Some(spp) = self.spp else { return false };
        let (mean, least, _) = counts.mean_min_max();
        if self.uniform { least >= spp } else { mean >= f64::from(spp) }
    }

    /// Whether an estimated `error` is as low as the target, if there is one.
    pub fn is_met_by(&self, error: f64) -> bool {
        self.target_error.is_some_and(|target| error <= f64::from(target))
    }
}
