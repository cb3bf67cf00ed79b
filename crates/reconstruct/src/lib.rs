//! From noisy samples to a picture that knows its own error.
//!
//! Every stage is a plain function from inputs, settings and a monitor to results: [`spikes`], [`prefilter`],
//! [`regression`], [`adaptive`]. [`reconstruct`] calls the first three in a row for each component of a stack.

pub mod adaptive;
pub mod box_filter;
mod emission;
pub mod exp;
mod method;
pub mod metrics;
mod paper;
mod pipeline;
pub mod prefilter;
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
