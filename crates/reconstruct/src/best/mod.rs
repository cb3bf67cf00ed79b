//! The project's own method: light split into a low layer and events, rebuilt in two passes of collaborative
//! regression, each pixel by the candidates that predict the other half best.
//!
//! Steps, one file each: what exceeds its surroundings goes to a sparse layer (`split`); features are freed of noise
//! (`features`; visibility and what paths meet next, by the others: `by_others`); a first regression guided by the other half
//! (`first_pass`); the sparse layer is spread over pixels that resemble its own (`spread`); what the residual still holds
//! is added (`cascade`), which makes a pilot picture; a second regression is guided by the pilot (`second_pass`); the
//! candidates are mixed by their error and a small network (`choice`); and wide noise is taken off (`clouds`). `piloted`
//! puts those up to the pilot in a row, `workshop` the rest.

mod alone;
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
mod light_guide;
mod natural;
mod passes;
pub(crate) mod piloted;
mod restore;
mod second_pass;
mod settings;
mod split;
pub(crate) mod spread;
#[cfg(test)]
pub(crate) mod test_scene;
mod workshop;

pub use cascade::MOST_PARTS;
pub use choice::{Chooser, trained, training};
pub use error::share_unseen;
pub use features::{GuideFeatures, guide_features, guide_features_freeing};
pub use light_guide::with_direct_light;
pub use settings::{BestSettings, FitSettings, LightSettings};
pub use workshop::{Extras, Workshop};

#[cfg(test)]
mod tests;
