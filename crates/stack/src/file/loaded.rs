//! One render as its files hold it: planes with roles, before they are put together to a stack.

use super::convention::{Measured, Useless, of_the_mean, usable};
use super::counts::{Spp, take_spp};
use super::found::{Found, FoundRole, layer_name};
use super::mend::{Oriented, mend_role, mend_variance, to_world_space};
use super::recognise::{Mapping, Match, Recognised, XYZ, recognise};
use super::role::{Convention, Measure, Role, Slot};
use super::xyz::rgb_of_xyz;
use super::{FileError, Layers};
use crate::{FeatureRole, Image, Noise};

/// What the user says about the files.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Layers with the role they have.
    pub map: Vec<Mapping>,
    /// Samples per pixel: of all files, or of each.
    pub spp: Vec<u32>,
    /// What every variance is.
    pub variance_is: Option<Convention>,
    /// Layers of our own stacks that nobody needs: no memory is taken for them.
    pub leave_out: Vec<&'static str>,
}

/// Everything known about one role.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Which.
    pub role: Role,
    /// Mean of all samples.
    pub mean: Image,
    /// Means of two halves of them.
    pub halves: Option<[Image; 2]>,
    /// Another measure of its noise; not when there are halves.
    pub measured: Option<Measured>,
}

/// One render.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Its planes: the colour first, then emission and features.
    pub planes: Vec<Plane>,
    /// Its samples, where the files say.
    pub spp: Option<Spp>,
    /// What was found so far.
    pub found: Found,
    /// What remains of the file.
    pub rest: Layers,
    /// Whether Tamis wrote it, so that nothing needs to be mended.
    pub own: bool,
}

impl Loaded {
    /// The plane of `role`.
    pub fn plane(&self, role: Role) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.role == role)
    }

    /// All images of `role`.
    pub fn images_mut(&mut self, role: Role) -> Vec<&mut Image> {
        let planes = self.planes.iter_mut().filter(|plane| plane.role == role);
        planes.flat_map(|plane| std::iter::once(&mut plane.mean).chain(plane.halves.iter_mut().flatten())).collect()
    }

    /// The estimate's noise when all there is to know is in this file.
    pub fn noise_of(&mut self, plane: &Plane) -> Noise {
        if let Some(halves) = &plane.halves {
            return Noise::Buckets(halves.to_vec());
        }
        let Some(measured) = &plane.measured else { return Noise::Unknown };
        let mut variance = of_the_mean(measured, &plane.mean, self.spp.as_ref().map(|spp| &spp.total[..]));
        if mend_variance(plane.role, &mut variance, &mut self.found.mended) {
            return Noise::VarianceOfMean(variance);
        }
        self.found.remarks.push(format!("the variance of {} is known nowhere and not used", plane.role.name()));
        Noise::Unknown
    }
}

/// Finds the planes of a render in `layers`. Emission is used only where something is known about its noise, which `apart`
/// says of several renders: else it stays in the picture, and is carried along.
///
/// # Errors
/// When there is no colour, or it is not clear which layer is which.
pub fn load(mut layers: Layers, options: &ReadOptions, nth: usize, apart: bool) -> Result<Loaded, FileError> {
    let recognised = recognise(&layers, &options.map)?;
    let given = options.spp.get(nth).or_else(|| options.spp.first().filter(|_| options.spp.len() == 1)).copied();
    let spp = take_spp(&mut layers, &recognised, given);
    let mut found = Found { renderer: recognised.renderer.name.into(), ..Found::default() };
    let mut planes = Vec::new();
    for role in Role::ALL.into_iter().filter(|role| !matches!(role, Role::Alpha | Role::Samples)) {
        let has_halves = recognised.get(Slot { role, measure: Measure::HalfA }).is_some();
        if role == Role::Emission && !apart && !has_halves {
            continue;
        }
        let mut taking = Taking { layers: &mut layers, recognised: &recognised, options, found: &mut found };
        if let Some(plane) = taking.plane(role, spp.is_some()) {
            planes.push(plane);
        }
    }
    for role in [Role::Alpha, Role::Samples] {
        if let Some(m) = recognised.mean(role) {
            found.roles.push(found_role(m, None));
        }
    }
    if options.variance_is.is_some()
        && recognised.matches.iter().all(|m| !matches!(m.slot.measure, Measure::Variance(_)))
    {
        found.remarks.push("there is no variance of which --variance-is could say the kind".into());
    }
    found.spp = spp.as_ref().map(Spp::found);
    Ok(Loaded { planes, spp, found, rest: layers, own: false })
}

fn found_role(m: &Match, from: Option<String>) -> FoundRole {
    let (role, mut channels) = (m.slot.role.name().into(), m.channels.clone());
    channels.dedup();
    FoundRole { role, channels, noise: String::new(), from, guessed: m.guessed }
}

