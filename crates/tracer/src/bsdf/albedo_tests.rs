//! No surface reflects more than it receives, and sampling finds what quadrature finds.

use glam::{Vec2, Vec3};

use super::chi_square::integral;
use super::{Coated, Conductor, GlassAlbedo, Lobe, MetalAlbedo, RoughGlass};

const COSINES: [f32; 6] = [0.02, 0.1, 0.3, 0.6, 0.9, 1.0];
const ALPHAS: [f32; 5] = [0.05, 0.15, 0.35, 0.7, 1.0];

fn towards(cosine: f32) -> Vec3 {
    Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
}

/// Mean weight of samples over a midpoint grid; every lobe choice takes its turn.
fn sampled_albedo(lobe: &Lobe, outgoing: Vec3) -> f32 {
    const SIDE: usize = 160;
    let sum: f64 = (0..SIDE * SIDE)
        .map(|i| {
            let u = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
            let choice = (i * 7919 % 1021) as f32 / 1021.0;
            // What radiance loses by refraction is no loss of light.
            f64::from(lobe.sample_direction(outgoing, choice, u).map_or(0.0, |s| s.weight.x * s.eta * s.eta))
        })
        .sum();
    (sum / (SIDE * SIDE) as f64) as f32
}

/// ∫ f cos dω by the midpoint rule in θ and φ; φ = π s³ looks closely at the narrow reflections near the horizon.
fn integrated_albedo(lobe: &Lobe, outgoing: Vec3) -> f32 {
    const ROWS: usize = 700;
    const COLUMNS: usize = 120;
    let row = std::f32::consts::FRAC_PI_2 / ROWS as f32;
    let mut sum = 0.0_f64;
    for i in 0..ROWS {
        let (sin, cos) = ((i as f32 + 0.5) * row).sin_cos();
        for j in 0..COLUMNS {
            let s = (j as f32 + 0.5) / COLUMNS as f32;
            // Half the hemisphere: the other half is its mirror image.
            let (y, x) = (std::f32::consts::PI * (1.0 - s * s * s)).sin_cos();
            let step = 6.0 * std::f32::consts::PI * s * s / COLUMNS as f32;
            sum += f64::from(lobe.evaluate(outgoing, Vec3::new(sin * x, sin * y, cos)).x * sin * step);
        }
    }
    (sum * f64::from(row)) as f32
}

/// White glass with an index of `eta` beyond.
pub(super) fn clear_glass(eta: f32, alpha: f32, cosine: f32) -> Lobe {
    let albedo = GlassAlbedo::new(eta, Some(alpha)).directional(true, alpha, cosine);
    Lobe::RoughGlass(RoughGlass::new(eta, Vec3::ONE, alpha, albedo))
}

pub(super) fn metal(reflectance: Vec3, alpha: f32, cosine: f32) -> Lobe {
    let albedo = MetalAlbedo::new(Some(alpha)).directional(alpha, cosine);
    Lobe::Conductor(Conductor::new(reflectance, alpha, albedo))
}

fn for_each_angle_and_roughness(mut check: impl FnMut(f32, f32)) {
    for cosine in COSINES {
        for alpha in ALPHAS {
            check(cosine, alpha);
        }
    }
}

#[test]
fn metal_reflects_what_quadrature_says_and_never_more_than_everything() {
    for_each_angle_and_roughness(|cosine, alpha| {
        for reflectance in [0.3, 1.0] {
            let lobe = metal(Vec3::splat(reflectance), alpha, cosine);
            let sampled = sampled_albedo(&lobe, towards(cosine));
            let exact = integrated_albedo(&lobe, towards(cosine));
            assert!((sampled - exact).abs() < 3e-3, "{cosine} {alpha} {reflectance}: {sampled} {exact}");
            assert!(sampled <= 1.003, "{cosine} {alpha}: {sampled}");
        }
    });
}

/// The white furnace: what reflects or transmits everything loses nothing, at any roughness and angle.
#[test]
fn white_metal_and_clear_glass_lose_no_light() {
    const COSINES: [f32; 7] = [0.02, 0.07, 0.2, 0.4, 0.65, 0.9, 1.0];
    for alpha in [0.002, 0.01, 0.05, 0.15, 0.25, 0.35, 0.5, 0.7, 0.85, 1.0] {
        let range = |lobe: &dyn Fn(f32) -> Lobe| {
            let albedos = COSINES.map(|cosine| sampled_albedo(&lobe(cosine), towards(cosine)));
            albedos.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)])
        };
        let mirrors = MetalAlbedo::new(Some(alpha));
        let glass = GlassAlbedo::new(1.5, Some(alpha));
        let pane = |outside: bool, cosine: f32| {
            let albedo = glass.directional(outside, alpha, cosine);
            Lobe::RoughGlass(RoughGlass::new(if outside { 1.5 } else { 1.0 / 1.5 }, Vec3::ONE, alpha, albedo))
        };
        let metal = |cosine| Lobe::Conductor(Conductor::new(Vec3::ONE, alpha, mirrors.directional(alpha, cosine)));
        let ranges = [range(&metal), range(&|cosine| pane(true, cosine)), range(&|cosine| pane(false, cosine))];
        eprintln!("white furnace, α = {alpha}: metal, glass from outside and from inside {ranges:.4?}");
        for [least, most] in ranges {
            assert!(least > 0.99 && most < 1.005, "{alpha}: {least} to {most}");
        }
    }
}

