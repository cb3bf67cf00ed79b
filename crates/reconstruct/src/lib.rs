//! From noisy samples to a picture that knows its own error.
//!
//! Every stage is a plain function from inputs, settings and a monitor to results. [`reconstruct`] (in `pipeline`) makes up
//! what a stack lacks ([`completion`]) and hands it to the chosen method, whose `reconstruct` puts its stages in a row for
//! each component: `paper` ([`spikes`], [`prefilter`], [`regression`]), [`best`] (the presets `best` and `fast`), or one of
//! the [`rivals`]. What several of them use stands beside them (`patch_distance`, `nl_means`, `block_matching`,
//! `collaborative`).

pub mod adaptive;
mod bands;
pub mod best;
pub mod blend;
mod block_matching;
pub mod box_filter;
mod collaborative;
pub mod completion;
mod components;
mod eight;
mod emission;
mod exp;
mod exposure;
mod lack;
mod ln;
mod lone_light;
mod marks;
mod method;
pub mod metrics;
pub mod network;
mod nl_means;
mod paper;
mod patch_distance;
mod per_pixel;
mod pieces;
mod pipeline;
pub mod prefilter;
mod reconstruction;
pub mod recorruption;
mod rectangle;
pub mod regression;
pub mod rivals;
mod settings;
pub mod spikes;
#[cfg(test)]
mod test_noise;
pub mod variance;

pub use best::Extras;
pub use lack::Lack;
pub use method::{Fit, Method, MethodSettings};
pub use pipeline::{reconstruct, reconstruct_freeing, reconstruct_with, reconstruct_with_chooser};
pub use reconstruction::{ReconstructError, Reconstruction};
pub use settings::Settings;
