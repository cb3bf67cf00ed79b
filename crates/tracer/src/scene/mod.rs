//! What is rendered: meshes, materials, emitters, sky; and how files become one.

mod area_light;
mod closest;
mod cut_out;
mod description;
mod dropped;
mod emitters;
mod environment_file;
mod error;
mod find_file;
mod fingerprint;
mod gltf;
mod guess;
mod instance;
mod load;
mod look;
mod mesh;
mod moving_placement;
mod mtl;
mod notes;
mod obj;
mod picture_file;
mod placed;
mod relief;
mod source;
mod specular;
mod surface;
mod textures;

use std::sync::OnceLock;

pub use crate::bvh::{Bounds, Placement};
pub use crate::motion::Motion;
pub use description::{RawRender, RenderEntry, TableDescription, describe_tables, nearest_name};
pub use dropped::Dropped;
pub use emitters::EmissiveTriangle;
pub use environment_file::read_environment;
pub use error::{Place, SceneError};
pub use fingerprint::Fingerprint;
pub use guess::{Guess, guess_camera, guess_environment};
pub use instance::Instance;
pub use load::{Loaded, load};
pub use mesh::Mesh;
pub use picture_file::linear_rgb;

use crate::environment::Environment;
use crate::light::delta::DeltaLight;
use crate::light::tree::LightTree;
use crate::material::Material;
use instance::InstanceTree;
use mesh::IndexedMesh;
use placed::Placed;

/// A scene ready for rays.
#[derive(Debug)]
pub struct Scene {
    /// Materials, indexed by the meshes.
    pub materials: Vec<Material>,
    /// Every triangle that emits, in scene space.
    pub emitters: Vec<EmissiveTriangle>,
    /// Lights that no ray can hit.
    pub delta_lights: Vec<DeltaLight>,
    /// The sky, if there is one.
    pub environment: Option<Environment>,
    meshes: Vec<IndexedMesh>,
    placed: Vec<Placed>,
    /// Tree over `placed`, when there is more than one.
    tree: Option<InstanceTree>,
    bounds: Bounds,
    dropped: Dropped,
    /// Made when light is first looked for.
    pub(crate) light_tree: OnceLock<LightTree>,
}

impl Scene {
    /// Builds a scene. Meshes that stand in it once are merged into one in scene space; those that stand in it several
    /// times are kept once, under a tree of instances. Triangles that are degenerate or not finite are dropped and
    /// counted ([`dropped`](Self::dropped)). Delta lights are added afterwards.
    ///
    /// # Errors
    /// When an index is out of range or nothing is left to see.
    pub fn new(
        meshes: Vec<Mesh>,
        instances: Vec<Instance>,
        materials: Vec<Material>,
        environment: Option<Environment>,
    ) -> Result<Self, SceneError> {
        instance::check(&meshes, &instances, materials.len())?;
        let mut dropped = Dropped::default();
        let (meshes, stands) = instance::merge_single(meshes, &instances);
        let meshes: Vec<_> =
            meshes.into_iter().map(|mesh| IndexedMesh::build(mesh, &materials, &mut dropped)).collect();
        let (placed, emitters) = instance::place(&meshes, &stands, &materials, &mut dropped);
        let bounds = placed.iter().map(|p| p.bounds).reduce(Bounds::union);
        let bounds = bounds.ok_or(SceneError::Empty { dropped })?;
        let tree = InstanceTree::build(&placed);
        Ok(Self {
            materials,
            emitters,
            delta_lights: vec![],
            environment,
            meshes,
            placed,
            tree,
            bounds,
            dropped,
            light_tree: OnceLock::new(),
        })
    }

    /// The box round everything.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// How many triangles there are, counting those of every instance.
    pub fn triangles(&self) -> usize {
        self.placed.iter().map(|p| self.meshes[p.mesh].mesh.triangles.len()).sum()
    }

    /// How many triangles are stored: those of instances once.
    pub fn stored_triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.mesh.triangles.len()).sum()
    }

    /// Triangles that were dropped because no ray could hit them.
    pub fn dropped(&self) -> Dropped {
        self.dropped
    }
}

#[cfg(test)]
mod tests;
