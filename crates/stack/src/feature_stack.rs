//! The feature stack: everything a reconstruction starts from.

use serde::{Deserialize, Serialize};

use crate::{Estimate, Image, Passthrough, SampleCounts, Size, Window};

/// Which part of the light a component holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ComponentRole {
    /// Everything that was scattered at least once by a surface that is not a perfect mirror or clear glass; in a
    /// foreign stack without an emission layer, the whole picture.
    Scattered,
    /// Emission and background seen directly, or through perfect mirrors and clear glass.
    Emission,
}

impl ComponentRole {
    /// All roles, in the order in which components are added up.
    pub const ALL: [Self; 2] = [Self::Scattered, Self::Emission];

    /// Name of its layer in a file.
    pub const fn layer(self) -> &'static str {
        match self {
            Self::Scattered => "noisy",
            Self::Emission => "emission",
        }
    }
}

/// Name of the layer of indirect light in a file.
pub const INDIRECT: &str = "indirect";
/// Name of the layer of gathered light in a file.
pub const GATHERED: &str = "gathered";

/// One summand of the picture, reconstructed by itself. Three channels of linear radiance, ≥ 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Which part of the light this is.
    pub role: ComponentRole,
    /// Its radiance.
    pub radiance: Estimate,
}

/// What a feature measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureRole {
    /// World-space position of the feature hit, in scene units.
    Position,
    /// Reflectance (specular for metals), 0 … 1.
    Albedo,
    /// World-space shading normal, unit length per sample, 0 on a miss.
    Normal,
    /// Share of light samples that reached the feature hit, 0 … 1.
    Visibility,
    /// Distance along the camera ray, in scene units.
    Depth,
    /// How near the surface lies that the path meets next, 0 (at infinity, or none) … 1: what an ambient occlusion tells.
    Proximity,
    /// Share of paths that meet a surface next which a light sample reaches, 0 … 1.
    Lit,
}

impl FeatureRole {
    /// All roles, in the order in which features stand in a stack.
    pub const ALL: [Self; 7] =
        [Self::Position, Self::Albedo, Self::Normal, Self::Visibility, Self::Depth, Self::Proximity, Self::Lit];

    /// Name of its layer in a file.
    pub const fn layer(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Visibility => "visibility",
            Self::Depth => "depth",
            Self::Proximity => "proximity",
            Self::Lit => "lit",
        }
    }

    /// Names of its channels in a file.
    pub const fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Position | Self::Normal => &["X", "Y", "Z"],
            Self::Albedo => &["R", "G", "B"],
            Self::Visibility | Self::Proximity | Self::Lit => &["Y"],
            Self::Depth => &["Z"],
        }
    }

    /// Whether it tells where paths go on from the feature hit, and so what indirect light does. Only we write it.
    pub const fn is_of_next_surface(self) -> bool {
        matches!(self, Self::Proximity | Self::Lit)
    }
}

/// An auxiliary image that explains the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// What it measures.
    pub role: FeatureRole,
    /// The measurement, with as many channels as the role has.
    pub estimate: Estimate,
}

/// Everything known about one picture before reconstruction: its components, its features, and how many samples each
/// pixel got. Which of them exist is known at run time only.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureStack {
    /// The part of the film this covers.
    pub window: Window,
    /// The whole film.
    pub film: Size,
    /// Sample counts.
    pub samples: SampleCounts,
    /// The picture is their sum. At least one.
    pub components: Vec<Component>,
    /// Part of what is scattered: what arrived at the surface of the features from other surfaces, not from a lamp or
    /// the sky. In as many buckets; `None` where a renderer does not keep it apart.
    pub indirect: Option<Estimate>,
    /// The same light with less noise: what leaves the surfaces it came from is the mean over all paths that met them
    /// nearby, and photons show caustics. On average as bright over the picture, but not to the last detail. In as many
    /// buckets.
    pub gathered: Option<Estimate>,
    /// Auxiliary images, in the order of [`FeatureRole::ALL`].
    pub features: Vec<Feature>,
    /// Layers nobody here interprets, carried along.
    pub passthrough: Vec<Passthrough>,
}

impl FeatureStack {
    /// Width and height of all its images.
    pub const fn size(&self) -> Size {
        self.window.size
    }

    /// The noisy picture: the sum of all components.
    pub fn beauty(&self) -> Image {
        let mut sum = Image::zeros(self.size(), 3);
        for component in &self.components {
            sum.add(&component.radiance.mean);
        }
        sum
    }

    /// What its planes take, in bytes.
    pub fn bytes(&self) -> usize {
        let components = self.components.iter().map(|component| &component.radiance);
        let features = self.features.iter().map(|feature| &feature.estimate);
        let estimates = components.chain(self.parts_of_light().map(|(_, light)| light)).chain(features);
        estimates.map(Estimate::bytes).sum::<usize>() + self.samples.bytes() + self.passed_through_bytes()
    }

    /// Those of them that stay until the picture is rebuilt: indirect and gathered light, and what nobody here interprets.
    pub fn staying_bytes(&self) -> usize {
        self.parts_of_light().map(|(_, light)| light.bytes()).sum::<usize>() + self.passed_through_bytes()
    }

    /// Indirect and gathered light, where they are known, with the names of their layers in a file.
    pub fn parts_of_light(&self) -> impl Iterator<Item = (&'static str, &Estimate)> {
        let parts = [(INDIRECT, &self.indirect), (GATHERED, &self.gathered)];
        parts.into_iter().filter_map(|(layer, light)| Some((layer, light.as_ref()?)))
    }

    fn passed_through_bytes(&self) -> usize {
        self.passthrough.iter().map(Passthrough::bytes).sum()
    }

    /// The component of `role`, if there is one.
    pub fn component(&self, role: ComponentRole) -> Option<&Component> {
        self.components.iter().find(|c| c.role == role)
    }

    /// The feature of `role`, if there is one.
    pub fn feature(&self, role: FeatureRole) -> Option<&Feature> {
        self.features.iter().find(|f| f.role == role)
    }
}
