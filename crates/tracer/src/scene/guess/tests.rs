use std::path::{Path, PathBuf};

use glam::{DAffine3, Vec2, Vec3};
use stack::Size;

use super::super::{Instance, Mesh, Placement, Scene, load};
use super::{guess_camera, guess_environment};
use crate::camera::CameraDescription;
use crate::material::{Colour, Material, Surface};

/// The sides of the unit cube but those left out, facing in or out; and a lamp of its own under the ceiling.
fn cube(without: &[usize], inward: bool, lamp: bool) -> Scene {
    let positions = super::super::Bounds { min: Vec3::ZERO, max: Vec3::ONE }.corners().to_vec();
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = Mesh { positions, ..Mesh::default() };
    for (_, &[a, b, c, d]) in sides.iter().enumerate().filter(|(i, _)| !without.contains(i)) {
        mesh.triangles.extend(if inward { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
        mesh.materials.extend([0, 0]);
    }
    if lamp {
        mesh.positions.extend([Vec3::new(0.4, 0.99, 0.4), Vec3::new(0.6, 0.99, 0.4), Vec3::new(0.5, 0.99, 0.6)]);
        mesh.triangles.push([8, 9, 10]);
        mesh.materials.push(1);
    }
    let material =
        |emission| Material::new("", Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) }, emission);
    let stand = Instance { mesh: 0, placement: Placement::new(DAffine3::IDENTITY).unwrap(), motion: None };
    Scene::new(vec![mesh], vec![stand], vec![material(Vec3::ZERO), material(Vec3::ONE)], None).unwrap()
}

fn is_inside(scene: &Scene, camera: &CameraDescription) -> bool {
    camera.eye.cmpgt(scene.bounds().min).all() && camera.eye.cmplt(scene.bounds().max).all()
}

#[test]
fn an_open_box_is_looked_into_from_its_open_side() {
    for (side, outward) in [(5, Vec3::Z), (1, Vec3::X), (4, Vec3::NEG_Z), (0, Vec3::NEG_X)] {
        for inward in [false, true] {
            let camera = guess_camera(&cube(&[side], inward, false)).value;
            let view = (camera.look_at - camera.eye).normalize();
            assert!(view.dot(outward) < -0.999);
            // The edge of the opening is the edge of the picture.
            let edge = camera.eye + view * ((camera.eye - Vec3::splat(0.5)).length() - 0.5);
            let half_height = (edge - camera.eye).length() * (0.5 * camera.fov.to_radians()).tan();
            assert!((0.5..0.53).contains(&half_height), "{half_height}");
        }
    }
}

#[test]
fn a_solid_is_seen_from_outside_and_wholly() {
    let scene = cube(&[], false, false);
    let camera = guess_camera(&scene).value;
    assert!(!is_inside(&scene, &camera) && camera.eye.y > 0.5);
    let view = (camera.look_at - camera.eye).normalize();
    for corner in scene.bounds().corners() {
        let angle = view.angle_between(corner - camera.eye).to_degrees();
        assert!(angle < 0.75 * camera.fov);
    }
}

#[test]
fn a_room_is_seen_from_inside() {
    for scene in [cube(&[], true, false), cube(&[], false, true)] {
        let guess = guess_camera(&scene);
        assert!(is_inside(&scene, &guess.value), "{}", guess.line);
    }
}

#[test]
fn the_line_can_be_typed_and_the_guess_does_not_change() {
    let scene = cube(&[5], true, false);
    let guess = guess_camera(&scene);
    assert_eq!(guess, guess_camera(&scene));
    let expected = "no camera given: looking into the open box, as with --eye 0.5,0.5,";
    assert!(
        guess.line.starts_with(expected) && guess.line.ends_with("--look-at 0.5,0.5,0.5 --fov 30"),
        "{}",
        guess.line
    );
}

#[test]
fn a_sky_is_assumed_where_nothing_emits() {
    assert_eq!(guess_environment(&cube(&[], false, false), 0.0).unwrap().value, Vec3::ONE);
    let lit = cube(&[], false, true);
    assert_eq!(guess_environment(&lit, 0.0), None);
    let glow = lit.emitters[0].radiance.max_element();
    assert!(guess_environment(&lit, 0.99 * glow).is_none() && guess_environment(&lit, glow).is_some());
    let mut scene = cube(&[], false, false);
    scene.environment = Some(crate::environment::Environment::constant(Vec3::ZERO));
    assert_eq!(guess_environment(&scene, 0.0), None);
}

/// A file among the shared scenes, when they are there.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
    path.exists().then_some(path)
}

/// How much of a picture taken with the guess shows something.
fn covered(scene: &Scene, camera: &CameraDescription) -> f32 {
    let camera = camera.on(Size::new(32, 32)).unwrap();
    let seen = |k: usize| {
        let film = Vec2::new((k % 32) as f32 + 0.5, (k / 32) as f32 + 0.5);
        scene.intersect(&camera.ray(film, Vec2::ZERO, 0.0)).is_some()
    };
    (0..1024).filter(|&k| seen(k)).count() as f32 / 1024.0
}

/// Checks the guess for a shared scene: whether it stands inside and how much of the picture shows something.
fn is_shown(name: &str, inside: bool, least: f32) -> Option<CameraDescription> {
    let scene = load(&shared(name)?).unwrap().scene;
    let guess = guess_camera(&scene);
    assert_eq!(is_inside(&scene, &guess.value), inside, "{}", guess.line);
    let covered = covered(&scene, &guess.value);
    assert!(covered > least, "{covered} {}", guess.line);
    Some(guess.value)
}

#[test]
fn cornell_boxes_are_seen_from_the_front() {
    for (name, least) in [("Original", 0.9), ("Sphere", 0.7), ("Mirror", 0.9), ("Water", 0.7), ("Empty-Squashed", 0.7)]
    {
        let camera = is_shown(&format!("cornell-box/CornellBox-{name}.obj"), false, least);
        assert!(camera.is_none_or(|c| (c.look_at - c.eye).normalize().z < -0.999));
    }
}

#[test]
fn sponza_is_seen_from_inside() {
    is_shown("sponza-dabrovic/sponza.obj", true, 0.8);
}

#[test]
fn sibenik_is_seen_from_inside() {
    is_shown("sibenik/sibenik.obj", true, 0.9);
}

#[test]
fn the_conference_room_is_seen_from_inside() {
    is_shown("conference/conference.obj", true, 0.9);
}

#[test]
fn objects_are_seen_from_outside() {
    is_shown("misc-obj/bunny/bunny.obj", false, 0.25);
    is_shown("chess/chess.obj", false, 0.25);
}
