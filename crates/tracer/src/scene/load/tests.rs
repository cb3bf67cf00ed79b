use std::fs;
use std::path::Path;

use glam::Vec3;
use tempfile::TempDir;

use super::{Loaded, load};
use crate::Ray;
use crate::camera::CameraDescription;
use crate::material::Surface;

const OBJ: &str = "mtllib a.mtl\nusemtl wall\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

fn folder(scene: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.obj"), OBJ).unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl wall\nKd .2 .4 .6\nnewmtl lamp\nKe 1 1 1\n").unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    folder
}

fn loaded(scene: &str) -> Loaded {
    load(&folder(scene).path().join("scene.toml")).unwrap()
}

fn refusal(scene: &str) -> String {
    let folder = folder(scene);
    let error = load(&folder.path().join("scene.toml")).unwrap_err();
    error.to_string().replace(&format!("{}/", folder.path().display()), "")
}

const GEOMETRY: &str = "[[geometry]]\nfile = \"a.obj\"\n";

#[test]
fn an_obj_file_is_a_scene_by_itself() {
    let folder = folder("");
    let loaded = load(&folder.path().join("a.obj")).unwrap();
    assert_eq!((loaded.triangles, loaded.cameras.len(), loaded.notes.len()), (2, 0, 0));
    assert!(loaded.render.is_none() && loaded.scene.environment.is_none());
}

#[test]
fn geometry_stands_where_it_is_put_and_is_read_once() {
    let twice = "[[geometry]]\nfile = \"a.obj\"\ntransform = { translate = [0, 0, 5], scale = 2 }\n";
    let scene = loaded(&format!("{GEOMETRY}{twice}")).scene;
    assert_eq!((scene.triangles(), scene.materials.len()), (4, 2));
    let ray = Ray { origin: Vec3::new(1.5, 0.4, 9.0), direction: -Vec3::Z, t_max: 100.0, time: 0.0 };
    assert!((scene.intersect(&ray).unwrap().distance - 4.0).abs() < 1e-5);
    assert_eq!(scene.bounds().max, Vec3::new(2.0, 2.0, 5.0));
}

#[test]
fn geometry_and_cameras_may_move() {
    let scene = format!(
        "{GEOMETRY}transform = {{ translate = [1, 0, 0] }}\nmotion = {{ translate = [0, 0, 2], rotate = [0, 180, 0] }}\n\
         [camera]\neye = [0, 0, 9]\nlook_at = [0, 0, 0]\nmotion = {{ translate = [1, 0, 0] }}\n"
    );
    let loaded = loaded(&scene);
    let ray = |time| Ray { origin: Vec3::new(0.5, 0.5, 9.0), direction: -Vec3::Z, t_max: 100.0, time };
    assert!(loaded.scene.intersect(&ray(0.0)).is_none());
    // Turned by half about its own origin at x = 1, it lies between 0 and 1, two nearer.
    assert!((loaded.scene.intersect(&ray(1.0)).unwrap().distance - 7.0).abs() < 1e-5);
    let motion = loaded.cameras[0].1.motion.unwrap();
    assert_eq!((motion.translate, motion.centre), (glam::DVec3::X, glam::DVec3::new(0.0, 0.0, 9.0)));
    assert!(refusal(&format!("{GEOMETRY}motion = {{ turn = [0, 1, 0] }}\n")).contains("no key 'turn'"));
    assert!(
        refusal(&format!("{GEOMETRY}motion = {{ rotate = [0, inf, 0] }}\n"))
            .starts_with("scene.toml:3: expected numbers of at most 1e37 for rotate")
    );
}

#[test]
fn cameras_are_one_or_many() {
    let one = loaded(&format!("[camera]\neye = [0, 0, 9]\nlook_at = [0, 1, 0]\n{GEOMETRY}"));
    let plain = CameraDescription::looking(Vec3::new(0.0, 0.0, 9.0), Vec3::Y);
    assert_eq!(one.cameras, [(None, plain)]);
    let many = loaded(&format!(
        "[[camera]]\nname = \"front\"\neye = [0, 0, 9]\nlook_at = [0, 1, 0]\nfov = 30\nlens_radius = 0.1\nfocus_distance = 4\n\
         shutter = [0, 0.5]\nup = [1, 0, 0]\n[[camera]]\neye = [1, 0, 0]\nlook_at = [0, 0, 0]\n{GEOMETRY}"
    ));
    assert_eq!(many.cameras.len(), 2);
    let front = CameraDescription {
        fov: 30.0,
        lens_radius: 0.1,
        focus_distance: Some(4.0),
        shutter: [0.0, 0.5],
        up: Vec3::X,
        ..plain
    };
    assert_eq!(many.cameras[0], (Some("front".into()), front));
}

