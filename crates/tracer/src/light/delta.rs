//! Lights too small to be hit: points, spots and suns. Only light samples find them.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::fork::Fork;
use super::light_sample::LightSample;
use super::mean_radiance::mean;
use super::receiver::Receiver;
use crate::bsdf::Frame;
use crate::interaction::Interaction;
use crate::sampler::warp::sample_cap;

/// A light that no ray can hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeltaLight {
    /// Shines the same in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiant intensity, W/sr.
        intensity: Vec3,
    },
    /// Shines into a cone (pbrt-v4, section 12.2.2).
    Spot {
        /// Where it is.
        position: Vec3,
        /// Unit vector along the axis.
        axis: Vec3,
        /// Radiant intensity along the axis, W/sr.
        intensity: Vec3,
        /// 1 − cos of the angle between axis and rim, where nothing arrives: of narrow spots the cosine alone would be 1.
        rim: f32,
        /// 1 − cos of the smaller angle up to which it shines as along the axis; smooth between.
        full: f32,
    },
    /// Infinitely far away, seen as an even disc.
    Sun {
        /// Unit vector along which its light goes.
        direction: Vec3,
        /// Irradiance of a surface that faces it, W/m².
        irradiance: Vec3,
        /// Diameter of the disc, in radians, below π.
        angle: f32,
    },
}

/// What a light sends to a point.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    /// Unit direction it comes from.
    direction: Vec3,
    /// Irradiance of a surface across that direction.
    irradiance: Vec3,
    /// Where the light is; `None` at infinity.
    source: Option<Vec3>,
}

impl DeltaLight {
    /// A spot whose rim is `angles[0]` degrees from its axis and which fades over the last `angles[1]` of them.
    pub fn spot(position: Vec3, axis: Vec3, intensity: Vec3, angles: [f32; 2]) -> Self {
        let [rim, fade] = angles.map(f32::to_radians);
        Self::Spot { position, axis, intensity, rim: one_minus_cos(rim), full: one_minus_cos(rim - fade) }
    }

    /// The same light, of this power in W. A sun, whose power is infinite, stays as it is.
    #[must_use]
    pub fn of_power(self, power: Vec3) -> Self {
        match self {
            Self::Point { position, .. } => Self::Point { position, intensity: power / (4.0 * PI) },
            Self::Spot { position, axis, rim, full, .. } => {
                Self::Spot { position, axis, intensity: power / spot_solid_angle(rim, full), rim, full }
            }
            Self::Sun { .. } => self,
        }
    }

    /// Power, in W; of a sun, what it sends through a sphere of radius `radius`.
    fn power(&self, radius: f64) -> f64 {
        match *self {
            Self::Point { intensity, .. } => f64::from(4.0 * PI) * mean(intensity),
            Self::Spot { intensity, rim, full, .. } => f64::from(spot_solid_angle(rim, full)) * mean(intensity),
            Self::Sun { irradiance, .. } => f64::from(PI) * radius * radius * mean(irradiance),
        }
    }

    /// What arrives at `point` if nothing is in the way; the point `u` in [0, 1)² says from where on a sun's disc.
    fn arrival(&self, point: Vec3, u: Vec2) -> Arrival {
        match *self {
            Self::Point { position, intensity } => from_near(point, position, intensity),
            Self::Spot { position, axis, intensity, rim, full } => {
                let arrival = from_near(point, position, intensity);
                // Of unit vectors, 1 − cos is half the square of their difference, without cancellation.
                let share = spot_falloff(rim, full, 0.5 * (axis + arrival.direction).length_squared());
                Arrival { irradiance: share * arrival.irradiance, ..arrival }
            }
            Self::Sun { direction, irradiance, angle } => {
                let (direction, share) = on_disc(-direction, 0.5 * angle, u);
                Arrival { direction, irradiance: share * irradiance, source: None }
            }
        }
    }
}

