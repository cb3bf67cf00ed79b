//! Nodes of four children and the test of their boxes.

use super::{Bounds, SlabRay};

/// Children of a node, one per lane.
pub(super) const LANES: usize = 4;

/// What a node's lane, or the root, leads to: an inner node or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link(u32);

impl Link {
    const LEAF: u32 = 1 << 31;

    /// Leads to inner node `index`.
    pub(super) const fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// Leads to leaf `index`.
    pub(super) const fn leaf(index: usize) -> Self {
        Self(index as u32 | Self::LEAF)
    }

    /// Whether it leads to a leaf.
    pub(super) const fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Index of the node or leaf.
    pub(super) const fn index(self) -> usize {
        (self.0 & !Self::LEAF) as usize
    }
}

/// Boxes of four children, by side (0 least, 1 greatest), axis and lane. Lanes without a child hold the empty box.
#[derive(Clone, Debug)]
#[repr(align(16))]
pub(super) struct WideNode {
    sides: [[[f32; LANES]; 3]; 2],
    links: [Link; LANES],
}

impl WideNode {
    /// A node without children.
    pub(super) const fn empty() -> Self {
        Self { sides: [[[f32::INFINITY; LANES]; 3], [[f32::NEG_INFINITY; LANES]; 3]], links: [Link(0); LANES] }
    }

    /// Puts a child into `lane`.
    pub(super) fn set(&mut self, lane: usize, bounds: Bounds, link: Link) {
        for axis in 0..3 {
            self.sides[0][axis][lane] = bounds.min[axis];
            self.sides[1][axis][lane] = bounds.max[axis];
        }
        self.links[lane] = link;
    }

    /// Lets every lane lead to where `moved` says instead.
    pub(super) fn relink(&mut self, moved: impl Fn(Link) -> Link) {
        self.links = self.links.map(moved);
    }

    /// Where `lane` leads.
    #[inline]
    pub(super) fn link(&self, lane: usize) -> Link {
        self.links[lane]
    }

    /// Distances at which the ray enters each child's box, and whether it does before `t_max`, a bit for each lane.
    ///
    /// A ray parallel to a slab and starting in one of its planes gives 0 · ∞ = NaN there. The comparisons are written
    /// so that NaN loses: that plane then does not narrow the interval, which is right, for the closed slab holds the
    /// whole ray. `max` and `min` of the standard library would do too but do not compile to one instruction.
    #[inline]
    pub(super) fn enter(&self, ray: &SlabRay, t_max: f32) -> ([f32; LANES], u32) {
        let mut near = [0.0f32; LANES];
        // Finite, for a slab that a parallel ray misses is entered and left at infinity.
        let mut far = [t_max.min(f32::MAX); LANES];
        for axis in 0..3 {
            let entry = &self.sides[ray.negative[axis]][axis];
            let exit = &self.sides[1 - ray.negative[axis]][axis];
            for lane in 0..LANES {
                let t = (entry[lane] - ray.entry_origin[axis]) * ray.inverse[axis];
                near[lane] = if t > near[lane] { t } else { near[lane] };
                let t = (exit[lane] - ray.exit_origin[axis]) * ray.inverse[axis];
                far[lane] = if t < far[lane] { t } else { far[lane] };
            }
        }
        let entered = (0..LANES).map(|lane| u32::from(near[lane] <= far[lane]) << lane).sum();
        (near, entered)
    }
}