#[test]
fn rough_glass_sends_on_what_quadrature_says() {
    for (eta, alpha, cosine) in [(1.5, 0.3, 0.9), (1.5, 0.7, 0.2), (1.0 / 1.5, 0.4, 0.6), (1.0 / 1.5, 1.0, 0.95)] {
        let outgoing = towards(cosine);
        let lobe = clear_glass(eta, alpha, cosine);
        let value =
            |incoming: Vec3| lobe.evaluate(outgoing, incoming).x * if incoming.z < 0.0 { eta * eta } else { 1.0 };
        let (sampled, exact) = (sampled_albedo(&lobe, outgoing), integral(value));
        assert!((f64::from(sampled) - exact).abs() < 5e-3, "{eta} {alpha} {cosine}: {sampled} {exact}");
    }
}

#[test]
fn coloured_metal_reflects_less_the_rougher_it_is() {
    let at = |alpha| sampled_albedo(&metal(Vec3::splat(0.5), alpha, 0.8), towards(0.8));
    // Light that is reflected twice is coloured twice.
    assert!(at(1.0) < at(0.5) && at(0.5) < at(0.1));
}

#[test]
fn coated_surfaces_reflect_what_coat_and_base_share_and_never_more_than_everything() {
    for_each_angle_and_roughness(|cosine, alpha| {
        for (diffuse, specular) in [(0.5, 0.04), (1.0, 0.04), (1.0, 0.5), (0.3, 1.0)] {
            let coated =
                |diffuse| Lobe::Coated(Coated::new(Vec3::splat(diffuse), Vec3::splat(specular), 0.0, alpha, cosine));
            let albedo = integrated_albedo(&coated(diffuse), towards(cosine));
            let coat = integrated_albedo(&coated(0.0), towards(cosine));
            let expected = coat + diffuse * (1.0 - coat);
            assert!((albedo - expected).abs() < 4e-3, "{cosine} {alpha} {diffuse} {specular}: {albedo} {expected}");
            assert!(albedo <= 1.005, "{cosine} {alpha} {diffuse} {specular}: {albedo}");
            let sampled = sampled_albedo(&coated(diffuse), towards(cosine));
            assert!((albedo - sampled).abs() < 4e-3, "{cosine} {alpha} {diffuse} {specular}: {albedo} {sampled}");
        }
    });
}

/// The white furnace of what is metal in part: base, coat and metal together lose nothing.
#[test]
fn white_surfaces_lose_no_light_however_metallic_they_are() {
    for_each_angle_and_roughness(|cosine, alpha| {
        for metallic in [0.0, 0.5, 0.996] {
            let lobe = Lobe::Coated(Coated::new(Vec3::ONE, Vec3::splat(0.04), metallic, alpha, cosine));
            let albedo = sampled_albedo(&lobe, towards(cosine));
            assert!((albedo - 1.0).abs() < 0.01, "{metallic} {alpha} {cosine}: {albedo}");
        }
    });
}

#[test]
fn a_black_coat_is_none() {
    let bare = Coated::new(Vec3::splat(0.5), Vec3::ZERO, 0.0, 0.3, 0.1);
    for incoming in [towards(0.1), towards(0.7)] {
        let value = Lobe::Coated(bare).evaluate(towards(0.1), incoming).x;
        assert!((value - 0.5 * incoming.z / std::f32::consts::PI).abs() < 1e-6, "{value}");
    }
}

#[test]
fn a_surface_becomes_metal_without_a_step() {
    let colour = Vec3::new(0.9, 0.6, 0.3);
    for_each_angle_and_roughness(|cosine, alpha| {
        let nearly = Lobe::Coated(Coated::new(colour, Vec3::splat(0.04), 0.9999, alpha, cosine));
        let outgoing = towards(cosine);
        // The mirrored direction and one off it.
        for incoming in [Vec3::new(-outgoing.x, 0.0, outgoing.z), Vec3::new(-0.3, 0.5, 0.66_f32.sqrt())] {
            let [a, b] = [&nearly, &metal(colour, alpha, cosine)].map(|lobe| lobe.evaluate(outgoing, incoming));
            assert!((a - b).length() < 0.01 * b.length() + 1e-4, "{alpha} {cosine}: {a} {b}");
        }
    });
}

#[test]
fn multiple_scattering_in_a_common_coat_hardly_shows() {
    for_each_angle_and_roughness(|cosine, alpha| {
        let coated = |k| Lobe::Coated(Coated::new(Vec3::splat(k), Vec3::splat(0.04), 0.0, alpha, cosine));
        let once = {
            // A coat whose facets reflect everything, which metal tells the share of.
            let albedo = MetalAlbedo::new(Some(alpha)).directional(alpha, cosine);
            integrated_albedo(&coated(0.0), towards(cosine)) / (1.0 + 0.04 * (1.0 - albedo) / albedo)
        };
        let now = integrated_albedo(&coated(0.5), towards(cosine));
        let before = once + 0.5 * (1.0 - once);
        eprintln!("alpha {alpha} cosine {cosine}: {before:.4} {now:.4} coat {once:.4}");
        assert!((now / before - 1.0).abs() < 0.01, "{alpha} {cosine}: {before} {now}");
    });
}
