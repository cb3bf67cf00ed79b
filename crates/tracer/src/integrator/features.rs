//! What a path tells about the surface its pixel shows.

use glam::Vec3;

use super::path_state::Path;
use super::{FeatureHit, TraceSettings};
use crate::Ray;
use crate::bsdf::Bsdf;
use crate::bvh::Bounds;
use crate::film::FeatureRecord;
use crate::interaction::Interaction;

/// Mirrors and interfaces of glass that features look through at most.
const MOST_SPECULAR: u32 = 16;

/// Whether the features of `path` are those of its hit number `bounce`, with scattering `bsdf`, for good.
pub(super) fn settle(path: &Path, bsdf: &Bsdf, bounce: u32, settings: &TraceSettings) -> bool {
    let looks_further = settings.feature_hit == FeatureHit::FirstNonSpecular
        && bsdf.is_specular()
        && bounce < MOST_SPECULAR.min(settings.max_depth);
    !path.settled && !looks_further
}

/// Features of a surface. Whether light reaches it, and what lies next, is for the path to find out.
pub(super) fn of_surface(hit: &Interaction, bsdf: &Bsdf) -> FeatureRecord {
    FeatureRecord {
        position: hit.position,
        albedo: bsdf.albedo(),
        normal: hit.shading_normal,
        visibility: 1.0,
        depth: hit.distance,
        proximity: 0.0,
        lit: 0.0,
    }
}

/// Features of a ray that leaves the scene: where it leaves the scene's bounding sphere (grown to hold the ray's origin,
/// so that there is such a place).
pub(super) fn of_miss(ray: &Ray, bounds: Bounds) -> FeatureRecord {
    let from_centre = ray.origin - bounds.centre();
    let radius = (0.5 * bounds.max.distance(bounds.min)).max(from_centre.length());
    let along = from_centre.dot(ray.direction);
    let beside = from_centre - along * ray.direction;
    let depth = (radius * radius - beside.length_squared()).max(0.0).sqrt() - along;
    FeatureRecord {
        position: ray.at(depth.max(0.0)),
        albedo: Vec3::ONE,
        normal: Vec3::ZERO,
        visibility: 1.0,
        depth: depth.max(0.0),
        proximity: 0.0,
        lit: 0.0,
    }
}

/// How near a surface at this `distance` is to a feature hit seen from `depth` away: half at 3 % of that, so that what
/// lies a few pixels off counts most whatever the scene's units.
pub(super) fn proximity(distance: f32, depth: f32) -> f32 {
    let near = 0.03 * depth;
    if near > 0.0 { near / (near + distance) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds() -> Bounds {
        Bounds { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) }
    }

    fn miss(origin: Vec3, direction: Vec3) -> FeatureRecord {
        of_miss(&Ray { origin, direction, t_max: f32::INFINITY, time: 0.0 }, bounds())
    }

    #[test]
    fn a_miss_lies_on_the_bounding_sphere_along_the_ray() {
        let direction = Vec3::new(0.6, 0.8, 0.0);
        let inside = miss(Vec3::new(0.2, 0.1, 0.3), direction);
        assert!((inside.position.length() - 3.0_f32.sqrt()).abs() < 1e-5);
        assert!((inside.position - Vec3::new(0.2, 0.1, 0.3) - inside.depth * direction).length() < 1e-5);
        let through = miss(Vec3::new(-10.0, 0.0, 0.0), Vec3::X);
        assert!((through.position - Vec3::new(10.0, 0.0, 0.0)).length() < 1e-4);
    }

    #[test]
    fn a_miss_is_finite_even_when_it_looks_away() {
        let away = miss(Vec3::new(-10.0, 0.0, 0.0), -Vec3::X);
        assert_eq!((away.position, away.depth), (Vec3::new(-10.0, 0.0, 0.0), 0.0));
        assert_eq!((away.normal, away.albedo, away.visibility), (Vec3::ZERO, Vec3::ONE, 1.0));
    }
}
