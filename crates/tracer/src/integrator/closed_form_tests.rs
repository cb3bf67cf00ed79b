//! Whole pictures against closed forms.

use std::sync::Arc;

use glam::Vec3;
use stack::{ComponentRole, FeatureRole, FeatureStack, Size};

use super::test_scenes::{
    Pieces, assert_scattered, diffuse, furnace, grey, indirect_and_gathered, lamp, looking_down, mean_of, peering,
    render,
};
use super::{DirectLight, FeatureHit, TraceSettings};
use crate::environment::{Environment, EnvironmentMap};
use crate::light::DeltaLight;
use crate::material::{Grey, Surface};
use crate::scene::Scene;
use crate::texture::{GreyTexture, Texture, Wrap};

const DEFAULT: TraceSettings = TraceSettings::DEFAULT;
const DOWN: Vec3 = Vec3::new(0.0, 0.0, 0.0);

/// Value of the first channel of a feature at the pixel `index`.
fn feature(stack: &FeatureStack, role: FeatureRole, index: usize) -> Vec<f32> {
    stack.feature(role).unwrap().estimate.mean.channels().iter().map(|c| c[index]).collect()
}

#[test]
fn a_diffuse_sphere_in_a_uniform_sky_shows_its_reflectance() {
    for reflectance in [0.0, 0.3, 1.0] {
        let (stack, report) = render(&furnace(reflectance), &looking_down(Size::new(16, 16)), 8, &DEFAULT);
        assert_eq!(report.not_finite, 0);
        for pixel in 0..256 {
            let [scattered, emission] = [ComponentRole::Scattered, ComponentRole::Emission]
                .map(|role| stack.component(role).unwrap().radiance.mean.channels()[0][pixel]);
            let surface = feature(&stack, FeatureRole::Normal, pixel)[1];
            // A pixel of sphere alone, or of sky alone; those on the border show both.
            if surface > 0.3 && pixel / 16 % 15 != 0 && pixel % 16 % 15 != 0 && emission == 0.0 {
                assert!((scattered - reflectance).abs() < 1e-3, "{pixel}: {scattered}");
            }
            if surface == 0.0 {
                assert_eq!((scattered, emission), (0.0, 1.0));
            }
        }
    }
}

/// Inside a glowing furnace every bounce adds its power of the reflectance.
#[test]
fn a_furnace_seen_from_inside_is_a_geometric_series() {
    for (surface, reflectance) in [(diffuse(0.5), 0.5), (Surface::Mirror { reflectance: grey(0.5) }, 0.5_f64)] {
        let scene = Pieces::default().sphere(-1.0, (surface, 1.0)).under(None);
        for max_depth in [0, 1, 3, 64] {
            let settings = TraceSettings { max_depth, ..DEFAULT };
            let (stack, _) = render(&scene, &peering(Vec3::ZERO, Vec3::new(0.3, 0.2, 1.0)), 512, &settings);
            let expected: f64 = (0..=max_depth as i32).map(|k| reflectance.powi(k)).sum();
            let [(a, error_a), (b, error_b)] = ComponentRole::ALL.map(|role| mean_of(&stack, role));
            let error = 4.0 * (error_a + error_b) + 1e-4;
            assert!((a + b - expected).abs() < error, "{max_depth}: {} ± {error} {expected}", a + b);
        }
    }
}

/// What arrives at the first surface from the second and those behind it: for a matt one from the third term of the
/// series on. Behind a mirror there are but mirrors, and all is emission.
#[test]
fn indirect_light_is_what_other_surfaces_send() {
    for (surface, reflectance) in [(diffuse(0.5), 0.5), (Surface::Mirror { reflectance: grey(0.5) }, 0.0_f64)] {
        let scene = Pieces::default().sphere(-1.0, (surface, 1.0)).under(None);
        for max_depth in [1, 3, 64] {
            let settings = TraceSettings { max_depth, ..DEFAULT };
            let (stack, _) = render(&scene, &peering(Vec3::ZERO, Vec3::new(0.3, 0.2, 1.0)), 512, &settings);
            let expected: f64 = (2..=max_depth as i32).map(|k| reflectance.powi(k)).sum();
            let indirect = &stack.indirect.as_ref().unwrap().mean.channels()[0];
            let mean = indirect.iter().map(|v| f64::from(*v)).sum::<f64>() / indirect.len() as f64;
            let error = 4.0 * mean_of(&stack, ComponentRole::Scattered).1 + 1e-4;
            assert!((mean - expected).abs() < error, "{max_depth}: {mean} ± {error} {expected}");
        }
    }
}

