//! The best bandwidths that are the same for all pixels, by search: what the network begins with, and has to beat.

use stack::{Cancelled, Monitor};

use super::gradient::Batch;
use super::{Example, rows_of};
use crate::rivals::lbf::kernel::{Bandwidths, TERMS};

/// Where the search begins: one valley is not the deepest of all.
const STARTS: [Bandwidths; 4] = [
    [1.0; TERMS],
    [1.0, 2.0, 2.0, 64.0, 16.0, 4.0],
    [2.0, 1.0, 16.0, 16.0, 16.0, 16.0],
    [1.0, 4.0, 4.0, 4.0, 4.0, 4.0],
];
/// Factors that are tried on each bandwidth in turn, each until it no longer helps, from every start …
const COARSE: [f32; 2] = [3.0, 1.7];
/// … and then from the best that was found.
const FINE: [f32; 2] = [1.4, 1.15];
/// Bandwidths stay between this and its inverse.
const MOST: f32 = 256.0;
/// Only every n-th row is looked at while searching.
const STEP: usize = 6;

/// Searches the bandwidths of least mean error over `examples`, with a window of `radius`. Reports one unit per start as
/// stage `fixed filter`.
///
/// # Errors
/// When `monitor` cancels.
pub fn best_fixed(examples: &[Example], radius: usize, monitor: &dyn Monitor) -> Result<Bandwidths, Cancelled> {
    let rows = rows_of(examples, STEP);
    let batch = Batch { examples, rows: &rows, radius };
    monitor.begin("fixed filter", STARTS.len() as u64);
    let mut best = Candidate { bandwidths: STARTS[0], error: f64::INFINITY };
    for bandwidths in STARTS {
        let mut candidate = Candidate { bandwidths, error: batch.error_of(bandwidths, monitor)? };
        candidate.descend(&batch, &COARSE, monitor)?;
        if candidate.error < best.error {
            best = candidate;
        }
        monitor.advance(1);
    }
    best.descend(&batch, &FINE, monitor)?;
    Ok(best.bandwidths)
}

/// Bandwidths and their error.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    bandwidths: Bandwidths,
    error: f64,
}

impl Candidate {
    /// Changes the bandwidths by each of `factors` as long as that helps.
    fn descend(&mut self, batch: &Batch, factors: &[f32], monitor: &dyn Monitor) -> Result<(), Cancelled> {
        for factor in factors {
            while self.improve(batch, *factor, monitor)? {}
        }
        monitor.note(&format!("fixed bandwidths {:.3?}: error {:.5}", self.bandwidths, self.error));
        Ok(())
    }

    /// Tries each bandwidth `factor` times and as many parts of what it is; whether anything helped.
    fn improve(&mut self, batch: &Batch, factor: f32, monitor: &dyn Monitor) -> Result<bool, Cancelled> {
        let before = self.error;
        for (term, factor) in (0..TERMS).flat_map(|term| [(term, factor), (term, 1.0 / factor)]) {
            let mut bandwidths = self.bandwidths;
            bandwidths[term] *= factor;
            if (1.0 / MOST..=MOST).contains(&bandwidths[term]) {
                let error = batch.error_of(bandwidths, monitor)?;
                if error < self.error {
                    *self = Self { bandwidths, error };
                }
            }
        }
        Ok(self.error < before * (1.0 - 1e-3))
    }
}
