//! The way of a photon, from where it is emitted to where it lands.

use glam::Vec3;
use rayon::prelude::*;
use stack::Place;

use super::map::{Landed, Photon};
use super::source::Sources;
use crate::bsdf::Bsdf;
use crate::interaction::{Interaction, left_after};
use crate::light::Lights;
use crate::sampler::{Decision, SEQUENCE_LENGTH, Sampler, Stream};
use crate::scene::Scene;

/// Sends photons through a scene.
#[derive(Debug)]
pub(crate) struct PhotonTracer<'a> {
    scene: &'a Scene,
    sources: Sources<'a>,
    sampler: Sampler,
    /// Surfaces that a photon may meet before the one where it lands.
    most_crossings: u32,
}

/// Most photons sent for a bucket in a pass: more would only take memory.
const MOST: u32 = 1 << 22;
const _: () = assert!(MOST <= SEQUENCE_LENGTH, "every photon has numbers of its own");

/// Photons have numbers of their own.
const SEED: u64 = 0x7068_6f74_6f6e;

impl<'a> PhotonTracer<'a> {
    /// Sends photons through `scene` for paths of up to `max_depth` scattering events; `None` when there is nothing that
    /// photons could find.
    pub(crate) fn new(scene: &'a Scene, max_depth: u32, seed: u64) -> Option<Self> {
        let most_crossings = max_depth.checked_sub(1).filter(|most| *most > 0)?;
        let sampler = Sampler::new(seed.wrapping_add(SEED));
        Some(Self { scene, sources: Sources::of(scene)?, sampler, most_crossings })
    }

    /// Sends `count` photons on their way for the bucket `bucket`, in a pass that begins with `before` samples on the
    /// film. Returns those that landed behind a mirror or glass, and how many rays it took.
    pub(crate) fn send(&self, lights: &Lights, before: u64, bucket: u32, count: u32) -> (Landed, u64) {
        let send_one = |index: u32| {
            let place = Place { sequence: bucket, point: index, bucket };
            self.follow(lights, &self.sampler.stream([before as i32, (before >> 32) as i32], place))
        };
        let (sent, rays): (Vec<_>, Vec<u64>) = (0..count.min(MOST)).into_par_iter().map(send_one).unzip();
        (Landed::new(&sent), rays.into_iter().sum())
    }

    fn follow(&self, lights: &Lights, stream: &Stream) -> (Option<Photon>, u64) {
        let Some(emission) = self.sources.emit(lights, stream).filter(|emission| emission.radiance != Vec3::ZERO)
        else {
            return (None, 0);
        };
        let (mut ray, mut radiance, mut density) = (emission.ray, emission.radiance, emission.density);
        let mut absorption = Vec3::ZERO;
        for crossings in 0..=self.most_crossings {
            let rays = u64::from(crossings) + 1;
            let Some(hit) = self.scene.intersect(&ray) else { return (None, rays) };
            radiance *= left_after(hit.distance, absorption);
            let bsdf = Bsdf::at(&hit);
            if !bsdf.is_specular() {
                let landed = crossings > 0 && (density * radiance).is_finite() && radiance != Vec3::ZERO;
                return (landed.then(|| Photon::new(&hit, radiance, density, crossings)), rays);
            }
            let choice = stream.sample_1d(Decision::lobe(crossings + 1));
            let way = stream.sample_2d(Decision::direction(crossings + 1));
            let Some(sample) = bsdf.sample_direction(choice, way) else { return (None, rays) };
            // Weights are those of light that comes the other way: it loses η² where this gains it.
            let squeezed = sample.eta * sample.eta;
            radiance *= sample.weight * squeezed * squeezed;
            density *= squeezed / bent(&hit, &bsdf, hit.outgoing, sample.direction);
            absorption = hit.absorption_towards(sample.direction, absorption);
            ray = hit.spawn(sample.direction);
        }
        (None, u64::from(self.most_crossings) + 1)
    }

    /// How densely photons come from the point of emitter `emitter` that is `seen`, one being sent
    /// ([`Photon::density`]).
    pub(crate) fn lamp_density(&self, emitter: u32, seen: &Interaction) -> f32 {
        self.sources.lamp_density(emitter, seen)
    }

    /// The same of light that comes through `point` from the sky at `towards`.
    pub(crate) fn sky_density(&self, point: Vec3, towards: Vec3) -> f32 {
        self.sources.sky_density(point, towards)
    }
}

/// How much further apart photons are that come along `from` and leave `hit` along `to` because its shading normal is not
/// that of the surface (Veach 1997, section 5.3.2).
pub(crate) fn bent(hit: &Interaction, bsdf: &Bsdf, from: Vec3, to: Vec3) -> f32 {
    let [geometric, shading] =
        [hit.geometric_normal, bsdf.normal()].map(|normal| normal.dot(to).abs() / normal.dot(from).abs());
    geometric / shading
}
