//! Light that leaves surfaces, averaged over all paths that meet them nearby.
//!
//! Most of the noise of indirect light is not in which way a path goes on from the surface that is seen, but in what it
//! finds there: whether a light sample arrives, whether a caustic is hit. What leaves a diffuse surface, or comes through
//! the coat of one, is the same in all directions and changes slowly, so paths share it (path space filtering, Keller, Dahm and Binder 2014; in cells of
//! space found by hashing, Binder, Fricke and Keller 2019). Cells become smaller as there are more paths to share: the
//! average is biased, but consistent.
//!
//! A path records a `point` where it goes on from the surface that is seen to a diffuse one, or if there is none, to the base
//! of a coated one; its `place` says which cells it
//! lies in; `leaving` knows what leaves them.

mod leaving;
mod place;
mod point;

#[cfg(test)]
mod tests;

pub(crate) use leaving::LeavingLight;
pub use point::GatherPoint;
