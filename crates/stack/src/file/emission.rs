//! A layer of directly seen emission in another renderer's stack.

use super::loaded::Plane;
use super::role::Role;
use crate::Image;

/// By how much emission may exceed the picture it is part of.
const ROUNDING: f32 = 1e-2;

/// Share of the pixels in which it must be part of the picture.
const PART_OF: f64 = 0.999;

/// Makes the colour what remains of the picture without its emission, so that both add up to it. A layer that is not
/// part of the picture is left out, and that is said.
pub fn split_emission(planes: &mut Vec<Plane>, remarks: &mut Vec<String>) {
    let Some(at) = planes.iter().position(|plane| plane.role == Role::Emission) else { return };
    let emission = planes.remove(at);
    let Some(colour) = planes.iter_mut().find(|plane| plane.role == Role::Colour) else { return };
    let same_noise = colour.halves.is_some() == emission.halves.is_some();
    if !same_noise || !is_part_of(&emission.mean, &colour.mean) {
        remarks.push("the emission layer is not part of the picture and not used".into());
        return;
    }
    subtract(&mut colour.mean, &emission.mean);
    if let (Some(colour), Some(emission)) = (&mut colour.halves, &emission.halves) {
        colour.iter_mut().zip(emission).for_each(|(colour, emission)| subtract(colour, emission));
    }
    planes.insert(at, emission);
}

fn is_part_of(emission: &Image, whole: &Image) -> bool {
    let fits = |pixel: &usize| {
        let (e, w) = (emission.rgb(*pixel), whole.rgb(*pixel));
        (0..3).all(|c| e[c] <= w[c] * (1.0 + ROUNDING) + f32::MIN_POSITIVE)
    };
    (0..whole.pixels()).filter(fits).count() as f64 >= PART_OF * whole.pixels() as f64
}

fn subtract(colour: &mut Image, emission: &Image) {
    for (colour, emission) in colour.channels_mut().iter_mut().zip(emission.channels()) {
        colour.iter_mut().zip(emission).for_each(|(c, e)| *c = (*c - e).max(0.0));
    }
}
