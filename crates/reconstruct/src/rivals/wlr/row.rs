//! One row of pixels, a vector's width at a time: first to learn how the error follows the bandwidth, then to rebuild.

use pulp::{Simd, WithSimd};

use super::WlrSettings;
use super::error_model::{ErrorModel, TRIED};
use super::trust::Reliability;
use crate::regression::RegressionSettings;
use crate::regression::bandwidth::{BandwidthSettings, Projection};
use crate::regression::curvature::Curvature;
use crate::regression::field::Field;
use crate::regression::lanes::{Lanes, MOST_LANES};
use crate::regression::local_linear::{Estimate, LocalLinear};
use crate::regression::neighbours::Neighbours;
use crate::regression::reduce::{Reduction, Truncation};
use crate::regression::window::Window;

/// What all rows share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shared<'a> {
    pub(crate) field: &'a Field,
    /// Mean over the window of each group's variance, summed over its channels.
    pub(crate) noise: &'a [Vec<f32>],
    pub(crate) wlr: &'a WlrSettings,
    pub(crate) regression: &'a RegressionSettings,
}

/// Learns the error model of every pixel of row `y`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search<'a> {
    pub(crate) shared: Shared<'a>,
    pub(crate) y: usize,
}

/// Rebuilds row `y` with the given shared `bandwidth` of each of its pixels; without, with the pilot bandwidth of our
/// paper's eq. 14.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rebuild<'a> {
    pub(crate) shared: Shared<'a>,
    pub(crate) y: usize,
    pub(crate) bandwidth: Option<&'a [f32]>,
}

/// A rebuilt row.
#[derive(Clone, Debug)]
pub(crate) struct RebuiltRow {
    pub(crate) colour: [Vec<f32>; 3],
    /// Squared bias and variance of this very estimate (eq. 7 of our paper).
    pub(crate) mse: Vec<f32>,
    pub(crate) bandwidth: Vec<f32>,
    pub(crate) rank: Vec<f32>,
}

/// All room a row needs.
#[derive(Debug)]
struct Workspace<S: Simd> {
    simd: S,
    window: Window<S>,
    reduction: Reduction<S>,
    projection: Projection<S>,
    curvature: Curvature<S>,
    local_linear: LocalLinear<S>,
    steady: Reliability<S>,
    confident: Reliability<S>,
}

impl<S: Simd> Workspace<S> {
    fn new(simd: S, field: &Field) -> Self {
        Self {
            simd,
            window: Window::new(simd, field),
            reduction: Reduction::new(simd, field),
            projection: Projection::new(simd, field),
            curvature: Curvature::new(simd, field),
            local_linear: LocalLinear::new(simd, field),
            steady: Reliability::new(simd, field),
            confident: Reliability::new(simd, field),
        }
    }

    /// Everything up to the fit, for the pixels from `x` on in row `y`: local coordinates, pilot bandwidth, feature
    /// bandwidths.
    #[inline(always)]
    fn prepare(&mut self, shared: &Shared, x: usize, y: usize) {
        let field = shared.field;
        self.window.move_to(field, x, y);
        let start = field.size.index(x, y);
        let simd = self.simd;
        let WlrSettings { thin, perturbation, .. } = *shared.wlr;
        let how = Truncation { stride: shared.regression.reduction.stride, thin, perturbation };
        self.reduction
            .truncate(field, &mut self.window, how, |window, rows| expected_error(simd, shared, window, start) * rows);
        self.projection.find(field, &self.window, &self.reduction, &BandwidthSettings::DEFAULT);
        self.steady.by_variance(field, &self.window);
        self.confident.by_confidence(&self.steady, field, &self.window, shared.wlr);
        let neighbours = Neighbours {
            field,
            window: &self.window,
            projection: &self.projection,
            rank: self.reduction.largest_rank,
            trust: &self.steady,
        };
        self.curvature.find(&neighbours, &shared.regression.curvature);
    }

