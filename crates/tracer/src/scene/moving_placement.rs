//! A mesh that moves while the shutter is open.

use glam::Vec3;

use crate::bvh::{Bounds, Placement};
use crate::motion::Motion;

/// A mesh that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovingPlacement {
    start: Placement,
    motion: Motion,
}

impl MovingPlacement {
    pub(super) const fn new(start: Placement, motion: Motion) -> Self {
        Self { start, motion }
    }

    /// Where it stands at `time`.
    pub(super) fn at(&self, time: f32) -> Placement {
        Placement::new(self.motion.at(time) * self.start.map()).unwrap_or(self.start)
    }

    /// A direction that turns along.
    pub(super) fn turned(&self, direction: Vec3, time: f32) -> Vec3 {
        self.motion.at(time).transform_vector3(direction.as_dvec3()).as_vec3()
    }

    /// Angle of its turn over the whole frame, in radians; more than one turn is possible.
    pub(super) fn whole_turn(&self) -> f64 {
        self.motion.turn.length()
    }

    /// A box round `points` (in the mesh's space) that holds them over the whole frame.
    pub(super) fn sweep<'p>(&self, points: impl Iterator<Item = &'p Vec3> + Clone) -> Bounds {
        self.swept(|time| {
            let placement = self.at(time);
            Bounds::of(points.clone().map(|p| placement.point(*p)))
        })
    }

    /// All of the frame from the boxes at single moments: those between which things hardly turn, widened by what they
    /// turn.
    fn swept(&self, at: impl Fn(f32) -> Bounds) -> Bounds {
        const FINEST: f64 = 0.1;
        let steps = (self.whole_turn() / FINEST).ceil().clamp(1.0, 256.0) as usize;
        let swept = (0..=steps).map(|i| at(i as f32 / steps as f32)).reduce(Bounds::union);
        let mut bounds = swept.unwrap_or(Bounds::EMPTY);
        let from_centre = |c: Vec3| (c.as_dvec3() - self.motion.centre).length();
        let reach = at(0.0).corners().into_iter().map(from_centre).fold(0.0, f64::max);
        let pad = Vec3::splat((1.01 * self.motion.bulge(1.0 / steps as f64, reach)) as f32);
        (bounds.min, bounds.max) = (bounds.min - pad, bounds.max + pad);
        bounds
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::super::{Instance, Mesh, Scene};
    use super::*;
    use crate::Ray;
    use crate::bvh::random::Random;
    use crate::material::{Colour, Material, Surface};

    fn tumble() -> Motion {
        Motion {
            translate: DVec3::new(1.0, -2.0, 0.5),
            turn: DVec3::new(2.0, 5.0, -3.0),
            centre: DVec3::new(0.3, 0.1, 0.0),
        }
    }

    #[test]
    fn a_motion_turns_about_its_centre_and_then_shifts() {
        let quarter = Motion { translate: DVec3::X, turn: DVec3::Z * std::f64::consts::FRAC_PI_2, centre: DVec3::Y };
        let there = quarter.at(1.0).transform_point3(DVec3::new(0.0, 3.0, 0.0));
        // From two above the centre to two left of it, then one to the right.
        assert!((there - DVec3::new(-1.0, 1.0, 0.0)).length() < 1e-12);
        assert!((quarter.at(0.5).transform_point3(DVec3::Y) - DVec3::new(0.5, 1.0, 0.0)).length() < 1e-12);
        assert_eq!(quarter.at(0.0), DAffine3::IDENTITY);
    }

    /// A triangle of each size, and the same standing where it is at one moment.
    fn scene(motion: Option<Motion>, placement: Placement) -> Scene {
        let surface = Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) };
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, 2.0 * Vec3::X, Vec3::Y, Vec3::new(0.0, 0.5, 1.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3], [1, 3, 2]],
            materials: vec![0; 3],
            ..Mesh::default()
        };
        let stand = Instance { mesh: 0, placement, motion };
        Scene::new(vec![mesh], vec![stand], vec![Material::new("white", surface, Vec3::ONE)], None).unwrap()
    }

    #[test]
    fn a_moving_mesh_looks_at_any_moment_like_one_that_stands_there() {
        let start = Placement::new(DAffine3::from_scale(DVec3::new(1.0, 2.0, 0.5))).unwrap();
        let moving = scene(Some(tumble()), start);
        let mut random = Random(6);
        let mut hits = 0;
        for i in 0..40 {
            let time = i as f32 / 39.0;
            let still = scene(None, MovingPlacement::new(start, tumble()).at(time));
            let (inner, outer) = (still.bounds(), moving.bounds());
            assert!(inner.min.cmpge(outer.min - 1e-5).all() && inner.max.cmple(outer.max + 1e-5).all(), "{time}");
            for _ in 0..400 {
                let origin = still.bounds().centre() + 4.0 * random.direction();
                let target = still.bounds().centre() + random.point();
                let ray = Ray { origin, direction: (target - origin).normalize(), t_max: f32::INFINITY, time };
                let (a, b) = (moving.intersect(&ray), still.intersect(&ray));
                assert_eq!((a.is_some(), moving.occluded(&ray)), (b.is_some(), a.is_some()));
                let (Some(a), Some(b)) = (a, b) else { continue };
                hits += 1;
                assert!(
                    (a.position - b.position).length() < 1e-5
                        && (a.geometric_normal - b.geometric_normal).length() < 1e-5
                );
                assert_eq!(a.emitter, b.emitter);
            }
        }
        assert!(hits > 3_000);
    }

    #[test]
    fn the_sweep_of_an_emitter_holds_it_at_any_time() {
        let surface = Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) };
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, 2.0 * Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            materials: vec![0],
            ..Mesh::default()
        };
        let gentle = Motion { turn: 0.2 * tumble().turn, ..tumble() };
        for motion in [tumble(), gentle] {
            let stand = Instance { mesh: 0, placement: Placement::IDENTITY, motion: Some(motion) };
            let material = Material::new("lamp", surface.clone(), Vec3::ONE);
            let scene = Scene::new(vec![mesh.clone()], vec![stand], vec![material], None).unwrap();
            let sweep = scene.emitter_sweep(0);
            for i in 0..=100 {
                let emitter = scene.emitter_at(0, i as f32 / 100.0);
                let there = Bounds::of(emitter.vertices);
                assert_eq!(sweep.bounds.union(there), sweep.bounds);
                assert!(f64::from(emitter.normal.angle_between(sweep.normal)) < sweep.turn + 1e-3);
            }
        }
    }
}
