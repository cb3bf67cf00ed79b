//! What files say, against what the scene is.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DMat3, DVec3, Mat2, Vec2, Vec3, Vec4};
use tempfile::TempDir;

use super::super::{Loaded, load};
use crate::Ray;
use crate::bsdf::Bsdf;
use crate::interaction::Interaction;
use crate::light::{DeltaLight, Lights};
use crate::material::{Colour, Material, SeeThrough, Surface};
use crate::texture::Wrap;

/// A unit square at z = 0: positions, texture coordinates in unsigned bytes, corners.
const POSITIONS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
const UVS: [u8; 16] = [0, 255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0];
const CORNERS: [u8; 6] = [0, 1, 2, 0, 2, 3];

fn bytes() -> Vec<u8> {
    let positions = POSITIONS.iter().flat_map(|v| v.to_le_bytes());
    positions.chain(UVS).chain(CORNERS).collect()
}

const VIEWS: &str = r#"[
    { "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 16, "byteStride": 4 },
    { "buffer": 0, "byteOffset": 64, "byteLength": 6 }]"#;
const ACCESSORS: &str = r#"[
    { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
    { "bufferView": 1, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC2" },
    { "bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR" }]"#;
const SQUARE: &str = r#"{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0 }"#;

/// The JSON of a file with the square as its only mesh; `more` is the rest.
fn document(more: &str) -> String {
    let data = STANDARD.encode(bytes());
    format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scenes": [{{ "nodes": [0] }}],
        "buffers": [{{ "uri": "data:application/octet-stream;base64,{data}", "byteLength": 70 }}],
        "bufferViews": {VIEWS}, "accessors": {ACCESSORS}, "meshes": [{{ "primitives": [{SQUARE}] }}], {more} }}"#
    )
}

/// Two pixels: red, and black of alpha 0.2.
fn png() -> Vec<u8> {
    let image = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 0, 0, 0, 51]).unwrap();
    let mut png = std::io::Cursor::new(vec![]);
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

fn folder(json: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.gltf"), json).unwrap();
    fs::write(folder.path().join("a b.png"), png()).unwrap();
    folder
}

fn loaded(json: &str) -> Loaded {
    load(&folder(json).path().join("a.gltf")).unwrap()
}

fn refusal(json: &str) -> String {
    let folder = folder(json);
    let refused = load(&folder.path().join("a.gltf")).unwrap_err().to_string();
    refused.replace(&format!("{}/", folder.path().display()), "")
}

