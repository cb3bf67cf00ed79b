//! Every pixel rebuilt by a local regression on the features.
//!
//! The steps of a pixel are those of the paper, one file each: the window of neighbours (`window`); the directions in
//! which its features vary (`reduce`, section 4.3, by `robust_pca`); the pilot bandwidth (`bandwidth`, section 4.4);
//! the curvature along each direction (`curvature`); the local linear estimate and its error (`local_linear`, section
//! 3.1). Neighbouring pixels take them side by side, in the lanes of the processor's vectors (`lanes`).

pub(crate) mod bandwidth;
pub(crate) mod cholesky;
pub(crate) mod curvature;
pub(crate) mod field;
pub(crate) mod lanes;
pub(crate) mod local_linear;
mod matrix;
pub(crate) mod neighbours;
pub(crate) mod normal_equations;
mod power_iteration;
pub(crate) mod reduce;
mod robust_pca;
mod row;
mod symmetric_eigen;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod twin;
pub(crate) mod window;

use stack::{Cancelled, Image, Monitor};

use crate::pieces::of_each;
use crate::prefilter::FeatureSet;
use field::Field;
use row::{Row, RowTask};

pub use bandwidth::{BandwidthSettings, pilot_bandwidth};
pub use curvature::CurvatureSettings;
pub use local_linear::LocalLinearSettings;
pub use reduce::{Energy, RankRule, ReductionMethod, ReductionSettings};
pub use robust_pca::{Lambda, Order};
pub use window::{Normalisation, WindowSettings};

stack::knob_groups! {
    /// Settings of the regression.
    pub struct RegressionSettings {
        /// Size and scaling of the window.
        window: WindowSettings,
        /// Dimensionality reduction.
        reduction: ReductionSettings,
        /// Shared bandwidth.
        bandwidth: BandwidthSettings,
        /// Bandwidth factors.
        curvature: CurvatureSettings,
        /// Local linear estimate.
        local_linear: LocalLinearSettings,
    }
}

/// What the regression starts from. All planes have the size of `features`.
#[derive(Clone, Copy, Debug)]
pub struct RegressionInput<'a> {
    /// Radiance freed of spikes, three finite channels.
    pub colour: &'a Image,
    /// Variance of its mean, three channels, finite and ≥ 0.
    pub variance: &'a Image,
    /// Prefiltered features.
    pub features: &'a FeatureSet,
    /// Pixels to rebuild; the others keep their colour with an error of zero. `None`: all.
    pub active: Option<&'a [bool]>,
}

/// The steps whose time is reported to the monitor, in order.
pub const STEPS: [&str; 4] = ["reduce", "bandwidth", "curvature", "regression"];

/// What the regression finds, one value per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    /// The estimate α̂ (eq. 4), three channels.
    pub picture: Image,
    /// Estimated mean squared error (eq. 7), mean over RGB.
    pub mse: Vec<f32>,
    /// Shared bandwidth h (eq. 14).
    pub bandwidth: Vec<f32>,
    /// Rank k of the reduced space (eq. 12).
    pub rank: Vec<f32>,
    /// How many pixels kept their colour, and its variance as error, because no other pixel of their window resembles
    /// them.
    pub kept: usize,
}

impl Regression {
    /// Nothing rebuilt yet: the colours of `input`, and no error.
    fn unchanged(input: &RegressionInput) -> Self {
        let nothing = vec![0.0; input.features.size.pixels()];
        Self { picture: input.colour.clone(), mse: nothing.clone(), bandwidth: nothing.clone(), rank: nothing, kept: 0 }
    }

    fn take(&mut self, y: usize, row: &Row) {
        let width = self.picture.size().width;
        let pixels = y * width..(y + 1) * width;
        for (channel, values) in self.picture.channels_mut().iter_mut().zip(&row.colour) {
            channel[pixels.clone()].copy_from_slice(values);
        }
        self.mse[pixels.clone()].copy_from_slice(&row.mse);
        self.bandwidth[pixels.clone()].copy_from_slice(&row.bandwidth);
        self.rank[pixels].copy_from_slice(&row.rank);
        self.kept += row.kept;
    }
}

/// Rebuilds every active pixel by a local linear regression on the features of its window (sections 3.1, 4.3, 4.4).
/// Reports one unit per row as stage `regression`, and how its time was spent on [`STEPS`].
///
/// # Errors
/// When `monitor` cancels.
pub fn regress(
    input: &RegressionInput,
    settings: &RegressionSettings,
    monitor: &dyn Monitor,
) -> Result<Regression, Cancelled> {
    let field = Field::new(input, settings.window.radius);
    let processor = pulp::Arch::new();
    monitor.begin("regression", field.size.height as u64);
    let row = |y| processor.dispatch(RowTask { input, field: &field, settings, y });
    let rows = of_each(0..field.size.height, monitor, row)?;
    let mut regression = Regression::unchanged(input);
    for (y, row) in rows.iter().enumerate() {
        regression.take(y, row);
    }
    for (i, step) in STEPS.into_iter().enumerate() {
        monitor.spent(step, rows.iter().map(|row| row.step_seconds[i]).sum());
    }
    Ok(regression)
}
