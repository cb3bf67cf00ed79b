//! Every lobe samples the density it claims.

use glam::Vec3;

use super::chi_square::{integral, p_value};
use super::{Coated, Conductor, Diffuse, Lobe, RoughGlass, RoughPane};

/// All lobes that are not specular, seen with cosine `cosine`.
fn lobes(cosine: f32) -> Vec<(String, Lobe)> {
    let mut lobes = vec![("diffuse".into(), Lobe::Diffuse(Diffuse { reflectance: Vec3::splat(0.5) }))];
    for alpha in [0.1, 0.4, 0.7, 1.0] {
        lobes.push((
            format!("conductor {alpha}"),
            Lobe::Conductor(Conductor::new(Vec3::new(0.9, 0.6, 0.3), alpha, 0.9)),
        ));
        let pane = RoughPane::new(1.5, Vec3::new(0.9, 0.8, 0.7), alpha, 0.9);
        lobes.push((format!("pane {alpha}"), Lobe::RoughPane(pane)));
        for metallic in [0.0, 0.6] {
            let coated = Coated::new(Vec3::new(0.2, 0.5, 0.8), Vec3::splat(0.2), metallic, alpha, cosine);
            lobes.push((format!("coated {alpha} {metallic}"), Lobe::Coated(coated)));
        }
        // Smoother glass refracts into less than a cell of the quadrature.
        for eta in [1.5, 1.0 / 1.5].into_iter().filter(|_| alpha > 0.5) {
            let glass = RoughGlass::new(eta, Vec3::new(0.9, 0.8, 0.7), alpha, 0.8);
            lobes.push((format!("glass {eta} {alpha}"), Lobe::RoughGlass(glass)));
        }
    }
    lobes
}

fn directions() -> impl Iterator<Item = Vec3> {
    [0.05_f32, 0.3, 0.8, 1.0].into_iter().enumerate().map(|(i, z)| {
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * (i as f32).cos(), radius * (i as f32).sin(), z)
    })
}

#[test]
fn chi_square() {
    for outgoing in directions() {
        for (name, lobe) in lobes(outgoing.z) {
            let pdf = |incoming: Vec3| lobe.direction_pdf(outgoing, incoming);
            let sample = |random: &mut super::chi_square::Random| {
                let choice = random.next();
                lobe.sample_direction(outgoing, choice, random.point()).map(|s| s.incoming)
            };
            let p = p_value(pdf, sample);
            // 84 tests: with 1e-4 each, a right sampler passes all of them 992 times in 1,000 (Šidák).
            assert!(p > 1e-4, "{name}, outgoing {outgoing}: p = {p}");
        }
    }
}

#[test]
fn densities_integrate_to_the_share_of_samples_above_the_surface() {
    for outgoing in directions() {
        for (name, lobe) in lobes(outgoing.z) {
            const SIDE: usize = 128;
            let kept = (0..SIDE * SIDE)
                .filter(|i| {
                    let u = (glam::Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
                    let choice = (i * 7919 % 1021) as f32 / 1021.0;
                    lobe.sample_direction(outgoing, choice, u).is_some()
                })
                .count() as f64
                / (SIDE * SIDE) as f64;
            let total = integral(|incoming| lobe.direction_pdf(outgoing, incoming));
            assert!((total - kept).abs() < 5e-3, "{name}, outgoing {outgoing}: {total} against {kept}");
        }
    }
}

#[test]
fn a_sample_carries_its_own_density_and_weight() {
    let mut random = super::chi_square::Random(3);
    for outgoing in directions() {
        for (name, lobe) in lobes(outgoing.z) {
            for _ in 0..100 {
                let choice = random.next();
                let Some(s) = lobe.sample_direction(outgoing, choice, random.point()) else { continue };
                let pdf = s.pdf.unwrap();
                assert!((pdf / lobe.direction_pdf(outgoing, s.incoming) - 1.0).abs() < 1e-4, "{name}");
                let value = lobe.evaluate(outgoing, s.incoming);
                assert!((s.weight * pdf - value).length() < 1e-3 * value.length().max(1e-3), "{name}");
            }
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    let all: Vec<Vec3> = directions().collect();
    for a in &all {
        for b in &all {
            for ((name, there), (_, back)) in lobes(a.z).into_iter().zip(lobes(b.z)) {
                // What is compensated is not reciprocal; what lies below a coat is.
                let even = |lobe: &Lobe, outgoing, incoming| {
                    lobe.even_albedo().map(|_| lobe.even_share(outgoing, incoming) * lobe.evaluate(outgoing, incoming))
                };
                let Some((there, back)) = even(&there, *a, *b).zip(even(&back, *b, *a)) else { continue };
                // f·cos ÷ cos.
                let (there, back) = (there / b.z, back / a.z);
                assert!((there - back).length() <= 1e-4 * there.length(), "{name}: {there} {back}");
            }
        }
    }
}
