//! The pose in which a file has left a mesh: morph targets by their weights, skins by where their joints are.

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3};
use gltf::Semantic;
use gltf::mesh::Primitive;

use super::buffers::Buffers;
use super::numbers::{as_many, shares, vectors, whole_vectors};

/// What moves the vertices of a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Pose {
    /// How much of each morph target.
    pub(super) weights: Vec<f32>,
    /// From a vertex to the scene, for each joint; `None` for a mesh that hangs on none.
    pub(super) joints: Option<Vec<DAffine3>>,
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