/// 1 − cos of `angle`, without cancellation.
fn one_minus_cos(angle: f32) -> f32 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// The integral of a spot's falloff over all directions: the smooth step takes half of its zone.
fn spot_solid_angle(rim: f32, full: f32) -> f32 {
    2.0 * PI * (full + 0.5 * (rim - full))
}

fn from_near(point: Vec3, position: Vec3, intensity: Vec3) -> Arrival {
    let span = position - point;
    let distance = span.length();
    Arrival { direction: span / distance, irradiance: intensity / (distance * distance), source: Some(position) }
}

/// What of its light a spot sends where 1 − cos of the angle to its axis is `here`: all of it up to `full`, nothing from `rim`
/// on, and 3t² − 2t³ between.
fn spot_falloff(rim: f32, full: f32, here: f32) -> f32 {
    if full >= rim {
        return if here < rim { 1.0 } else { 0.0 };
    }
    let t = ((rim - here) / (rim - full)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A direction uniform over the disc of radius `angle` round `towards`, and what it stands for of the irradiance E of a
/// surface that faces the disc: its radiance is E/(π sin² a), the solid angle 2π(1 − cos a); their product is E · 2/(1 +
/// cos a).
fn on_disc(towards: Vec3, angle: f32, u: Vec2) -> (Vec3, f32) {
    let most = one_minus_cos(angle);
    let direction = Frame::new(towards).to_world(sample_cap(most, u)).normalize();
    (direction, 2.0 / (2.0 - most))
}

/// They take no less than this share of the light samples where there are other lights, which following surfaces finds,
/// too; and no more than the rest.
const SMALLEST_SHARE: f64 = 0.25;

/// All of them, ready to be sampled.
#[derive(Debug)]
pub(super) struct DeltaLights<'a> {
    lights: &'a [DeltaLight],
    /// Between them and all other lights.
    fork: Fork,
}

impl<'a> DeltaLights<'a> {
    /// `lights` in a scene within a sphere of radius `radius` whose other lights have the power `others`.
    pub(super) fn new(lights: &'a [DeltaLight], radius: f64, others: f64) -> Self {
        let power: f64 = lights.iter().map(|light| light.power(radius)).sum();
        Self { lights, fork: Fork::new(power, others, SMALLEST_SHARE..=1.0 - SMALLEST_SHARE) }
    }

    /// The choice between them and all other lights.
    pub(super) fn fork(&self) -> Fork {
        self.fork
    }

    /// Light that may arrive at `from`. One of the lights is chosen by `choice`, in [0, 1), in proportion to what arrives if
    /// nothing is in the way, for which all are looked at. `None` when nothing does, or only from behind.
    pub(super) fn sample(&self, from: &Interaction, receiver: Receiver, choice: f64, u: Vec2) -> Option<LightSample> {
        let arrivals = || self.lights.iter().map(|light| light.arrival(from.position, u));
        let weight = |arrival: &Arrival| {
            let counts = receiver.two_sided || receiver.normal.dot(arrival.direction) > 0.0;
            if counts { mean(arrival.irradiance) } else { 0.0 }
        };
        let total: f64 = arrivals().map(|arrival| weight(&arrival)).sum();
        let mut left = choice * total;
        let mut chosen = None;
        for arrival in arrivals() {
            let weight = weight(&arrival);
            if weight > 0.0 {
                chosen = Some((arrival, weight / total));
                left -= weight;
                if left < 0.0 {
                    break;
                }
            }
        }
        let (Arrival { direction, irradiance, source }, probability) = chosen?;
        let shadow_ray = match source {
            Some(position) => from.spawn_to(position, -direction, Vec3::ZERO),
            None => from.spawn(direction),
        };
        let pdf = (probability * self.fork.share()) as f32;
        Some(LightSample { direction, radiance: irradiance, pdf, is_delta: true, shadow_ray })
    }
}

#[cfg(test)]
mod tests;