/// What a material becomes; `textures` may point to the image.
fn material(material: &str) -> (Material, Vec<String>) {
    let textures = r#""textures": [{ "source": 0 }], "images": [{ "uri": "a%20b.png" }]"#;
    let loaded = loaded(&document(&format!(r#""nodes": [{{ "mesh": 0 }}], {textures}, "materials": [{material}]"#)));
    (loaded.scene.materials[0].clone(), loaded.notes)
}

fn ray(x: f32, y: f32, z: f32) -> Ray {
    Ray { origin: Vec3::new(x, y, z), direction: -Vec3::Z, t_max: f32::INFINITY, time: 0.0 }
}

const PLAIN: &str = r#""nodes": [{ "mesh": 0 }], "materials": [{}]"#;

#[test]
fn numbers_are_read_however_they_are_stored() {
    let scene = loaded(&document(PLAIN)).scene;
    let mesh = &scene.meshes[0].mesh;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y]);
    assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], "upwards, as elsewhere");
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    // The first corner is moved by a sparse accessor.
    let moved = r#""count": 4, "type": "VEC3", "sparse": { "count": 1,
        "indices": { "bufferView": 2, "byteOffset": 1, "componentType": 5121 },
        "values": { "bufferView": 0, "byteOffset": 24 } } }"#;
    let sparse = document(PLAIN).replacen(r#""count": 4, "type": "VEC3" }"#, moved, 1);
    assert_eq!(loaded(&sparse).scene.meshes[0].mesh.positions[1], Vec3::X + Vec3::Y);
    let zeros = sparse.replacen(r#""bufferView": 0, "componentType""#, r#""componentType""#, 1);
    assert!(load(&folder(&zeros).path().join("a.gltf")).is_err(), "all corners but one are zero: nothing to see");
}

/// The square with colours at its corners, green, yellow, red and black, of opacity 0, as one material shows them.
fn coloured(material: &str) -> Loaded {
    let json = document(&format!(r#""nodes": [{{ "mesh": 0 }}], "materials": [{material}]"#));
    let last = r#""count": 6, "type": "SCALAR" }"#;
    let colours = r#", { "bufferView": 1, "componentType": 5121, "count": 4, "type": "VEC4" }"#;
    let json = json.replacen(last, &format!("{last}{colours}"), 1);
    loaded(&json.replacen(r#""POSITION": 0"#, r#""POSITION": 0, "COLOR_0": 3"#, 1))
}

#[test]
fn colours_of_vertices_multiply_the_base() {
    let dull = r#"{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_ior": { "ior": 1 } } MORE }"#;
    let scene = coloured(&dull.replace("MORE", "")).scene;
    let opaque = [Vec4::new(0.0, 1.0, 0.0, 1.0), Vec4::new(1.0, 1.0, 0.0, 1.0), Vec4::X + Vec4::W, Vec4::W];
    assert_eq!(scene.meshes[0].mesh.colours, opaque, "bytes are shares, and what is opaque stays so");
    let hit = scene.intersect(&ray(0.75, 0.25, 1.0)).unwrap();
    assert!((hit.tint - Vec3::new(0.75, 0.75, 0.0)).length() < 1e-6);
    assert!((Bsdf::at(&hit).albedo() - Vec3::new(0.375, 0.75, 0.0)).length() < 1e-6);
    // No ray meets what has no opacity, or less than its mask asks for.
    let veil = coloured(&dull.replace("MORE", r#", "alphaMode": "BLEND""#)).scene;
    assert!(veil.intersect(&ray(0.75, 0.25, 1.0)).is_none());
    let mask = coloured(&dull.replace("MORE", r#", "alphaMode": "MASK""#)).scene;
    assert!(mask.intersect(&ray(0.75, 0.25, 1.0)).is_none());
    let low = coloured(&dull.replace("MORE", r#", "alphaMode": "MASK", "alphaCutoff": 0"#)).scene;
    assert!(low.intersect(&ray(0.75, 0.25, 1.0)).is_some());
    // Where there is no material, the colour is all there is; and floats are read as they stand.
    let json = document(r#""nodes": [{ "mesh": 0 }]"#).replace(r#", "material": 0"#, "");
    let bare = loaded(&json.replacen(r#""POSITION": 0"#, r#""POSITION": 0, "COLOR_0": 0"#, 1)).scene;
    let hit = bare.intersect(&ray(0.75, 0.25, 1.0)).unwrap();
    assert!((Bsdf::at(&hit).albedo() - Vec3::new(0.75, 0.25, 0.0)).length() < 1e-6);
    let few = document(PLAIN).replacen(r#""POSITION": 0"#, r#""POSITION": 0, "COLOR_0": 2"#, 1);
    assert!(refusal(&few).contains("accessors[2] has 1 numbers for each element, expected 4"));
}

#[test]
fn colours_of_vertices_multiply_what_is_drawn_without_light() {
    let scene = coloured(
        r#"{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 1, 1] },
        "extensions": { "KHR_materials_unlit": {} } }"#,
    )
    .scene;
    let lights = Lights::new(&scene);
    let seen = scene.intersect(&ray(0.75, 0.25, 1.0)).unwrap();
    assert!((lights.emitted(seen.emitter.unwrap(), &seen) - Vec3::new(0.375, 0.75, 0.0)).length() < 1e-6);
    // Two triangles, of the mean colours of their corners.
    let radiances: Vec<Vec3> = scene.emitters.iter().map(|emitter| emitter.radiance * 3.0).collect();
    assert!(
        (radiances[0] - Vec3::new(1.0, 2.0, 0.0)).length() + (radiances[1] - Vec3::new(0.5, 1.0, 0.0)).length() < 1e-6
    );
    // What is sampled is what is seen there.
    let floor = Material::new("floor", Surface::Mirror { reflectance: Colour::constant(Vec3::ONE) }, Vec3::ZERO);
    let from = Interaction {
        position: Vec3::new(0.2, 0.4, 2.0),
        geometric_normal: -Vec3::Z,
        shading_normal: -Vec3::Z,
        outgoing: -Vec3::Z,
        material: &floor,
        ..seen
    };
    for i in 0..16 {
        let u = (Vec2::new((i % 4) as f32, (i / 4) as f32) + 0.5) / 4.0;
        let sample = lights.sample_light(&from, Bsdf::at(&from).receiver(), i << 28, u).unwrap();
        let there = scene.intersect(&Ray { t_max: f32::INFINITY, ..sample.shadow_ray }).unwrap();
        assert!((lights.emitted(there.emitter.unwrap(), &there) - sample.radiance).length() < 1e-4, "{i}");
    }
}

#[test]
fn binary_files_hold_the_same() {
    let json = document(PLAIN);
    let json =
        json.replace(&format!(r#""uri": "data:application/octet-stream;base64,{}", "#, STANDARD.encode(bytes())), "");
    let chunk = |kind: &[u8], content: &[u8]| {
        let padded = content.len().next_multiple_of(4);
        let mut chunk = [&(padded as u32).to_le_bytes(), kind, content].concat();
        chunk.resize(8 + padded, b' ');
        chunk
    };
    let chunks = [chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", &bytes())].concat();
    let header = [b"glTF".as_slice(), &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes()].concat();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.glb");
    fs::write(&path, [header, chunks].concat()).unwrap();
    let mesh = load(&path).unwrap().scene.meshes[0].mesh.clone();
    assert_eq!(format!("{mesh:?}"), format!("{:?}", loaded(&document(PLAIN)).scene.meshes[0].mesh));
    fs::write(&path, json).unwrap();
    assert!(load(&path).unwrap_err().to_string().ends_with("buffers[0] has neither a uri nor a binary part"));
}

#[test]
fn everything_stands_where_its_node_puts_it() {
    let nodes = r#""scene": 0, "nodes": [
        { "children": [1, 2, 3], "translation": [10, 0, 0], "scale": [2, 2, 2] },
        { "mesh": 0 },
        { "mesh": 0, "rotation": [0, 0, 0.70710678, 0.70710678], "translation": [0, 0, 1] },
        { "camera": 0, "name": "node", "translation": [0, 0, 5], "rotation": [0, 0.70710678, 0, 0.70710678] }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }], "materials": [{}]"#;
    let loaded = loaded(&document(nodes));
    assert_eq!((loaded.scene.triangles(), loaded.scene.stored_triangles()), (4, 2));
    assert_eq!(loaded.scene.intersect(&ray(11.5, 0.5, 9.0)).unwrap().distance, 9.0);
    // Turned by 90° round z, it stands at x from -1 to 0.
    assert!((loaded.scene.intersect(&ray(8.5, 0.5, 9.0)).unwrap().distance - 7.0).abs() < 1e-5);
    let (name, camera) = &loaded.cameras[0];
    assert_eq!((name.as_deref(), camera.eye), (Some("node"), Vec3::new(10.0, 0.0, 10.0)));
    assert!((camera.look_at - camera.eye + Vec3::X).length() < 1e-6 && (camera.fov - 28.6479).abs() < 1e-3);
}

#[test]
fn a_camera_without_perspective_sees_all_distances_alike() {
    let nodes = r#""nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0.5, 0.5, 3], "scale": [2, 2, 2] },
        { "camera": 1, "translation": [0, 0, 5] }], "materials": [{}],
        "cameras": [{ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 0.5, "znear": 0, "zfar": 9 } },
        { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 0, "znear": 0, "zfar": 9 } }]"#;
    let json = document(nodes).replacen(r#""scenes": [{ "nodes": [0] }]"#, r#""scenes": [{ "nodes": [0, 1, 2] }]"#, 1);
    let loaded = loaded(&json);
    let camera = loaded.cameras[0].1.on(stack::Size::new(100, 100)).unwrap();
    // 2 high and wide round (0.5, 0.5), near and far.
    for (film, at) in [([50.0, 50.0], [0.5, 0.5]), ([0.0, 50.0], [-0.5, 0.5]), ([50.0, 100.0], [0.5, -0.5])] {
        let ray = camera.ray(film.into(), Vec2::ZERO, 0.0);
        for z in [-1.0, 0.0, 2.0] {
            let seen = ray.at((z - ray.origin.z) / ray.direction.z);
            assert!((seen.truncate() - Vec2::from(at)).length() < 0.01, "{film:?}: {seen}");
        }
    }
    assert!(loaded.cameras.len() == 1 && loaded.notes.len() == 2, "{:?}", loaded.notes);
    assert!(loaded.notes[0].contains("one from far away") && loaded.notes[1].contains("sees nothing"));
}

#[test]
fn lights_shine_along_their_nodes() {
    let lights = r#""extensionsUsed": ["KHR_lights_punctual"], "extensions": { "KHR_lights_punctual": { "lights": [
        { "type": "point", "intensity": 2, "color": [1, 0.5, 0] },
        { "type": "spot", "spot": { "innerConeAngle": 0, "outerConeAngle": 0.5 } },
        { "type": "directional", "intensity": 0 }, { "type": "directional", "intensity": 3 }] } },
        "materials": [{}], "nodes": [{ "mesh": 0, "children": [1, 2, 3, 4] },
        { "translation": [1, 2, 3], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "rotation": [-0.70710678, 0, 0, 0.70710678], "extensions": { "KHR_lights_punctual": { "light": 1 } } },
        { "extensions": { "KHR_lights_punctual": { "light": 2 } } },
        { "extensions": { "KHR_lights_punctual": { "light": 3 } } }]"#;
    let loaded = loaded(&document(lights));
    let [point, spot, sun] = loaded.scene.delta_lights[..] else { panic!("{:?}", loaded.scene.delta_lights) };
    assert_eq!(point, DeltaLight::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity: Vec3::new(2.0, 1.0, 0.0) });
    let DeltaLight::Spot { axis, rim, .. } = spot else { panic!("{spot:?}") };
    assert!((axis + Vec3::Y).length() < 1e-6 && (rim - (1.0 - 0.5_f32.cos())).abs() < 1e-6);
    let DeltaLight::Sun { direction, irradiance, .. } = sun else { panic!("{sun:?}") };
    assert_eq!((direction, irradiance), (-Vec3::Z, Vec3::splat(3.0)));
    assert!(loaded.notes[0].contains("nodes[3]: a light that shines nowhere"));
}

fn is(colour: &Colour, expected: [f32; 3]) -> bool {
    (colour.factor - Vec3::from(expected)).length() < 1e-6
}

#[test]
fn materials_are_made_of_what_there_is_a_surface_for() {
    let surface = |text: &str| material(text).0.surface;
    let metal = surface(r#"{ "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0, 1], "roughnessFactor": 0.5 } }"#);
    assert!(matches!(&metal, Surface::Conductor { reflectance, alpha: 0.25 } if is(reflectance, [1.0, 0.5, 0.0])));
    let plastic = r#"{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 } EXT }"#;
    let with = |extensions: &str| plastic.replace("EXT", &format!(", \"extensions\": {{ {extensions} }}"));
    let Surface::Coated { specular, alpha: 1.0, .. } = surface(&plastic.replace("EXT", "")) else { panic!() };
    assert!(is(&specular, [0.04; 3]));
    let shiny = with(r#""KHR_materials_ior": { "ior": 2 }, "KHR_materials_specular": { "specularFactor": 0.5 }"#);
    let Surface::Coated { specular, .. } = surface(&shiny) else { panic!() };
    assert!(is(&specular, [1.0 / 18.0; 3]), "half of 1/9");
    for bare in [r#""KHR_materials_ior": { "ior": 1 }"#, r#""KHR_materials_specular": { "specularFactor": 0 }"#] {
        assert!(matches!(surface(&with(bare)), Surface::Diffuse { .. }), "{bare}");
    }
    let pane = r#""KHR_materials_transmission": { "transmissionFactor": 1 }"#;
    assert!(matches!(surface(&with(pane)), Surface::ThinGlass { ior: 1.5, alpha: 1.0, .. }));
    let ball = format!(
        r#"{pane}, "KHR_materials_volume": {{ "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.25, 0] }}"#
    );
    assert!(matches!(surface(&with(&ball)), Surface::Glass { ior: 1.5, alpha: 1.0, .. }));
    let (ball, notes) = material(&with(&ball));
    let after_two = (-2.0 * ball.maps.absorption).exp();
    assert!((after_two - Vec3::new(1.0, 0.25, 0.0)).abs().max_element() < 1e-5 && notes.is_empty(), "{after_two}");
    let veiled = with(r#""KHR_materials_transmission": { "transmissionFactor": 0.3 }"#);
    let (veiled, notes) = material(&veiled);
    let SeeThrough { share, glass } = &**veiled.maps.see_through.as_ref().unwrap();
    assert!(matches!(veiled.surface, Surface::Coated { .. }) && matches!(glass.surface, Surface::ThinGlass { .. }));
    assert!(share.factor == 0.3 && share.texture.is_none() && notes.is_empty(), "{notes:?}");
    let mapped = r#""KHR_materials_transmission": { "transmissionFactor": 0.5, "transmissionTexture": { "index": 0 } },
        "KHR_materials_specular": { "specularTexture": { "index": 0 } }"#;
    let maps = material(&with(mapped)).0.maps;
    let ends = [0.25, 0.75].map(|x| Vec2::new(x, 0.5));
    assert_eq!(ends.map(|uv| maps.see_through.as_ref().unwrap().share.at(uv)), [0.5, 0.0], "red");
    assert_eq!(ends.map(|uv| maps.specular.as_ref().unwrap().lookup(uv)), [1.0, 0.2], "alpha");
    let metal = format!(r#"{{ "extensions": {{ {pane} }} }}"#);
    assert!(matches!(surface(&metal), Surface::Conductor { .. }), "light does not pass through metal");
    let painted = with(r#""KHR_materials_specular": { "specularColorTexture": { "index": 0 } }"#);
    let Surface::Coated { specular, .. } = surface(&painted) else { panic!() };
    assert_eq!(specular.at(Vec2::new(0.25, 0.5)), Vec3::new(0.04, 0.0, 0.0));
    let lamp = r#""KHR_materials_emissive_strength": { "emissiveStrength": 5 }"#;
    let lamp = with(lamp).replacen('{', r#"{ "emissiveFactor": [1, 0.5, 0],"#, 1);
    assert_eq!(material(&lamp).0.emission.factor, Vec3::new(5.0, 2.5, 0.0));
    let drawn = material(&with(r#""KHR_materials_unlit": {}"#)).0;
    assert!(is(&drawn.emission, [0.5; 3]));
    assert!(matches!(&drawn.surface, Surface::Diffuse { reflectance } if is(reflectance, [0.0; 3])));
}

#[test]
fn clear_coats_lie_over_materials() {
    let coated = |coat: &str| {
        material(&format!(
            r#"{{ "extensions": {{ "KHR_materials_clearcoat": {coat} }}, "normalTexture": {{ "index": 0 }} }}"#
        ))
    };
    let coat = |text: &str| coated(text).0.maps.clear_coat;
    let plain = coat(r#"{ "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25 }"#).unwrap();
    assert_eq!((plain.cover.factor, plain.roughness.factor), (0.5, 0.25));
    assert!(plain.normals.is_none(), "relief of the base is not the coat's");
    assert!(coat("{}").is_none() && coat(r#"{ "clearcoatRoughnessFactor": 1 }"#).is_none());
    let index = r#"{ "index": 0 }"#;
    let mapped = coat(&format!(
        r#"{{ "clearcoatFactor": 1, "clearcoatTexture": {index}, "clearcoatRoughnessFactor": 1, "clearcoatRoughnessTexture": {index},
        "clearcoatNormalTexture": {{ "index": 0, "extensions": {{ "KHR_texture_transform": {{ "scale": [2, 1] }} }} }} }}"#
    ))
    .unwrap();
    let left = Vec2::new(0.25, 0.5);
    assert_eq!((mapped.cover.at(left), mapped.roughness.at(left)), (1.0, 0.0), "red of cover, green of roughness");
    assert_eq!(mapped.normals.unwrap().map, Mat2::from_diagonal(Vec2::new(2.0, 1.0)));
    let (gone, notes) = coated(r#"{ "clearcoatFactor": 1, "clearcoatTexture": { "index": 7 } }"#);
    assert!(
        gone.maps.clear_coat.is_some() && notes[0].contains("textures[7] is not there; it is left out"),
        "{notes:?}"
    );
    let (bare, notes) = coated(r#"{ "clearcoatFactor": "much" }"#);
    assert!(bare.maps.clear_coat.is_none() && notes[0].contains("KHR_materials_clearcoat: invalid type"), "{notes:?}");
    let glass = r#"{ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 }, "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_clearcoat": { "clearcoatFactor": 1 } } }"#;
    let (glass, notes) = material(glass);
    assert!(
        glass.maps.clear_coat.is_none() && notes[0].contains("a clear coat over glass is not supported"),
        "{notes:?}"
    );
}

#[test]
fn older_files_say_gloss_in_place_of_roughness() {
    let glossy = |gloss: &str| {
        material(&format!(
            r#"{{ "alphaMode": "BLEND", "extensions": {{ "KHR_materials_pbrSpecularGlossiness": {gloss} }} }}"#
        ))
    };
    let (plain, notes) = glossy(
        r#"{ "diffuseFactor": [0.5, 0.25, 0, 0.75], "specularFactor": [0.1, 0.2, 0.3], "glossinessFactor": 0.5 }"#,
    );
    assert!(notes.is_empty() && plain.maps.opacity.unwrap().factor == 0.75, "{notes:?}");
    let Surface::Coated { diffuse, specular, alpha: 0.25 } = &plain.surface else { panic!("{:?}", plain.surface) };
    assert!(is(diffuse, [0.5, 0.25, 0.0]) && is(specular, [0.1, 0.2, 0.3]));
    let mapped = glossy(
        r#"{ "diffuseTexture": { "index": 0 }, "specularGlossinessTexture": { "index": 0 }, "glossinessFactor": 0.5 }"#,
    );
    let mapped = mapped.0;
    let Surface::Coated { diffuse, specular, alpha: 1.0 } = &mapped.surface else { panic!("{:?}", mapped.surface) };
    let [left, right] = [0.25, 0.75].map(|x| Vec2::new(x, 0.5));
    assert_eq!([diffuse.at(left), specular.at(right)], [Vec3::X, Vec3::ZERO]);
    let roughness = mapped.maps.roughness.unwrap();
    assert!((roughness.lookup(left) - 0.5).abs() < 1e-6 && (roughness.lookup(right) - 0.9).abs() < 1e-6);
    assert!((mapped.maps.opacity.unwrap().at(right) - 0.2).abs() < 1e-6);
}

#[test]
fn materials_for_what_has_none_are_there_where_they_are_needed() {
    let count = |json: &str| loaded(json).scene.materials.len();
    assert_eq!(count(&document(PLAIN)), 1);
    let bare = document(PLAIN).replace(r#", "material": 0"#, "");
    assert_eq!(count(&bare), 2);
}

#[test]
fn what_is_not_supported_is_said_once_for_all_materials() {
    let red = r#"{ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_clearcoat": { "clearcoatFactor": 1 } } }"#;
    let named = |names: &[&str]| {
        names.iter().map(|n| red.replacen('{', &format!(r#"{{ "name": "{n}","#), 1)).collect::<Vec<_>>().join(", ")
    };
    let notes = |names: &[&str]| {
        loaded(&document(&format!(r#""nodes": [{{ "mesh": 0 }}], "materials": [{}]"#, named(names)))).notes
    };
    assert_eq!(notes(&["a", "b"]), ["material 'a' and 1 other: a clear coat over glass is not supported and ignored"]);
    assert!(notes(&["a", "b", "c"])[0].starts_with("material 'a' and 2 others: "));
    let sheen = document(PLAIN).replacen("\"asset\"", "\"extensionsUsed\": [\"KHR_materials_sheen\"], \"asset\"", 1);
    assert!(loaded(&sheen).notes[0].ends_with("the extension KHR_materials_sheen is not supported and ignored"));
    let variants =
        r#""POSITION": 0, "TEXCOORD_0": 1 }, "extensions": { "KHR_materials_variants": { "mappings": [] } }"#;
    let variants = document(PLAIN).replacen(r#""POSITION": 0, "TEXCOORD_0": 1 }"#, variants, 1);
    assert!(loaded(&variants).notes[0].ends_with("of the variants of materials, the usual one is shown"));
}

#[test]
fn a_mesh_stands_wherever_its_instances_are() {
    let places = r#""nodes": [{ "mesh": 0, "translation": [10, 0, 0], "extensions": {
        "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0, "SCALE": SCALED, "_ID": 2 } } } }], "materials": [{}]"#;
    let scene = loaded(&document(&places.replace(r#", "SCALE": SCALED"#, ""))).scene;
    assert_eq!((scene.triangles(), scene.stored_triangles()), (8, 2));
    // At (0, 0), (1, 0), (1, 1) and (0, 1): a square of side 2.
    for (x, y) in [(10.1, 0.1), (11.9, 0.1), (11.9, 1.9), (10.1, 1.9)] {
        assert_eq!(scene.intersect(&ray(x, y, 1.0)).unwrap().distance, 1.0);
    }
    assert!(scene.intersect(&ray(9.9, 0.5, 1.0)).is_none());
    let more = document(&places.replace("SCALED", "9"));
    assert!(refusal(&more).ends_with("nodes[0]: EXT_mesh_gpu_instancing: accessors[9] is not there"));
    let mixed = document(&places.replace("SCALED", "3"));
    let last = r#""count": 6, "type": "SCALAR" }"#;
    let three = r#", { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }"#;
    let mixed = mixed.replacen(last, &format!("{last}{three}"), 1);
    assert!(refusal(&mixed).ends_with("its accessors do not hold equally many elements"));
}

#[test]
fn a_skin_hangs_on_its_joints() {
    // The lower edge hangs on the first joint, the upper one on the second.
    let (of_joints, weights) =
        ([0_u8, 1, 0, 0].repeat(4), [[255_u8, 0, 0, 0].repeat(2), [0, 255, 0, 0].repeat(2)].concat());
    let data = STANDARD.encode([of_joints, weights].concat());
    let nodes = r#""nodes": [{ "mesh": 0, "skin": 0, "translation": [100, 0, 0], "children": [1] }, { "children": [2] },
        { "translation": [-100, 0, 1] }], "skins": [{ "joints": [1, 2] }], "materials": [{}]"#;
    let json = document(nodes)
        .replacen("\"byteLength\": 70 }", &format!("\"byteLength\": 70 }}, {{ \"uri\": \"data:;base64,{data}\", \"byteLength\": 32 }}"), 1)
        .replacen(r#""byteLength": 6 }"#, r#""byteLength": 6 }, { "buffer": 1, "byteLength": 16 }, { "buffer": 1, "byteOffset": 16, "byteLength": 16 }"#, 1)
        .replacen(
            r#""count": 6, "type": "SCALAR" }"#,
            r#""count": 6, "type": "SCALAR" }, { "bufferView": 3, "componentType": 5121, "count": 4, "type": "VEC4" },
            { "bufferView": 4, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4" }"#,
            1,
        )
        .replacen(r#""POSITION": 0"#, r#""POSITION": 0, "JOINTS_0": 3, "WEIGHTS_0": 4, "NORMAL": 0"#, 1);
    let found = loaded(&json);
    let mesh = &found.scene.meshes[0].mesh;
    // The first joint is where the node of the mesh is, 100 to the right; the second is back, and above.
    let expected =
        [Vec3::new(100.0, 0.0, 0.0), Vec3::new(101.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.0, 1.0, 1.0)];
    assert_eq!(mesh.positions, expected);
    assert!((mesh.normals[2] - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6);
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    let few = json.replace(r#""joints": [1, 2]"#, r#""joints": [1]"#);
    assert!(refusal(&few).ends_with("a vertex hangs on joint 1, of 1"));
    let away = json.replace(r#", "children": [1] }"#, " }");
    assert!(refusal(&away).ends_with("nodes[0]: skins[0] hangs on nodes[1], which is not in the scene"));
}

#[test]
fn a_skin_turns_its_normals_with_its_joints() {
    let turned = super::pose::turned(DVec3::new(0.6, 0.8, 0.0), DMat3::from_diagonal(DVec3::new(2.0, 1.0, 1.0)));
    assert!((turned - DVec3::new(0.3, 0.8, 0.0).normalize()).length() < 1e-12);
    let quarter = DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2);
    assert!((super::pose::turned(DVec3::X, quarter) - DVec3::Y).length() < 1e-12);
}

#[test]
fn morph_targets_count_by_their_weights() {
    let with = |of_mesh: &str, of_node: &str| {
        let json = document(&format!(
            r#""nodes": [{{ "children": [1, 2] }}, {{ "mesh": 0 {of_node} }}, {{ "mesh": 0, "translation": [0, 9, 0] }}], "materials": [{{}}]"#
        ));
        let json = json.replacen(r#""material": 0 }"#, r#""material": 0, "targets": [{ "POSITION": 0 }] }"#, 1);
        let json = json.replacen(r#""primitives": ["#, &format!(r#"{of_mesh} "primitives": ["#), 1);
        let scene = loaded(&json).scene;
        // How far the squares reach.
        [0.5, 9.5]
            .map(|y| (0..40).take_while(|x| scene.intersect(&ray(0.05 + 0.1 * *x as f32, y, 1.0)).is_some()).count())
    };
    assert_eq!(with("", ""), [10, 10]);
    assert_eq!(with(r#""weights": [0.5],"#, ""), [15, 15]);
    assert_eq!(with(r#""weights": [0.5],"#, r#", "weights": [2]"#), [30, 15]);
}

#[test]
fn compressed_geometry_is_refused_with_a_remedy() {
    let needs = |name: &str| {
        refusal(&document(PLAIN).replacen("\"asset\"", &format!("\"extensionsRequired\": [\"{name}\"], \"asset\""), 1))
    };
    assert_eq!(
        needs("EXT_meshopt_compression"),
        "a.gltf: needs the extension EXT_meshopt_compression, which is not supported; unpack it with \
         gltfpack -i IN.glb -o OUT.glb -noq, or export it without compression"
    );
    assert!(needs("KHR_draco_mesh_compression").ends_with("open it in Blender and export it without compression"));
    assert!(needs("KHR_texture_basisu").ends_with("export it with textures in PNG or JPEG"));
    assert!(needs("X_y").ends_with("export it without"));
    // A file that does not say that it needs it.
    let draco = r#""POSITION": 0, "TEXCOORD_0": 1 }, "extensions": { "KHR_draco_mesh_compression": {} }"#;
    let both = document(PLAIN).replacen(r#""POSITION": 0, "TEXCOORD_0": 1 }"#, draco, 1);
    assert_eq!(loaded(&both).triangles, 2, "it is there uncompressed, too");
    let only = both.replacen(r#"{ "bufferView": 0, "componentType": 5126"#, r#"{ "componentType": 5126"#, 1);
    assert!(refusal(&only).starts_with("a.gltf: has geometry that only KHR_draco_mesh_compression holds"));
}

#[test]
fn textures_lie_where_the_file_lays_them() {
    let at = |x: f32| Vec2::new(x, 0.5);
    let painted = r#"{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 INFO }, "metallicRoughnessTexture": { "index": 0 } } MORE }"#;
    let with = |info: &str, more: &str| material(&painted.replace("INFO", info).replace("MORE", more)).0;
    let plain = with("", "");
    let Surface::Coated { diffuse, .. } = &plain.surface else { panic!("blue is 0: no metal") };
    assert_eq!((diffuse.at(at(0.25)), diffuse.at(at(0.75))), (Vec3::X, Vec3::ZERO));
    assert_eq!(plain.maps.roughness.unwrap().lookup(at(0.25)), 0.0);
    assert!(plain.maps.metallic.is_none() && plain.maps.opacity.is_none());
    let moved = with(r#", "extensions": { "KHR_texture_transform": { "offset": [0.5, 0] } }"#, "");
    let Surface::Coated { diffuse, .. } = &moved.surface else { panic!() };
    assert_eq!(diffuse.at(at(0.25)), Vec3::ZERO);
    let relief = r#", "normalTexture": { "index": 0, "texCoord": 1, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0], "scale": [1, 2], "texCoord": 0 } } }"#;
    let normals = with("", relief).maps.normals.unwrap();
    assert_eq!((normals.lookup(at(0.25)), normals.lookup(at(0.75))), (Vec3::ZERO, Vec3::X));
    assert_eq!(normals.map, Mat2::from_diagonal(Vec2::new(1.0, 2.0)));
    let broken = relief.replace("[0.5, 0]", "3");
    let (blank, notes) = material(&painted.replace("INFO", "").replace("MORE", &broken));
    assert!(blank.maps.normals.is_none() && notes[0].contains("KHR_texture_transform of its normal texture"));
    let wraps = |sampler: &str| {
        let textures = r#""textures": [{ "source": 0, "sampler": 0 }], "images": [{ "uri": "a%20b.png" }]"#;
        let material = painted.replace("INFO", "").replace("MORE", "");
        let rest =
            format!(r#""nodes": [{{ "mesh": 0 }}], {textures}, "samplers": [{sampler}], "materials": [{material}]"#);
        loaded(&document(&rest)).scene.materials[0].maps.roughness.clone().unwrap().wrap
    };
    assert_eq!(wraps("{}"), [Wrap::Repeat; 2]);
    assert_eq!(wraps(r#"{ "wrapS": 33648, "wrapT": 33071 }"#), [Wrap::Mirror, Wrap::Clamp]);
    let opacity = |more: &str, x: f32| with("", more).maps.opacity_at(at(x), 1.0);
    assert!((opacity(r#", "alphaMode": "BLEND""#, 0.75) - 0.2).abs() < 1e-6);
    assert_eq!(opacity(r#", "alphaMode": "MASK""#, 0.75), 0.0);
    assert_eq!(opacity(r#", "alphaMode": "MASK""#, 0.25), 1.0);
    // Halfway between 1 and 0.2 the alpha is 0.6: an edge is where that passes the cutoff, and sharp.
    assert_eq!([0.5, 0.6].map(|x| opacity(r#", "alphaMode": "MASK""#, x)), [1.0, 0.0]);
    let map = with("", r#", "alphaMode": "MASK""#).maps;
    assert_eq!([0.6, 0.4].map(|of_vertices| map.opacity_at(at(0.25), of_vertices)), [1.0, 0.0]);
    assert!(
        with("", r#", "alphaMode": "MASK", "alphaCutoff": 0.1"#).maps.opacity.is_none_or(|all| all.at(at(0.75)) == 1.0)
    );
    // Base colour by the second set, metal and roughness by the first, emission by a third.
    let third = r#", "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0, "texCoord": 2 }"#;
    let notes = material(&painted.replace("INFO", r#", "texCoord": 1"#).replace("MORE", third)).1;
    assert_eq!(
        notes,
        [
            "material 'material 0': textures laid out by a third set of texture coordinates are not supported and ignored"
        ]
    );
}

#[test]
fn each_texture_is_laid_out_by_its_own_coordinates() {
    // The second set is the first one turned by half a turn, so that what is red on the left is on the right.
    let turned: Vec<u8> = UVS.chunks(4).flat_map(|uv| [255 - uv[0], 255 - uv[1], 0, 0]).collect();
    let data = STANDARD.encode(&turned);
    let json = |info: &str| {
        let textures = r#""textures": [{ "source": 0 }], "images": [{ "uri": "a%20b.png" }]"#;
        let painted = format!(
            r#"{{ "pbrMetallicRoughness": {{ "metallicFactor": 0, "baseColorTexture": {{ "index": 0 {info} }} }},
            "emissiveFactor": [1, 1, 1], "emissiveTexture": {{ "index": 0 }} }}"#
        );
        document(&format!(r#""nodes": [{{ "mesh": 0 }}], {textures}, "materials": [{painted}]"#))
            .replacen("\"byteLength\": 70 }", &format!("\"byteLength\": 70 }}, {{ \"uri\": \"data:;base64,{data}\", \"byteLength\": 16 }}"), 1)
            .replacen(r#""byteLength": 6 }"#, r#""byteLength": 6 }, { "buffer": 1, "byteLength": 16, "byteStride": 4 }"#, 1)
            .replacen(
                r#""count": 6, "type": "SCALAR" }"#,
                r#""count": 6, "type": "SCALAR" }, { "bufferView": 3, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC2" }"#,
                1,
            )
            .replacen(r#""TEXCOORD_0": 1"#, r#""TEXCOORD_0": 1, "TEXCOORD_1": 3"#, 1)
    };
    for (info, red) in [("", 0.25), (r#", "texCoord": 1"#, 0.75)] {
        let found = loaded(&json(info));
        assert!(found.notes.iter().all(|note| !note.contains("texture coordinates")), "{:?}", found.notes);
        let scene = found.scene;
        let seen = |x: f32| scene.intersect(&ray(x, 0.4, 1.0)).unwrap();
        assert!(Bsdf::at(&seen(red)).albedo().x > 0.9 && Bsdf::at(&seen(1.0 - red)).albedo().x < 0.1, "{info}");
        // Emission stays by the first set, for light samples, too.
        let lights = Lights::new(&scene);
        let emitted = |x: f32| lights.emitted(seen(x).emitter.unwrap(), &seen(x)).x;
        assert!(emitted(0.25) > 0.9 && emitted(0.75) < 0.1, "{info}");
    }
}

#[test]
fn images_may_lie_in_the_file() {
    let uri = format!("data:image/png;base64,{}", STANDARD.encode(png()));
    let rest = |images: &str| {
        let painted = r#"[{ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": 0 } } }]"#;
        let textures = r#""textures": [{ "source": 0 }]"#;
        document(&format!(r#""nodes": [{{ "mesh": 0 }}], {textures}, "images": [{images}], "materials": {painted}"#))
    };
    let found = loaded(&rest(&format!(r#"{{ "uri": "{uri}" }}"#)));
    let Surface::Coated { diffuse, .. } = &found.scene.materials[0].surface else { panic!() };
    assert_eq!(diffuse.at(Vec2::new(0.25, 0.5)), Vec3::X);
    for (image, why) in [
        (r#"{ "uri": "gone.png" }"#, "texture 'gone.png' is missing"),
        (r#"{ "uri": "data:image/png;base64,!" }"#, "texture 'images[0]' is embedded with a mistake"),
        (r#"{ "bufferView": 0, "mimeType": "image/png" }"#, "texture 'images[0]' cannot be read"),
        ("{}", "texture 'images[0]' is nowhere"),
    ] {
        let found = loaded(&rest(image));
        assert!(found.missing_textures == 1 && found.notes[0].contains(why), "{:?}", found.notes);
    }
}

#[test]
fn what_only_glows_is_told_from_what_shines() {
    let glowing = document(r#""nodes": [{ "mesh": 0 }], "materials": [{ "emissiveFactor": [1, 1, 1] }]"#);
    let loaded = loaded(&glowing);
    assert_eq!((loaded.glow, loaded.scene.emitters.len()), (1.0, 2));
    assert!(super::super::guess_environment(&loaded.scene, loaded.glow).is_some());
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let good = document(PLAIN);
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        refusal(&good.replacen(from, to, 1))
    };
    for (from, to, expected) in [
        (
            "\"nodes\": [{ \"mesh\": 0 }]",
            "\"nodes\": [{ \"mesh\": 7 }]",
            "nodes[0].mesh points to something that is not there",
        ),
        (
            "[{ \"mesh\": 0 }]",
            "[{ \"mesh\": 0, \"children\": [0] }]",
            "nodes[0] stands in the scene twice, expected a tree",
        ),
        ("\"byteLength\": 70", "\"byteLength\": 71", "buffers[0] has 70 bytes, expected 71"),
        (
            "\"byteOffset\": 64, \"byteLength\": 6",
            "\"byteOffset\": 65, \"byteLength\": 6",
            "bufferViews[2] spans 6 bytes from byte 65 on",
        ),
        ("\"count\": 6", "\"count\": 7", "accessors[2] claims 7 elements, more than its view has bytes for"),
        ("\"type\": \"VEC2\"", "\"type\": \"VEC3\"", "accessors[1] has 3 numbers for each element, expected 2"),
        (
            "\"count\": 4, \"type\": \"VEC2\"",
            "\"count\": 3, \"type\": \"VEC2\"",
            "3 texture coordinates for 4 positions",
        ),
        (
            "\"count\": 4, \"type\": \"VEC3\"",
            "\"count\": 2, \"type\": \"VEC3\"",
            "4 texture coordinates for 2 positions",
        ),
        ("\"POSITION\": 0", "\"POSITION\": 9", "accessors[9], which positions are to be in, is not there"),
        ("\"indices\": 2", "\"indices\": 0", "accessors[0] does not hold whole numbers"),
        (
            "\"asset\"",
            "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"asset\"",
            "needs the extension KHR_draco_mesh_compression",
        ),
        ("\"scenes\"", "\"s\": 0, \"scenes\"", ""),
        ("{ \"asset\"", "[ \"asset\"", "its JSON has a mistake"),
        (
            "data:application/octet-stream;base64",
            "data:application/octet-stream",
            "buffers[0] is embedded in a way that is not supported",
        ),
    ] {
        if expected.is_empty() {
            assert!(
                load(&folder(&good.replacen(from, to, 1)).path().join("a.gltf")).is_ok(),
                "unknown keys are no mistakes"
            );
            continue;
        }
        let refused = with(from, to);
        assert!(refused.starts_with("a.gltf: ") && refused.contains(expected), "{refused}");
    }
    assert_eq!(
        refusal(
            &good.replace(&format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes())), "gone.bin")
        ),
        "gone.bin: no such file; check the path, which is relative to the file that names it"
    );
    assert!(refusal("").contains("is empty"));
    let lines = good.replacen("\"indices\": 2", "\"indices\": 2, \"mode\": 1", 1);
    assert!(refusal(&lines).contains("no face with three corners"));
    let quantised = good.replacen("\"asset\"", "\"extensionsRequired\": [\"KHR_mesh_quantization\"], \"asset\"", 1);
    assert_eq!(loaded(&quantised).triangles, 2);
}

#[test]
fn a_scene_file_takes_meshes_and_changes_materials_by_name() {
    let folder =
        folder(&document(r#""materials": [{ "name": "wall" }], "nodes": [{ "mesh": 0, "translation": [0, 0, 3] }]"#));
    let scene = "[[geometry]]\nfile = \"a.gltf\"\ntransform = { translate = [0, 0, 1] }\n\
                 [material.wall]\nmetallic = 0\nbase_color = [0.1, 0.2, 0.3]\n";
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let scene = load(&folder.path().join("scene.toml")).unwrap().scene;
    assert_eq!(scene.intersect(&ray(0.5, 0.5, 9.0)).unwrap().distance, 5.0);
    assert!(matches!(&scene.materials[0].surface, Surface::Coated { diffuse, .. } if is(diffuse, [0.1, 0.2, 0.3])));
}

/// Files that nobody here wrote, where they are.
#[test]
fn shared_files_are_read_or_refused() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes/gltf");
    let triangles = |name: &str| load(&shared.join(name)).map(|loaded| loaded.triangles);
    if !shared.is_dir() {
        return;
    }
    assert_eq!(triangles("FlightHelmet/FlightHelmet.gltf").unwrap(), 94_722);
    assert_eq!(triangles("usd-shaderball/usd-shaderball-ball.glb").unwrap(), 63_856);
    for form in ["-Binary/BoxTextured.glb", "-Embedded/BoxTextured.gltf", "/BoxTextured.gltf"] {
        assert_eq!(triangles(&format!("assimp-cases/BoxTextured-glTF{form}")).unwrap(), 12);
    }
    let bad = triangles("assimp-cases/IndexOutOfRange/IndexOutOfRange.gltf").unwrap_err().to_string();
    assert!(bad.ends_with("meshes[0].primitives[0]: a corner is vertex 255, of 24"), "{bad}");
    let missing = triangles("assimp-cases/MissingBin/BoxTextured.gltf").unwrap_err().to_string();
    assert!(missing.contains("BoxTextured0.bin: no such file"), "{missing}");
}
