//! Light that arrives at a surface directly, and how two ways of finding it share the work.

use super::DirectLight;
use super::path::PathTracer;
use super::path_state::{Departure, Path};
use super::surface::Surface;
use crate::interaction::left_after;
use crate::light::LightSample;
use crate::sampler::{Decision, Stream};

/// Weight of a sample that has density `own` in its own technique and `other` in the other one (Veach's power
/// heuristic, β = 2), written so that no square overflows.
#[inline]
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

impl PathTracer<'_> {
    /// Takes one light sample at `hit` and adds what arrives when `adds`. Whether it arrives, where that is `asked`.
    pub(super) fn sample_direct(
        &self,
        path: &mut Path,
        at: &Surface,
        stream: &Stream,
        adds: bool,
        asked: bool,
    ) -> bool {
        let adds = adds && !at.bsdf.is_specular() && self.settings.direct_light != DirectLight::Surfaces;
        if !adds && !asked {
            return false;
        }
        let choice = stream.sample_bits(Decision::light(at.bounce));
        let point = stream.sample_2d(Decision::light_point(at.bounce));
        let sample = self.lights.sample_light(at.hit, at.bsdf.receiver(), choice, point);
        sample.is_some_and(|sample| self.arrives(path, at, &sample, adds, asked))
    }

    /// Whether the light of `sample` arrives; if so and if `adds`, its contribution is added.
    fn arrives(&self, path: &mut Path, at: &Surface, sample: &LightSample, adds: bool, asked: bool) -> bool {
        if !at.bsdf.is_reached_from(sample.direction) {
            return false;
        }
        let value = at.bsdf.evaluate(sample.direction);
        let matters = adds && value.max_element() != 0.0;
        if !matters && !asked {
            return false;
        }
        path.rays += 1;
        if self.scene.occluded(&sample.shadow_ray) {
            return false;
        }
        if matters {
            let weight = match self.settings.direct_light {
                DirectLight::Both if !sample.is_delta => {
                    power_heuristic(sample.pdf, at.bsdf.direction_pdf(sample.direction))
                }
                _ => 1.0,
            };
            let absorption = at.hit.absorption_towards(sample.direction, path.absorption);
            let left = left_after(sample.shadow_ray.t_max, absorption);
            let radiance = path.throughput * left * value * sample.radiance * (weight / sample.pdf);
            path.add_scattered(radiance, at.shared_from(sample.direction, path), 1.0);
        }
        true
    }

    /// Share of the light that a path found by following a surface, when `light_pdf` tells the density of light
    /// samples there.
    pub(super) fn found_share(&self, departure: Option<Departure>, light_pdf: impl Fn(Departure) -> f32) -> f32 {
        match (departure, self.settings.direct_light) {
            (None, _) | (_, DirectLight::Surfaces) => 1.0,
            (Some(_), DirectLight::Lights) => 0.0,
            (Some(departure), DirectLight::Both) => power_heuristic(departure.pdf, light_pdf(departure)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_weights_share_one_whole() {
        for (a, b) in [(1.0, 1.0), (0.1, 7.0), (3e-5, 1e30), (2.0, 0.0)] {
            let sum = power_heuristic(a, b) + if b > 0.0 { power_heuristic(b, a) } else { 0.0 };
            assert!((sum - 1.0).abs() < 1e-6, "{a} {b} {sum}");
        }
        assert_eq!(power_heuristic(2.0, 1.0), 0.8);
    }
}
