//! No surface reflects more than it receives, and sampling finds what quadrature finds.

use glam::{Vec2, Vec3};

use super::{Coated, Conductor, Lobe};

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
            f64::from(lobe.sample_direction(outgoing, choice, u).map_or(0.0, |s| s.weight.x))
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
            let lobe = Lobe::Conductor(Conductor::new(Vec3::splat(reflectance), alpha));
            let sampled = sampled_albedo(&lobe, towards(cosine));
            let exact = integrated_albedo(&lobe, towards(cosine));
            assert!((sampled - exact).abs() < 3e-3, "{cosine} {alpha} {reflectance}: {sampled} {exact}");
            assert!(sampled <= 1.0, "{cosine} {alpha}: {sampled}");
        }
    });
}

#[test]
fn smooth_metal_reflects_nearly_everything() {
    for cosine in [0.3, 0.6, 1.0] {
        let lobe = Lobe::Conductor(Conductor::new(Vec3::ONE, 0.002));
        assert!((sampled_albedo(&lobe, towards(cosine)) - 1.0).abs() < 1e-3);
    }
}

#[test]
fn coated_surfaces_reflect_what_coat_and_base_share_and_never_more_than_everything() {
    for_each_angle_and_roughness(|cosine, alpha| {
        for (diffuse, specular) in [(0.5, 0.04), (1.0, 0.04), (1.0, 0.5), (0.3, 1.0)] {
            let coated =
                |diffuse| Lobe::Coated(Coated::new(Vec3::splat(diffuse), Vec3::splat(specular), alpha, cosine));
            let albedo = integrated_albedo(&coated(diffuse), towards(cosine));
            let coat = integrated_albedo(&coated(0.0), towards(cosine));
            let expected = coat + diffuse * (1.0 - coat);
            assert!((albedo - expected).abs() < 4e-3, "{cosine} {alpha} {diffuse} {specular}: {albedo} {expected}");
            assert!(albedo <= 1.002, "{cosine} {alpha} {diffuse} {specular}: {albedo}");
            let sampled = sampled_albedo(&coated(diffuse), towards(cosine));
            assert!((albedo - sampled).abs() < 4e-3, "{cosine} {alpha} {diffuse} {specular}: {albedo} {sampled}");
        }
    });
}
