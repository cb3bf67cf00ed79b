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
            .starts_with("scene.toml:3: expected finite")
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
    assert_eq!(map("scale = -1"), "scene.toml:5: expected a factor of 0 or more, found -1");
    assert!(map("rotate = 5").starts_with("a.mtl: cannot be read as a picture"));
    assert!(refusal(&format!("{GEOMETRY}[environment]\nfile = \"none.hdr\"\n")).contains("none.hdr: no such file"));
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
    let glass = changed("transmission = 1\nior = 1.33\nbase_color = 0.9").surface;
    assert!(
        matches!(glass, Surface::Glass { ior: 1.33, transmittance, alpha: 0.0 } if transmittance.factor == Vec3::splat(0.9))
    );
    assert!(matches!(changed("transmission = 1\nroughness = 0.5").surface, Surface::Glass { alpha: 0.25, .. }));
    assert!(matches!(changed("transmission = 1\nthin = true").surface, Surface::ThinGlass { ior: 1.5, .. }));
    assert_eq!(changed("alpha = 0.25").maps.opacity.unwrap().factor, 0.25);
    let coat = changed("roughness = 0.1\nspecular = 0.08").surface;
    assert!(
        matches!(coat, Surface::Coated { specular, diffuse, .. } if specular.factor == Vec3::splat(0.08) && diffuse.factor == base)
    );
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
    assert_eq!(geometry("scale = 0"), "scene.toml:3: expected a transform that can be undone, found a singular one");
    assert!(geometry("matrix = [1, 2]").contains("12 or 16 numbers"));
    assert!(geometry("matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0], scale = 2").contains("either matrix or its parts"));
    assert!(
        geometry("scale = \"big\"").contains("expected a number or three numbers"),
        "{}",
        geometry("scale = \"big\"")
    );
    let material = |rest: &str| refusal(&format!("{GEOMETRY}[material.wall]\n{rest}"));
    assert_eq!(material("roughness = 2"), "scene.toml:4: expected a number from 0 to 1, found 2");
    assert!(material("emission = [1, 2, -3]").contains("expected radiance of 0 or more"));
    assert!(refusal("[[geometry]\n").starts_with("scene.toml:1:"));
}

#[test]
fn what_is_no_scene_file_is_refused() {
    let folder = folder("");
    let refuse = |name: &str| load(&folder.path().join(name)).unwrap_err().to_string();
    assert!(refuse("a.mtl").contains("expected a file that ends in .obj or .toml"));
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
