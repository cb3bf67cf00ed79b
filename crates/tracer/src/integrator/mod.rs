//! The path tracer.

mod settings;

pub use settings::{DirectLight, FeatureHit, TraceSettings};
