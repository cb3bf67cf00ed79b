//! Feature stacks and pictures as files.
//!
//! [`read_stack`] takes a stack that Tamis wrote, or another renderer's; [`read_buckets`] several independent renders
//! of one picture. [`write_stack`] writes what [`read_stack`] needs to get the very same stack again.
//!
//! Channels of our own files (`docs/exr.md` has the whole list): the picture `R G B`; per component `noisy.*` or
//! `emission.*` and its buckets `noisy.bucket0.*` …; per feature its mean, and its halves (`albedoA.*`, `albedoB.*`)
//! or buckets; `samples.Y`; then whatever result layers were asked for. Everything is 32-bit float; metadata is one
//! JSON text attribute.

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
mod found;
mod header_order;
mod independence;
mod layer_list;
mod layers;
mod loaded;
mod memory;
mod mend;
mod own;
mod pfm;
mod picture;
mod read;
mod recognise;
mod role;
#[cfg(test)]
mod round_trip;
mod sources;
mod together;
mod write;

pub use atomic::{check_writable, write_atomically};
pub use carried::Carried;
pub use error::FileError;
pub use found::{Found, FoundRole, FoundSpp};
pub use layers::{Layers, Passthrough};
pub use loaded::ReadOptions;
pub use mend::Mended;
pub use pfm::{read_pfm, write_pfm};
pub use picture::{extension, read_picture, write_picture};
pub use read::{Inputs, ReadStack, read_buckets, read_inputs, read_stack};
pub use recognise::Mapping;
pub use role::{Convention, Measure, Role, Slot};
pub use sources::{Source, is_one_stack};
pub use write::{ResultLayer, StackHeader, write_stack};
