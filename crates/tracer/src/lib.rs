//! A small unbiased path tracer that writes feature stacks.

pub mod bsdf;
pub mod bvh;
pub mod camera;
mod digest;
pub mod environment;
pub mod film;
pub mod gather;
pub mod integrator;
pub mod interaction;
pub mod light;
pub mod material;
mod motion;
mod photon;
mod ray;
pub mod sampler;
pub mod scene;
pub mod texture;

pub use ray::Ray;
