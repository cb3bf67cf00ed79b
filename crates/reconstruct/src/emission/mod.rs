//! Directly seen emission: a component that needs a treatment of its own.

mod rebuild;
mod unsplit;

pub use rebuild::rebuild_emission;
pub use unsplit::with_emission_apart;
