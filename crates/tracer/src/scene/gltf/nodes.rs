//! What stands where in a glTF file.

use std::path::Path;

use glam::{DAffine3, DMat4, DVec3, Vec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::{Kind, Light};
use gltf::{Camera, Node};

use super::super::notes::Notes;
use super::super::{Instance, Mesh, Placement};
use super::buffers::Buffers;
use super::instancing::places_of;
use super::materials::Needs;
use super::poses::Poses;
use crate::camera::CameraDescription;
use crate::light::DeltaLight;

/// Diameter of the disc of a directional light, in radians: that of the sun.
const SUN: f32 = 0.53 * std::f32::consts::PI / 180.0;

/// How far behind its place a camera without perspective stands, in halves of the height that it sees: what is as far behind the
/// middle as the picture is high then is 0.4 % smaller.
const FAR_AWAY: f32 = 500.0;

/// What has been put in its place so far.
pub(super) struct Stage {
    /// Those of the file, and those that stand in a pose of their own.
    pub(super) meshes: Vec<Mesh>,
    pub(super) instances: Vec<Instance>,
    pub(super) cameras: Vec<(Option<String>, CameraDescription)>,
    pub(super) delta_lights: Vec<DeltaLight>,
}

impl Stage {
    /// An empty one for the meshes of a file.
    pub(super) fn new(meshes: Vec<Mesh>) -> Self {
        Self { meshes, instances: Vec::new(), cameras: Vec::new(), delta_lights: Vec::new() }
    }

    /// Puts the scene of `document` that is to be shown, else its first, in its place.
    ///
    /// # Errors
    /// In words, when there is none, or a node stands below several others or itself.
    pub(super) fn set(
        &mut self,
        document: &gltf::Document,
        buffers: &Buffers,
        needs: &[Needs],
        path: &Path,
        notes: &mut Notes,
    ) -> Result<(), String> {
        let scene = document.default_scene().or_else(|| document.scenes().next()).ok_or("has no scene")?;
        let nodes = standing(&scene, document.nodes().len())?;
        let poses = Poses::new(document, buffers, needs, &nodes);
        for (node, map) in &nodes {
            let at = |reason: String| format!("nodes[{}]: {reason}", node.index());
            if let Some(mesh) = node.mesh() {
                let several = places_of(node, document, buffers)
                    .map_err(|reason| at(format!("EXT_mesh_gpu_instancing: {reason}")))?;
                let several = several.unwrap_or(vec![DAffine3::IDENTITY]);
                let (mesh, places) = match poses.of(node, &mesh).map_err(at)? {
                    None => (mesh.index(), several.iter().map(|within| *map * *within).collect()),
                    Some(posed) => {
                        self.meshes.push(posed.mesh);
                        // A skin stands where its joints are, wherever its node is.
                        let places = match posed.is_skinned {
                            true => vec![DAffine3::IDENTITY],
                            false => several.iter().map(|within| *map * *within).collect(),
                        };
                        (self.meshes.len() - 1, places)
                    }
                };
                self.place_mesh(node, mesh, places, path, notes);
            }
            self.place_others(node, *map, path, notes);
        }
        Ok(())
    }
    /// A node's mesh, which is number `mesh`, at all places that it is put in.
    fn place_mesh(&mut self, node: &Node, mesh: usize, places: Vec<DAffine3>, path: &Path, notes: &mut Notes) {
        if self.meshes[mesh].triangles.is_empty() {
            return;
        }
        for place in places {
            match Placement::new(place) {
                Some(placement) => self.instances.push(Instance { mesh, placement, motion: None }),
                None => {
                    let (path, node) = (path.display(), node.index());
                    notes.add(format!("{path}: nodes[{node}]: a mesh without extent left out"));
                }
            }
        }
    }

    fn place_others(&mut self, node: &Node, map: DAffine3, path: &Path, notes: &mut Notes) {
        let what = || format!("{}: nodes[{}]", path.display(), node.index());
        if let Some(camera) = node.camera() {
            match description(&camera, map).filter(|description| description.check().is_ok()) {
                Some(description) => {
                    let name = camera.name().or(node.name()).map(str::to_owned);
                    self.cameras.push((name, description));
                    if matches!(camera.projection(), Projection::Orthographic(_)) {
                        notes.add(format!(
                            "{}: a camera without perspective is one from far away; what is behind it may come into view",
                            what()
                        ));
                    }
                }
                None => notes.add(format!("{}: a camera that sees nothing is left out", what())),
            }
        }
        if let Some(light) = node.light() {
            match delta_light(&light, map) {
                Some(light) => self.delta_lights.push(light),
                None => notes.add(format!("{}: a light that shines nowhere is left out", what())),
            }
        }
    }
}

/// All nodes of `scene`, of `count` in the file and in its order, with the maps from their space to the scene's.
///
/// # Errors
/// In words, when a node stands below several others or itself.
fn standing<'a>(scene: &gltf::Scene<'a>, count: usize) -> Result<Vec<(Node<'a>, DAffine3)>, String> {
    let mut seen = vec![false; count];
    let mut left: Vec<(Node, DAffine3)> = scene.nodes().map(|node| (node, DAffine3::IDENTITY)).collect();
    left.reverse();
    let mut all = Vec::new();
    while let Some((node, above)) = left.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(format!("nodes[{}] stands in the scene twice, expected a tree", node.index()));
        }
        let matrix = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
        let map = above * DAffine3::from_mat4(matrix);
        let children: Vec<Node> = node.children().collect();
        left.extend(children.into_iter().rev().map(|child| (child, map)));
        all.push((node, map));
    }
    Ok(all)
}

