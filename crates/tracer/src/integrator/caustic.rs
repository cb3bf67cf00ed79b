//! Caustics at the surface that a path shows: among photons, and what they leave to paths that hit a lamp by themselves.
//!
//! A path that goes on in a direction of density p and photons of density q, both per solid angle there, find the same
//! light; they count by p/(p + βq) and βq/(p + βq). What one photon stands for is its light divided by q, so that
//! β f cos θ L/(p + βq) is what it adds (Georgiev et al. 2012, with all but the last choice of a path made by mirrors and
//! glass, which are the same for both).

use glam::Vec3;

use super::direct::Surface;
use super::path_state::{Landing, Path};
use crate::interaction::Interaction;
use crate::photon::{Emitter, PhotonMap};

/// Radius of the disc that photons are looked for in, in pixels …
const REACH: f32 = 1.4;

/// … and how many photons are enough: where there are more, the disc is smaller, for caustics to be sharp …
const ENOUGH: f32 = 4.0;

/// … but no smaller than this share of its area.
const SMALLEST: f32 = 1.0 / 32.0;

/// β: photons blur, and pixels share what is wrong with them. Where paths are good enough, they shall do it.
const TRUST: f32 = 0.1;

/// What a path needs to know of photons.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photons<'a> {
    /// How they were sent.
    emitter: &'a Emitter<'a>,
    /// Those of the bucket the path belongs to.
    map: &'a PhotonMap,
    /// Those of another one, which tell how many there are without knowing these.
    others: &'a PhotonMap,
    /// Radius of the disc that they are looked for in, over the length of the path.
    reach: f32,
}

impl<'a> Photons<'a> {
    /// Those of the `bucket` among `maps` for sample number `index` of pixels `pixel_width` wide: discs shrink, so that
    /// many samples leave nothing of their blur (Knaus and Zwicker 2011).
    pub(super) fn new(
        emitter: &'a Emitter<'a>,
        maps: &'a [PhotonMap],
        bucket: u32,
        pixel_width: f32,
        index: u32,
    ) -> Self {
        let (bucket, shrunk) = (bucket as usize, (1.0 + index as f32 / 8.0).powf(-1.0 / 6.0));
        let others = &maps[(bucket + 1) % maps.len()];
        Photons { emitter, map: &maps[bucket], others, reach: REACH * pixel_width * shrunk }
    }

    /// Adds to what `path` gathers the caustic at the surface it has come to, and remembers where that is.
    pub(super) fn show(&self, path: &mut Path, at: &Surface, max_depth: u32) {
        let (position, normal) = (at.hit.position, at.hit.facing_normal());
        let widest = (self.reach * path.length).powi(2);
        let mut count = 0.0;
        self.others.near(position, normal, widest, &mut |_| count += 1.0);
        let squared = widest * (ENOUGH / count).clamp(SMALLEST, 1.0);
        let sent = TRUST * squared * self.map.sent() as f32;
        let mut sum = Vec3::ZERO;
        self.map.near(position, normal, squared, &mut |photon| {
            if at.bounce + photon.crossings + 1 > max_depth {
                return;
            }
            let of_path = at.bsdf.direction_pdf(photon.towards);
            let both = of_path + sent * photon.density * normal.dot(photon.towards).max(0.0);
            if both > 0.0 {
                sum += TRUST * at.bsdf.evaluate(photon.towards) * photon.radiance / both;
            }
        });
        path.record.gathered += path.throughput * sum;
        path.landing = Some(Landing { sent, normal, cosine: 0.0, thinned: 1.0 });
    }

    /// Share of what emitter `emitter` sends to the end of the path that is left to it.
    pub(super) fn leave_of_lamp(&self, path: &Path, emitter: u32, seen: &Interaction) -> f32 {
        self.leave(path, || self.emitter.lamp_density(emitter, seen))
    }

    /// Share of what the sky sends along the path that is left to it.
    pub(super) fn leave_of_sky(&self, path: &Path) -> f32 {
        self.leave(path, || self.emitter.sky_density(path.ray.origin, path.ray.direction))
    }

    fn leave(&self, path: &Path, density: impl Fn() -> f32) -> f32 {
        let Some(landing) = path.landing.filter(|_| path.indirect && path.departure.is_none()) else { return 1.0 };
        let of_path = (path.spread * path.spread).recip();
        let of_photons = landing.sent * landing.cosine * density() / landing.thinned;
        of_path / (of_path + of_photons)
    }
}
