//! What a loop of tracing and reconstruction leaves.

use reconstruct::Reconstruction;
use stack::{FeatureStack, Image};
use tracer::integrator::TraceReport;

use crate::guide::Followed;

/// One turn of the loop.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    /// Mean samples per pixel at its end.
    pub spp: f64,
    /// Estimated relative MSE of the picture then.
    pub estimated_rmse: Option<f64>,
    /// Seconds since the loop began.
    pub seconds: f64,
}

/// What the loop leaves.
pub struct Finished {
    pub stack: FeatureStack,
    pub reconstruction: Option<Reconstruction>,
    pub rounds: Vec<Round>,
    /// Samples that were traced; a film that was begun by an earlier run holds more.
    pub samples: u64,
    pub rays: u64,
    /// Samples that were NaN or infinite and count as zero.
    pub not_finite: u64,
    /// Whether Ctrl-C ended it.
    pub interrupted: bool,
    /// A target error was given and not reached.
    pub missed_target: bool,
    /// How far another denoiser's picture was followed.
    pub guide: Option<Followed>,
}

impl Finished {
    /// A `stack` that is not rebuilt, after the work that `report` tells of.
    pub fn unrebuilt(stack: FeatureStack, report: &TraceReport) -> Self {
        Self {
            stack,
            reconstruction: None,
            rounds: Vec::new(),
            samples: report.samples,
            rays: report.rays,
            not_finite: report.not_finite,
            interrupted: false,
            missed_target: false,
            guide: None,
        }
    }

    /// The picture to show: reconstructed, or as it was sampled.
    pub fn picture(&self) -> Image {
        self.reconstruction.as_ref().map_or_else(|| self.stack.beauty(), |r| r.picture.clone())
    }
}
