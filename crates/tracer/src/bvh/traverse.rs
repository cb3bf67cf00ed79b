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
        let mut current = self.root;
        loop {
            let next = if current.is_leaf() {
                match visit(current.index(), t_max) {
                    ControlFlow::Continue(t) => t_max = t,
                    ControlFlow::Break(()) => return,
                }
                None
            } else {
                self.enter(current, ray, t_max, stack, &mut height)
            };
            current = match next {
                Some(link) => link,
                None => loop {
                    if height == 0 {
                        return;
                    }
                    height -= 1;
                    if stack[height].near <= t_max {
                        break stack[height].link;
                    }
                },
            };
        }
    }

    /// The nearest child of a node that the ray enters. The others are pushed, the nearest on top.
    #[inline]
    fn enter(&self, link: Link, ray: &SlabRay, t_max: f32, stack: &mut [Pending], height: &mut usize) -> Option<Link> {
        let node = &self.nodes[link.index()];
        let (near, mut entered) = node.enter(ray, t_max);
        if entered == 0 {
            return None;
        }
        let mut take = || {
            let lane = entered.trailing_zeros() as usize % LANES;
            entered &= entered - 1;
            (Pending { link: node.link(lane), near: near[lane] }, entered != 0)
        };
        let (mut nearest, mut more) = take();
        let bottom = *height;
        while more {
            let mut child;
            (child, more) = take();
            // Of those that are entered at the same distance, the last comes first.
            if child.near <= nearest.near {
                std::mem::swap(&mut child, &mut nearest);
            }
            let mut slot = *height;
            while slot > bottom && stack[slot - 1].near < child.near {
                stack[slot] = stack[slot - 1];
                slot -= 1;
            }
            stack[slot] = child;
            *height += 1;
        }
        Some(nearest.link)
    }
}
