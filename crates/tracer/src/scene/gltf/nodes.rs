//! What stands where in a glTF file.

use std::path::Path;

use glam::{DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::{Kind, Light};
use gltf::{Camera, Node};
use serde::Deserialize;

use super::super::notes::Notes;
use super::super::{Instance, Placement};
use super::buffers::Buffers;
use super::numbers::vectors;
use crate::camera::CameraDescription;
use crate::light::DeltaLight;

/// Diameter of the disc of a directional light, in radians: that of the sun.
const SUN: f32 = 0.53 * std::f32::consts::PI / 180.0;

/// What has been put in its place so far.
pub(super) struct Stage {
    pub(super) instances: Vec<Instance>,
    pub(super) cameras: Vec<(Option<String>, CameraDescription)>,
    pub(super) delta_lights: Vec<DeltaLight>,
    /// Whether a mesh has anything to see.
    visible: Vec<bool>,
}

impl Stage {
    /// An empty one for meshes of which some are `visible`.
    pub(super) fn new(visible: Vec<bool>) -> Self {
        Self { instances: Vec::new(), cameras: Vec::new(), delta_lights: Vec::new(), visible }
    }

    /// Puts the scene of `document` that is to be shown, else its first, in its place.
    ///
    /// # Errors
    /// In words, when there is none, or a node stands below several others or itself.
    pub(super) fn set(
        &mut self,
        document: &gltf::Document,
        buffers: &Buffers,
        path: &Path,
        notes: &mut Notes,
    ) -> Result<(), String> {
        let scene = document.default_scene().or_else(|| document.scenes().next()).ok_or("has no scene")?;
        let mut seen = vec![false; document.nodes().len()];
        let mut left: Vec<(Node, DAffine3)> = scene.nodes().map(|node| (node, DAffine3::IDENTITY)).collect();
        // In the file's order.
        left.reverse();
        while let Some((node, above)) = left.pop() {
            if std::mem::replace(&mut seen[node.index()], true) {
                return Err(format!("nodes[{}] stands in the scene twice, expected a tree", node.index()));
            }
            let matrix = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
            let map = above * DAffine3::from_mat4(matrix);
            let several = places_of(&node, document, buffers)
                .map_err(|reason| format!("nodes[{}]: EXT_mesh_gpu_instancing: {reason}", node.index()))?;
            self.place_mesh(&node, map, several.as_deref(), path, notes);
            self.place_others(&node, map, path, notes);
            let children: Vec<Node> = node.children().collect();
            left.extend(children.into_iter().rev().map(|child| (child, map)));
        }
        Ok(())
    }

    /// The mesh of a node, at all places that it is put in there.
    fn place_mesh(&mut self, node: &Node, map: DAffine3, several: Option<&[DAffine3]>, path: &Path, notes: &mut Notes) {
        let Some(mesh) = node.mesh().filter(|mesh| self.visible[mesh.index()]) else { return };
        for within in several.unwrap_or(&[DAffine3::IDENTITY]) {
            match Placement::new(map * *within) {
                Some(placement) => self.instances.push(Instance { mesh: mesh.index(), placement, motion: None }),
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
                }
                None => notes.add(format!("{}: a camera that has no perspective is left out", what())),
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

/// `EXT_mesh_gpu_instancing` of a node.
#[derive(Deserialize)]
struct WrittenPlaces {
    attributes: WrittenAttributes,
}

/// Numbers of accessors; others than these say nothing about where meshes are.
#[derive(Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct WrittenAttributes {
    translation: Option<usize>,
    rotation: Option<usize>,
    scale: Option<usize>,
}

/// Where within a node its mesh stands, when that is several times.
///
/// # Errors
/// In words, when numbers are not there.
fn places_of(node: &Node, document: &gltf::Document, buffers: &Buffers) -> Result<Option<Vec<DAffine3>>, String> {
    let Some(written) = node.extension_value("EXT_mesh_gpu_instancing") else { return Ok(None) };
    let WrittenPlaces { attributes } = WrittenPlaces::deserialize(written).map_err(|why| why.to_string())?;
    let accessor = |number: usize| {
        let there = document.accessors().nth(number);
        there.ok_or_else(|| format!("accessors[{number}] is not there"))
    };
    let three = |number: Option<usize>| number.map(|number| vectors::<3>(&accessor(number)?, buffers)).transpose();
    let translations = three(attributes.translation)?;
    let scales = three(attributes.scale)?;
    let rotations = attributes.rotation.map(|number| vectors::<4>(&accessor(number)?, buffers)).transpose()?;
    let counts = [translations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len)];
    let mut counts = counts.into_iter().flatten();
    let Some(count) = counts.next() else { return Ok(None) };
    if counts.any(|other| other != count) {
        return Err("its accessors do not hold equally many elements".into());
    }
    let place = |i: usize| {
        let translation = translations.as_ref().map_or(DVec3::ZERO, |all| Vec3::from(all[i]).as_dvec3());
        let scale = scales.as_ref().map_or(DVec3::ONE, |all| Vec3::from(all[i]).as_dvec3());
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |all| DQuat::from_array(all[i].map(f64::from)));
        DAffine3::from_scale_rotation_translation(scale, unit(rotation), translation)
    };
    Ok(Some((0..count).map(place).collect()))
}

/// Of length 1; no turn where there is none to be told.
fn unit(rotation: DQuat) -> DQuat {
    let length = rotation.length();
    if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY }
}

/// The direction and the place to which `map` moves -z and the origin.
fn ahead(map: DAffine3) -> (Vec3, Vec3) {
    (map.transform_vector3(DVec3::NEG_Z).normalize_or_zero().as_vec3(), map.translation.as_vec3())
}

fn description(camera: &Camera, map: DAffine3) -> Option<CameraDescription> {
    let Projection::Perspective(perspective) = camera.projection() else { return None };
    let (forward, eye) = ahead(map);
    let up = map.transform_vector3(DVec3::Y).as_vec3();
    let fov = perspective.yfov().to_degrees();
    Some(CameraDescription { up, fov, ..CameraDescription::looking(eye, eye + forward) })
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
