//! Triangles that emit.

use std::borrow::Cow;

use glam::{Vec3, Vec4};

use super::mesh::IndexedMesh;
use super::moving_placement::MovingPlacement;
use super::placed::Placed;
use super::{Bounds, Scene};
use crate::material::{Material, Tinted};
use crate::texture::TexCoords;

/// A triangle that emits on the side its normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissiveTriangle {
    /// Corners, in scene space.
    pub vertices: [Vec3; 3],
    /// Unit normal of the side that emits.
    pub normal: Vec3,
    /// Area, in squared scene units.
    pub area: f32,
    /// Emitted radiance, the same in all directions of that side; its mean where it varies.
    pub radiance: Vec3,
    /// Texture coordinates of the corners.
    pub uvs: [TexCoords; 3],
    /// What multiplies emission and opacity at the corners.
    pub tints: [Vec4; 3],
    /// Index of its material.
    pub material: u32,
    /// Whether emission or opacity vary over it.
    pub varies: bool,
    /// Which placed mesh it moves with, and as which of its triangles.
    moves_as: Option<(u32, u32)>,
}

impl Scene {
    /// Emitter `index` where it is at `time`.
    #[inline]
    pub fn emitter_at(&self, index: usize, time: f32) -> Cow<'_, EmissiveTriangle> {
        let emitter = &self.emitters[index];
        let Some((placed, moving, triangle)) = self.moving(emitter) else { return Cow::Borrowed(emitter) };
        // Rounded as rays find it: from other corners, a light sample would lie beside the triangle, perhaps behind it.
        let vertices = Placed::corners(&self.meshes[placed.mesh], triangle, Some(&moving.at(time)));
        let normal = placed.cross(vertices).normalize().as_vec3();
        Cow::Owned(EmissiveTriangle { vertices, normal, ..*emitter })
    }

    /// What holds emitter `index` over the frame.
    pub(crate) fn emitter_sweep(&self, index: usize) -> EmitterSweep {
        let emitter = &self.emitters[index];
        let Some((placed, moving, triangle)) = self.moving(emitter) else {
            return EmitterSweep { bounds: Bounds::of(emitter.vertices), normal: emitter.normal, turn: 0.0 };
        };
        EmitterSweep {
            bounds: moving.sweep(self.meshes[placed.mesh].mesh.corners(triangle).iter()),
            normal: moving.turned(emitter.normal, 0.5),
            turn: 0.5 * moving.whole_turn(),
        }
    }

    /// The mesh that `emitter` moves with, how that moves, and which of its triangles the emitter is.
    #[inline]
    fn moving(&self, emitter: &EmissiveTriangle) -> Option<(&Placed, &MovingPlacement, u32)> {
        let (placed, triangle) = emitter.moves_as?;
        let placed = &self.placed[placed as usize];
        Some((placed, placed.moving.as_ref()?, triangle))
    }
}

/// Where an emitter is and where it shines while it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterSweep {
    /// All of it at any time of the frame.
    pub(crate) bounds: Bounds,
    /// Its unit normal in the middle of the frame.
    pub(crate) normal: Vec3,
    /// How far, in radians, its normal is from that at most.
    pub(crate) turn: f64,
}

/// Lists the emitters of `placed`, which is number `number`, in the order of its mesh's emissive triangles.
pub(super) fn emitters_of<'a>(
    mesh: &'a IndexedMesh,
    placed: &'a Placed,
    number: u32,
    materials: &'a [Material],
) -> impl Iterator<Item = EmissiveTriangle> + 'a {
    (0..mesh.mesh.triangles.len()).filter(|&t| emits(mesh, t, materials)).map(move |t| {
        let vertices = Placed::corners(mesh, t as u32, placed.placement.as_ref());
        let cross = placed.cross(vertices);
        let normal = cross.normalize().as_vec3();
        let index = mesh.mesh.materials[t];
        let material = &materials[index as usize];
        let tints = tints(mesh, t, material);
        let tint = (tints[0] + tints[1] + tints[2]).truncate() / 3.0;
        EmissiveTriangle {
            vertices,
            normal,
            area: (0.5 * cross.length()) as f32,
            radiance: tint * material.emission.mean(),
            tints,
            uvs: mesh.mesh.corner_uvs(t as u32),
            material: index,
            varies: material.emission.texture.is_some() || material.maps.opacity.is_some() || is_tinted(mesh, material),
            moves_as: placed.moving.map(|_| (number, t as u32)),
        }
    })
}

/// Whether the colours of the vertices of `mesh` change what `material` emits.
fn is_tinted(mesh: &IndexedMesh, material: &Material) -> bool {
    material.maps.tinted == Tinted::Emission && !mesh.mesh.colours.is_empty()
}

/// What multiplies emission and opacity of triangle `triangle` of `mesh` at its corners.
fn tints(mesh: &IndexedMesh, triangle: usize, material: &Material) -> [Vec4; 3] {
    let colours = mesh.mesh.corner_colours(triangle as u32);
    match material.maps.tinted {
        Tinted::Emission => colours,
        Tinted::Base | Tinted::Nothing => colours.map(|colour| Vec3::ONE.extend(colour.w)),
    }
}

/// Whether triangle `triangle` of `mesh` emits.
fn emits(mesh: &IndexedMesh, triangle: usize, materials: &[Material]) -> bool {
    materials[mesh.mesh.materials[triangle] as usize].emits()
}

/// For each triangle of `mesh` its rank among those that emit; `u32::MAX` for the others. Empty when none does.
pub(super) fn ranks(mesh: &IndexedMesh, materials: &[Material]) -> Vec<u32> {
    let mut next = 0;
    let rank = |triangle| {
        if !emits(mesh, triangle, materials) {
            return u32::MAX;
        }
        next += 1;
        next - 1
    };
    let ranks: Vec<u32> = (0..mesh.mesh.triangles.len()).map(rank).collect();
    if ranks.iter().all(|&r| r == u32::MAX) { vec![] } else { ranks }
}