#[test]
fn the_sky_is_colour_times_scale() {
    let sky =
        |table: &str| loaded(&format!("{table}\n{GEOMETRY}")).scene.environment.and_then(|e| e.constant_radiance());
    assert_eq!(sky("[environment]\ncolor = [1, 2, 3]\nscale = 0.5"), Some(Vec3::new(0.5, 1.0, 1.5)));
    assert_eq!(sky("[environment]"), Some(Vec3::ONE));
    assert_eq!(sky(""), None);
}

#[test]
fn the_sky_may_be_a_map_that_is_turned_and_scaled() {
    let scene = format!("[environment]\nfile = \"SKY.pfm\"\nrotate = 90\nscale = 2\n{GEOMETRY}");
    let folder = folder(&scene);
    let planes = vec![vec![1.0, 3.0]; 3];
    let image = stack::Image::from_channels(stack::Size::new(2, 1), planes);
    stack::file::write_picture(&folder.path().join("sky.pfm"), &image).unwrap();
    let sky = load(&folder.path().join("scene.toml")).unwrap().scene.environment.unwrap();
    // The map is 1 round +x and 3 round −x; a quarter turn takes +x to −z.
    let at = |direction| sky.radiance(direction).x;
    assert!((at(-Vec3::Z) - 2.0).abs() < 1e-4 && (at(Vec3::Z) - 6.0).abs() < 1e-4);
    let map = |rest: &str| refusal(&format!("{GEOMETRY}[environment]\nfile = \"a.mtl\"\n{rest}\n"));
    assert_eq!(map("color = [1, 1, 1]"), "scene.toml:5: expected either file or color, found both");
    assert_eq!(map("scale = -1"), "scene.toml:5: expected scale ≥ 0, found -1");
    assert!(map("rotate = 5").starts_with("a.mtl: cannot be read as a picture"));
    assert!(refusal(&format!("{GEOMETRY}[environment]\nfile = \"none.hdr\"\n")).contains("none.hdr: no such file"));
}

#[test]
fn a_clear_coat_of_a_file_can_be_changed_and_taken_off() {
    let changed = |table: &str| {
        let folder = folder(&format!("{GEOMETRY}[material.wall]\n{table}\n"));
        let library = fs::read_to_string(folder.path().join("a.mtl")).unwrap();
        fs::write(folder.path().join("a.mtl"), library.replace("newmtl wall", "newmtl wall\nPc 0.7\nPcr 0.3")).unwrap();
        let scene = load(&folder.path().join("scene.toml")).unwrap().scene;
        let coat = scene.materials.iter().find(|m| m.name == "wall").unwrap().maps.clear_coat.clone();
        coat.map(|coat| [coat.cover.factor, coat.roughness.factor])
    };
    assert_eq!(changed("roughness = 1"), Some([0.7, 0.3]));
    assert_eq!(changed("clear_coat_roughness = 0.1"), Some([0.7, 0.1]));
    assert_eq!(changed("clear_coat = 0"), None);
}

