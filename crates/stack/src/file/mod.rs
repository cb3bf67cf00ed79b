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
mod error;
mod layers;
mod pfm;
mod picture;
mod read;
#[cfg(test)]
mod round_trip;
mod write;

pub use atomic::{check_writable, write_atomically};
pub use error::FileError;
pub use layers::{Layers, Passthrough};
pub use pfm::{read_pfm, write_pfm};
pub use picture::{extension, read_picture, write_picture};
pub use read::{ReadStack, read_buckets, read_stack};
pub use write::{ResultLayer, StackHeader, write_stack};