    /// The local linear fit with shared bandwidth `h`.
    #[inline(always)]
    fn fit(&mut self, shared: &Shared, h: Lanes<S>) -> Estimate<S> {
        self.projection.shared = h;
        let neighbours = Neighbours {
            field: shared.field,
            window: &self.window,
            projection: &self.projection,
            rank: self.reduction.largest_rank,
            trust: &self.confident,
        };
        self.local_linear.estimate(&neighbours, &self.curvature.factors, &shared.regression.local_linear).0
    }
}

/// Expected squared length of a row of feature noise in the window's scales: Σ over groups of scale² · variance.
#[inline(always)]
fn expected_error<S: Simd>(simd: S, shared: &Shared, window: &Window<S>, start: usize) -> Lanes<S> {
    let mut sum = Lanes::splat(simd, 0.0);
    for (group, noise) in shared.field.groups.iter().zip(shared.noise) {
        let mut scale = Lanes::splat(simd, 0.0);
        for feature in group.clone() {
            scale = scale.max(window.scales[feature]);
        }
        let mut here = [0.0; MOST_LANES];
        for (to, from) in here.iter_mut().zip(&noise[start..]) {
            *to = *from;
        }
        sum += scale.squared() * Lanes::load(simd, &here);
    }
    sum
}

impl WithSimd for Search<'_> {
    type Output = Vec<ErrorModel>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<ErrorModel> {
        let width = self.shared.field.size.width;
        let mut workspace = Workspace::new(simd, self.shared.field);
        let mut models = Vec::with_capacity(width);
        for start in (0..width).step_by(Lanes::<S>::COUNT) {
            workspace.prepare(&self.shared, start, self.y);
            // A plain loop: closures given to `map` would not be compiled for the processor's vectors.
            let (mut biases, mut variances) = ([[0.0; MOST_LANES]; TRIED.len()], [[0.0; MOST_LANES]; TRIED.len()]);
            for (i, h) in TRIED.into_iter().enumerate() {
                let estimate = workspace.fit(&self.shared, Lanes::splat(simd, h));
                biases[i] = estimate.bias.to_array();
                variances[i] = estimate.variance.to_array();
            }
            for lane in 0..Lanes::<S>::COUNT.min(width - start) {
                let (biases, variances) = (biases.map(|b| b[lane]), variances.map(|v| v[lane]));
                models.push(ErrorModel::fit(workspace.reduction.rank[lane], &biases, &variances));
            }
        }
        models
    }
}

impl WithSimd for Rebuild<'_> {
    type Output = RebuiltRow;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> RebuiltRow {
        let width = self.shared.field.size.width;
        let mut workspace = Workspace::new(simd, self.shared.field);
        let mut row = RebuiltRow::new(width);
        for start in (0..width).step_by(Lanes::<S>::COUNT) {
            workspace.prepare(&self.shared, start, self.y);
            let mut h = workspace.projection.shared.to_array();
            if let Some(bandwidth) = self.bandwidth {
                h.iter_mut().zip(&bandwidth[start..]).for_each(|(h, given)| *h = *given);
            }
            let estimate = workspace.fit(&self.shared, Lanes::load(simd, &h));
            let (colour, mse) = (estimate.colour.map(|c| c.to_array()), estimate.mse.to_array());
            for lane in 0..Lanes::<S>::COUNT.min(width - start) {
                (0..3).for_each(|c| row.colour[c].push(colour[c][lane].max(0.0)));
                row.mse.push(mse[lane]);
                row.bandwidth.push(h[lane]);
                row.rank.push(workspace.reduction.rank[lane] as f32);
            }
        }
        row
    }
}

impl RebuiltRow {
    fn new(width: usize) -> Self {
        let room = || Vec::with_capacity(width);
        Self { colour: [0; 3].map(|_| room()), mse: room(), bandwidth: room(), rank: room() }
    }
}