#[test]
fn materials_are_changed_by_name() {
    let changed = |table: &str| {
        let scene = loaded(&format!("{GEOMETRY}[material.wall]\n{table}\n")).scene;
        let index = scene.materials.iter().position(|m| m.name == "wall").unwrap();
        scene.materials[index].clone()
    };
    let base = Vec3::new(0.2, 0.4, 0.6);
    let material = changed("emission = [3, 2, 1]");
    assert_eq!(material.emission.factor, Vec3::new(3.0, 2.0, 1.0));
    assert!(matches!(material.surface, Surface::Diffuse { reflectance } if reflectance.factor == base));
    let rough = changed("metallic = 1\nroughness = 0.5").surface;
    assert!(matches!(rough, Surface::Conductor { reflectance, alpha: 0.25 } if reflectance.factor == base));
    assert!(matches!(changed("metallic = 1").surface, Surface::Mirror { .. }));
    let nearly = changed("metallic = 0.996");
    assert_eq!(nearly.maps.metallic.unwrap().factor, 0.996);
    assert!(matches!(nearly.surface, Surface::Coated { diffuse, alpha: 1.0, .. } if diffuse.factor == base));
    assert!(changed("metallic = 0\nroughness = 1").maps.metallic.is_none());
    let glass = changed("transmission = 1\nior = 1.33\nbase_color = 0.9").surface;
    assert!(
        matches!(glass, Surface::Glass { ior: 1.33, transmittance, alpha: 0.0 } if transmittance.factor == Vec3::splat(0.9))
    );
    assert!(matches!(changed("transmission = 1\nroughness = 0.5").surface, Surface::Glass { alpha: 0.25, .. }));
    assert!(matches!(changed("transmission = 1\nthin = true").surface, Surface::ThinGlass { ior: 1.5, .. }));
    assert_eq!(changed("alpha = 0.25").maps.opacity.unwrap().factor, 0.25);
    for bare in ["roughness = 0.1\nspecular = 0", "roughness = 0.1\nior = 1"] {
        assert!(matches!(changed(bare).surface, Surface::Diffuse { .. }), "{bare}");
    }
    let clear = changed("clear_coat = 0.5\nclear_coat_roughness = 0.2").maps.clear_coat.unwrap();
    assert_eq!((clear.cover.factor, clear.roughness.factor), (0.5, 0.2));
    assert!(changed("clear_coat_roughness = 0.2").maps.clear_coat.is_none());
    let coat = changed("roughness = 0.1\nspecular = 0.08").surface;
    assert!(
        matches!(coat, Surface::Coated { specular, diffuse, .. } if specular.factor == Vec3::splat(0.08) && diffuse.factor == base)
    );
}

/// Writes a picture of one pixel in that colour.
fn write_pixel(folder: &TempDir, name: &str, colour: [u8; 4]) {
    let pixel = image::RgbaImage::from_raw(1, 1, colour.to_vec()).unwrap();
    pixel.save(folder.path().join(name)).unwrap();
}

#[test]
fn materials_may_be_given_images() {
    let changed = |table: &str| {
        let folder = folder(&format!("{GEOMETRY}[material.wall]\n{table}\n"));
        write_pixel(&folder, "a.png", [255, 188, 0, 51]);
        write_pixel(&folder, "up.png", [128, 128, 255, 255]);
        write_pixel(&folder, "tilted.png", [204, 128, 230, 255]);
        let loaded = load(&folder.path().join("scene.toml")).map_err(|error| error.to_string())?;
        Ok(loaded.scene.materials[0].clone())
    };
    let must = |table: &str| changed(table).unwrap_or_else(|error: String| panic!("{table}: {error}"));
    let at = glam::Vec2::splat(0.3);
    let near = |a: Vec3, b: [f32; 3]| (a - Vec3::from(b)).length() < 2e-3;
    let Surface::Diffuse { reflectance } = must("base_color = \"A.png\"").surface else { panic!() };
    assert!(near(reflectance.at(at), [1.0, 0.503, 0.0]), "colours are decoded from sRGB");
    let lamp =
        must("emission = { file = \"a.png\", factor = [2, 20, 2], wrap = \"clamp\", scale = [2, 3], offset = [1, 0] }");
    assert!(near(lamp.emission.at(at) / 10.0, [0.2, 1.006, 0.0]));
    let texture = lamp.emission.texture.unwrap();
    assert!(
        texture.wrap == [crate::texture::Wrap::Clamp; 2]
            && texture.map == glam::Mat2::from_diagonal(glam::Vec2::new(2.0, 3.0))
            && texture.offset == glam::Vec2::X
    );
    let veil = must("alpha = { file = \"a.png\", factor = 0.5 }").maps.opacity.unwrap();
    assert!((veil.at(at) - 0.1).abs() < 1e-6, "the image's alpha");
    let veil = must("alpha = { file = \"a.png\", channel = \"red\" }").maps.opacity.unwrap();
    assert_eq!(veil.at(at), 1.0);
    let rough = must("roughness = { file = \"a.png\", factor = 0.5, channel = \"alpha\" }");
    assert!(matches!(rough.surface, Surface::Coated { alpha: 0.25, .. }));
    assert!((rough.maps.roughness.unwrap().lookup(at) - 0.2).abs() < 1e-6);
    let partly = must("metallic = { file = \"a.png\", channel = \"alpha\" }");
    assert!(matches!(partly.surface, Surface::Coated { .. }), "only what is coated can be metal in places");
    assert!((partly.maps.metallic.unwrap().at(at) - 0.2).abs() < 1e-6);
    let slope = |table: &str| {
        let texel = 2.0 * must(table).maps.normals.unwrap().lookup(at) - Vec3::ONE;
        texel.x / texel.z
    };
    let once = slope("normal_map = \"tilted.png\"");
    assert!((once - 0.6 / 0.8).abs() < 0.01);
    assert!((slope("normal_map = { file = \"tilted.png\", factor = 2 }") / once - 2.0).abs() < 1e-4);
    assert!(slope("bump_map = \"up.png\"").abs() < 0.01);

    let refused = |table: &str| {
        let error = changed(table).unwrap_err();
        error[error.find("scene.toml").unwrap_or_default()..].to_string()
    };
    assert_eq!(refused("base_color = \"none.png\""), "scene.toml:4: texture 'none.png' is missing");
    assert!(refused("base_color = \"a.mtl\"").starts_with("scene.toml:4: texture 'a.mtl' cannot be read"));
    assert_eq!(
        refused("\nroughness = { fil = \"a.png\" }"),
        "scene.toml:5: there is no key 'fil'; did you mean 'file'?"
    );
    assert_eq!(
        refused("alpha = { file = \"a.png\", wrap = \"tile\" }"),
        "scene.toml:4: there is no value 'tile'; did you mean 'repeat'?"
    );
    assert_eq!(
        refused("alpha = { file = \"a.png\", factor = [1, 2, 3] }"),
        "scene.toml:4: expected one number for factor, found three"
    );
    assert_eq!(
        refused("bump_map = \"a.png\"\nnormal_map = \"a.png\""),
        "scene.toml:4: expected either normal_map or bump_map, found both"
    );
    assert_eq!(refused("roughness = 1.5"), "scene.toml:4: expected roughness 0 … 1, found 1.5");
    assert!(
        refused("roughness = [1, 2, 3]").starts_with("scene.toml:4: expected a number, or an image's name or table")
    );
    assert!(refused("normal_map = 1").starts_with("scene.toml:4: expected an image's name or table, found floating"));
}

