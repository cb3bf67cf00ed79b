//! Meshes in the pose in which a file has left them: morph targets by their weights, skins by where their joints are.

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3};
use gltf::mesh::Primitive;
use gltf::{Node, Semantic};

use super::super::Mesh;
use super::buffers::Buffers;
use super::materials::Needs;
use super::numbers::{as_many, shares, vectors, whole_vectors};
use super::primitives::read_mesh;

/// What moves the vertices of a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Pose {
    /// How much of each morph target.
    pub(super) weights: Vec<f32>,
    /// From a vertex to the scene, for each joint; `None` for a mesh that hangs on none.
    pub(super) joints: Option<Vec<DAffine3>>,
}

/// A mesh in a pose of its own.
pub(super) struct Posed {
    pub(super) mesh: Mesh,
    /// Whether it is in the scene's space, not in its node's.
    pub(super) is_skinned: bool,
}

/// Poses of the meshes that nodes show.
pub(super) struct Poses<'a> {
    buffers: &'a Buffers,
    needs: &'a [Needs],
    /// Where each node of the file is, if it is in the scene.
    maps: Vec<Option<DAffine3>>,
}

impl<'a> Poses<'a> {
    /// Of a scene of these `nodes`.
    pub(super) fn new(
        document: &gltf::Document,
        buffers: &'a Buffers,
        needs: &'a [Needs],
        nodes: &[(Node, DAffine3)],
    ) -> Self {
        let mut maps = vec![None; document.nodes().len()];
        nodes.iter().for_each(|(node, map)| maps[node.index()] = Some(*map));
        Self { buffers, needs, maps }
    }

    /// The mesh of `node` in its pose; `None` where that is how the mesh is without.
    ///
    /// # Errors
    /// In words, when numbers are not there or joints are not in the scene.
    pub(super) fn of(&self, node: &Node, mesh: &gltf::Mesh) -> Result<Option<Posed>, String> {
        let joints = node.skin().map(|skin| self.joints(&skin)).transpose()?;
        let own = node.weights().filter(|own| Some(*own) != mesh.weights());
        if joints.is_none() && own.is_none() {
            return Ok(None);
        }
        let weights = own.or(mesh.weights()).unwrap_or_default().to_vec();
        let is_skinned = joints.is_some();
        let mesh = read_mesh(mesh, self.buffers, self.needs, &Pose { weights, joints })?;
        Ok(Some(Posed { mesh, is_skinned }))
    }

    fn joints(&self, skin: &gltf::Skin) -> Result<Vec<DAffine3>, String> {
        let inverse = match skin.inverse_bind_matrices() {
            Some(matrices) => vectors::<16>(&matrices, self.buffers)?,
            None => Vec::new(),
        };
        let joint = |(i, joint): (usize, Node)| {
            let map = self.maps.get(joint.index()).copied().flatten();
            let map = map.ok_or_else(|| {
                format!("skins[{}] hangs on nodes[{}], which is not in the scene", skin.index(), joint.index())
            })?;
            let bound = inverse.get(i).map_or(DMat4::IDENTITY, |m| DMat4::from_cols_array(&m.map(f64::from)));
            Ok(map * DAffine3::from_mat4(bound))
        };
        skin.joints().enumerate().map(joint).collect()
    }
}

impl Pose {
    /// Moves the vertices of `primitive`.
    ///
    /// # Errors
    /// In words, when numbers are not there.
    pub(super) fn take(
        &self,
        primitive: &Primitive,
        buffers: &Buffers,
        positions: &mut [Vec3],
        normals: &mut [Vec3],
    ) -> Result<(), String> {
        for (target, weight) in primitive.morph_targets().zip(&self.weights).filter(|(_, weight)| **weight != 0.0) {
            for (all, moved) in [(&mut *positions, target.positions()), (&mut *normals, target.normals())] {
                let Some(moved) = moved.filter(|_| !all.is_empty()) else { continue };
                let moved = vectors::<3>(&moved, buffers)?;
                as_many("displacement", moved.len(), all.len())?;
                all.iter_mut().zip(moved).for_each(|(v, moved)| *v += *weight * Vec3::from(moved));
            }
        }
        match &self.joints {
            Some(joints) => skin(joints, primitive, buffers, positions, normals),
            None => Ok(()),
        }
    }
}

/// Moves vertices with the joints that they hang on. What hangs on none stays.
fn skin(
    joints: &[DAffine3],
    primitive: &Primitive,
    buffers: &Buffers,
    positions: &mut [Vec3],
    normals: &mut [Vec3],
) -> Result<(), String> {
    let mut mixed = vec![(DMat4::ZERO, 0.0); positions.len()];
    for set in 0.. {
        let (of_joints, weights) = (primitive.get(&Semantic::Joints(set)), primitive.get(&Semantic::Weights(set)));
        let Some((of_joints, weights)) = of_joints.zip(weights) else { break };
        let (of_joints, weights) = (whole_vectors::<4>(&of_joints, buffers)?, shares::<4>(&weights, buffers)?);
        as_many("joint", of_joints.len(), positions.len())?;
        as_many("weight", weights.len(), positions.len())?;
        for ((mixed, of_joints), weights) in mixed.iter_mut().zip(of_joints).zip(weights) {
            for (joint, weight) in of_joints.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
                let there = joints.get(joint as usize);
                let map = there.ok_or_else(|| format!("a vertex hangs on joint {joint}, of {}", joints.len()))?;
                mixed.0 += f64::from(weight) * DMat4::from(*map);
                mixed.1 += f64::from(weight);
            }
        }
    }
    for (i, (mixed, sum)) in mixed.into_iter().enumerate().filter(|(_, (_, sum))| *sum > 0.0) {
        let map = DAffine3::from_mat4(mixed * sum.recip());
        positions[i] = map.transform_point3(positions[i].as_dvec3()).as_vec3();
        if let Some(normal) = normals.get_mut(i) {
            *normal = turned(normal.as_dvec3(), map.matrix3).as_vec3();
        }
    }
    Ok(())
}

/// A normal as `matrix` turns surfaces: by its cofactors, which need no inverse.
pub(super) fn turned(normal: DVec3, matrix: DMat3) -> DVec3 {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    (normal.x * y.cross(z) + normal.y * z.cross(x) + normal.z * x.cross(y)).normalize_or_zero()
}
