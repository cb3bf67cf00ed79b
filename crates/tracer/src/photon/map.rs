//! Photons that have landed, found by where they are.

use std::ops::ControlFlow;

use glam::Vec3;

use crate::bvh::Bounds;
use crate::interaction::Interaction;

/// Photons in a leaf of the tree at most.
const LEAF: usize = 8;
/// Of so many photons, one is among the few …
const FEW: usize = 8;
/// … and of more, where these would be more than that.
const MOST_OF_FEW: usize = 256;
/// Least cosine between the normals of two surfaces that a photon may stand for.
const SAME_SURFACE: f32 = 0.8;

/// A photon that has landed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Photon {
    /// Where, in scene units.
    position: Vec3,
    /// The surface's unit normal on the side where it came from.
    normal: Vec3,
    /// Unit vector to where it came from.
    pub(crate) towards: Vec3,
    /// Radiance that comes from there.
    pub(crate) radiance: Vec3,
    /// Density of such photons, one being sent, per étendue at the surface (projected area × solid angle), times π.
    pub(crate) density: f32,
    /// Mirrors and interfaces of glass on its way.
    pub(crate) crossings: u32,
}

impl Photon {
    pub(super) fn new(hit: &Interaction, radiance: Vec3, density: f32, crossings: u32) -> Self {
        Self {
            position: hit.position,
            normal: hit.facing_normal(),
            towards: hit.outgoing,
            radiance,
            density,
            crossings,
        }
    }
}

/// What a photon is the middle of; of no meaning in leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    /// Along which axis these photons are split.
    axis: usize,
    /// The box round them.
    bounds: Bounds,
}

/// Photons of one bucket, as a tree that is split in the middle along the longest side of its box.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PhotonMap {
    photons: Vec<Photon>,
    /// One for each of them.
    nodes: Vec<Node>,
    /// How many were sent.
    sent: u32,
}

impl PhotonMap {
    /// Photons that have landed of those that were `sent`.
    pub(super) fn new(mut photons: Vec<Photon>, sent: u32) -> Self {
        let mut nodes = vec![Node { axis: 0, bounds: Bounds::EMPTY }; photons.len()];
        split(&mut photons, &mut nodes);
        Self { photons, nodes, sent }
    }

    /// How many were sent.
    pub(crate) const fn sent(&self) -> u32 {
        self.sent
    }

    /// Calls `visit` with all photons on the surface of `position` and `normal`, no further than √`squared` away.
    pub(crate) fn near(&self, position: Vec3, normal: Vec3, squared: f32, mut visit: impl FnMut(&Photon)) {
        let _ = self.search(position, normal, squared, |photon| {
            visit(photon);
            ControlFlow::Continue(())
        });
    }

    /// How many there are, but no more than `most`.
    pub(crate) fn count_near(&self, position: Vec3, normal: Vec3, squared: f32, most: u32) -> u32 {
        let mut count = 0;
        let _ = self.search(position, normal, squared, |_| {
            count += 1;
            if count < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        count
    }

    fn search(
        &self,
        position: Vec3,
        normal: Vec3,
        squared: f32,
        mut visit: impl FnMut(&Photon) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut visit_near = |photon: &Photon| {
            if photon.position.distance_squared(position) <= squared && photon.normal.dot(normal) > SAME_SURFACE {
                visit(photon)?;
            }
            ControlFlow::Continue(())
        };
        walk(&self.photons, &self.nodes, position, squared.sqrt(), &mut visit_near)
    }
}

/// Photons of one bucket.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Landed {
    /// All of them.
    pub(crate) all: PhotonMap,
    /// One in eight, or a few hundred: enough where light is averaged anyway.
    pub(crate) few: PhotonMap,
}

impl Landed {
    /// Of all photons that were sent, those that have landed.
    pub(super) fn new(sent: &[Option<Photon>]) -> Self {
        let few = (sent.len() / MOST_OF_FEW).max(FEW);
        let of = |step: usize| {
            let photons = sent.iter().step_by(step).copied();
            PhotonMap::new(photons.flatten().collect(), sent.len().div_ceil(step) as u32)
        };
        Self { all: of(1), few: of(few) }
    }
}

/// Puts the middle photon along an axis in the middle, and does so with both parts.
fn split(photons: &mut [Photon], nodes: &mut [Node]) {
    if photons.len() <= LEAF {
        return;
    }
    let bounds = Bounds::of(photons.iter().map(|photon| photon.position));
    let axis = bounds.extent().max_position();
    let middle = photons.len() / 2;
    photons.select_nth_unstable_by(middle, |a, b| a.position[axis].total_cmp(&b.position[axis]));
    nodes[middle] = Node { axis, bounds };
    let (below, above) = photons.split_at_mut(middle);
    let (nodes_below, nodes_above) = nodes.split_at_mut(middle);
    rayon::join(|| split(below, nodes_below), || split(&mut above[1..], &mut nodes_above[1..]));
}

/// Visits all `photons` of a tree that may be within `reach` of `position`.
fn walk(
    photons: &[Photon],
    nodes: &[Node],
    position: Vec3,
    reach: f32,
    visit: &mut impl FnMut(&Photon) -> ControlFlow<()>,
) -> ControlFlow<()> {
    if photons.len() <= LEAF {
        return photons.iter().try_for_each(visit);
    }
    let middle = photons.len() / 2;
    let Node { axis, bounds } = nodes[middle];
    if position.distance_squared(position.clamp(bounds.min, bounds.max)) > reach * reach {
        return ControlFlow::Continue(());
    }
    let beyond = position[axis] - photons[middle].position[axis];
    if beyond <= reach {
        walk(&photons[..middle], &nodes[..middle], position, reach, visit)?;
    }
    if beyond.abs() <= reach {
        visit(&photons[middle])?;
    }
    if beyond >= -reach {
        walk(&photons[middle + 1..], &nodes[middle + 1..], position, reach, visit)?;
    }
    ControlFlow::Continue(())
}
