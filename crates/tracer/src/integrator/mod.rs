//! The path tracer: unidirectional, with multiple importance sampling and Russian roulette, unbiased up to `max_depth`.
//!
//! `path` follows one path, event by event; `direct`, `features` and `roulette` are its events; `passes` cuts work into
//! pieces and `trace` runs them.

mod caustic;
mod direct;
mod error;
mod features;
mod passes;
mod path;
mod path_state;
mod roulette;
mod settings;
mod surface;
mod trace;

#[cfg(test)]
mod caustic_tests;
#[cfg(test)]
mod closed_form_tests;
#[cfg(test)]
mod lens_tests;
#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod repeatability_tests;
#[cfg(test)]
mod test_scenes;

pub use error::TraceError;
pub use passes::passes_of;
pub use settings::{DirectLight, FeatureHit, TraceSettings};
pub use trace::{TraceReport, trace};