/// In a hall with a small lamp light is gathered on all walls: on average as bright, with half of the noise.
#[test]
fn gathered_light_is_indirect_light_with_less_noise() {
    let coated = Surface::Coated { diffuse: grey(0.5), specular: grey(0.05), alpha: 0.2 };
    for surface in [diffuse(0.5), coated] {
        let scene = Pieces::default()
            .sphere(-4.0, (surface, 0.0))
            .quad(Vec3::new(0.5, 0.0, -1.0), Vec3::X * 0.2, Vec3::Z * 0.2, lamp(50.0))
            .under(None);
        let (stack, _) = render(&scene, &looking_down(Size::new(32, 32)), 64, &DEFAULT);
        let [indirect, gathered] = indirect_and_gathered(&stack);
        assert!((gathered.0 - indirect.0).abs() < 4.0 * indirect.1.sqrt(), "{gathered:?} {indirect:?}");
        assert!(gathered.1 < 0.6 * indirect.1, "{gathered:?} {indirect:?}");
    }
}

/// Where both are, light is gathered at what is diffuse.
#[test]
fn no_light_is_lost_between_coated_and_diffuse_surfaces() {
    let coated = Surface::Coated { diffuse: grey(0.4), specular: grey(0.3), alpha: 0.1 };
    let scene = Pieces::default()
        .sphere(-4.0, (diffuse(0.7), 0.0))
        .sphere(1.0, (coated, 0.0))
        .quad(Vec3::new(1.5, 3.0, 0.0), Vec3::X, Vec3::Z, lamp(20.0))
        .under(None);
    let (stack, _) = render(&scene, &looking_down(Size::new(32, 32)), 256, &DEFAULT);
    let [indirect, gathered] = indirect_and_gathered(&stack);
    let error = 4.0 * (indirect.1 + gathered.1).sqrt();
    assert!(error < 0.02 * indirect.0 && (gathered.0 - indirect.0).abs() < error, "{gathered:?} {indirect:?}");
}

/// Form factor from a point to a rectangle a × b parallel to its plane, at distance c above, one corner above the
/// point (Howell's catalogue of configuration factors, B-3).
fn corner_form_factor(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / std::f64::consts::TAU
}

/// A floor of reflectance 0.5 under a lamp 2 × 1 at height 1.5.
fn lit_floor(sky: Option<f32>) -> Scene {
    Pieces::default()
        .quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, (diffuse(0.5), 0.0))
        .quad(Vec3::new(-1.0, 1.5, -0.5), Vec3::X * 2.0, Vec3::Z, lamp(3.0))
        .under(sky)
}

#[test]
fn a_floor_under_a_lamp_is_as_bright_as_the_form_factor_says() {
    let expected = 0.5 * 3.0 * 4.0 * corner_form_factor(1.0, 0.5, 1.5);
    for direct_light in [DirectLight::Both, DirectLight::Lights, DirectLight::Surfaces] {
        let settings = TraceSettings { direct_light, ..DEFAULT };
        let (stack, _) = render(&lit_floor(None), &peering(Vec3::new(3.0, 1.0, 0.0), DOWN), 1024, &settings);
        assert_scattered(&stack, expected, 1e-4);
        assert_eq!(mean_of(&stack, ComponentRole::Emission).0, 0.0);
        assert_eq!(feature(&stack, FeatureRole::Visibility, 5), [1.0]);
        assert!((feature(&stack, FeatureRole::Depth, 5)[0] - 10.0_f32.sqrt()).abs() < 1e-3);
    }
}

