//! `EXT_mesh_gpu_instancing`: a node's mesh at several places.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use gltf::Node;
use serde::Deserialize;

use super::buffers::Buffers;
use super::numbers::vectors;

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
pub(super) fn places_of(
    node: &Node,
    document: &gltf::Document,
    buffers: &Buffers,
) -> Result<Option<Vec<DAffine3>>, String> {
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
