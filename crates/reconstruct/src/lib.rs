//! From noisy samples to a picture that knows its own error.
//!
//! Every stage is a plain function from inputs, settings and a monitor to results: [`spikes`], [`prefilter`],
//! [`regression`], [`adaptive`]. [`reconstruct`] calls the first three in a row for each component of a stack.

pub mod adaptive;
pub mod best;
pub mod box_filter;
pub mod collaborative;
mod emission;
pub mod exp;
mod method;
pub mod metrics;
pub mod nl_means;
mod paper;
pub mod patch_distance;
mod pipeline;
pub mod prefilter;
pub mod rectangle;
pub mod regression;
pub mod rivals;
mod settings;
pub mod spikes;
#[cfg(test)]
mod test_noise;
pub mod variance;

pub use method::{Fit, Method, MethodSettings};
pub use pipeline::{ReconstructError, Reconstruction, reconstruct};
pub use settings::Settings;
