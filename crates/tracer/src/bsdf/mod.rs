//! How surfaces scatter light.
//!
//! A [`Lobe`] scatters in a local frame whose +z is the normal on the viewer's side; a [`Bsdf`] is a lobe at a point of
//! the scene and works in world space. Every surface but glass looks the same from both sides.
//!
//! Values are radiometric: `evaluate` is f·|cos θ| of the incoming direction, `weight` of a sample is f·|cos θ| ÷ pdf.
//! Light is followed backwards (radiance, not importance), so crossing into an index η scales radiance by 1/η².

mod albedo_grid;
mod clear_coat;
mod coat_albedo;
mod coated;
mod conductor;
mod diffuse;
mod facet_albedo;
mod frame;
mod fresnel;
mod ggx;
mod glass;
mod horizon;
mod lobe;
mod mirror;
mod rough_glass;
mod rough_pane;
mod shared_tables;
mod surface;
mod thin_glass;

#[cfg(test)]
mod albedo_tests;
#[cfg(test)]
pub(crate) mod chi_square;
#[cfg(test)]
mod clear_coat_tests;
#[cfg(test)]
mod sampling_tests;

pub use coated::Coated;
pub use conductor::Conductor;
pub use diffuse::Diffuse;
pub(crate) use facet_albedo::{GlassAlbedo, MetalAlbedo};
pub(crate) use frame::Frame;
pub use glass::Glass;
pub use lobe::{Lobe, Scattered};
pub use mirror::Mirror;
pub use rough_glass::RoughGlass;
pub use rough_pane::RoughPane;
pub(crate) use shared_tables::{SharedTables, Table};
pub(crate) use surface::may_be_specular;
pub use surface::{Bsdf, DirectionSample};
pub use thin_glass::ThinGlass;
