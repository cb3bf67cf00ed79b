//! The learning-based filter (Kalantari, Bako, Sen 2015: *A Machine Learning Approach for Filtering Monte Carlo Noise*).
//!
//! A cross-bilateral filter (`filter`, `kernel`) compares pixels by their distance on the screen, their colours and their
//! primary features (`primary`). Its bandwidths are chosen for every pixel by a small network (`network`) from secondary
//! features (`secondary`) that describe noise and detail around it. The network is trained together with the filter
//! (`training`), on renders of this project's scenes; `weights` holds the result. Spikes that are left in the filtered
//! picture are replaced by medians, as the paper does.
//!
//! Not the paper's: one place instead of two texture hits, its distances in units of the step between pixels; secondary
//! features from buckets instead of single samples, relative and logarithmic; tanh in the hidden layer; Adam instead of
//! RPROP; an error map (`error`).

mod error;
mod filter;
mod kernel;
mod network;
mod primary;
mod secondary;
mod statistics;
#[cfg(test)]
mod test_scene;
#[cfg(test)]
mod tests;
pub mod training;
mod weights;

use rayon::prelude::*;
use stack::{Cancelled, FeatureStack, Image, Monitor, Size};

use crate::Settings;
use crate::pieces::of_each;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::spikes::{SpikeMethod, SpikeSettings, remove_spikes};
use error::estimated_error;
use filter::{FilteredRow, RowFilter};
pub use kernel::{Bandwidths, TERMS};
pub use network::{HIDDEN, Network, PARAMETERS};
pub use primary::{FEATURES, Primary};
pub use secondary::{INPUTS, Inputs, secondary};
pub use weights::trained;

stack::knobs! {
    /// The learning-based filter (Kalantari et al. 2015).
    pub struct LbfSettings("lbf") {
        /// Radius of the window, in pixels. The weights were trained with the default.
        radius: usize = 10, 1..=32;
        /// Whether spikes left in the filtered picture are replaced by medians; how far off one is, `--spike-deviations`
        /// says.
        spike_removal: bool = true, ..;
    }
}

/// Where bandwidths come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tuning<'a> {
    /// The network with the weights that come with this crate: the method.
    Trained,
    /// Another network.
    Network(&'a Network),
    /// The same for all pixels: what the network is to be better than.
    Fixed(Bandwidths),
}

/// Rebuilds `radiance`, three channels with the `variance` of its mean. The error map is Stein's estimate (`error`).
///
/// # Errors
/// When there is no feature, one does not fit, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    radiance: &Image,
    variance: &Image,
    tuning: Tuning,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let primary = Primary::new(stack, radiance, variance, &settings.prefilter, monitor)?;
    let bandwidths = match tuning {
        Tuning::Trained => chosen(&trained()?, &primary),
        Tuning::Network(network) => chosen(network, &primary),
        Tuning::Fixed(bandwidths) => vec![bandwidths; stack.size().pixels()],
    };
    let rows = filtered(&primary, &bandwidths, settings.lbf.radius, monitor)?;
    let mse = Image::from_channels(stack.size(), vec![estimated_error(&primary, &rows)]);
    let spikes = SpikeSettings { removal: settings.lbf.spike_removal, method: SpikeMethod::Lbf, ..settings.spikes };
    let clean = remove_spikes(&put_together(stack.size(), &rows), &mse, &spikes, monitor)?;
    let marked = clean.marked.iter().filter(|marked| **marked).count();
    let mse = clean.variance.into_channels().swap_remove(0);
    Ok(Reconstruction { mse, marked, ..Reconstruction::plain(clean.colour) })
}

/// The bandwidths `network` chooses for every pixel.
fn chosen(network: &Network, primary: &Primary) -> Vec<Bandwidths> {
    secondary(primary).par_iter().map(|inputs| network.bandwidths(inputs)).collect()
}

/// The whole picture filtered, row by row. Reports one unit per row as stage `filter`.
fn filtered(
    primary: &Primary,
    bandwidths: &[Bandwidths],
    radius: usize,
    monitor: &dyn Monitor,
) -> Result<Vec<FilteredRow>, Cancelled> {
    let Size { width, height } = primary.size;
    monitor.begin("filter", height as u64);
    let processor = pulp::Arch::new();
    of_each(0..height, monitor, |y| {
        let bandwidths = &bandwidths[y * width..][..width];
        processor.dispatch(RowFilter { primary, radius, y, bandwidths })
    })
}

fn put_together(size: Size, rows: &[FilteredRow]) -> Image {
    let channel = |c: usize| rows.iter().flat_map(|row| row.colour[c].iter().copied()).collect();
    Image::from_channels(size, (0..3).map(channel).collect())
}
