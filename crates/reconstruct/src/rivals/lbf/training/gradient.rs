//! The error of some filtered rows, and how it follows the network's parameters.

use rayon::prelude::*;
use stack::{Cancelled, Monitor};

use super::example::Example;
use crate::rivals::lbf::filter::{FilteredRow, RowFilter, RowGradient};
use crate::rivals::lbf::kernel::Bandwidths;
use crate::rivals::lbf::network::{Network, PARAMETERS};

/// ε of the relative error (the paper's equation 5).
const EPSILON: f32 = 0.01;

/// Rows of some examples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch<'a> {
    pub(super) examples: &'a [Example],
    /// Numbers of example and row.
    pub(super) rows: &'a [(usize, usize)],
    /// Radius of the window.
    pub(super) radius: usize,
}

/// Mean error and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Slope {
    /// Mean over pixels and channels of ½ (ĉ − c)²/(c² + ε).
    pub(super) error: f64,
    /// Its derivative by each parameter.
    pub(super) gradient: Vec<f64>,
}

impl Batch<'_> {
    /// The error with the bandwidths that `network` chooses, and its slope.
    ///
    /// # Errors
    /// When `monitor` cancels.
    pub(super) fn slope(&self, network: &Network, monitor: &dyn Monitor) -> Result<Slope, Cancelled> {
        let slopes = self.by_rows(monitor, |example, y| slope_of_row(example, y, self.radius, network))?;
        let mut total = Slope { error: 0.0, gradient: vec![0.0; PARAMETERS] };
        for slope in slopes {
            total.error += slope.error;
            total.gradient.iter_mut().zip(&slope.gradient).for_each(|(sum, g)| *sum += g);
        }
        let share = 1.0 / self.values();
        total.error *= share;
        total.gradient.iter_mut().for_each(|g| *g *= share);
        Ok(total)
    }

    /// The error with the same `bandwidths` for all pixels.
    ///
    /// # Errors
    /// When `monitor` cancels.
    pub(super) fn error_of(&self, bandwidths: Bandwidths, monitor: &dyn Monitor) -> Result<f64, Cancelled> {
        let errors = self.by_rows(monitor, |example, y| {
            let bandwidths = vec![bandwidths; example.primary.size.width];
            let filter = RowFilter { primary: &example.primary, radius: self.radius, y, bandwidths: &bandwidths };
            error_of_row(&pulp::Arch::new().dispatch(filter), example, y).0
        })?;
        Ok(errors.iter().sum::<f64>() / self.values())
    }

    /// What `work` makes of each row, in the rows' order.
    fn by_rows<T: Send>(
        &self,
        monitor: &dyn Monitor,
        work: impl Fn(&Example, usize) -> T + Sync,
    ) -> Result<Vec<T>, Cancelled> {
        let task = |&(example, y): &(usize, usize)| {
            if monitor.cancelled() { Err(Cancelled) } else { Ok(work(&self.examples[example], y)) }
        };
        self.rows.par_iter().map(task).collect()
    }

    /// How many values the error is the mean of.
    fn values(&self) -> f64 {
        let widths = self.rows.iter().map(|(example, _)| self.examples[*example].primary.size.width);
        (3 * widths.sum::<usize>()).max(1) as f64
    }
}

/// Sums over one row.
fn slope_of_row(example: &Example, y: usize, radius: usize, network: &Network) -> Slope {
    let width = example.primary.size.width;
    let activations: Vec<_> =
        example.inputs[y * width..][..width].iter().map(|inputs| network.activate(inputs)).collect();
    let bandwidths: Vec<Bandwidths> = activations.iter().map(|at| at.bandwidths).collect();
    let filter = RowFilter { primary: &example.primary, radius, y, bandwidths: &bandwidths };
    let processor = pulp::Arch::new();
    let filtered = processor.dispatch(filter);
    let (error, slope) = error_of_row(&filtered, example, y);
    let slopes = processor.dispatch(RowGradient { filter, filtered: &filtered, slope: &slope });
    let mut gradient = vec![0.0; PARAMETERS];
    for (at, slope) in activations.iter().zip(&slopes) {
        network.add_gradient(at, slope, &mut gradient);
    }
    Slope { error, gradient }
}

/// Sum of ½ (ĉ − c)²/(c² + ε) over a row and its channels, and the derivative by each ĉ.
fn error_of_row(filtered: &FilteredRow, example: &Example, y: usize) -> (f64, [Vec<f32>; 3]) {
    let mut error = 0.0;
    let slope = std::array::from_fn(|c| {
        let reference = &example.reference[c][y * filtered.weight.len()..];
        let of = |(found, truth): (&f32, &f32)| {
            let slope = (found - truth) / (truth * truth + EPSILON);
            error += f64::from(0.5 * slope * (found - truth));
            slope
        };
        filtered.colour[c].iter().zip(reference).map(of).collect()
    });
    (error, slope)
}
