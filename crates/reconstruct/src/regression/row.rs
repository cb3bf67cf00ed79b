//! One row of pixels, rebuilt a vector's width at a time.

use std::time::Instant;

use pulp::{Simd, WithSimd};

use super::bandwidth::Projection;
use super::curvature::Curvature;
use super::field::Field;
use super::lanes::{Lanes, MOST_LANES};
use super::local_linear::LocalLinear;
use super::neighbours::Neighbours;
use super::reduce::Reduction;
use super::window::Window;
use super::{RegressionInput, RegressionSettings, STEPS};

/// A row to rebuild.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowTask<'a> {
    pub(crate) input: &'a RegressionInput<'a>,
    pub(crate) field: &'a Field,
    pub(crate) settings: &'a RegressionSettings,
    pub(crate) y: usize,
}

/// A rebuilt row, see [`super::Regression`].
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) colour: [Vec<f32>; 3],
    pub(crate) mse: Vec<f32>,
    pub(crate) bandwidth: Vec<f32>,
    pub(crate) rank: Vec<f32>,
    pub(crate) kept: usize,
    pub(crate) step_seconds: [f64; STEPS.len()],
}

/// All room a row needs.
#[derive(Debug)]
struct Workspace<S: Simd> {
    window: Window<S>,
    reduction: Reduction<S>,
    projection: Projection<S>,
    curvature: Curvature<S>,
    local_linear: LocalLinear<S>,
}

/// The pixels worked on side by side, as plain numbers: entry i belongs to the i-th of them.
#[derive(Clone, Copy, Debug)]
struct Rebuilt {
    colour: [[f32; MOST_LANES]; 3],
    mse: [f32; MOST_LANES],
    bandwidth: [f32; MOST_LANES],
    rank: [usize; MOST_LANES],
    /// 1 where no neighbour resembles the pixel.
    alone: [f32; MOST_LANES],
}

impl WithSimd for RowTask<'_> {
    type Output = Row;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Row {
        let width = self.field.size.width;
        let mut workspace = Workspace::new(simd, self.field);
        let mut row = self.unchanged();
        for start in (0..width).step_by(Lanes::<S>::COUNT) {
            let pixels = start..(start + Lanes::<S>::COUNT).min(width);
            if pixels.clone().any(|x| self.is_active(x)) {
                workspace.window.move_to(self.field, start, self.y);
                let rebuilt = workspace.rebuild(self.field, self.settings, &mut row.step_seconds);
                for x in pixels.filter(|x| self.is_active(*x)) {
                    row.write(x, &rebuilt, x - start);
                }
            }
        }
        self.keep_what_was_not_rebuilt(&mut row);
        row
    }
}

impl RowTask<'_> {
    fn unchanged(&self) -> Row {
        let width = self.field.size.width;
        let pixels = self.y * width..(self.y + 1) * width;
        let colour = [0, 1, 2].map(|c| self.input.colour.channels()[c][pixels.clone()].to_vec());
        let (mse, bandwidth, rank) = (vec![0.0; width], vec![0.0; width], vec![0.0; width]);
        Row { colour, mse, bandwidth, rank, kept: 0, step_seconds: [0.0; STEPS.len()] }
    }

    fn is_active(&self, x: usize) -> bool {
        self.input.active.is_none_or(|active| active[self.field.size.index(x, self.y)])
    }

    /// An estimate that is not finite gives way to the pixel's own colour and variance.
    fn keep_what_was_not_rebuilt(&self, row: &mut Row) {
        for x in 0..row.mse.len() {
            let finite = row.colour.iter().all(|channel| channel[x].is_finite()) && row.mse[x].is_finite();
            if !finite {
                let pixel = self.field.size.index(x, self.y);
                for (values, channel) in row.colour.iter_mut().zip(self.input.colour.channels()) {
                    values[x] = channel[pixel];
                }
                row.mse[x] = self.input.variance.channels().iter().map(|channel| channel[pixel] / 3.0).sum();
                row.kept += 1;
            }
        }
    }
}

impl<S: Simd> Workspace<S> {
    fn new(simd: S, field: &Field) -> Self {
        Self {
            window: Window::new(simd, field),
            reduction: Reduction::new(simd, field),
            projection: Projection::new(simd, field),
            curvature: Curvature::new(simd, field),
            local_linear: LocalLinear::new(simd, field),
        }
    }

    /// Rebuilds the pixels the window stands on; adds the time of each step to `seconds`.
    #[inline(always)]
    fn rebuild(&mut self, field: &Field, settings: &RegressionSettings, seconds: &mut [f64; STEPS.len()]) -> Rebuilt {
        let (window, projection) = (&mut self.window, &mut self.projection);
        let begin = Instant::now();
        self.reduction.find(field, window, settings.window.normalise, &settings.reduction);
        let (rank, window) = (self.reduction.largest_rank, &*window);
        let reduced = Instant::now();
        projection.find(field, window, &self.reduction, &settings.bandwidth);
        let projected = Instant::now();
        let neighbours = Neighbours { field, window, projection, rank, trust: window };
        self.curvature.find(&neighbours, &settings.curvature);
        let bent = Instant::now();
        let (estimate, alone) =
            self.local_linear.estimate(&neighbours, &self.curvature.factors, &settings.local_linear);
        let times = [begin, reduced, projected, bent, Instant::now()];
        for (sum, step) in seconds.iter_mut().zip(times.windows(2)) {
            *sum += (step[1] - step[0]).as_secs_f64();
        }
        let colour = [0, 1, 2].map(|c| estimate.colour[c].to_array());
        let (mse, bandwidth) = (estimate.mse.to_array(), projection.shared.to_array());
        Rebuilt { colour, mse, bandwidth, rank: self.reduction.rank, alone: alone.to_array() }
    }
}

impl Row {
    /// Takes over entry `lane` of `rebuilt` as pixel `x`.
    fn write(&mut self, x: usize, rebuilt: &Rebuilt, lane: usize) {
        for (values, colour) in self.colour.iter_mut().zip(&rebuilt.colour) {
            values[x] = colour[lane];
        }
        self.mse[x] = rebuilt.mse[lane];
        self.bandwidth[x] = rebuilt.bandwidth[lane];
        self.rank[x] = rebuilt.rank[lane] as f32;
        self.kept += usize::from(rebuilt.alone[lane] != 0.0);
    }
}
