//! Caustics that photons show against those that paths find.

use glam::Vec3;
use stack::Size;

use super::TraceSettings;
use super::test_scenes::{Pieces, diffuse, grey, indirect_and_gathered, lamp, looking_down, render};
use crate::environment::{Environment, EnvironmentMap};
use crate::material::Surface;
use crate::scene::{Motion, Scene};

const SIZE: Size = Size::new(24, 24);

fn assert_same_light_with_less_noise(scene: &Scene, share: f64) {
    let (stack, _) = render(scene, &looking_down(SIZE), 1024, &TraceSettings::DEFAULT);
    let [indirect, gathered] = indirect_and_gathered(&stack);
    // What pixels lack together is not in their variances.
    let error = 5.0 * (indirect.1 + gathered.1).sqrt() + 0.01 * indirect.0;
    assert!(indirect.0 > 0.0 && (gathered.0 - indirect.0).abs() < error, "{gathered:?} {indirect:?}");
    assert!(gathered.1 < share * indirect.1, "{gathered:?} {indirect:?}");
    // Without photons paths are left to themselves, and are the same.
    let [with, without] = [TraceSettings::DEFAULT.photons, 0.0]
        .map(|photons| render(scene, &looking_down(SIZE), 8, &TraceSettings { photons, ..TraceSettings::DEFAULT }).0);
    assert_eq!((&without.components, &without.indirect), (&with.components, &with.indirect));
    assert_ne!(without.gathered, with.gathered);
}

fn floor(pieces: Pieces) -> Pieces {
    pieces.quad(Vec3::new(-4.0, -1.0, 4.0), Vec3::X * 8.0, -Vec3::Z * 8.0, (diffuse(0.5), 0.0))
}

/// A lamp beside the camera that shines down: large enough for paths to hit it now and then.
fn under_lamp(pieces: Pieces) -> Scene {
    pieces.quad(Vec3::new(1.0, 3.5, 0.0), Vec3::X, Vec3::Z, lamp(20.0)).under(None)
}

fn glass(ior: f32) -> (Surface, f32) {
    (Surface::Glass { ior, transmittance: grey(0.9), alpha: 0.0 }, 0.0)
}

#[test]
fn a_mirror_throws_the_light_of_a_lamp_on_the_floor() {
    let mirror = (Surface::Mirror { reflectance: grey(0.8) }, 0.0);
    let pieces = floor(Pieces::default()).quad(Vec3::new(-1.5, -1.0, -1.0), Vec3::Z * 2.0, Vec3::Y * 2.0, mirror);
    assert_same_light_with_less_noise(&under_lamp(pieces), 0.2);
}

#[test]
fn a_ball_of_glass_bundles_light() {
    let scene = under_lamp(floor(Pieces::default()).sphere(1.0, glass(1.5)));
    assert_same_light_with_less_noise(&scene, 0.2);
}

/// Light is squeezed where it is shown.
#[test]
fn what_lies_in_glass_is_lit_through_it() {
    let inside = Pieces::default().sphere(0.5, (diffuse(0.5), 0.0)).sphere(1.0, glass(1.5));
    assert_same_light_with_less_noise(&under_lamp(inside), 0.2);
}

#[test]
fn a_small_sun_of_the_sky_shines_through_a_pane() {
    let mut texels = vec![[0.1; 3]; 64 * 32];
    texels[5 * 64 + 20] = [3000.0; 3];
    let pane = (Surface::ThinGlass { ior: 1.5, transmittance: grey(0.9), alpha: 0.0 }, 0.0);
    let pieces = floor(Pieces::default()).quad(Vec3::new(-1.5, 0.0, -1.5), Vec3::X * 3.0, Vec3::Z * 3.0, pane);
    let scene = pieces.under_sky(Some(Environment::mapped(EnvironmentMap::new(64, 32, texels))));
    assert_same_light_with_less_noise(&scene, 0.2);
}

/// There paths find it without fail.
#[test]
fn photons_leave_an_even_sky_to_paths() {
    let scene = floor(Pieces::default()).sphere(1.0, glass(1.5)).under(Some(1.0));
    let of = |photons| {
        let settings = TraceSettings { photons, ..TraceSettings::DEFAULT };
        indirect_and_gathered(&render(&scene, &looking_down(SIZE), 64, &settings).0)[1]
    };
    let [with, without] = [TraceSettings::DEFAULT.photons, 0.0].map(of);
    assert!((with.0 / without.0 - 1.0).abs() < 0.01 && with.1 < 1.1 * without.1, "{with:?} {without:?}");
}

#[test]
fn paths_of_photons_are_no_longer_than_others() {
    let scene = under_lamp(floor(Pieces::default()).sphere(1.0, glass(1.5)));
    for max_depth in [1, 2, 3] {
        let settings = TraceSettings { max_depth, ..TraceSettings::DEFAULT };
        let [indirect, gathered] = indirect_and_gathered(&render(&scene, &looking_down(SIZE), 64, &settings).0);
        // A ball takes two interfaces; at its foot, what it reflects takes one.
        let error = 5.0 * (indirect.1 + gathered.1).sqrt();
        assert!((gathered.0 - indirect.0).abs() <= error, "{max_depth}: {gathered:?} {indirect:?}");
    }
}

#[test]
fn a_lamp_of_infinite_radiance_spoils_no_other() {
    let scene = |radiance: f32| {
        let glowing = floor(Pieces::default()).sphere(1.0, glass(1.5));
        // Far away, and shining upwards.
        under_lamp(glowing.quad(Vec3::new(90.0, 0.0, 0.0), Vec3::Z, Vec3::X, lamp(radiance)))
    };
    let [with, without] =
        [f32::INFINITY, 0.0].map(|radiance| render(&scene(radiance), &looking_down(SIZE), 16, &TraceSettings::DEFAULT));
    assert_eq!((with.1.not_finite, &with.0.components), (0, &without.0.components));
}

#[test]
fn where_something_moves_there_are_no_photons() {
    let motion = Motion { translate: glam::DVec3::X, turn: glam::DVec3::ZERO, centre: glam::DVec3::ZERO };
    let scene = under_lamp(floor(Pieces::default()).sphere(1.0, glass(1.5)).moving(motion));
    let of = |photons| render(&scene, &looking_down(SIZE), 8, &TraceSettings { photons, ..TraceSettings::DEFAULT });
    assert_eq!(of(1.0), of(0.0));
}
