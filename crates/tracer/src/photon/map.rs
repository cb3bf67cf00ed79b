//! Photons that have landed, found by where they are.

use glam::Vec3;

use crate::interaction::Interaction;

/// Photons in a leaf of the tree at most.
const LEAF: usize = 8;
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

/// Photons of one bucket, as a tree that is split in the middle along the longest side of its box.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PhotonMap {
    photons: Vec<Photon>,
    /// Along which axis each inner node is split; in the order in which they are met.
    axes: Vec<u8>,
    /// How many were sent.
    sent: u32,
}

impl PhotonMap {
    /// Photons that have landed of those that were `sent`.
    pub(super) fn new(mut photons: Vec<Photon>, sent: u32) -> Self {
        let mut axes = vec![0; photons.len()];
        split(&mut photons, &mut axes);
        Self { photons, axes, sent }
    }

    /// How many were sent.
    pub(crate) const fn sent(&self) -> u32 {
        self.sent
    }

    /// Calls `visit` with all photons on the surface of `position` and `normal`, no further than √`squared` away.
    pub(crate) fn near(&self, position: Vec3, normal: Vec3, squared: f32, visit: &mut impl FnMut(&Photon)) {
        let mut visit_near = |photon: &Photon| {
            if photon.position.distance_squared(position) <= squared && photon.normal.dot(normal) > SAME_SURFACE {
                visit(photon);
            }
        };
        walk(&self.photons, &self.axes, position, squared.sqrt(), &mut visit_near);
    }
}

/// Puts the middle photon along an axis in the middle, and does so with both parts.
fn split(photons: &mut [Photon], axes: &mut [u8]) {
    if photons.len() <= LEAF {
        return;
    }
    let (min, max) = photons.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), photon| {
        (min.min(photon.position), max.max(photon.position))
    });
    let axis = (max - min).max_position();
    let middle = photons.len() / 2;
    photons.select_nth_unstable_by(middle, |a, b| a.position[axis].total_cmp(&b.position[axis]));
    axes[middle] = axis as u8;
    let (below, above) = photons.split_at_mut(middle);
    let (axes_below, axes_above) = axes.split_at_mut(middle);
    rayon::join(|| split(below, axes_below), || split(&mut above[1..], &mut axes_above[1..]));
}

/// Visits all photons that may be within `reach` of `position`.
fn walk(photons: &[Photon], axes: &[u8], position: Vec3, reach: f32, visit: &mut impl FnMut(&Photon)) {
    if photons.len() <= LEAF {
        photons.iter().for_each(visit);
        return;
    }
    let middle = photons.len() / 2;
    let axis = usize::from(axes[middle]);
    let beyond = position[axis] - photons[middle].position[axis];
    if beyond <= reach {
        walk(&photons[..middle], &axes[..middle], position, reach, visit);
    }
    if beyond.abs() <= reach {
        visit(&photons[middle]);
    }
    if beyond >= -reach {
        walk(&photons[middle + 1..], &axes[middle + 1..], position, reach, visit);
    }
}