struct Taking<'a> {
    layers: &'a mut Layers,
    recognised: &'a Recognised,
    options: &'a ReadOptions,
    found: &'a mut Found,
}

impl Taking<'_> {
    fn plane(&mut self, role: Role, spp_known: bool) -> Option<Plane> {
        let mean_match = self.recognised.mean(role)?;
        let halves = [Measure::HalfA, Measure::HalfB].map(|measure| self.recognised.get(Slot { role, measure }));
        let variance = self.recognised.get(Slot { role, measure: Measure::Variance(Convention::Unsaid) });
        let mut mean = self.image(&mean_match.channels)?;
        if role == Role::Colour && mean_match.channels == XYZ {
            mean = rgb_of_xyz(&mean);
            self.found.remarks.push("the picture is CIE XYZ, and was taken to linear Rec. 709".into());
        }
        let (halves, from) = match halves {
            [Some(a), Some(b)] => {
                let from = format!("{} and {}", layer_name(&a.channels), layer_name(&b.channels));
                (self.image(&a.channels).zip(self.image(&b.channels)).map(|(a, b)| [a, b]), Some(from))
            }
            _ => (None, None),
        };
        let (measured, told) = match variance {
            Some(found) if halves.is_none() => self.measured(found, spp_known),
            _ => (None, None),
        };
        self.found.roles.push(found_role(mean_match, from.or(told)));
        Some(Plane { role, mean, halves, measured })
    }

    /// A variance, unless it is of no use; then it stays where it is and that is said.
    fn measured(&mut self, found: &Match, spp_known: bool) -> (Option<Measured>, Option<String>) {
        let Measure::Variance(own) = found.slot.measure else { return (None, None) };
        let convention = self.options.variance_is.unwrap_or(own);
        let layer = layer_name(&found.channels);
        match usable(convention, spp_known) {
            Err(Useless::SamplesUnknown) => {
                let what =
                    format!("{layer} is a {convention}; it can be used when the number of samples is known: --spp N");
                self.found.remarks.push(what);
                (None, None)
            }
            Err(Useless::KindUnknown) => {
                self.found.remarks.push(format!("{layer} is not used: say what it is with --variance-is"));
                (None, None)
            }
            Ok(()) => {
                let mean = found.mean.as_ref().and_then(|names| self.image(names));
                let values = self.image(&found.channels);
                (values.map(|values| Measured { values, convention, mean }), Some(format!("{layer}, a {convention}")))
            }
        }
    }

    fn image(&mut self, names: &[String]) -> Option<Image> {
        match names {
            [only] => {
                let plane = self.layers.take_scalar(only)?;
                Some(Image::from_channels(self.layers.window.size, vec![plane]))
            }
            several => take_image(self.layers, several),
        }
    }
}

/// Takes the channels `names` out as one image, when all are there. One that is named for all is there once.
pub fn take_image(layers: &mut Layers, names: &[String]) -> Option<Image> {
    if let Some(only) = names.first().filter(|first| names.iter().all(|name| name == *first)) {
        let plane = layers.take(only)?;
        return Some(Image::from_channels(layers.window.size, vec![plane; names.len()]));
    }
    if !names.iter().all(|name| layers.has(name)) {
        return None;
    }
    let planes = names.iter().filter_map(|name| layers.take(name)).collect();
    Some(Image::from_channels(layers.window.size, planes))
}

/// Mends the pixels of renders that belong together: other renderers' only.
pub fn mend_all(renders: &mut [Loaded]) {
    if renders.iter().any(|render| render.own) {
        return;
    }
    let mut list = Vec::new();
    for role in Role::ALL {
        let mut images: Vec<&mut Image> = renders.iter_mut().flat_map(|render| render.images_mut(role)).collect();
        mend_role(role, &mut images, &mut list);
    }
    for render in renders.iter_mut() {
        if leave_camera_space(render) {
            let what = "positions and normals were in camera space and are taken to world space (worldToCamera)";
            render.found.remarks.push(what.into());
        }
    }
    if let Some(first) = renders.first_mut() {
        first.found.mended.extend(list);
    }
}

fn leave_camera_space(render: &mut Loaded) -> bool {
    let Some(matrix) = render.rest.carried.world_to_camera() else { return false };
    let mean = |role| render.plane(Role::Feature(role)).map(|plane| plane.mean.clone());
    let Some((position, normal)) = mean(FeatureRole::Position).zip(mean(FeatureRole::Normal)) else { return false };
    let mut turned: Vec<Oriented<'_>> = Vec::new();
    for plane in &mut render.planes {
        let images = std::iter::once(&mut plane.mean).chain(plane.halves.iter_mut().flatten());
        match plane.role {
            Role::Feature(FeatureRole::Position) => turned.extend(images.map(Oriented::Position)),
            Role::Feature(FeatureRole::Normal) => turned.extend(images.map(Oriented::Normal)),
            _ => {}
        }
    }
    to_world_space(&matrix, &position, &normal, &mut turned)
}
