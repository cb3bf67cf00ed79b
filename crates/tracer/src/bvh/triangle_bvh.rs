//! A tree over the triangles of one mesh.

use std::ops::ControlFlow;

use glam::Vec3;

use super::node::LANES;
use super::packet::Packet;
use super::watertight::Crossing;
use super::{Bounds, Placement, ShearedRay, SlabRay, WideBvh};
use crate::Ray;

/// Triangles that a tree is built over at once: beside ten million, what building half a million takes (some
/// 300 bytes each) is little.
const CHUNK: usize = 1 << 19;

/// The nearest triangle a ray crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Number of the triangle in the mesh.
    pub triangle: u32,
    /// Weights of its three vertices at the hit.
    pub barycentric: [f32; 3],
    /// Distance along the ray.
    pub distance: f32,
}

/// A tree over the triangles of one mesh.
///
/// Among triangles at the same distance the one with the lowest number is hit, so the result does not depend on the
/// shape of the tree.
#[derive(Debug)]
pub struct TriangleBvh {
    tree: WideBvh,
    packets: Vec<Packet>,
}

impl TriangleBvh {
    /// Builds a tree over triangles `0..count`, whose vertices must be finite. `None` when there are none.
    ///
    /// Building takes several times the memory of what is built, so large meshes are cut into chunks that are built one
    /// after the other.
    pub fn build(count: u32, vertices_of: impl Fn(u32) -> [Vec3; 3]) -> Option<Self> {
        Self::build_in_chunks(count, vertices_of, CHUNK)
    }

    /// The same in chunks of at most `size` triangles.
    pub(super) fn build_in_chunks(count: u32, vertices_of: impl Fn(u32) -> [Vec3; 3], size: usize) -> Option<Self> {
        let mut all: Vec<u32> = (0..count).collect();
        let (mut trees, mut packets) = (vec![], vec![]);
        for chunk in chunks(&mut all, &|t| Bounds::of(vertices_of(t)).centre(), size) {
            let boxes: Vec<Bounds> = chunk.iter().map(|&t| Bounds::of(vertices_of(t))).collect();
            let Some((tree, leaves)) = WideBvh::build(&boxes, LANES as u32) else { continue };
            let of_leaf = |mut members: Vec<u32>| {
                members.iter_mut().for_each(|member| *member = chunk[*member as usize]);
                Packet::new(&members, &vertices_of)
            };
            trees.push((tree, packets.len()));
            packets.extend(leaves.into_iter().map(of_leaf));
        }
        packets.shrink_to_fit();
        Some(Self { tree: WideBvh::join(trees)?, packets })
    }

    /// The box round all triangles.
    pub fn bounds(&self) -> &Bounds {
        self.tree.bounds()
    }

    /// The nearest triangle nearer than `t_max`, with the mesh standing at `placement` if given, else where it is.
    ///
    /// Placed triangles are taken to the ray and not the ray to them, so that distances and errors are those of the
    /// scene and meshes stay watertight. Of the crossings only those count that `counts` lets.
    #[inline]
    pub fn closest(
        &self,
        ray: &Ray,
        sheared: &ShearedRay,
        placement: Option<&Placement>,
        t_max: f32,
        counts: impl Fn(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        let mut nearest = Nearest { hit: None, t_max };
        self.tree.traverse(&self.slab_ray(ray, placement), t_max, |leaf, _| {
            self.crossings(leaf, sheared, placement, |triangle, at| nearest.offer(at.on(triangle), &counts));
            ControlFlow::Continue(nearest.t_max)
        });
        nearest.hit
    }

    /// Whether any triangle is nearer than `t_max`, with the mesh standing at `placement`. Of the crossings only those
    /// count that `counts` lets.
    #[inline]
    pub fn occluded(
        &self,
        ray: &Ray,
        sheared: &ShearedRay,
        placement: Option<&Placement>,
        t_max: f32,
        counts: impl Fn(&TriangleHit) -> bool,
    ) -> bool {
        let mut found = false;
        self.tree.traverse(&self.slab_ray(ray, placement), t_max, |leaf, _| {
            self.crossings(leaf, sheared, placement, |triangle, at| {
                found = found || at.distance < t_max && counts(&at.on(triangle));
            });
            if found { ControlFlow::Break(()) } else { ControlFlow::Continue(t_max) }
        });
        found
    }

    #[inline]
    fn crossings(
        &self,
        leaf: usize,
        sheared: &ShearedRay,
        placement: Option<&Placement>,
        found: impl FnMut(u32, Crossing),
    ) {
        match placement {
            None => self.packets[leaf].crossings(sheared, found),
            Some(placement) => self.packets[leaf].placed(placement).crossings(sheared, found),
        }
    }

    /// The ray in the mesh's space. Its direction is not unit there, so that distances stay those of the scene.
    #[inline]
    fn slab_ray(&self, ray: &Ray, placement: Option<&Placement>) -> SlabRay {
        let Some(placement) = placement else { return SlabRay::new(ray, self.bounds(), 0.0) };
        let corners = self.bounds().corners().map(|c| placement.point(c).abs().max_element());
        let reach = corners.into_iter().fold(0.0, f32::max) + 2.0 * ray.origin.abs().max_element();
        let local = Ray {
            origin: placement.inverse_point(ray.origin),
            direction: placement.inverse_direction(ray.direction),
            ..*ray
        };
        SlabRay::new(&local, self.bounds(), placement.inverse_error(reach))
    }
}

/// Cuts triangles into chunks of at most `size`, at the middle one along the longest axis of their centres.
fn chunks<'a>(triangles: &'a mut [u32], centre_of: &impl Fn(u32) -> Vec3, size: usize) -> Vec<&'a [u32]> {
    if triangles.len() <= size {
        return vec![triangles];
    }
    let axis = Bounds::of(triangles.iter().map(|&t| centre_of(t))).extent().max_position();
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |&a, &b| centre_of(a)[axis].total_cmp(&centre_of(b)[axis]));
    let (low, high) = triangles.split_at_mut(middle);
    [chunks(low, centre_of, size), chunks(high, centre_of, size)].concat()
}

impl Crossing {
    #[inline]
    fn on(self, triangle: u32) -> TriangleHit {
        TriangleHit { triangle, barycentric: self.barycentric, distance: self.distance }
    }
}

/// The nearest crossing so far.
struct Nearest {
    hit: Option<TriangleHit>,
    t_max: f32,
}

impl Nearest {
    #[inline]
    fn offer(&mut self, at: TriangleHit, counts: impl Fn(&TriangleHit) -> bool) {
        let tie = at.distance == self.t_max && self.hit.is_some_and(|hit| at.triangle < hit.triangle);
        if (at.distance < self.t_max || tie) && counts(&at) {
            self.hit = Some(at);
            self.t_max = at.distance;
        }
    }
}
