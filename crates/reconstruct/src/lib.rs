//! From noisy samples to a picture that knows its own error.

pub mod adaptive;
pub mod box_filter;
pub mod exp;
pub mod metrics;
pub mod prefilter;
pub mod regression;
pub mod spikes;
#[cfg(test)]
mod test_noise;
pub mod variance;
