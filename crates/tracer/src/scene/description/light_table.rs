//! `[[light]]`: lights that are no part of a geometry file.

use std::f32::consts::PI;

use glam::Vec3;
use serde::Deserialize;

use super::super::SceneError;
use super::super::area_light::AreaLight;
use super::keys::{FINITE, NOT_NEGATIVE, POSITIVE, TomlTable, TomlValue, toml_table};
use super::mistakes::{Lines, nearest};
use super::triple::Triple;
use crate::light::DeltaLight;

toml_table! {
    /// A light.
    pub(super) struct LightTable {
        /// its shape
        required r#type: LightType;
        /// where its middle is
        optional position: [f32; 3] = "required", FINITE;
        /// a point it shines at; not its position
        optional look_at: [f32; 3] = "required", FINITE;
        /// which way the second side of a quad runs, roughly
        default up: [f32; 3] = [0.0, 1.0, 0.0], FINITE;
        /// lengths of a quad's sides, across `up` and along it
        optional size: [f32; 2] = "required", POSITIVE;
        /// of a disk or a sphere
        optional radius: f32 = "required", POSITIVE;
        /// angle between a spot's axis and its rim, in degrees
        default cone_angle: f32 = 30.0, 0.001..=180.0;
        /// over how many degrees inside of the rim a spot fades out
        default cone_delta_angle: f32 = 5.0, 0.0..=180.0;
        /// where the sun's light goes
        optional direction: [f32; 3] = "required", FINITE;
        /// diameter of the sun as one sees it, in degrees; 0 makes sharp shadows
        default angle: f32 = 0.53, 0.0..=90.0;
        /// emitted radiance, W/(m² sr)
        optional radiance: Triple = "none", NOT_NEGATIVE;
        /// emitted power, W
        optional power: Triple = "none", NOT_NEGATIVE;
        /// radiant intensity (of a spot: along its axis), W/sr
        optional intensity: Triple = "none", NOT_NEGATIVE;
        /// irradiance of a surface that faces the sun, W/m²
        optional irradiance: Triple = "none", NOT_NEGATIVE;
    }
}

/// The shapes of lights.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum LightType {
    Quad,
    Disk,
    Sphere,
    Point,
    Spot,
    Sun,
}

/// Which keys a type of light has.
pub(super) struct Shape {
    pub(super) name: &'static str,
    pub(super) required: &'static [&'static str],
    pub(super) optional: &'static [&'static str],
    /// How bright it is is said by one of these.
    pub(super) brightness: &'static [&'static str],
}

impl LightType {
    pub(super) const ALL: [Self; 6] = [Self::Quad, Self::Disk, Self::Sphere, Self::Point, Self::Spot, Self::Sun];

    /// Its keys.
    pub(super) const fn shape(self) -> Shape {
        const AREA: &[&str] = &["radiance", "power"];
        const SMALL: &[&str] = &["intensity", "power"];
        let (name, required, optional, brightness): (_, &'static [_], &'static [_], _) = match self {
            Self::Quad => ("quad", &["position", "look_at", "size"], &["up"], AREA),
            Self::Disk => ("disk", &["position", "look_at", "radius"], &[], AREA),
            Self::Sphere => ("sphere", &["position", "radius"], &[], AREA),
            Self::Point => ("point", &["position"], &[], SMALL),
            Self::Spot => ("spot", &["position", "look_at"], &["cone_angle", "cone_delta_angle"], SMALL),
            Self::Sun => ("sun", &["direction"], &["angle"], &["irradiance"]),
        };
        Shape { name, required, optional, brightness }
    }
}

impl TomlValue for LightType {
    fn kind() -> String {
        "one of the types above".into()
    }
}

/// A light, checked.
#[derive(Debug)]
pub(in super::super) enum Light {
    Area(AreaLight),
    Delta(DeltaLight),
}