/// The direction and the place to which `map` moves -z and the origin.
fn ahead(map: DAffine3) -> (Vec3, Vec3) {
    (map.transform_vector3(DVec3::NEG_Z).normalize_or_zero().as_vec3(), map.translation.as_vec3())
}

fn description(camera: &Camera, map: DAffine3) -> Option<CameraDescription> {
    let (forward, eye) = ahead(map);
    let up = map.transform_vector3(DVec3::Y).as_vec3();
    match camera.projection() {
        Projection::Perspective(perspective) => {
            let fov = perspective.yfov().to_degrees();
            Some(CameraDescription { up, fov, ..CameraDescription::looking(eye, eye + forward) })
        }
        Projection::Orthographic(orthographic) => {
            // Scaled with its node, as what it sees is.
            let half_height = orthographic.ymag().abs() * map.transform_vector3(DVec3::Y).length() as f32;
            let fov = 2.0 * FAR_AWAY.recip().atan().to_degrees();
            let from = eye - FAR_AWAY * half_height * forward;
            (half_height > 0.0).then(|| CameraDescription { up, fov, ..CameraDescription::looking(from, eye) })
        }
    }
}

/// A light that is finite and brighter than nothing.
fn delta_light(light: &Light, map: DAffine3) -> Option<DeltaLight> {
    let (axis, position) = ahead(map);
    let intensity = light.intensity() * Vec3::from(light.color());
    let sound = intensity.is_finite() && intensity.max_element() > 0.0 && intensity.min_element() >= 0.0;
    if !(sound && position.is_finite()) {
        return None;
    }
    match light.kind() {
        Kind::Point => Some(DeltaLight::Point { position, intensity }),
        _ if axis == Vec3::ZERO => None,
        Kind::Directional => Some(DeltaLight::Sun { direction: axis, irradiance: intensity, angle: SUN }),
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let [inner, rim] = [inner_cone_angle, outer_cone_angle].map(f32::to_degrees);
            (rim > 0.0 && rim <= 90.0)
                .then(|| DeltaLight::spot(position, axis, intensity, [rim, (rim - inner).clamp(0.0, rim)]))
        }
    }
}
