//! From noisy samples to a picture that knows its own error.

pub mod adaptive;
pub mod metrics;
pub mod prefilter;
pub mod regression;
pub mod spikes;