impl LightTable {
    /// The light, checked.
    pub(super) fn light(&self, lines: &Lines) -> Result<Light, SceneError> {
        self.check(lines)?;
        let shape = self.r#type().shape();
        self.check_keys(&shape, lines)?;
        let bright = self.brightness().vec3();
        let by_power = self.power().is_some();
        let position = || Vec3::from_array(*self.position().unwrap_or(&[0.0; 3]));
        let delta = |light: DeltaLight| Light::Delta(if by_power { light.of_power(bright) } else { light });
        let area = |light: AreaLight| {
            let radiance = if by_power { bright / (PI * light.area()) } else { bright };
            Light::Area(AreaLight { radiance, ..light })
        };
        Ok(match self.r#type() {
            LightType::Quad => {
                let [across, along] = *self.size().unwrap_or(&[1.0; 2]);
                area(AreaLight::quad(position(), self.axis(lines)?, self.up().into(), [across, along]))
            }
            LightType::Disk => area(AreaLight::disk(position(), self.axis(lines)?, self.width())),
            LightType::Sphere => area(AreaLight::sphere(position(), self.width())),
            LightType::Point => delta(DeltaLight::Point { position: position(), intensity: bright }),
            LightType::Spot => {
                let angles = [self.cone_angle(), self.cone_delta_angle().min(self.cone_angle())];
                delta(DeltaLight::spot(position(), self.axis(lines)?, bright, angles))
            }
            LightType::Sun => {
                let direction = self.unit("direction", *self.direction().unwrap_or(&[0.0; 3]), lines)?;
                delta(DeltaLight::Sun { direction, irradiance: bright, angle: self.angle().to_radians() })
            }
        })
    }

    /// Checks that all keys are there that its shape needs, and no other.
    fn check_keys(&self, shape: &Shape, lines: &Lines) -> Result<(), SceneError> {
        let given = self.given();
        let known = || [&["type"], shape.required, shape.optional, shape.brightness].concat();
        if let Some((name, offset)) = given.iter().find(|(name, _)| !known().contains(name)) {
            return Err(SceneError::UnknownName {
                place: lines.at(*offset),
                what: format!("key of a {} light", shape.name).into(),
                name: (*name).into(),
                nearest: nearest(name, known().into_iter()),
            });
        }
        let has = |key: &&&str| given.iter().any(|(name, _)| name == *key);
        let refuse = |expected: &str, found| Err(lines.malformed(self.r#type.span().start, expected, found));
        if let Some(missing) = shape.required.iter().find(|key| !has(key)) {
            return refuse(&format!("the key '{missing}' in a {} light", shape.name), "none");
        }
        match shape.brightness.iter().filter(has).count() {
            1 => Ok(()),
            0 => refuse(&format!("{} in a {} light", shape.brightness.join(" or "), shape.name), "neither"),
            _ => refuse(&format!("either {}", shape.brightness.join(" or ")), "both"),
        }
    }

    /// What says how bright it is, in whatever unit.
    fn brightness(&self) -> Triple {
        let all = [self.radiance(), self.power(), self.intensity(), self.irradiance()];
        all.into_iter().flatten().next().copied().unwrap_or(Triple::splat(0.0))
    }

    fn width(&self) -> f32 {
        *self.radius().unwrap_or(&1.0)
    }

    /// Unit vector from its position to what it shines at.
    fn axis(&self, lines: &Lines) -> Result<Vec3, SceneError> {
        let [from, to] = [self.position(), self.look_at()].map(|p| Vec3::from_array(*p.unwrap_or(&[0.0; 3])));
        self.unit("look_at", (to - from).to_array(), lines)
    }

    fn unit(&self, key: &str, vector: [f32; 3], lines: &Lines) -> Result<Vec3, SceneError> {
        let found = Vec3::from_array(vector);
        let offset = self.place_of(key).unwrap_or_default();
        found.try_normalize().ok_or_else(|| lines.malformed(offset, &format!("a direction by {key}"), "none"))
    }
}
