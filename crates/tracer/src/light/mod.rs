//! Where light comes from: triangles that emit, the sky, and lights too small to be hit.
//!
//! First the sky, the lamps or the lights too small to be hit are chosen, by power; then one of the lamps, by what it may
//! send to the surface that asks (`tree`). The sky stays out of the tree: it has no place, so there is no distance to
//! weigh against the lamps'.

pub(crate) mod delta;
mod fork;
mod light_bounds;
mod light_sample;
mod mean_radiance;
mod normal_cone;
mod receiver;
mod sky;
pub(crate) mod tree;
mod triangle;

use std::f32::consts::PI;

pub use delta::DeltaLight;
use delta::DeltaLights;
use fork::Fork;
use glam::{Vec2, Vec3};
use light_bounds::LightBounds;
pub use light_sample::LightSample;
pub(crate) use mean_radiance::mean;
use normal_cone::NormalCone;
pub use receiver::Receiver;
use sky::Sky;
use tree::LightTree;

use crate::interaction::Interaction;
use crate::material::Tinted;
use crate::scene::{EmissiveTriangle, Scene};

/// The sky is found by following surfaces, wherever it is seen at all; lamps are not. So the sky takes no more than
/// this share of the light samples when there are lamps.
const LARGEST_SKY_SHARE: f64 = 0.5;

/// All lights of a scene, ready to be sampled.
#[derive(Debug)]
pub struct Lights<'a> {
    scene: &'a Scene,
    delta: DeltaLights<'a>,
    lamps: &'a LightTree,
    sky: Option<Sky<'a>>,
    /// Between the sky and the lamps.
    fork: Fork,
}

impl<'a> Lights<'a> {
    /// The lights of `scene`. A triangle's power is π A L; the sky's is what falls on a sphere round the scene from
    /// outside, 4π² r² L, L being its mean.
    pub fn new(scene: &'a Scene) -> Self {
        let of_scene = || LightTree::new(&(0..scene.emitters.len()).map(|i| lamp(scene, i)).collect::<Vec<_>>());
        let lamps = scene.light_tree.get_or_init(of_scene);
        let sky = scene.environment.as_ref().map(|environment| Sky { environment });
        let radius = f64::from(scene.bounds().max.distance(scene.bounds().min)) / 2.0;
        let sky_power =
            scene.environment.as_ref().map_or(0.0, |e| 4.0 * f64::from(PI * PI) * radius * radius * mean(e.mean()));
        let fork = Fork::new(sky_power, lamps.power(), 0.0..=LARGEST_SKY_SHARE);
        let delta = DeltaLights::new(&scene.delta_lights, radius, sky_power + lamps.power());
        Self { scene, delta, lamps, sky, fork }
    }

    /// Chooses a light by the whole number `choice` (uniform over 2³²) and a point on it by `u` in [0, 1)², for the
    /// surface `receiver` at `from`. `None` when no light comes from there: there is no light, or it shines away.
    pub fn sample_light(&self, from: &Interaction, receiver: Receiver, choice: u32, u: Vec2) -> Option<LightSample> {
        let choice = match self.delta.fork().take(choice) {
            Ok(choice) => return self.delta.sample(from, receiver, choice, u),
            Err(rest) => rest,
        };
        let Err(choice) = self.fork.take(choice) else {
            return self.sky?.sample(from, receiver, u).map(|sample| scaled(sample, self.sky_share()));
        };
        let lamp = self.lamps.sample_lamp(&receiver, choice)?;
        let light = self.scene.emitter_at(lamp.index, from.time);
        let sample = triangle::sample(&light, &self.scene.materials[light.material as usize], from, u)?;
        Some(scaled(sample, self.lamp_share() * lamp.probability))
    }

    /// Density per solid angle with which [`sample_light`](Self::sample_light) looks from `receiver` to the point of
    /// emitter `emitter` that `seen` is, at the end of a ray from there. 0 behind it.
    pub fn light_pdf(&self, receiver: Receiver, emitter: u32, seen: &Interaction) -> f32 {
        let index = emitter as usize;
        let of_point = triangle::pdf(&self.scene.emitter_at(index, seen.time), seen);
        if of_point == 0.0 {
            return 0.0;
        }
        self.lamp_share() * self.lamps.lamp_probability(&receiver, index) * of_point
    }

    /// Density per solid angle with which it looks from `receiver` into the sky at `direction`.
    pub fn sky_pdf(&self, receiver: Receiver, direction: Vec3) -> f32 {
        self.sky_share() * self.sky.map_or(0.0, |sky| sky.pdf(receiver, direction))
    }

    /// Radiance that emitter `emitter` sends back along the ray that ended at `seen`; it emits on one side only.
    pub fn emitted(&self, emitter: u32, seen: &Interaction) -> Vec3 {
        let triangle = self.scene.emitter_at(emitter as usize, seen.time);
        match triangle.normal.dot(seen.outgoing) > 0.0 {
            false => Vec3::ZERO,
            true if seen.material.maps.tinted == Tinted::Emission => seen.tint * seen.material.emission.at(seen.uv),
            true if triangle.varies => seen.material.emission.at(seen.uv),
            true => triangle.radiance,
        }
    }

    /// A point of emitter `emitter` chosen by `u` in [0, 1)², uniform over its area, seen from along its normal; and its
    /// radiance.
    pub(crate) fn point_of_lamp(&self, emitter: usize, u: Vec2) -> (Interaction<'a>, Vec3) {
        let light = &self.scene.emitters[emitter];
        triangle::point(light, &self.scene.materials[light.material as usize], u)
    }

    /// Radiance of the sky at `direction`.
    pub fn sky_radiance(&self, direction: Vec3) -> Vec3 {
        self.sky.map_or(Vec3::ZERO, |sky| sky.environment.radiance(direction))
    }

    fn sky_share(&self) -> f32 {
        self.delta.fork().rest() * self.fork.share() as f32
    }

    fn lamp_share(&self) -> f32 {
        self.delta.fork().rest() - self.sky_share()
    }
}

/// Emitter `index` of `scene` as the tree knows it.
fn lamp(scene: &Scene, index: usize) -> LightBounds {
    let emitter = &scene.emitters[index];
    let sweep = scene.emitter_sweep(index);
    LightBounds { bounds: sweep.bounds, cone: NormalCone::new(sweep.normal, sweep.turn), power: power(emitter) }
}

/// Power of `emitter`, averaged over the channels.
pub(crate) fn power(emitter: &EmissiveTriangle) -> f64 {
    f64::from(PI * emitter.area) * mean(emitter.radiance)
}

fn scaled(sample: LightSample, share: f32) -> LightSample {
    LightSample { pdf: share * sample.pdf, ..sample }
}

#[cfg(test)]
mod tests;