/// E = I cos θ/d² of the point, E cos θ of the sun; beside a lamp and a sky each adds what it does alone.
#[test]
fn lights_that_no_ray_hits_add_their_irradiance() {
    let point = DeltaLight::Point { position: Vec3::new(1.0, 1.2, 0.5), intensity: Vec3::splat(2.0) };
    let sun = Vec3::new(-1.0, -3.0, 0.0).normalize();
    let sun = DeltaLight::Sun { direction: sun, irradiance: Vec3::splat(1.5), angle: 0.01 };
    let of_point = 2.0 * 1.2 / (1.0_f64 + 1.2 * 1.2 + 0.25).powf(1.5);
    let of_sun = 1.5 * 3.0 / 10.0_f64.sqrt();
    let camera = peering(Vec3::new(3.0, 1.0, 0.0), DOWN);
    let seen = |mut scene: Scene, lights: &[DeltaLight], direct_light| {
        scene.delta_lights = lights.to_vec();
        render(&scene, &camera, 1024, &TraceSettings { direct_light, ..DEFAULT }).0
    };
    let floor = || {
        let floor = (diffuse(0.5), 0.0);
        Pieces::default().quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, floor)
    };
    for direct_light in [DirectLight::Both, DirectLight::Lights] {
        let expected = |irradiance: f64| 0.5 * irradiance / std::f64::consts::PI;
        assert_scattered(&seen(floor().under(None), &[point], direct_light), expected(of_point), 1e-5);
        assert_scattered(&seen(floor().under(None), &[point, sun], direct_light), expected(of_point + of_sun), 1e-4);
        // The lamp hides neither light from the point seen.
        let others = 0.5 * 3.0 * 4.0 * corner_form_factor(1.0, 0.5, 1.5);
        let high = DeltaLight::Point { position: Vec3::new(4.0, 2.0, 0.0), intensity: Vec3::splat(9.0) };
        let of_high = 9.0 * 2.0 / 20.0_f64.powf(1.5);
        let both = seen(lit_floor(None), &[high], direct_light);
        assert_scattered(&both, others + expected(of_high), 1e-4);
        let under_sky = seen(floor().under(Some(0.3)), &[point], direct_light);
        assert_scattered(&under_sky, 0.5 * 0.3 + expected(of_point), 1e-4);
    }
    let dark = seen(floor().under(None), &[point], DirectLight::Surfaces);
    assert_eq!(mean_of(&dark, ComponentRole::Scattered).0, 0.0);
}

/// A map of `radiance` everywhere.
fn flat_map(radiance: f32) -> Environment {
    Environment::mapped(EnvironmentMap::new(16, 8, vec![[radiance; 3]; 128]))
}

#[test]
fn a_flat_map_is_a_constant_sky() {
    let floor = |sky| {
        Pieces::default()
            .quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, (diffuse(0.5), 0.0))
            .quad(Vec3::new(1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::Y * 2.0, (diffuse(0.3), 0.0))
            .under_sky(Some(sky))
    };
    let camera = peering(Vec3::new(-3.0, 1.0, 0.0), Vec3::new(0.5, 0.0, 0.0));
    let mean = |sky, direct_light| {
        let settings = TraceSettings { direct_light, ..DEFAULT };
        mean_of(&render(&floor(sky), &camera, 1024, &settings).0, ComponentRole::Scattered)
    };
    let constant = mean(Environment::constant(Vec3::splat(2.0)), DirectLight::Both);
    for direct_light in [DirectLight::Both, DirectLight::Lights, DirectLight::Surfaces] {
        assert_agree(mean(flat_map(2.0), direct_light), constant);
    }
}

/// A floor under a map that is bright in one texel: the sum over the texel's bilinear hat, here by fine quadrature in
/// f64 over u and v of L cos θ, the floor's irradiance.
#[test]
fn a_floor_under_a_map_with_one_bright_texel_is_as_bright_as_the_integral_says() {
    let (width, height) = (32_usize, 16_usize);
    let (column, row, peak) = (20_usize, 3_usize, 100.0_f64);
    let mut texels = vec![[0.0; 3]; width * height];
    texels[row * width + column] = [peak as f32; 3];
    let hat = |i: usize, at: f64| (1.0 - (at - i as f64 - 0.5).abs()).max(0.0);
    let (mut irradiance, fine) = (0.0, 64);
    for j in 0..height * fine / 2 {
        for i in 0..width * fine {
            let (x, y) = ((i as f64 + 0.5) / fine as f64, (j as f64 + 0.5) / fine as f64);
            let (sin, cos) = (std::f64::consts::PI * y / height as f64).sin_cos();
            irradiance += peak * hat(column, x) * hat(row, y) * cos * sin;
        }
    }
    let pi = std::f64::consts::PI;
    irradiance *= 2.0 * pi / (width * fine) as f64 * pi / (height * fine) as f64;
    let sky = Environment::mapped(EnvironmentMap::new(width, height, texels)).turned_to(200.0);
    let scene = Pieces::default()
        .quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, (diffuse(0.5), 0.0))
        .under_sky(Some(sky));
    for direct_light in [DirectLight::Both, DirectLight::Lights] {
        let settings = TraceSettings { direct_light, ..DEFAULT };
        let (stack, _) = render(&scene, &peering(Vec3::new(3.0, 1.0, 0.0), DOWN), 2048, &settings);
        let (mean, error) = mean_of(&stack, ComponentRole::Scattered);
        assert!(error < 3e-3 * mean, "too noisy to tell: {mean} ± {error}");
        assert_scattered(&stack, 0.5 * irradiance / pi, 0.0);
    }
}

