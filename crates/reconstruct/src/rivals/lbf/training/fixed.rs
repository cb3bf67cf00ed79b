//! The best bandwidths that are the same for all pixels, by search: what the network begins with, and has to beat.

use stack::{Cancelled, Monitor};

use super::gradient::Batch;
use super::{Example, rows_of};
use crate::rivals::lbf::kernel::{Bandwidths, TERMS};

/// Factors that are tried on each bandwidth in turn, each until it no longer helps.
const FACTORS: [f32; 4] = [4.0, 2.0, 1.414, 1.19];
/// Bandwidths stay between this and its inverse.
const MOST: f32 = 256.0;
/// Only every n-th row is looked at while searching.
const STEP: usize = 4;

/// Searches the bandwidths of least mean error over `examples`, with a window of `radius`. Reports one unit per factor as
/// stage `fixed filter`.
///
/// # Errors
/// When `monitor` cancels.
pub fn best_fixed(examples: &[Example], radius: usize, monitor: &dyn Monitor) -> Result<Bandwidths, Cancelled> {
    let rows = rows_of(examples, STEP);
    let batch = Batch { examples, rows: &rows, radius };
    monitor.begin("fixed filter", FACTORS.len() as u64);
    let mut best = Candidate { bandwidths: [1.0; TERMS], error: batch.error_of([1.0; TERMS], monitor)? };
    for factor in FACTORS {
        while best.improve(&batch, factor, monitor)? {}
        monitor.note(&format!("bandwidths {:.3?}: error {:.5}", best.bandwidths, best.error));
        monitor.advance(1);
    }
    Ok(best.bandwidths)
}

/// Bandwidths and their error.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    bandwidths: Bandwidths,
    error: f64,
}

impl Candidate {
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
        Ok(self.error < before * (1.0 - 1e-4))
    }
}
