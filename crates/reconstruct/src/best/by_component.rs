//! Components rebuilt by collaborative fits, direct and indirect light apart where that is better.

use std::borrow::Cow;

use stack::{Component, ComponentRole, Image, Monitor, SampleCounts};

use super::choice::Chooser;
use super::error::share_unseen;
use super::features::CleanFeatures;
use super::indirect::Light;
use super::light_features::with_direct_light;
use super::rebuild::rebuild;
use super::recipe::{Extras, Recipe};
use crate::Settings;
use crate::components::{is_lit, variance_of};
use crate::emission::rebuild_emission;
use crate::exposure::Exposed;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::regression::RegressionSettings;

/// What all components of a stack are rebuilt with.
pub struct Components<'a> {
    recipe: Recipe<'a>,
    /// How directly seen emission is rebuilt.
    of_emission: &'a RegressionSettings,
    /// What makes their light as bright as usual.
    exposure: f32,
}

impl<'a> Components<'a> {
    /// Components of a stack with so many samples (`counts`) are made `exposure` times as bright before they are rebuilt.
    ///
    /// # Errors
    /// When the network would be asked about candidates that it does not know.
    pub fn new(
        counts: &'a SampleCounts,
        features: &'a CleanFeatures,
        settings: &'a Settings,
        chooser: Option<&'a Chooser>,
        extras: Extras<'a>,
        exposure: f32,
    ) -> Result<Self, ReconstructError> {
        settings.best.check_candidates()?;
        let recipe = Recipe { counts, features, beside: None, settings: &settings.best, chooser, extras };
        Ok(Self { recipe, of_emission: &settings.regression, exposure })
    }

    /// A component by itself, or direct and indirect light by themselves.
    ///
    /// # Errors
    /// When nothing is known about the component's noise, or `monitor` cancels.
    pub fn rebuilt(&self, light: Light, monitor: &dyn Monitor) -> Result<Reconstruction, ReconstructError> {
        let Self { recipe, exposure, .. } = *self;
        let passes: Cow<[Image]> = match exposure {
            1.0 => Cow::Borrowed(recipe.extras.passes),
            _ => recipe.extras.passes.iter().map(|pass| pass.clone().exposed(exposure)).collect(),
        };
        let extras = Extras { passes: &passes, ..recipe.extras };
        let bright = Components { recipe: Recipe { extras, ..recipe }, ..*self };
        let rebuilt = match light {
            Light::Whole(component) => bright.rebuilt_whole(component.exposed(exposure), monitor),
            Light::Apart { parts, share } => {
                bright.rebuilt_apart(parts.map(|part| part.exposed(exposure)), share, monitor)
            }
        };
        Ok(rebuilt?.exposed(1.0 / exposure))
    }

    /// Direct light, which has this `share` of the noise, and then indirect light.
    fn rebuilt_apart(
        &self,
        [direct, indirect]: [Component; 2],
        share: f32,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        let Recipe { features, settings, .. } = self.recipe;
        let mut sum = Reconstruction::plain(Image::zeros(features.set.size, 3));
        if is_lit(&direct) {
            let settings = settings.for_direct_light(share);
            let recipe = Recipe { settings: &settings, ..self.recipe };
            sum.add(rebuild(&recipe, Cow::Owned(direct), monitor)?);
        }
        if is_lit(&indirect) {
            let extended = with_direct_light(features, &sum.picture, settings.light.direct_guide);
            let (features, beside) = (extended.as_ref().unwrap_or(features), Some(&sum.picture));
            let recipe = Recipe { features, beside, ..self.recipe };
            sum.add(rebuild(&recipe, Cow::Owned(indirect), monitor)?);
        }
        Ok(sum)
    }

    fn rebuilt_whole(
        &self,
        component: Cow<'_, Component>,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        if component.role == ComponentRole::Scattered {
            return rebuild(&self.recipe, component, monitor);
        }
        let Recipe { counts, features, .. } = self.recipe;
        let variance = variance_of(&component, counts)?;
        // Its buckets are not needed any more.
        let radiance = match component {
            Cow::Owned(component) => Cow::Owned(component.radiance.mean),
            Cow::Borrowed(component) => Cow::Borrowed(&component.radiance.mean),
        };
        let mut rebuilt = rebuild_emission(&radiance, &variance, &features.set, self.of_emission, monitor)?;
        share_unseen(&mut rebuilt.mse, &variance);
        Ok(rebuilt)
    }
}