#[test]
fn mirrors_and_glass_keep_all_light_of_a_uniform_sky() {
    for (surface, slack) in [
        (Surface::Mirror { reflectance: grey(1.0) }, 1e-6),
        (Surface::Conductor { reflectance: grey(1.0), alpha: 1e-4 }, 1e-6),
        (Surface::Glass { ior: 1.5, transmittance: grey(1.0), alpha: 0.0 }, 1e-4),
        (Surface::Glass { ior: 1.0, transmittance: grey(1.0), alpha: 0.0 }, 1e-6),
        (Surface::Glass { ior: 1.0, transmittance: grey(1.0), alpha: 0.09 }, 1e-6),
        (Surface::ThinGlass { ior: 1.5, transmittance: grey(1.0), alpha: 0.0 }, 1e-6),
    ] {
        let scene = Pieces::default().sphere(1.0, (surface, 0.0)).under(Some(1.0));
        let settings = TraceSettings { max_depth: 1000, ..DEFAULT };
        let (stack, _) = render(&scene, &looking_down(Size::new(24, 24)), 16, &settings);
        let emission = &stack.component(ComponentRole::Emission).unwrap().radiance.mean;
        for value in &emission.channels()[0] {
            assert!((value - 1.0).abs() < slack, "{value}");
        }
        assert_eq!(mean_of(&stack, ComponentRole::Scattered).0, 0.0);
    }
}

/// A straight way through a slab of glass that does not bend light, and back from a white wall in it that a lamp in it lights:
/// all that absorbs is the way, by Beer's and Lambert's law.
#[test]
fn light_is_absorbed_along_its_way_through_coloured_glass() {
    let wide = 40.0;
    let glass = || (Surface::Glass { ior: 1.0, transmittance: grey(1.0), alpha: 0.0 }, 0.0);
    let level = |pieces: Pieces, y: f32, up: bool, what: (Surface, f32)| {
        let [a, b] = if up { [Vec3::Z, Vec3::X] } else { [Vec3::X, Vec3::Z] };
        let mut with = pieces.quad(Vec3::new(-wide / 2.0, y, -wide / 2.0), wide * a, wide * b, what);
        with.last_material().maps.absorption = Vec3::splat(0.5);
        with
    };
    let slab = level(level(Pieces::default(), 2.0, true, glass()), 0.0, false, glass());
    let camera = peering(Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO);
    let (stack, _) = render(&slab.under(Some(1.0)), &camera, 8, &DEFAULT);
    assert!((mean_of(&stack, ComponentRole::Emission).0 - (-1.0_f64).exp()).abs() < 1e-5);
    // A floor that shines, seen through glass above it.
    let shining = level(level(Pieces::default(), 2.0, true, glass()), 0.0, true, lamp(1.0)).under(None);
    let (stack, _) = render(&shining, &camera, 8, &DEFAULT);
    assert!((mean_of(&stack, ComponentRole::Emission).0 - (-1.0_f64).exp()).abs() < 1e-5);
    // A small lamp at height 1 lights the floor; paths and lamp samples find the same.
    let lamp = lamp(10_000.0);
    for direct_light in [DirectLight::Both, DirectLight::Lights, DirectLight::Surfaces] {
        let lit = level(level(Pieces::default(), 2.0, true, glass()), 0.0, true, (diffuse(0.5), 0.0));
        let side = 0.1;
        let at = Vec3::new(0.5, 1.0, 0.0);
        let lit = lit.quad(at - side / 2.0 * (Vec3::X + Vec3::Z), side * Vec3::X, side * Vec3::Z, lamp.clone());
        let settings = TraceSettings { max_depth: 2, direct_light, ..DEFAULT };
        let samples = if direct_light == DirectLight::Surfaces { 1 << 17 } else { 1 << 12 };
        let (stack, _) = render(&lit.under(None), &camera, samples, &settings);
        let squared = 1.25_f64;
        let irradiance = 10_000.0 * f64::from(side * side) / squared / squared;
        let way = squared.sqrt() + 2.0;
        assert_scattered(&stack, 0.5 * irradiance / std::f64::consts::PI * (-0.5 * way).exp(), 0.02);
    }
}

