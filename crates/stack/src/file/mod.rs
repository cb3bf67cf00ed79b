//! Feature stacks and pictures as files.
//!
//! [`read_inputs`] takes a stack that Tamis wrote, or another renderer's: from one file with layers, several with a role
//! each, two halves, several independent renders, or slices of one render. [`write_stack`] writes what is needed to get
//! the very same stack again.
//!
//! The way of another renderer's files: `sources` (which file is what) → `exr_read`, `pfm` (channels) → `recognise` (which
//! layer is what, by the names in `alias`, else `by_value`) → `loaded` (planes, `counts`, `convention` of variances) →
//! `mend` → `together` (one stack) → `found` (what is said about it).
//!
//! Channels of our own files (`docs/exr.md` has the whole list): the picture `R G B`; per component `noisy.*` or
//! `emission.*` and its buckets `noisy.bucket0.*` …; per feature its mean, and its halves (`albedoA.*`, `albedoB.*`), its
//! buckets or its variance; `samples.Y`; then whatever result layers were asked for. Everything is 32-bit float; metadata is
//! one JSON text attribute, beside what was there in the file the stack was read from.

mod alias;
mod atomic;
mod borrowed;
mod by_value;
mod carried;
mod convention;
mod counts;
mod emission;
mod error;
mod exr_read;
mod exr_text;
mod exr_write;
mod found;
mod header_order;
#[cfg(test)]
mod hostile_tests;
mod in_flight;
mod independence;
#[cfg(test)]
mod integrity_tests;
mod layer_list;
mod layers;
mod loaded;
mod memory;
mod memory_limit;
mod mend;
mod moments;
mod own;
mod passes;
mod pfm;
mod picture;
mod read;
mod read_layers;
mod recognise;
mod record;
#[cfg(test)]
mod renderer_tests;
mod role;
#[cfg(test)]
mod round_trip;
mod same_window;
mod shared_noise;
mod slices;
mod slot_names;
mod sources;
mod survey;
mod taken;
mod temporaries;
#[cfg(test)]
mod test_files;
mod together;
mod write;
mod write_channels;
mod xyz;

pub use atomic::{check_writable, write_atomically};
pub use carried::Carried;
pub use error::{Action, FileError};
pub use found::{Found, FoundRole, FoundSpp};
pub use layers::{Layers, Passthrough};
pub use loaded::ReadOptions;
pub use memory_limit::memory_limit;
pub use mend::Mended;
pub use passes::{Pass, PassError};
pub use pfm::{read_pfm, write_pfm};
pub use picture::{extension, read_picture, read_picture_with_alpha, read_picture_with_record, write_picture};
pub use read::{Inputs, ReadStack, read_buckets, read_inputs, read_stack};
pub use recognise::Mapping;
pub use record::Record;
pub use role::{Convention, Measure, Role, Slot};
pub use slices::read_render;
pub use sources::{Source, is_one_stack};
pub use survey::{Survey, survey};
pub use temporaries::exit_without_litter;
pub use write::{ResultLayer, StackHeader, write_stack};
