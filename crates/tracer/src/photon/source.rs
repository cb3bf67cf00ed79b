//! Where photons begin: on lamps and in the sky.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::target::Targets;
use crate::Ray;
use crate::interaction::Interaction;
use crate::light::{self, Lights};
use crate::sampler::warp::sample_sphere;
use crate::sampler::{Decision, Stream};
use crate::scene::{EmissiveTriangle, Scene};

/// Light that begins its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emission {
    /// Its way.
    pub(super) ray: Ray,
    /// Its radiance.
    pub(super) radiance: Vec3,
    /// Density of the choice per étendue (area across the ray × solid angle), times π; above 0.
    pub(super) density: f32,
}

/// All light that a path can hit by chance.
#[derive(Debug)]
pub(super) struct Sources<'a> {
    scene: &'a Scene,
    targets: Targets,
    /// Power of each emitter and all before it.
    lamps: Vec<f64>,
    /// Share of photons that come from the sky.
    sky_share: f32,
}

impl<'a> Sources<'a> {
    /// Those of `scene`; `None` when there are none, when nothing in it mirrors or refracts, or when something moves.
    pub(super) fn of(scene: &'a Scene) -> Option<Self> {
        let targets = if scene.is_still() { Targets::new(scene.specular_triangles())? } else { return None };
        let add_power = |sum: &mut f64, lamp: &EmissiveTriangle| {
            *sum += light::power(lamp);
            Some(*sum)
        };
        let lamps: Vec<f64> = scene.emitters.iter().scan(0.0, add_power).collect();
        let sky_shines = scene.environment.as_ref().is_some_and(|sky| light::mean(sky.mean()) > 0.0);
        let sky_share = match (sky_shines, lamps.last().is_some_and(|all| *all > 0.0)) {
            (false, false) => return None,
            (true, false) => 1.0,
            (false, true) => 0.0,
            (true, true) => 0.5,
        };
        Some(Self { scene, targets, lamps, sky_share })
    }

    /// Chooses light by the decisions of `stream`. `None` when it would leave a lamp's back.
    pub(super) fn emit(&self, lights: &Lights, stream: &Stream) -> Option<Emission> {
        let (source, target) = (stream.sample_1d(Decision::light(0)), stream.sample_1d(Decision::roulette(0)));
        let (point, way) = (stream.sample_2d(Decision::light_point(0)), stream.sample_2d(Decision::direction(0)));
        if source < self.sky_share {
            return self.emit_from_sky(lights, target, [point, way]);
        }
        self.emit_from_lamp(lights, (source - self.sky_share) / (1.0 - self.sky_share), target, [point, way])
    }

    fn emit_from_sky(&self, lights: &Lights, target: f32, [point, way]: [Vec2; 2]) -> Option<Emission> {
        let sky = self.scene.environment.as_ref()?;
        let towards = match sky.map() {
            Some(_) => sky.sample_direction(way)?.direction,
            None => sample_sphere(way),
        };
        let through = self.targets.point_across(towards, target, point);
        // From outside of the scene.
        let bounds = self.scene.bounds();
        let away = 2.0 * bounds.radius() + through.distance(bounds.centre());
        let origin = through + away * towards;
        let ray = Ray { origin, direction: -towards, t_max: f32::INFINITY, time: 0.0 };
        let (radiance, density) = (lights.sky_radiance(towards), self.sky_density(through, towards));
        (density > 0.0).then_some(Emission { ray, radiance, density })
    }

    fn emit_from_lamp(&self, lights: &Lights, lamp: f32, target: f32, [point, way]: [Vec2; 2]) -> Option<Emission> {
        let sought = f64::from(lamp) * self.lamps.last()?;
        let index = self.lamps.partition_point(|sum| *sum <= sought).min(self.lamps.len() - 1);
        let (from, radiance) = lights.point_of_lamp(index, point);
        let direction = self.targets.direction_from(from.position, target, way);
        let seen = Interaction { outgoing: direction, ..from };
        let density = self.lamp_density(index as u32, &seen);
        (density > 0.0).then(|| Emission { ray: from.spawn(direction), radiance, density })
    }

    /// Density per étendue, times π, of the light that emitter `emitter` sends to where it is `seen` from.
    pub(super) fn lamp_density(&self, emitter: u32, seen: &Interaction) -> f32 {
        let (index, lamp) = (emitter as usize, &self.scene.emitters[emitter as usize]);
        let cosine = lamp.normal.dot(seen.outgoing);
        if cosine <= 0.0 {
            return 0.0;
        }
        let before = if index == 0 { 0.0 } else { self.lamps[index - 1] };
        let probability = ((self.lamps[index] - before) / self.lamps[self.lamps.len() - 1]) as f32;
        let of_direction = self.targets.direction_pdf(seen.position, seen.outgoing);
        PI * (1.0 - self.sky_share) * probability / lamp.area * of_direction / cosine
    }

    /// The same of light that comes through `point` from the sky at `towards`.
    pub(super) fn sky_density(&self, point: Vec3, towards: Vec3) -> f32 {
        let Some(sky) = &self.scene.environment else { return 0.0 };
        let of_direction = match sky.map() {
            Some(_) => sky.direction_pdf(towards),
            None => 0.25 / PI,
        };
        PI * self.sky_share * of_direction * self.targets.point_pdf(point, towards)
    }
}