#[test]
fn instances_cost_their_triangles_once() {
    let stands = |instances: &str| format!("{GEOMETRY}transform = {{ scale = 2 }}\ninstances = [{instances}]\n");
    let loaded = loaded(&stands("{}, { translate = [0, 0, 5] }, { rotate = [0, 90, 0] }, { scale = 0.5 }"));
    assert_eq!((loaded.triangles, loaded.scene.stored_triangles()), (8, 2));
    // Scaled first, then where the instance puts it.
    let ray = Ray { origin: Vec3::new(1.5, 0.4, 9.0), direction: -Vec3::Z, t_max: 100.0, time: 0.0 };
    assert!((loaded.scene.intersect(&ray).unwrap().distance - 4.0).abs() < 1e-5);
    assert_eq!(
        refusal(&stands("{}, { scale = 0 }")),
        "scene.toml:4: expected a transform that can be undone, found a singular or too large one"
    );
    // Found by damaging files: these used to end in a panic.
    for (large, said) in [
        ("{ translate = [2, 0, -1e39] }", "numbers of at most 1e37 for translate"),
        ("{ scale = [-1e39, 2, 1] }", "numbers of at most 1e37 for scale"),
        ("{ scale = 1e-39 }", "singular or too large"),
        ("{ matrix = [1, 0, 0, 1e39, 0, 1, 0, 0, 0, 0, 1, 0] }", "singular or too large"),
    ] {
        assert!(refusal(&stands(&format!("{{}}, {large}"))).contains(said), "{large}");
    }
    for far in
        ["{ matrix = [1, 1e38, 0, 0, 0, 1, 0, 0, 0, 0, 1, 3] }", "{ matrix = [1, 0, 0, 3e38, 0, 1, 0, 0, 0, 0, 1, 0] }"]
    {
        let loaded = self::loaded(&stands(&format!("{{}}, {{ translate = [0, 0, 5] }}, {far}")));
        assert_eq!((loaded.triangles, loaded.dropped.not_finite), (4, 2), "{far}");
    }
    assert!(refusal(&format!("{GEOMETRY}motion = {{ translate = [0, 1e300, 0] }}\n")).contains("at most 1e37"));
    assert!(refusal(&stands("{ move = [0, 0, 0] }")).starts_with("scene.toml:4: there is no key 'move'"));
    assert!(refusal(&stands("")).contains("no visible triangle"));
}

