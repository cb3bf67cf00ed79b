//! One path, from the camera to its end.

use glam::Vec3;

use super::caustic::Photons;
use super::path_state::{Departure, Path};
use super::surface::Surface;
use super::{TraceSettings, features, roulette};
use crate::Ray;
use crate::bsdf::Bsdf;
use crate::film::SampleRecord;
use crate::interaction::{Interaction, left_after};
use crate::light::Lights;
use crate::photon;
use crate::sampler::{Decision, Stream};
use crate::scene::Scene;

/// Follows paths through a scene.
#[derive(Debug)]
pub(super) struct PathTracer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) lights: Lights<'a>,
    pub(super) settings: TraceSettings,
}

impl<'a> PathTracer<'a> {
    /// Prepares to follow paths through `scene`.
    pub(super) fn new(scene: &'a Scene, settings: &TraceSettings) -> Self {
        Self { scene, lights: Lights::new(scene), settings: *settings }
    }

    /// Follows the path that begins with `camera_ray`, its decisions taken from `stream`. Returns what it recorded, and
    /// how many rays it took. Radiance is unbiased but for paths longer than `max_depth`.
    pub(super) fn follow(&self, camera_ray: Ray, stream: &Stream, photons: Option<&Photons>) -> (SampleRecord, u64) {
        let mut path = Path::new(camera_ray);
        for bounce in 0..=self.settings.max_depth {
            path.rays += 1;
            let Some(hit) = self.scene.intersect(&path.ray) else {
                self.leave_scene(&mut path, bounce, photons);
                break;
            };
            path.length += hit.distance;
            path.throughput *= left_after(hit.distance, path.absorption);
            self.see_emitter(&mut path, &hit, photons);
            let comes_next = path.settled && !path.indirect;
            path.indirect |= path.settled;
            let bsdf = Bsdf::at(&hit);
            let gathers = path.gather_at(&hit, &bsdf, self.scene.bounds());
            let surface = Surface { hit: &hit, bsdf: &bsdf, bounce, gathers };
            let goes_on = bounce < self.settings.max_depth;
            let is_feature_hit = self.record_features(&mut path, &surface);
            let arrives = self.sample_direct(&mut path, &surface, stream, goes_on, is_feature_hit || comes_next);
            let recorded = &mut path.record.features;
            if is_feature_hit {
                recorded.visibility = f32::from(arrives);
            } else if comes_next {
                recorded.proximity = features::proximity(hit.distance, recorded.depth);
                recorded.lit = f32::from(arrives);
            }
            if !bsdf.is_specular() {
                let shown = photons.filter(|_| (is_feature_hit || gathers) && goes_on);
                path.landing = shown.map(|photons| photons.show(&mut path, &surface, self.settings.max_depth));
            }
            if !(goes_on && scatter(&mut path, &surface, stream) && self.survives(&mut path, bounce, stream)) {
                break;
            }
        }
        (path.record, path.rays)
    }

    /// The path meets nothing but the sky.
    fn leave_scene(&self, path: &mut Path, bounce: u32, photons: Option<&Photons>) {
        let direction = path.ray.direction;
        let share = self.found_share(path.departure, |from| self.lights.sky_pdf(from.receiver, direction));
        let left = photons.map_or(1.0, |photons| photons.leave_of_sky(path));
        path.add_emission(share * self.lights.sky_radiance(direction), left);
        if !path.settled {
            path.set_features(features::of_miss(&path.ray, self.scene.bounds()), true, bounce == 0);
        }
    }

    /// Adds what `hit` emits towards the path.
    fn see_emitter(&self, path: &mut Path, hit: &Interaction, photons: Option<&Photons>) {
        let Some(emitter) = hit.emitter else { return };
        let share = self.found_share(path.departure, |from| self.lights.light_pdf(from.receiver, emitter, hit));
        let left = photons.map_or(1.0, |photons| photons.leave_of_lamp(path, emitter, hit));
        path.add_emission(share * self.lights.emitted(emitter, hit), left);
    }

    /// Records features until they are settled. Whether they are settled here: then the light sample taken here decides
    /// on visibility.
    fn record_features(&self, path: &mut Path, at: &Surface) -> bool {
        if path.settled {
            return false;
        }
        let settles = features::settle(path, at.bsdf, at.bounce, &self.settings);
        path.set_features(features::of_surface(at.hit, at.bsdf), settles, at.bounce == 0);
        settles
    }

    /// Plays Russian roulette, never before the features are settled: they must not depend on how dim a mirror is.
    fn survives(&self, path: &mut Path, bounce: u32, stream: &Stream) -> bool {
        if bounce < self.settings.roulette_depth || !path.settled {
            return true;
        }
        let survival = roulette::survival(path.throughput.max_element() * path.eta_scale);
        path.throughput /= survival;
        survival >= 1.0 || stream.sample_1d(Decision::roulette(bounce)) < survival
    }
}

/// Sends the path on from a surface. Whether it goes on: the light may be absorbed.
fn scatter(path: &mut Path, at: &Surface, stream: &Stream) -> bool {
    let choice = stream.sample_1d(Decision::lobe(at.bounce));
    let Some(sample) = at.bsdf.sample_direction(choice, stream.sample_2d(Decision::direction(at.bounce))) else {
        return false;
    };
    let squeezed = sample.eta * sample.eta;
    if let Some(landing) = &mut path.landing {
        if at.bsdf.is_specular() {
            landing.thinned *= squeezed * photon::bent(at.hit, at.bsdf, sample.direction, at.hit.outgoing);
        } else {
            landing.cosine = landing.normal.dot(sample.direction).max(0.0);
        }
    }
    path.shared = at.shared_from(sample.direction, path);
    path.throughput *= sample.weight;
    path.eta_scale *= squeezed;
    path.specular &= at.bsdf.is_specular();
    path.spread = sample.pdf.map_or(path.spread, |pdf| pdf.sqrt().recip());
    path.departure = sample.pdf.map(|pdf| Departure { pdf, receiver: at.bsdf.receiver() });
    path.absorption = at.hit.absorption_towards(sample.direction, path.absorption);
    path.ray = at.hit.spawn(sample.direction);
    path.throughput != Vec3::ZERO
}
