//! Walking the tree, nearest children first.

use std::ops::ControlFlow;

use super::node::{LANES, Link};
use super::{SlabRay, WideBvh};

/// A subtree still to visit, and where the ray enters it.
#[derive(Clone, Copy)]
struct Pending {
    link: Link,
    near: f32,
}

const NOTHING: Pending = Pending { link: Link::node(0), near: 0.0 };

/// Entries the stack on the stack holds; a deeper tree (no real scene has one) takes it from the heap.
const SHALLOW: usize = 64;

impl WideBvh {
    /// Calls `visit` with the index of each leaf whose box the ray enters before the current greatest distance.
    ///
    /// `visit` gets that distance and returns the new one, or breaks to end the walk.
    #[inline]
    pub fn traverse(&self, ray: &SlabRay, t_max: f32, visit: impl FnMut(usize, f32) -> ControlFlow<(), f32>) {
        if !ray.sound {
            return;
        }
        if self.stack_needed <= SHALLOW {
            self.walk(ray, t_max, visit, &mut [NOTHING; SHALLOW]);
        } else {
            self.walk(ray, t_max, visit, &mut vec![NOTHING; self.stack_needed]);
        }
    }

    #[inline]
    fn walk(
        &self,
        ray: &SlabRay,
        mut t_max: f32,
        mut visit: impl FnMut(usize, f32) -> ControlFlow<(), f32>,
        stack: &mut [Pending],
    ) {
        let mut height = 0;
        let mut current = Some(self.root);
        while let Some(link) = current {
            current = None;
            if link.is_leaf() {
                match visit(link.index(), t_max) {
                    ControlFlow::Continue(t) => t_max = t,
                    ControlFlow::Break(()) => return,
                }
            } else {
                height = self.push_children(link, ray, t_max, stack, height);
            }
            while height > 0 && current.is_none() {
                height -= 1;
                current = (stack[height].near <= t_max).then_some(stack[height].link);
            }
        }
    }

    /// Pushes the children of a node that the ray enters, the nearest on top; returns the new height.
    #[inline]
    fn push_children(&self, link: Link, ray: &SlabRay, t_max: f32, stack: &mut [Pending], height: usize) -> usize {
        let node = &self.nodes[link.index()];
        let near = node.enter(ray, t_max);
        let mut top = height;
        for lane in 0..LANES {
            if near[lane] == f32::INFINITY {
                continue;
            }
            let mut slot = top;
            while slot > height && stack[slot - 1].near < near[lane] {
                stack[slot] = stack[slot - 1];
                slot -= 1;
            }
            stack[slot] = Pending { link: node.link(lane), near: near[lane] };
            top += 1;
        }
        top
    }
}
