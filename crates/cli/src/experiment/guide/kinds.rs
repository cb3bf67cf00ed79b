//! Guides of many kinds.

use anyhow::Result;
use reconstruct::box_filter::box_mean;
use reconstruct::reconstruct;
use reconstruct::recorruption::recorrupted_halves;
use stack::{ComponentRole, Image};

use crate::experiment::case::{Case, settings};
use crate::progress::Progress;
use crate::settings::Preset;

/// A guide.
pub struct Kind {
    /// What it is.
    pub name: &'static str,
    pub picture: Image,
    /// References of its own, where it is one of the stack's itself.
    pub references: Option<[Image; 2]>,
}

/// All guides there are for `case`, which was rebuilt to `picture`: other programs' pictures, other methods', the noisy
/// picture, blurred pictures, a black one, and one of two references, judged by the other.
///
/// # Errors
/// When another method fails.
pub fn kinds(case: &Case, picture: &Image, progress: &Progress) -> Result<Vec<Kind>> {
    let plain = |name: &'static str, picture: Image| Kind { name, picture, references: None };
    let mut kinds: Vec<Kind> = case.others.iter().map(|(name, picture)| plain(name, picture.clone())).collect();
    let noisy = case.stack.beauty();
    if let Some(other) = case.other("oidn") {
        kinds.push(plain("oidn blurred", blurred(other, 1)));
        kinds.push(plain("oidn darker", scaled(other, 0.95)));
    }
    kinds.push(plain("noisy", noisy.clone()));
    kinds.push(plain("noisy blurred", blurred(&noisy, 1)));
    kinds.push(plain("noisy blurred more", blurred(&noisy, 2)));
    kinds.push(plain("ours blurred", blurred(picture, 1)));
    kinds.push(plain("black", Image::zeros(noisy.size(), 3)));
    for (name, preset, flags) in [("fast", Preset::Fast, &[][..]), ("nfor", Preset::Paper, &[("method", "nfor")][..])] {
        let found = reconstruct(&case.stack, &settings(preset, flags)?.reconstruction, progress)?;
        kinds.push(plain(name, found.picture));
    }
    let [first, second] = &case.references;
    if first != second {
        let references = Some([second.clone(), second.clone()]);
        kinds.push(Kind { name: "a reference", picture: first.clone(), references });
    }
    kinds.extend(noisier(case, case.other("oidn"), 0.1).map(|picture| plain("oidn with noise", picture)));
    if first != second {
        let references = Some([second.clone(), second.clone()]);
        let picture = noisier(case, Some(first), 1.0);
        kinds.extend(picture.map(|picture| Kind { name: "a reference with noise", picture, references }));
    }
    Ok(kinds)
}

/// `image` with noise of its own, `share` of the variance of the scattered light; `None` when nothing is known of that.
fn noisier(case: &Case, image: Option<&Image>, share: f32) -> Option<Image> {
    let component = case.stack.component(ComponentRole::Scattered)?;
    let mut variance = component.radiance.variance_of_mean(&case.stack.samples)?;
    let unknown = |v: f32| if v.is_finite() { share * v } else { 0.0 };
    variance.channels_mut().iter_mut().flatten().for_each(|v| *v = unknown(*v));
    let [noisy, _] = recorrupted_halves(image?, &variance);
    Some(noisy)
}

/// `image` times `factor`.
fn scaled(image: &Image, factor: f32) -> Image {
    let planes = image.channels().iter().map(|plane| plane.iter().map(|v| factor * v).collect());
    Image::from_channels(image.size(), planes.collect())
}

/// `image` after two box filters of this radius, one after the other.
fn blurred(image: &Image, radius: usize) -> Image {
    let size = image.size();
    let blurred = |plane: &Vec<f32>| box_mean(&box_mean(plane, size, radius), size, radius);
    Image::from_channels(size, image.channels().iter().map(blurred).collect())
}
