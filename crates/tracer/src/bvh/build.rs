//! From boxes to a tree of four-way nodes.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::Bounds;
use super::node::{LANES, Link, WideNode};

/// A tree of four-way nodes over boxes, with leaves of a few boxes each.
#[derive(Debug)]
pub struct WideBvh {
    pub(super) nodes: Vec<WideNode>,
    pub(super) root: Link,
    /// Stack entries a walk can need.
    pub(super) stack_needed: usize,
    bounds: Bounds,
}

impl WideBvh {
    /// Builds a tree over `boxes`, which must be finite and not empty, with at most `per_leaf` boxes in a leaf.
    ///
    /// Returns the tree and the boxes of each leaf. With no boxes there is no tree.
    pub fn build(boxes: &[Bounds], per_leaf: u32) -> Option<(Self, Vec<Vec<u32>>)> {
        let bounds = boxes.iter().copied().reduce(Bounds::union)?;
        let binary = build_binary(boxes, &bounds, per_leaf);
        let order = preorder(&binary);
        let node_bounds = true_bounds(&binary, &order, boxes);
        let mut collapse = Collapse { binary: &binary, bounds: &node_bounds, unit: unit_of(&bounds), leaves: vec![] };
        let (nodes, root, depth) = collapse.run();
        Some((Self { nodes, root, stack_needed: (LANES - 1) * depth + 1, bounds }, collapse.leaves))
    }

    /// Trees that are joined under one over their boxes, each with the number that its first leaf gets. `None` when there
    /// are none.
    pub(super) fn join(mut trees: Vec<(Self, usize)>) -> Option<Self> {
        if trees.len() < 2 {
            return trees.pop().map(|(tree, _)| tree);
        }
        let boxes: Vec<Bounds> = trees.iter().map(|(tree, _)| tree.bounds).collect();
        let (mut joined, leaves) = Self::build(&boxes, 1)?;
        joined.stack_needed += trees.iter().map(|(tree, _)| tree.stack_needed).max()?;
        let (above, mut roots) = (joined.nodes.len(), vec![]);
        for (mut tree, first_leaf) in trees {
            let before = joined.nodes.len();
            let moved = |link: Link| match link.is_leaf() {
                true => Link::leaf(link.index() + first_leaf),
                false => Link::node(link.index() + before),
            };
            roots.push(moved(tree.root));
            tree.nodes.iter_mut().for_each(|node| node.relink(moved));
            joined.nodes.append(&mut tree.nodes);
        }
        let below = |link: Link| if link.is_leaf() { roots[leaves[link.index()][0] as usize] } else { link };
        joined.nodes[..above].iter_mut().for_each(|node| node.relink(below));
        joined.root = below(joined.root);
        Some(joined)
    }

    /// The box round everything.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }
}

/// Greatest extent, never zero.
fn unit_of(bounds: &Bounds) -> f64 {
    let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
    if extent > 0.0 { extent } else { 1.0 }
}

/// Lets obvhs build a tree over the boxes scaled to the unit cube, where its areas neither overflow nor vanish.
fn build_binary(boxes: &[Bounds], bounds: &Bounds, per_leaf: u32) -> Bvh2 {
    let (origin, unit) = (bounds.min.as_dvec3(), unit_of(bounds));
    let scaled = |p: glam::Vec3| Vec3A::from(((p.as_dvec3() - origin) / unit).as_vec3());
    let scaled: Vec<Aabb> = boxes.iter().map(|b| Aabb::new(scaled(b.min), scaled(b.max))).collect();
    let params = BvhBuildParams { max_prims_per_leaf: per_leaf, ..BvhBuildParams::medium_build() };
    build_bvh2(&scaled, params, &mut Duration::default())
}

/// Indices of all nodes, parents before children.
fn preorder(binary: &Bvh2) -> Vec<usize> {
    let mut order = vec![0];
    let mut next = 0;
    while next < order.len() {
        let node = &binary.nodes[order[next]];
        if !node.is_leaf() {
            order.extend([node.first_index as usize, node.first_index as usize + 1]);
        }
        next += 1;
    }
    order
}

/// The exact box of every node, taken from the boxes themselves.
fn true_bounds(binary: &Bvh2, order: &[usize], boxes: &[Bounds]) -> Vec<Bounds> {
    let mut bounds = vec![Bounds::EMPTY; binary.nodes.len()];
    for &index in order.iter().rev() {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        bounds[index] = if node.is_leaf() {
            leaf_members(binary, index).iter().fold(Bounds::EMPTY, |b, &m| b.union(boxes[m as usize]))
        } else {
            bounds[first].union(bounds[first + 1])
        };
    }
    bounds
}

/// Which boxes a leaf holds.
fn leaf_members(binary: &Bvh2, index: usize) -> &[u32] {
    let node = &binary.nodes[index];
    &binary.primitive_indices[node.first_index as usize..][..node.prim_count as usize]
}

/// Turns a binary tree into a four-way one.
struct Collapse<'a> {
    binary: &'a Bvh2,
    bounds: &'a [Bounds],
    unit: f64,
    leaves: Vec<Vec<u32>>,
}

/// A binary subtree waiting to become the wide node `wide`.
struct Waiting {
    binary: usize,
    wide: usize,
    depth: usize,
}

impl Collapse<'_> {
    /// The wide nodes, the root and the depth.
    fn run(&mut self) -> (Vec<WideNode>, Link, usize) {
        if self.binary.nodes[0].is_leaf() {
            return (vec![], self.leaf(0), 0);
        }
        let mut nodes = vec![WideNode::empty()];
        let mut waiting = vec![Waiting { binary: 0, wide: 0, depth: 1 }];
        let mut deepest = 1;
        while let Some(Waiting { binary, wide, depth }) = waiting.pop() {
            deepest = deepest.max(depth);
            for (lane, child) in self.four_children(binary).into_iter().enumerate() {
                let link = if self.binary.nodes[child].is_leaf() {
                    self.leaf(child)
                } else {
                    waiting.push(Waiting { binary: child, wide: nodes.len(), depth: depth + 1 });
                    nodes.push(WideNode::empty());
                    Link::node(nodes.len() - 1)
                };
                nodes[wide].set(lane, self.bounds[child], link);
            }
        }
        (nodes, Link::node(0), deepest)
    }

    /// Up to four descendants of `parent`: whichever inner node is largest is opened, until there are four.
    fn four_children(&self, parent: usize) -> Vec<usize> {
        let open = |index: usize| {
            let first = self.binary.nodes[index].first_index as usize;
            [first, first + 1]
        };
        let mut children = open(parent).to_vec();
        while children.len() < LANES {
            let inner = (0..children.len()).filter(|&i| !self.binary.nodes[children[i]].is_leaf());
            let area = |i: usize| self.bounds[children[i]].half_area(self.unit);
            let Some(largest) = inner.max_by(|&a, &b| area(a).total_cmp(&area(b))) else { break };
            let opened = open(children.swap_remove(largest));
            children.extend(opened);
        }
        children
    }

    fn leaf(&mut self, index: usize) -> Link {
        self.leaves.push(leaf_members(self.binary, index).to_vec());
        Link::leaf(self.leaves.len() - 1)
    }
}
