//! Light that is rebuilt by itself, beside what it is in two references.

use std::borrow::Cow;

use stack::{Component, ComponentRole, FeatureStack, Image};

use crate::best::indirect::{IndirectLight, take_off};
use crate::components::is_lit;
use crate::reconstruction::ReconstructError;

/// Light that is rebuilt by itself.
pub struct Light<'a> {
    /// With its noise.
    pub component: Cow<'a, Component>,
    /// The same light in both references.
    pub references: [Image; 2],
}

/// All scattered light.
///
/// # Errors
/// When the stack has none.
pub fn whole_light<'a>(stack: &'a FeatureStack, references: &[FeatureStack; 2]) -> Result<Light<'a>, ReconstructError> {
    let layer = ComponentRole::Scattered.layer();
    let component = stack.component(ComponentRole::Scattered).ok_or(ReconstructError::NoiseUnknown { layer })?;
    let scattered = |reference: &FeatureStack| {
        assert_eq!(reference.size(), stack.size());
        reference.component(ComponentRole::Scattered).expect("a reference with scattered light").radiance.mean.clone()
    };
    Ok(Light { component: Cow::Borrowed(component), references: references.each_ref().map(scattered) })
}

/// Direct and indirect light.
pub struct Parts {
    pub direct: Light<'static>,
    pub indirect: Light<'static>,
    /// Share of the noise that direct light has.
    pub share: f32,
}

/// Direct and indirect light, where they are known apart and there is some of both.
pub fn parts_of(whole: &Light, stack: &FeatureStack, references: &[FeatureStack; 2], gathered: bool) -> Option<Parts> {
    let radiance = &whole.component.radiance;
    let indirect = IndirectLight::of(stack, gathered).filter(|indirect| indirect.is_part_of(radiance))?;
    let [Some(first), Some(second)] = references.each_ref().map(|reference| reference.indirect.as_ref()) else {
        return None;
    };
    let of_indirect = [first, second].map(|estimate| estimate.mean.clone());
    let mut of_direct = whole.references.clone();
    of_direct.iter_mut().zip(&of_indirect).for_each(|(whole, part)| take_off(whole, part));
    let share = indirect.direct_share_of_noise(radiance, &stack.samples, 1.0);
    let [direct, indirect] = indirect.parts(whole.component.clone().into_owned());
    let light = |component, references| Light { component: Cow::Owned(component), references };
    let both_lit = is_lit(&direct) && is_lit(&indirect);
    both_lit.then(|| Parts { direct: light(direct, of_direct), indirect: light(indirect, of_indirect), share })
}
