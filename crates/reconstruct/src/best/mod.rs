//! The project's own method: light split into a low layer and events, rebuilt in two passes of collaborative
//! regression, each pixel by the candidates that predict the other half best.
//!
//! `reconstruct` takes a stack, parts direct and indirect light (`indirect`), and has each part rebuilt in light of usual
//! brightness (`by_component`). The steps of that, one file each: what exceeds its surroundings goes to a sparse layer (`split`); features are freed of noise
//! (`features`; visibility and what paths meet next, by the others: `by_others`); a first regression guided by the other half
//! (`first_pass`); the sparse layer is spread over pixels that resemble its own (`spread`); what the residual still holds
//! is added (`cascade`), which makes a pilot picture; a second regression is guided by the pilot (`second_pass`); the
//! candidates are mixed by their error and a small network (`choice`); wide noise is taken off (`clouds`), lost light given
//! back (`restore`), and the error estimated (`error`). `piloted` puts those up to the pilot in a row, `workshop` the rest.

mod alone;
mod by_component;
mod by_others;
mod cascade;
mod choice;
mod clouds;
mod crossed;
mod error;
mod features;
mod first_pass;
mod given;
pub(crate) mod guided_kernel;
pub(crate) mod halves;
mod indirect;
mod light_guide;
mod natural;
mod passes;
pub(crate) mod piloted;
mod reconstruct;
mod restore;
mod second_pass;
mod settings;
mod split;
pub(crate) mod spread;
#[cfg(test)]
pub(crate) mod test_scene;
mod workshop;

pub use cascade::MOST_PARTS;
pub use choice::{Chooser, chooser_of, training};
pub use features::{GuideFeatures, guide_features};
pub use reconstruct::{reconstruct, reconstruct_freeing};
pub use settings::{BestSettings, FitSettings, LightSettings};
pub use workshop::Extras;

#[cfg(test)]
mod tests;
