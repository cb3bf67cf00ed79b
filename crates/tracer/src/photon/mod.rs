//! Light followed from where it is emitted: photons that mirrors and glass send on to a surface.
//!
//! A path that looks for a caustic must hit a lamp by chance, through a mirror or glass. A photon comes from the lamp; it
//! only has to land near the surface that a path shows. Both find the same light, and share it as multiple importance
//! sampling says (vertex merging, Georgiev et al. 2012): where paths find it easily, as a wide sky in a window, photons
//! are left next to nothing.
//!
//! Photons are sent only to the `targets`, balls round all that mirrors or refracts, from the `source`s of light that a
//! path can hit; `flight` follows them to the first surface that does neither, and the `map` finds those near a point.

mod flight;
mod map;
mod source;
mod target;

#[cfg(test)]
mod tests;

pub(crate) use flight::{PhotonTracer, bent};
pub(crate) use map::Landed;
