//! Caustics at the surface that a path shows: among photons, and what they leave to paths that hit a lamp by themselves.
//!
//! A path that goes on in a direction of density p and photons of density q, both per solid angle there, find the same
//! light; they count by p/(p + βq) and βq/(p + βq). What one photon stands for is its light divided by q, so that
//! β f cos θ L/(p + βq) is what it adds (Georgiev et al. 2012, with all but the last choice of a path made by mirrors and
//! glass, which are the same for both).

use super::TraceSettings;
use super::path_state::{Landing, Path};
use super::surface::Surface;
use crate::interaction::Interaction;
use crate::light::Lights;
use crate::photon::{Landed, PhotonTracer};
use crate::scene::Scene;

/// Radius of the disc that photons are looked for in, in pixels …
const REACH: f32 = 1.4;

/// … and where light is gathered, against what a path stands for (as [`GatherPoint`](crate::gather::GatherPoint) knows it).
const REACH_WHERE_GATHERED: f32 = 0.1;

/// How many photons are enough: where there are more, the disc is smaller, for caustics to be sharp …
const ENOUGH: f32 = 4.0;

/// … up to this many, and where light is gathered to these.
const MOST: u32 = 64;
const MOST_WHERE_GATHERED: u32 = 8;

/// β: photons blur, and pixels share what is wrong with them. Where paths are good enough, they shall do it.
const TRUST: f32 = 0.1;

/// Sends photons where there is something that they could find.
#[derive(Debug)]
pub(super) struct Caustics<'a> {
    tracer: PhotonTracer<'a>,
    /// Photons sent for every sample.
    per_sample: f32,
    /// Width of a pixel, over the length of its paths.
    pixel_width: f32,
}

impl<'a> Caustics<'a> {
    /// Those of `scene` in pixels that are `pixel_width` wide at distance 1; `None` when there are none to be found so.
    pub(super) fn of(scene: &'a Scene, settings: &TraceSettings, pixel_width: f32) -> Option<Self> {
        let TraceSettings { max_depth, seed, photons: per_sample, .. } = *settings;
        let tracer = (per_sample > 0.0).then(|| PhotonTracer::new(scene, max_depth, seed)).flatten()?;
        Some(Self { tracer, per_sample, pixel_width })
    }

    /// Sends photons for a pass that takes so many `samples` for every bucket, `before` samples having been taken. How many
    /// rays they took comes with them.
    pub(super) fn send(&self, lights: &Lights, before: u64, samples: &[u64]) -> (PassPhotons<'_>, u64) {
        let sent = samples.iter().enumerate().map(|(bucket, samples)| {
            let count = (f64::from(self.per_sample) * *samples as f64).ceil() as u32;
            self.tracer.send(lights, before, bucket as u32, count)
        });
        let (landed, rays): (Vec<_>, Vec<u64>) = sent.unzip();
        (PassPhotons { caustics: self, landed }, rays.into_iter().sum())
    }
}

/// Photons of a pass.
#[derive(Debug)]
pub(super) struct PassPhotons<'a> {
    caustics: &'a Caustics<'a>,
    /// For every bucket.
    landed: Vec<Landed>,
}

impl PassPhotons<'_> {
    /// What sample number `index` of a pixel sees of those of its `bucket`: discs shrink, so that many samples leave nothing
    /// of their blur (Knaus and Zwicker 2011).
    pub(super) fn of(&self, bucket: u32, index: u32) -> Photons<'_> {
        let Self { caustics: Caustics { tracer, pixel_width, .. }, landed } = self;
        let (bucket, shrunk) = (bucket as usize, (1.0 + index as f32 / 8.0).powf(-1.0 / 6.0));
        let others = &landed[(bucket + 1) % landed.len()];
        Photons { tracer, own: &landed[bucket], others, reach: REACH * pixel_width * shrunk }
    }
}

/// What a path needs to know of photons.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photons<'a> {
    /// How they were sent.
    tracer: &'a PhotonTracer<'a>,
    /// Those of the bucket the path belongs to.
    own: &'a Landed,
    /// Those of another one, which tell how many there are without knowing these.
    others: &'a Landed,
    /// Radius of the disc that they are looked for in, over the length of the path.
    reach: f32,
}

impl Photons<'_> {
    /// Adds to what `path` gathers the caustic at the surface it has come to. Returns what the path must remember of that.
    pub(super) fn show(&self, path: &mut Path, at: &Surface, max_depth: u32) -> Landing {
        let (own, others, most, radius) = if at.gathers {
            let radius = REACH_WHERE_GATHERED * path.spread * at.hit.distance;
            (&self.own.few, &self.others.few, MOST_WHERE_GATHERED, radius)
        } else {
            (&self.own.all, &self.others.all, MOST, self.reach * path.length)
        };
        let (position, normal, widest) = (at.hit.position, at.hit.facing_normal(), radius * radius);
        let count = others.count_near(position, normal, widest, most);
        let squared = widest * (ENOUGH / count as f32).min(1.0);
        let sent = TRUST * squared * own.sent() as f32;
        own.near(position, normal, squared, |photon| {
            let of_path = at.bsdf.direction_pdf(photon.towards);
            let both = of_path + sent * photon.density * normal.dot(photon.towards).max(0.0);
            if at.bounce + photon.crossings < max_depth && both > 0.0 {
                let found = path.throughput * at.bsdf.evaluate(photon.towards) * photon.radiance * (TRUST / both);
                path.gather(found, at.shared_from(photon.towards, path));
            }
        });
        Landing { sent, normal, cosine: 0.0, thinned: 1.0 }
    }

    /// Share of what emitter `emitter` sends to the end of the path that is left to it.
    pub(super) fn leave_of_lamp(&self, path: &Path, emitter: u32, seen: &Interaction) -> f32 {
        self.leave(path, || self.tracer.lamp_density(emitter, seen))
    }

    /// Share of what the sky sends along the path that is left to it.
    pub(super) fn leave_of_sky(&self, path: &Path) -> f32 {
        self.leave(path, || self.tracer.sky_density(path.ray.origin, path.ray.direction))
    }

    fn leave(&self, path: &Path, density: impl Fn() -> f32) -> f32 {
        let Some(landing) = path.landing.filter(|_| path.indirect && path.departure.is_none()) else { return 1.0 };
        let of_path = (path.spread * path.spread).recip();
        let of_photons = landing.sent * landing.cosine * density() / landing.thinned;
        of_path / (of_path + of_photons)
    }
}