#[test]
fn rough_white_surfaces_neither_gain_nor_lose_light() {
    for alpha in [0.01, 0.1, 0.4, 1.0] {
        for surface in [
            Surface::Conductor { reflectance: grey(1.0), alpha },
            Surface::Coated { diffuse: grey(1.0), specular: grey(0.04), alpha },
            Surface::Coated { diffuse: grey(1.0), specular: grey(0.6), alpha },
            Surface::Glass { ior: 1.5, transmittance: grey(1.0), alpha },
            Surface::ThinGlass { ior: 1.5, transmittance: grey(1.0), alpha },
        ] {
            let scene = Pieces::default().sphere(1.0, (surface.clone(), 0.0)).under(Some(1.0));
            let (stack, _) = render(
                &scene,
                &peering(Vec3::new(0.0, 3.0, 0.0), Vec3::new(0.3, 0.9, 0.2)),
                512,
                &TraceSettings { max_depth: 500, ..DEFAULT },
            );
            let (mean, error) = mean_of(&stack, ComponentRole::Scattered);
            assert!(mean < 1.002 + 4.0 * error, "{surface:?}: {mean} ± {error}");
            assert!(mean > 0.99 - 4.0 * error, "{surface:?}: {mean} ± {error}");
        }
    }
}

/// A lamp whose left half is half as bright and whose right half is half a hole emits like one of half the radiance. The
/// texture is so wide that its blended seams do not matter.
#[test]
fn lamps_with_textures_and_holes_shine_as_much_as_there_is_of_them() {
    let half = |left: f32, right: f32| (0..64).map(move |i| if i < 32 { left } else { right });
    let mut pieces = Pieces::default()
        .quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, (diffuse(0.5), 0.0))
        .quad(Vec3::new(-1.0, 1.5, -0.5), Vec3::X * 2.0, Vec3::Z, lamp(6.0));
    let lamp = pieces.last_material();
    let bright = Texture { wrap: [Wrap::Clamp; 2], ..Texture::new(64, 1, half(0.5, 1.0).map(|c| [c; 3]).collect()) };
    lamp.emission.texture = Some(Arc::new(bright));
    let holes = GreyTexture { wrap: [Wrap::Clamp; 2], ..GreyTexture::new(64, 1, half(1.0, 0.5).collect()) };
    lamp.maps.opacity = Some(Grey { factor: 1.0, texture: Some(Arc::new(holes)) });
    let scene = pieces.under(None);
    let expected = 0.5 * 3.0 * 4.0 * corner_form_factor(1.0, 0.5, 1.5);
    for direct_light in [DirectLight::Both, DirectLight::Lights, DirectLight::Surfaces] {
        let settings = TraceSettings { direct_light, ..DEFAULT };
        let (stack, _) = render(&scene, &peering(Vec3::new(3.0, 1.0, 0.0), DOWN), 1024, &settings);
        assert_scattered(&stack, expected, 3e-3);
    }
}

/// Under a veil of opacity 0.25 that is black, three quarters of the light arrive, and three quarters of it are seen
/// through the veil.
#[test]
fn a_black_veil_dims_what_it_hangs_before() {
    let mut pieces = Pieces::default()
        .quad(Vec3::new(-50.0, 0.0, 50.0), Vec3::X * 100.0, -Vec3::Z * 100.0, (diffuse(0.5), 0.0))
        .quad(Vec3::new(-50.0, 1.0, 50.0), Vec3::X * 100.0, -Vec3::Z * 100.0, (diffuse(0.0), 0.0));
    pieces.last_material().maps.opacity = Some(Grey::constant(0.25));
    let scene = pieces.under(Some(1.0));
    let (stack, _) = render(&scene, &peering(Vec3::new(0.3, 3.0, 0.0), DOWN), 1024, &DEFAULT);
    assert_scattered(&stack, 0.5 * 0.75 * 0.75, 1e-3);
}

