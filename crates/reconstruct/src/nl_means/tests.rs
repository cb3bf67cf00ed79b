//! Non-local means against their formula, and on pictures whose result is known.

use stack::Silent;

use super::*;
use crate::patch_distance::tests::{distance_twin, random_planes};
use crate::patch_distance::{NoisyPlanes, PatchComparison};
use crate::test_noise::TestNoise;

const COMPARISON: PatchComparison = PatchComparison { patch_radius: 1, epsilon: 1e-6, noise_taken_off: 1.0 };

fn guide<'a>(size: Size, [values, variances]: [&'a [Vec<f32>]; 2], radius: usize) -> Guide<'a> {
    Guide { planes: NoisyPlanes { size, values, variances }, comparison: COMPARISON, radius }
}

/// Σ k v/Σ k over the window of pixel `c`, in double precision.
fn twin(guide: &Guide, bandwidth: f64, source: &[f32], c: [isize; 2]) -> f64 {
    let (size, reach) = (guide.planes.size, guide.radius as isize);
    let (mut sum, mut total) = (0.0, 0.0);
    for q in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [c[0] + dx, c[1] + dy])) {
        if (0..size.width as isize).contains(&q[0]) && (0..size.height as isize).contains(&q[1]) {
            let kernel = (-distance_twin(guide.planes, c, q, guide.comparison) / (bandwidth * bandwidth)).exp();
            sum += kernel * f64::from(source[size.index(q[0] as usize, q[1] as usize)]);
            total += kernel;
        }
    }
    sum / total
}

#[test]
fn agree_with_the_formula_at_every_pixel() {
    let size = Size::new(12, 10);
    let [values, variances] = random_planes(size, 3, 21);
    let guide = guide(size, [&values, &variances], 3);
    let sources = [values[0].clone(), TestNoise(3).normals(size.pixels(), 2.0, 1.0)];
    let means = nl_means(&guide, 0.7, &sources, &Silent).unwrap();
    for (source, mean) in sources.iter().zip(&means) {
        for (i, mean) in mean.iter().enumerate() {
            let expected = twin(&guide, 0.7, source, [(i % 12) as isize, (i / 12) as isize]);
            assert!((f64::from(*mean) - expected).abs() < 2e-5 * (1.0 + expected.abs()), "{i}: {mean} {expected}");
        }
    }
}

#[test]
fn agree_with_the_formula_across_tiles() {
    let size = Size::new(TILE + 5, TILE + 3);
    let [values, variances] = random_planes(size, 1, 22);
    let guide = guide(size, [&values, &variances], 2);
    let means = nl_means(&guide, 1.0, &values, &Silent).unwrap();
    for [x, y] in [[TILE - 1, 5], [TILE, TILE], [TILE + 4, TILE + 2], [TILE - 2, TILE + 1]] {
        let (mean, expected) = (means[0][size.index(x, y)], twin(&guide, 1.0, &values[0], [x as isize, y as isize]));
        assert!((f64::from(mean) - expected).abs() < 2e-5, "{x} {y}: {mean} {expected}");
    }
}

#[test]
fn constants_stay_whatever_the_guide() {
    let size = Size::new(17, 9);
    let [values, variances] = random_planes(size, 3, 23);
    let means = nl_means(&guide(size, [&values, &variances], 4), 0.5, &[vec![0.7; size.pixels()]], &Silent).unwrap();
    assert!(means[0].iter().all(|v| (v - 0.7).abs() < 1e-6));
}

#[test]
fn noise_shrinks_as_many_times_as_pixels_have_weight() {
    let size = Size::new(60, 60);
    let flat = [vec![vec![0.0; size.pixels()]], vec![vec![1.0; size.pixels()]]];
    let noisy = TestNoise(24).normals(size.pixels(), 0.0, 1.0);
    let means = nl_means(&guide(size, [&flat[0], &flat[1]], 2), 1.0, &[noisy], &Silent).unwrap();
    let inner = (0..size.pixels()).filter(|i| (2..58).contains(&(i % 60)) && (2..58).contains(&(i / 60)));
    let variance = inner.map(|i| means[0][i] * means[0][i]).sum::<f32>() / (56.0 * 56.0);
    assert!((variance * 25.0 - 1.0).abs() < 0.15, "25 pixels of weight one leave 1/25, not {variance}");
}

#[test]
fn an_edge_stays_and_the_noise_beside_it_goes() {
    let size = Size::new(24, 20);
    let mut noise = TestNoise(25);
    let clean: Vec<f32> = (0..size.pixels()).map(|i| if i % 24 < 12 { 0.0 } else { 1.0 }).collect();
    let noisy = vec![clean.iter().map(|v| v + 0.05 * noise.normal() as f32).collect::<Vec<f32>>()];
    let variances = vec![vec![0.0025; size.pixels()]];
    let means = nl_means(&guide(size, [&noisy, &variances], 5), 0.6, &noisy, &Silent).unwrap();
    let error = |plane: &[f32]| plane.iter().zip(&clean).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
    assert!(error(&means[0]) < 0.2 * error(&noisy[0]), "{} of {}", error(&means[0]), error(&noisy[0]));
    assert!(means[0].iter().zip(&clean).all(|(a, b)| (a - b).abs() < 0.15), "nothing bleeds over the edge");
}