#[test]
fn lights_of_all_types_are_read() {
    let light = |table: &str| loaded(&format!("{GEOMETRY}[[light]]\n{table}\n")).scene;
    let power = |scene: &crate::scene::Scene| {
        scene.emitters.iter().map(|e| std::f32::consts::PI * e.area * e.radiance.x).sum::<f32>()
    };
    for (shape, area) in [
        ("type = \"quad\"\nlook_at = [0, 0, 0]\nsize = [2, 3]", 6.0),
        ("type = \"disk\"\nlook_at = [0, 0, 0]\nradius = 2", 12.566),
        ("type = \"sphere\"\nradius = 2", 50.265),
    ] {
        let scene = light(&format!("{shape}\nposition = [0, 9, 0]\npower = [100, 50, 0]"));
        assert!((power(&scene) / 100.0 - 1.0).abs() < 1e-4, "{shape}: {}", power(&scene));
        let scene = light(&format!("{shape}\nposition = [0, 9, 0]\nradiance = 3"));
        assert!((power(&scene) / (3.0 * std::f32::consts::PI * area) - 1.0).abs() < 1e-4, "{shape}");
        let down = Ray { origin: Vec3::new(0.2, 5.0, 0.3), direction: Vec3::Y, t_max: 100.0, time: 0.0 };
        assert!(scene.intersect(&down).unwrap().emitter.is_some(), "{shape} shines at what it looks at");
    }
    let point = light("type = \"point\"\nposition = [0, 9, 0]\nintensity = 4");
    assert!(point.emitters.is_empty());
    assert_eq!(
        point.delta_lights,
        [crate::light::DeltaLight::Point { position: Vec3::new(0.0, 9.0, 0.0), intensity: Vec3::splat(4.0) }]
    );
    let spot = "type = \"spot\"\nposition = [0, 9, 0]\nlook_at = [0, 0, 0]\n";
    assert_eq!(light(&format!("{spot}power = 1")).delta_lights.len(), 1);
    assert_eq!(light("type = \"sun\"\ndirection = [0, -2, 0]\nirradiance = 1").delta_lights.len(), 1);

    let refused = |table: &str| refusal(&format!("{GEOMETRY}[[light]]\n{table}\n"));
    assert_eq!(
        refused("type = \"point\"\nposition = [0, 1, 0]\nradius = 2\nintensity = 1"),
        "scene.toml:6: there is no key of a point light 'radius'; did you mean 'type'?"
    );
    assert_eq!(refused("type = \"lamp\""), "scene.toml:4: there is no value 'lamp'; did you mean 'quad'?");
    assert_eq!(
        refused("type = \"sphere\"\nradius = 2\npower = 1"),
        "scene.toml:4: expected the key 'position' in a sphere light, found none"
    );
    assert_eq!(
        refused("type = \"point\"\nposition = [0, 1, 0]"),
        "scene.toml:4: expected intensity or power in a point light, found neither"
    );
    assert_eq!(refused(&format!("{spot}power = -1")), "scene.toml:7: expected power ≥ 0, found -1");
    assert_eq!(
        refused("type = \"sun\"\ndirection = [0, 0, 0]\nirradiance = 1"),
        "scene.toml:5: expected a direction by direction, found none"
    );
    assert_eq!(refused("position = [0, 1, 0]"), "scene.toml:3: expected a key `type`, found none");
}

#[test]
fn the_render_table_is_handed_on_with_its_lines() {
    let scene = format!("[render]\nspp = 64\nsize = [640, 480]\n\npreset = \"best\"\nscale = 0.5\n{GEOMETRY}");
    let render = loaded(&scene).render.unwrap();
    let entries: Vec<_> = render.entries.iter().map(|e| (e.key.as_str(), e.text.as_str(), e.line)).collect();
    assert_eq!(entries, [("spp", "64", 2), ("size", "640,480", 3), ("preset", "best", 5), ("scale", "0.5", 6)]);
    assert!(render.file.ends_with("scene.toml"));
}

#[test]
fn unknown_names_are_told_with_their_line_and_the_nearest_known_one() {
    assert_eq!(
        refusal(&format!("[camera]\neye = [0, 0, 9]\nlook_at = [0, 1, 0]\nlens_radus = 1\n{GEOMETRY}")),
        "scene.toml:4: there is no key 'lens_radus'; did you mean 'lens_radius'?"
    );
    assert_eq!(
        refusal(&format!("[enviroment]\n{GEOMETRY}")),
        "scene.toml:1: there is no key 'enviroment'; did you mean 'environment'?"
    );
    assert_eq!(
        refusal("[[geometry]]\nfile = \"a.obj\"\ntransform = { translation = [0, 0, 1] }\n"),
        "scene.toml:3: there is no key 'translation'; did you mean 'translate'?"
    );
    assert_eq!(
        refusal(&format!("{GEOMETRY}[material.wall]\nbase_colour = 1\n")),
        "scene.toml:4: there is no key 'base_colour'; did you mean 'base_color'?"
    );
    assert_eq!(
        refusal(&format!("{GEOMETRY}[material.well]\nroughness = 1\n")),
        "scene.toml:3: there is no material 'well'; did you mean 'wall'?"
    );
}

