//! The project's own method: light split into a low layer and events, rebuilt in two passes of collaborative
//! regression, each pixel by the candidates that predict the other half best.
//!
//! The road of a stack, one step a file (`docs/best.md` says why each is as it is):
//!
//! * `reconstruct`: the components of a stack; `indirect` parts direct and indirect light where that is better.
//! * `by_component`: each of those in light of usual brightness, direct light before indirect.
//! * `rebuild`: the steps of one, put in a row by itself, `piloted` and `second_half`:
//!   1. `features` are freed of noise, visibility and what paths meet next by the others (`by_others`).
//!   2. `split`: what exceeds its surroundings leaves the low layer and becomes events.
//!   3. `first_pass`: a regression of each half of the low layer, guided by the other half.
//!   4. `spread`: events are spread over pixels that resemble their own.
//!   5. `cascade`: what the residual still holds is added, which makes the pilot picture.
//!   6. `second_pass`: regressions that the pilot guides, which make candidates.
//!   7. `choice`: candidates are mixed by their error and a small network.
//!   8. `clouds`: wide noise is taken off; `restore`: lost light is given back.
//!   9. `error`: the picture's own estimate of its error.

mod by_component;
mod by_others;
mod cascade;
mod choice;
mod clouds;
mod crossed;
pub(crate) mod edge_avoiding;
mod error;
mod features;
mod first_pass;
mod given;
pub(crate) mod halves;
mod indirect;
mod light_features;
mod natural;
mod passes;
mod piloted;
mod rebuild;
mod recipe;
mod reconstruct;
mod restore;
mod second_half;
mod second_pass;
mod settings;
pub(crate) mod split;
pub(crate) mod spread;
#[cfg(test)]
pub(crate) mod test_scene;

pub use cascade::MOST_PARTS;
pub use choice::{Chooser, chooser_of, training};
pub use features::{CleanFeatures, clean_features};
pub use recipe::Extras;
pub use reconstruct::{reconstruct, reconstruct_freeing};
pub use settings::{BestSettings, FitSettings, LightSettings};

#[cfg(test)]
mod tests;
