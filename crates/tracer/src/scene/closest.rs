//! Rays against a scene.

use std::ops::ControlFlow;

use super::Scene;
use crate::Ray;
use crate::bvh::{ShearedRay, SlabRay, TriangleHit};
use crate::interaction::Interaction;

impl Scene {
    /// The nearest surface the ray meets before its `t_max`. Among surfaces at the same distance it is always the same.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction<'_>> {
        let (placed, hit) = self.closest(ray)?;
        Some(self.interaction(ray, placed, &hit))
    }

    /// Whether anything lies on the ray before its `t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let sheared = ShearedRay::new(ray);
        let Some(tree) = &self.tree else { return self.occludes(0, ray, &sheared) };
        let mut found = false;
        tree.boxes.traverse(&SlabRay::new(ray, &self.bounds, 0.0), ray.t_max, |leaf, t_max| {
            found = self.occludes(tree.leaves[leaf], ray, &sheared);
            if found { ControlFlow::Break(()) } else { ControlFlow::Continue(t_max) }
        });
        found
    }

    /// The nearest triangle: which of `placed`, and where.
    #[inline]
    pub(super) fn closest(&self, ray: &Ray) -> Option<(usize, TriangleHit)> {
        let sheared = ShearedRay::new(ray);
        let Some(tree) = &self.tree else { return Some((0, self.closest_in(0, ray, &sheared, ray.t_max)?)) };
        let mut nearest: Option<(usize, TriangleHit)> = None;
        tree.boxes.traverse(&SlabRay::new(ray, &self.bounds, 0.0), ray.t_max, |leaf, t_max| {
            let placed = tree.leaves[leaf];
            // One step further, so that ties come back and are settled below.
            if let Some(hit) = self.closest_in(placed, ray, &sheared, t_max.next_up()) {
                let tie = hit.distance == t_max && nearest.is_some_and(|(other, _)| placed < other);
                if hit.distance < t_max || tie {
                    nearest = Some((placed, hit));
                }
            }
            ControlFlow::Continue(nearest.map_or(t_max, |(_, hit)| hit.distance))
        });
        nearest
    }

    #[inline]
    fn closest_in(&self, placed: usize, ray: &Ray, sheared: &ShearedRay, t_max: f32) -> Option<TriangleHit> {
        let stand = &self.placed[placed];
        let (mesh, placement) = (&self.meshes[stand.mesh], stand.at(ray.time));
        let counts = |hit: &TriangleHit| !mesh.is_cut_out || self.is_there(placed, ray, hit);
        mesh.tree.as_ref()?.closest(ray, sheared, placement.as_deref(), t_max, counts)
    }

    #[inline]
    fn occludes(&self, placed: usize, ray: &Ray, sheared: &ShearedRay) -> bool {
        let stand = &self.placed[placed];
        let (mesh, placement) = (&self.meshes[stand.mesh], stand.at(ray.time));
        let counts = |hit: &TriangleHit| !mesh.is_cut_out || self.is_there(placed, ray, hit);
        let tree = mesh.tree.as_ref();
        tree.is_some_and(|tree| tree.occluded(ray, sheared, placement.as_deref(), ray.t_max, counts))
    }
}