#[test]
fn values_that_cannot_be_are_told_with_their_line() {
    assert!(refusal("[camera]\neye = [0, 0, 9]\nlook_at = [0, 1, 0]\n").contains("at least one [[geometry]] table"));
    assert!(refusal("[[geometry]]\nfile = \"b.obj\"\n").contains("b.obj: no such file"));
    assert!(refusal("[[geometry]]\nfile = \"a.mtl\"\n").contains("a.mtl: expected a file that ends in .obj"));
    let camera = |rest: &str| refusal(&format!("{GEOMETRY}[camera]\neye = [0, 0, 9]\n{rest}"));
    assert!(camera("look_at = [0, 0, 9]\n").starts_with("scene.toml:5: camera look_at: found [0, 0, 9]"));
    assert!(camera("look_at = [0, 0, 0]\nfov = 200\n").starts_with("scene.toml:6: camera fov: found 200"));
    assert!(camera("look_at = [0, 0]\n").starts_with("scene.toml:5:"));
    assert!(camera("look_at = [0, 0, 0]\nfov = \"wide\"\n").starts_with("scene.toml:6:"));
    assert!(camera("").contains("look_at"));
    let geometry = |transform: &str| refusal(&format!("{GEOMETRY}transform = {{ {transform} }}\n"));
    assert_eq!(
        geometry("scale = 0"),
        "scene.toml:3: expected a transform that can be undone, found a singular or too large one"
    );
    assert!(geometry("matrix = [1, 2]").contains("12 or 16 numbers"));
    assert!(geometry("matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0], scale = 2").contains("either matrix or its parts"));
    assert!(
        geometry("scale = \"big\"").contains("expected a number or three numbers"),
        "{}",
        geometry("scale = \"big\"")
    );
    let material = |rest: &str| refusal(&format!("{GEOMETRY}[material.wall]\n{rest}"));
    assert_eq!(material("roughness = 2"), "scene.toml:4: expected roughness 0 … 1, found 2");
    assert_eq!(material("emission = [1, 2, -3]"), "scene.toml:4: expected emission ≥ 0, found -3");
    assert!(refusal("[[geometry]\n").starts_with("scene.toml:1:"));
}

#[test]
fn what_is_no_scene_file_is_refused() {
    let folder = folder("");
    let refuse = |name: &str| load(&folder.path().join(name)).unwrap_err().to_string();
    assert!(refuse("a.mtl").contains("expected a file that ends in .obj, .gltf, .glb or .toml"));
    assert!(refuse("none.xyz").contains("no such file"));
    assert!(refuse("").contains("is a folder"));
    assert!(load(Path::new("no/such/scene.toml")).unwrap_err().to_string().contains("no such file"));
}

/// A folder among the shared scenes, when they are there.
fn shared(name: &str) -> Vec<std::path::PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    files.filter(|path| path.extension().is_some_and(|e| e == "obj")).collect()
}

#[test]
fn cornell_boxes_load_with_their_lamp_and_nothing_missing() {
    for path in shared("cornell-box").iter().filter(|p| p.to_string_lossy().contains("CornellBox")) {
        let loaded = load(path).unwrap();
        assert_eq!((loaded.scene.emitters.len(), loaded.notes.len()), (2, 0), "{}", path.display());
        assert!(loaded.scene.emitters.iter().all(|e| e.normal.y < -0.999), "lamps shine down");
    }
}

#[test]
fn strange_files_load_or_are_refused_with_a_reason() {
    for path in
        ["weird-obj/assimp", "weird-obj/assimp-invalid", "weird-obj/tinyobjloader"].iter().flat_map(|f| shared(f))
    {
        match load(&path) {
            Ok(loaded) => assert!(loaded.triangles > 0 && !loaded.scene.bounds().is_empty()),
            Err(error) => assert!(error.to_string().contains(&path.display().to_string()), "{error}"),
        }
    }
}
