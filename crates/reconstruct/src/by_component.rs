//! Components rebuilt by collaborative fits, direct and indirect light apart where that is better.

use std::borrow::Cow;

use stack::{Component, ComponentRole, FeatureStack, Image, Monitor};

use crate::best::{Chooser, Extras, GuideFeatures, Workshop};
use crate::components::{is_lit, variance_of};
use crate::emission::rebuild_emission;
use crate::exposure::Exposed;
use crate::indirect::IndirectLight;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::{Settings, best};

/// What collaborative fits need to rebuild a component.
pub struct Collaborative<'a> {
    workshop: Workshop<'a>,
    settings: &'a Settings,
    exposure: f32,
}

impl<'a> Collaborative<'a> {
    /// Work on components of `stack`, made `exposure` times as bright for it.
    ///
    /// # Errors
    /// When the network would be asked about candidates that it does not know.
    pub fn new(
        stack: &'a FeatureStack,
        features: &'a GuideFeatures,
        settings: &'a Settings,
        chooser: Option<&'a Chooser>,
        extras: Extras<'a>,
        exposure: f32,
    ) -> Result<Self, ReconstructError> {
        settings.best.check_candidates()?;
        let workshop = Workshop { stack, features, beside: None, settings: &settings.best, chooser, extras };
        Ok(Self { workshop, settings, exposure })
    }

    /// A component by itself, or, where its direct light has little noise, direct and `indirect` light by themselves.
    ///
    /// # Errors
    /// When the component's noise does not come in buckets, or `monitor` cancels.
    pub fn rebuilt(
        &self,
        component: Cow<'_, Component>,
        indirect: Option<IndirectLight>,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        let Self { workshop, exposure, .. } = *self;
        let passes: Cow<[Image]> = match exposure {
            1.0 => Cow::Borrowed(workshop.extras.passes),
            _ => workshop.extras.passes.iter().map(|pass| pass.clone().exposed(exposure)).collect(),
        };
        let extras = Extras { passes: &passes, ..workshop.extras };
        let bright = Collaborative { workshop: Workshop { extras, ..workshop }, ..*self };
        let rebuilt = match indirect.filter(|indirect| self.is_known_apart(indirect, &component)) {
            None => bright.rebuilt_whole(component.exposed(exposure), monitor),
            Some(indirect) => bright.with_indirect(indirect, component, monitor),
        };
        Ok(rebuilt?.exposed(1.0 / exposure))
    }

    /// A component whose `indirect` light is known.
    fn with_indirect(
        &self,
        indirect: IndirectLight,
        component: Cow<'_, Component>,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        let Self { workshop: Workshop { stack, features, settings, .. }, exposure, .. } = *self;
        let share = || indirect.direct_share_of_noise(&component.radiance, &stack.samples, exposure);
        let little = settings.light.apart.then(share).filter(|share| *share < settings.light.direct_noise);
        let Some(share) = little else {
            return self.rebuilt_whole(indirect.within(component).exposed(exposure), monitor);
        };
        let parts = indirect.parts(component.into_owned());
        let [direct, indirect] = parts.map(|part| part.exposed(exposure));
        let mut sum = Reconstruction::plain(Image::zeros(stack.size(), 3));
        if is_lit(&direct) {
            let settings = settings.for_direct_light(share);
            let workshop = Workshop { settings: &settings, ..self.workshop };
            sum.add(workshop.rebuild(Cow::Owned(direct), monitor)?);
        }
        if is_lit(&indirect) {
            let guided = best::with_direct_light(features, &sum.picture, settings.light.direct_guide);
            let (features, beside) = (guided.as_ref().unwrap_or(features), Some(&sum.picture));
            let workshop = Workshop { features, beside, ..self.workshop };
            sum.add(workshop.rebuild(Cow::Owned(indirect), monitor)?);
        }
        Ok(sum)
    }

    /// Whether `indirect` light can be told from the rest. Passes need the weights of the whole as it was found.
    fn is_known_apart(&self, indirect: &IndirectLight, component: &Component) -> bool {
        self.workshop.extras.passes.is_empty() && indirect.is_part_of(&component.radiance)
    }

    fn rebuilt_whole(
        &self,
        component: Cow<'_, Component>,
        monitor: &dyn Monitor,
    ) -> Result<Reconstruction, ReconstructError> {
        let Workshop { stack, features, .. } = self.workshop;
        if component.role == ComponentRole::Scattered {
            return self.workshop.rebuild(component, monitor);
        }
        let (radiance, variance) = (&component.radiance.mean, variance_of(stack, &component)?);
        let mut rebuilt = rebuild_emission(radiance, &variance, &features.set, self.settings, monitor)?;
        best::share_unseen(&mut rebuilt.mse, &variance);
        Ok(rebuilt)
    }
}