/// A scene in which every technique matters: lamp, sky, gloss, glass and several bounces.
fn busy() -> Scene {
    Pieces::default()
        .quad(Vec3::new(-3.0, -1.0, 3.0), Vec3::X * 6.0, -Vec3::Z * 6.0, (diffuse(0.7), 0.0))
        .quad(
            Vec3::new(-3.0, -1.0, -2.0),
            Vec3::X * 6.0,
            Vec3::Y * 4.0,
            (Surface::Conductor { reflectance: grey(0.8), alpha: 0.3 }, 0.0),
        )
        .quad(
            Vec3::new(-2.0, -1.0, -2.0),
            Vec3::Y * 4.0,
            Vec3::Z * 4.0,
            (Surface::Coated { diffuse: grey(0.5), specular: grey(0.3), alpha: 0.3 }, 0.0),
        )
        .quad(Vec3::new(-1.0, 2.5, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0, lamp(4.0))
        .sphere(0.6, (Surface::Glass { ior: 1.4, transmittance: grey(0.9), alpha: 0.0 }, 0.0))
        .under(Some(0.3))
}

fn busy_mean(settings: TraceSettings) -> (f64, f64) {
    scene_mean(&busy(), settings)
}

fn scene_mean(scene: &Scene, settings: TraceSettings) -> (f64, f64) {
    let camera = crate::camera::CameraDescription::looking(Vec3::new(1.0, 1.0, 5.0), Vec3::ZERO);
    let (stack, report) = render(scene, &camera.on(Size::new(12, 12)).unwrap(), 512, &settings);
    assert_eq!(report.not_finite, 0);
    mean_of(&stack, ComponentRole::Scattered)
}

fn assert_agree(a: (f64, f64), b: (f64, f64)) {
    assert!((a.0 - b.0).abs() < 4.0 * a.1.hypot(b.1), "{a:?} {b:?}");
    assert!(a.1 < 0.02 * a.0 && b.1 < 0.02 * b.0, "too noisy to tell: {a:?} {b:?}");
}

#[test]
fn all_ways_of_finding_direct_light_agree() {
    let [both, lights, surfaces] = [DirectLight::Both, DirectLight::Lights, DirectLight::Surfaces]
        .map(|direct_light| busy_mean(TraceSettings { direct_light, seed: direct_light as u64, ..DEFAULT }));
    assert_agree(both, lights);
    assert_agree(both, surfaces);
    assert!(both.1 < lights.1.min(surfaces.1), "combining should not add noise: {both:?} {lights:?} {surfaces:?}");
}

/// A frosted pane between camera, lamp and sky, under a map.
#[test]
fn all_ways_of_finding_light_through_rough_glass_agree() {
    for sky in [Environment::constant(Vec3::splat(0.3)), sloping_map()] {
        let scene = Pieces::default()
            .quad(Vec3::new(-3.0, -1.0, 3.0), Vec3::X * 6.0, -Vec3::Z * 6.0, (diffuse(0.7), 0.0))
            .quad(Vec3::new(-1.0, 2.5, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0, lamp(4.0))
            .sphere(0.9, (Surface::Glass { ior: 1.5, transmittance: grey(0.9), alpha: 0.4 }, 0.0))
            .under_sky(Some(sky));
        let [both, lights, surfaces] =
            [DirectLight::Both, DirectLight::Lights, DirectLight::Surfaces].map(|direct_light| {
                scene_mean(&scene, TraceSettings { direct_light, seed: direct_light as u64, ..DEFAULT })
            });
        assert_agree(both, lights);
        assert_agree(both, surfaces);
    }
}

/// A map that is brighter towards one side, and has a sun.
fn sloping_map() -> Environment {
    let mut texels: Vec<[f32; 3]> = (0..512).map(|i| [(i % 32) as f32 / 32.0; 3]).collect();
    texels[100] = [50.0; 3];
    Environment::mapped(EnvironmentMap::new(32, 16, texels))
}

#[test]
fn roulette_changes_no_mean() {
    let with = busy_mean(TraceSettings { roulette_depth: 0, ..DEFAULT });
    let without = busy_mean(TraceSettings { roulette_depth: 4096, seed: 1, ..DEFAULT });
    assert_agree(with, without);
}

/// Lamp and mirror side by side, a floor below.
#[test]
fn emission_is_what_is_seen_directly_or_through_mirrors() {
    let scene = Pieces::default()
        .quad(
            Vec3::new(-1.0, -1.0, -2.0),
            Vec3::X * 2.0,
            Vec3::Y * 2.0,
            (Surface::Mirror { reflectance: grey(0.5) }, 0.0),
        )
        .quad(Vec3::new(-4.0, -4.0, 6.0), Vec3::Y * 8.0, Vec3::X * 8.0, lamp(2.0))
        .quad(Vec3::new(3.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0, (diffuse(0.5), 0.0))
        .under(None);
    let eye = Vec3::new(0.0, 0.0, 3.0);
    for (target, scattered, emission, normal) in [
        // Into the lamp, into its image, onto the diffuse wall.
        (Vec3::new(0.5, 0.5, 6.0), false, 2.0, -Vec3::Z),
        (Vec3::new(0.5, 0.5, -2.0), false, 1.0, -Vec3::Z),
        (Vec3::new(4.0, 0.0, -2.0), true, 0.0, Vec3::Z),
    ] {
        let (stack, _) = render(&scene, &peering(eye, target), 64, &DEFAULT);
        assert_eq!(mean_of(&stack, ComponentRole::Emission).0, emission, "{target}");
        assert_eq!(mean_of(&stack, ComponentRole::Scattered).0 > 0.0, scattered, "{target}");
        assert_eq!(feature(&stack, FeatureRole::Normal, 0), normal.to_array(), "{target}");
        let depth = feature(&stack, FeatureRole::Depth, 0)[0];
        assert!((depth / eye.distance(target) - 1.0).abs() < 1e-3, "{target}: {depth}");
    }
}

#[test]
fn features_look_through_mirrors_unless_told_not_to() {
    let scene = Pieces::default()
        .quad(
            Vec3::new(-1.0, -1.0, -2.0),
            Vec3::X * 2.0,
            Vec3::Y * 2.0,
            (Surface::Mirror { reflectance: grey(0.9) }, 0.0),
        )
        .quad(Vec3::new(-9.0, -9.0, 4.0), Vec3::Y * 18.0, Vec3::X * 18.0, (diffuse(0.25), 0.0))
        .under(None);
    let camera = peering(Vec3::new(0.0, 0.0, 2.0), Vec3::new(0.0, 0.0, -2.0));
    let (stack, _) = render(&scene, &camera, 8, &DEFAULT);
    assert!((feature(&stack, FeatureRole::Albedo, 0)[0] - 0.25).abs() < 1e-6);
    assert!((feature(&stack, FeatureRole::Position, 0)[2] - 4.0).abs() < 1e-4);
    assert!((feature(&stack, FeatureRole::Depth, 0)[0] - 4.0).abs() < 1e-4);
    let first = TraceSettings { feature_hit: FeatureHit::First, ..DEFAULT };
    let (stack, _) = render(&scene, &camera, 8, &first);
    assert!((feature(&stack, FeatureRole::Albedo, 0)[0] - 0.9).abs() < 1e-6);
    assert!((feature(&stack, FeatureRole::Position, 0)[2] + 2.0).abs() < 1e-4);
}

#[test]
fn visibility_tells_light_from_shadow() {
    let scene = Pieces::default()
        .quad(Vec3::new(-9.0, 0.0, 9.0), Vec3::X * 18.0, -Vec3::Z * 18.0, (diffuse(0.5), 0.0))
        .quad(Vec3::new(-0.1, 4.0, -0.1), Vec3::X * 0.2, Vec3::Z * 0.2, lamp(9.0))
        .quad(Vec3::new(-1.0, 2.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0, (diffuse(0.0), 0.0))
        .quad(Vec3::new(6.0, 5.0, -1.0), Vec3::X, Vec3::Z, (diffuse(0.0), 0.0))
        .under(None);
    for max_depth in [0, 1] {
        let settings = TraceSettings { max_depth, ..DEFAULT };
        let seen = |eye: Vec3, at: Vec3| {
            let (stack, _) = render(&scene, &peering(eye, at), 8, &settings);
            feature(&stack, FeatureRole::Visibility, 3)[0]
        };
        assert_eq!(seen(Vec3::new(8.0, 1.0, 0.0), Vec3::new(0.5, 0.0, 0.0)), 0.0, "in the shadow");
        assert_eq!(seen(Vec3::new(8.0, 1.0, 0.0), Vec3::new(5.0, 0.0, 0.0)), 1.0, "in the light");
        assert_eq!(seen(Vec3::new(6.5, 8.0, 0.0), Vec3::new(6.5, 5.0, -0.5)), 0.0, "facing away from the light");
    }
}

/// Of a matt floor below a ceiling, cosines are distributed as 2c, and the ceiling lies h/c away.
#[test]
fn proximity_is_that_of_the_surface_a_path_meets_next() {
    let floor =
        |pieces: Pieces| pieces.quad(Vec3::new(-9.0, 0.0, 9.0), Vec3::X * 18.0, -Vec3::Z * 18.0, (diffuse(0.5), 0.0));
    let ceiling = |pieces: Pieces, height: f32, reflects: f32| {
        pieces.quad(Vec3::new(-4e3, height, -4e3), Vec3::X * 8e3, Vec3::Z * 8e3, (diffuse(reflects), 0.0))
    };
    let seen = |scene: &Scene, max_depth: u32| {
        let settings = TraceSettings { max_depth, ..DEFAULT };
        let camera = peering(Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 0.1));
        let (stack, _) = render(scene, &camera, 4096, &settings);
        let mean = |role| (0..16).map(|pixel| feature(&stack, role, pixel)[0]).sum::<f32>() / 16.0;
        [FeatureRole::Proximity, FeatureRole::Lit].map(mean)
    };
    let depth = Vec3::new(0.0, 2.0, 0.1).length();
    for height in [2.5, 20.0] {
        let a = f64::from(height / (0.03 * depth));
        let expected = (1.0 - 2.0 * a + 2.0 * a * a * ((1.0 + a) / a).ln()) as f32;
        let scene = ceiling(floor(Pieces::default()), height, 0.5).under(None);
        let [near, lit] = seen(&scene, 2);
        assert!((near - expected).abs() < 0.02 * expected, "{near} {expected}");
        assert_eq!(lit, 0.0, "there is no light");
        assert_eq!(seen(&scene, 0), [0.0; 2], "paths end at the floor");
    }
    assert_eq!(seen(&floor(Pieces::default()).under(Some(1.0)), 2), [0.0; 2], "nothing but the sky comes next");
}

#[test]
fn next_surfaces_are_lit_where_light_samples_reach_them() {
    let room = |lamp_above: bool| {
        let edge = if lamp_above { (Vec3::X, Vec3::Z) } else { (Vec3::Z, Vec3::X) };
        Pieces::default()
            .quad(Vec3::new(-9.0, 0.0, 9.0), Vec3::X * 18.0, -Vec3::Z * 18.0, (diffuse(0.5), 0.0))
            .quad(Vec3::new(-4e3, 5.0, -4e3), Vec3::X * 8e3, Vec3::Z * 8e3, (diffuse(0.5), 0.0))
            .quad(Vec3::new(2.0, 3.0, 2.0), edge.0, edge.1, lamp(9.0))
            .under(None)
    };
    let lit = |scene: Scene| {
        let (stack, _) = render(&scene, &peering(Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 0.1)), 512, &DEFAULT);
        (0..16).map(|pixel| feature(&stack, FeatureRole::Lit, pixel)[0]).sum::<f32>() / 16.0
    };
    // Rays that meet the lamp itself meet no light.
    let [down, up] = [lit(room(true)), lit(room(false))];
    assert!(down == 0.0 && up > 0.9, "{down} {up}");
}

#[test]
fn a_miss_has_the_features_of_a_miss() {
    let (stack, _) = render(&furnace(0.5), &peering(Vec3::new(0.0, 0.0, 1.2), Vec3::new(0.0, 0.0, 9.0)), 8, &DEFAULT);
    assert_eq!(feature(&stack, FeatureRole::Normal, 0), [0.0; 3]);
    assert_eq!(feature(&stack, FeatureRole::Albedo, 0), [1.0; 3]);
    assert_eq!(feature(&stack, FeatureRole::Visibility, 0), [1.0]);
    assert_eq!(feature(&stack, FeatureRole::Proximity, 0), [0.0]);
    let radius = 3.0_f32.sqrt();
    assert!((feature(&stack, FeatureRole::Position, 0)[2] - radius).abs() < 1e-3);
    assert!((feature(&stack, FeatureRole::Depth, 0)[0] - (radius - 1.2)).abs() < 1e-3);
}

#[test]
fn samples_that_are_not_finite_are_counted_and_count_as_zero() {
    let scene = Pieces::default()
        .quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0, (diffuse(0.5), f32::INFINITY))
        .under(None);
    let (stack, report) = render(&scene, &peering(Vec3::new(0.0, 3.0, 1.0), DOWN), 8, &DEFAULT);
    assert_eq!((report.samples, report.not_finite), (128, 128));
    assert_eq!(stack.beauty().rgb(0), [0.0; 3]);
    assert_eq!(feature(&stack, FeatureRole::Albedo, 0), [0.5; 3]);
}
