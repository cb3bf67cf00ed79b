//! What flows between renderer and denoiser.
//!
//! A [`FeatureStack`] is the whole state of a picture before reconstruction; a [`SampleMap`] asks the renderer for more
//! samples. Module [`mod@file`] reads and writes stacks as OpenEXR, module [`merge`] adds them up. This crate knows
//! neither of its users.
//!
//! Limits: EXR files of scan lines or tiles, whose parts cover the same pixels with channels of full resolution; deep data
//! is refused.

mod estimate;
mod fault;
mod feature_stack;
pub mod file;
mod image;
mod knob;
pub mod merge;
mod monitor;
mod samples;

pub use estimate::{Estimate, Noise};
pub use fault::Fault;
pub use feature_stack::{Component, ComponentRole, Feature, FeatureRole, FeatureStack, GATHERED, INDIRECT};
pub use file::Passthrough;
pub use image::{Image, Size, Window, planes_of_zeros};
pub use knob::{Knob, KnobError, KnobValue, Knobs, flag_name, read_knob};
pub use monitor::{Cancelled, Monitor, Silent};
pub use samples::{Dealing, GroupCounts, Place, SampleCounts, SampleMap, place};
