//! Meshes in poses of their own, as nodes show them.

use glam::{DAffine3, DMat4};
use gltf::Node;

use super::super::Mesh;
use super::buffers::Buffers;
use super::materials::Needs;
use super::numbers::vectors;
use super::pose::Pose;
use super::primitives::read_mesh;

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
