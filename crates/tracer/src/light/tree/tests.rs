use glam::Vec3;

use super::super::light_bounds::LightBounds;
use super::super::normal_cone::NormalCone;
use super::*;
use crate::bvh::Bounds;
use crate::bvh::random::Random;

/// A square of side `size` at `centre`, shining along `normal`.
fn lamp(centre: Vec3, size: f32, normal: Vec3, power: f64) -> LightBounds {
    let (x, y) = normal.any_orthonormal_pair();
    let corner = |u: f32, v: f32| centre + size * ((u - 0.5) * x + (v - 0.5) * y);
    let bounds = Bounds::of([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
    LightBounds { bounds, cone: NormalCone::new(normal, 0.0), power }
}

/// Lamps of any size, direction and power in a cube.
fn lamps(count: usize, random: &mut Random) -> Vec<LightBounds> {
    let mut one = || {
        let power = f64::from(random.unit()).powi(4);
        lamp(random.point(), 0.2 * random.unit(), random.direction(), power)
    };
    (0..count).map(|_| one()).collect()
}

fn receiver(random: &mut Random) -> Receiver {
    Receiver { position: 1.5 * random.point(), normal: random.direction(), two_sided: random.unit() < 0.3 }
}

#[test]
fn probabilities_add_up_to_one_everywhere() {
    let mut random = Random(1);
    for count in [1, 2, 5, 9, 300] {
        let tree = LightTree::new(&lamps(count, &mut random));
        for _ in 0..200 {
            let receiver = receiver(&mut random);
            let total: f64 = (0..count).map(|i| f64::from(tree.lamp_probability(&receiver, i))).sum();
            assert!((total - 1.0).abs() < 1e-5, "{count}: {total}");
        }
    }
}

/// Pearson's χ² of the lamps chosen, against the probabilities told.
#[test]
fn lamps_come_as_often_as_their_probabilities_say() {
    let mut random = Random(2);
    const SAMPLES: u32 = 1 << 16;
    for count in [2, 9, 60] {
        let tree = LightTree::new(&lamps(count, &mut random));
        for _ in 0..4 {
            let receiver = receiver(&mut random);
            let mut found = vec![0.0; count];
            for _ in 0..SAMPLES {
                let chosen = tree.sample_lamp(&receiver, random.bits() as u32).unwrap();
                let told = tree.lamp_probability(&receiver, chosen.index);
                assert!((chosen.probability / told - 1.0).abs() < 1e-5, "{chosen:?} {told}");
                found[chosen.index] += 1.0;
            }
            let expected: Vec<f64> =
                (0..count).map(|i| f64::from(tree.lamp_probability(&receiver, i)) * f64::from(SAMPLES)).collect();
            let cells = found.iter().zip(&expected).filter(|(_, expected)| **expected > 5.0);
            let (statistic, cells) = cells.fold((0.0, 0), |(s, n), (f, e)| (s + (f - e) * (f - e) / e, n + 1));
            // Mean n and variance 2 n; six standard deviations.
            let limit = f64::from(cells) + 6.0 * f64::from(2 * cells).sqrt() + 10.0;
            assert!(statistic < limit, "{count}: {statistic} {limit}");
        }
    }
}

/// Whatever is sent is reckoned with: no lamp that shines on a receiver has probability 0.
#[test]
fn every_lamp_that_shines_on_a_receiver_is_found() {
    let mut random = Random(3);
    for _ in 0..20 {
        let all = lamps(40, &mut random);
        let tree = LightTree::new(&all);
        for _ in 0..200 {
            let receiver = receiver(&mut random);
            for (i, lamp) in all.iter().enumerate() {
                let corners = lamp.bounds.corners();
                let shines = corners.iter().any(|corner| {
                    let span = *corner - receiver.position;
                    let there = receiver.normal.dot(span);
                    lamp.cone.axis().dot(-span) > 1e-5 && (there > 1e-5 || receiver.two_sided)
                });
                // The box of a tilted square is more than the square; what its corners do not see, the square does not.
                assert!(!shines || lamp.power < 1e-3 || tree.lamp_probability(&receiver, i) > 0.0);
            }
        }
    }
}

#[test]
fn scale_and_place_of_a_scene_do_not_matter() {
    let mut random = Random(4);
    let all = lamps(100, &mut random);
    let (tree, receiver) = (LightTree::new(&all), receiver(&mut random));
    for size in [1e-15_f32, 1.0, 1e15] {
        let scaled = all.iter().map(|lamp| LightBounds {
            bounds: Bounds { min: size * lamp.bounds.min, max: size * lamp.bounds.max },
            ..*lamp
        });
        let there = LightTree::new(&scaled.collect::<Vec<_>>());
        let receiver_there = Receiver { position: size * receiver.position, ..receiver };
        for i in 0..all.len() {
            let (a, b) = (tree.lamp_probability(&receiver, i), there.lamp_probability(&receiver_there, i));
            assert!((a - b).abs() < 1e-4, "{size} {i}: {a} {b}");
        }
    }
}

#[test]
fn lamps_without_power_are_never_chosen() {
    let dark = lamp(Vec3::ZERO, 1.0, Vec3::Y, 0.0);
    let lit = lamp(Vec3::X, 1.0, Vec3::Y, 1.0);
    let receiver = Receiver { position: Vec3::Y, normal: -Vec3::Y, two_sided: false };
    assert_eq!(LightTree::new(&[]).sample_lamp(&receiver, 7), None);
    let none = LightTree::new(&[dark, dark]);
    assert_eq!((none.sample_lamp(&receiver, 7), none.lamp_probability(&receiver, 0)), (None, 0.0));
    let one = LightTree::new(&[dark, lit, dark]);
    assert_eq!(one.sample_lamp(&receiver, u32::MAX), Some(ChosenLamp { index: 1, probability: 1.0 }));
    assert_eq!(one.lamp_probability(&receiver, 2), 0.0);
}

/// Lamps that lie at one place cannot be told apart, and are found all the same.
#[test]
fn equal_lamps_are_equally_likely() {
    let tree = LightTree::new(&vec![lamp(Vec3::ONE, 0.1, Vec3::Y, 1.0); 64]);
    let receiver = Receiver { position: Vec3::new(1.0, 3.0, 1.0), normal: -Vec3::Y, two_sided: false };
    assert!((0..64).all(|i| (tree.lamp_probability(&receiver, i) * 64.0 - 1.0).abs() < 1e-5));
}

/// Over a floor under 1,000 lamps, of which the few that are near matter to each point: one sample is right on average,
/// and has no more than one and a half times the error of a sample of one panel of their extent and power.
#[test]
fn a_thousand_lamps_are_hardly_noisier_than_one_panel() {
    const SIDE: usize = 32;
    const POINTS: usize = 100;
    const SAMPLES: usize = 256;
    let cell = |i: usize| Vec3::new((i % SIDE) as f32 + 0.5, 1.0, (i / SIDE) as f32 + 0.5);
    let all: Vec<_> = (0..SIDE * SIDE).map(|i| lamp(cell(i), 0.1, -Vec3::Y, 1.0)).collect();
    let tree = LightTree::new(&all);
    let mut random = Random(5);
    // Irradiance per power from a point that shines down.
    let sent = |point: Vec3, at: Vec3| f64::from((point.y - at.y).powi(2) / point.distance_squared(at).powi(2));
    let (mut errors, mut squares) = ([0.0; 2], [0.0; 2]);
    for _ in 0..POINTS {
        let position = Vec3::new(4.0 + 24.0 * random.unit(), 0.0, 4.0 + 24.0 * random.unit());
        let receiver = Receiver { position, normal: Vec3::Y, two_sided: false };
        let truth: f64 = (0..all.len()).map(|i| sent(cell(i), position)).sum();
        for _ in 0..SAMPLES {
            let chosen = tree.sample_lamp(&receiver, random.bits() as u32).unwrap();
            let of_lamps = sent(cell(chosen.index), position) / f64::from(chosen.probability);
            let on_panel = Vec3::new(SIDE as f32 * random.unit(), 1.0, SIDE as f32 * random.unit());
            let of_panel = sent(on_panel, position) * all.len() as f64;
            for (i, estimate) in [of_lamps, of_panel].into_iter().enumerate() {
                errors[i] += (estimate / truth - 1.0) / (POINTS * SAMPLES) as f64;
                squares[i] += (estimate / truth - 1.0).powi(2) / (POINTS * SAMPLES) as f64;
            }
        }
    }
    let standard_error = (squares[0] / (POINTS * SAMPLES) as f64).sqrt();
    assert!(errors[0].abs() < 4.0 * standard_error, "{} ± {standard_error}", errors[0]);
    assert!(squares[0].sqrt() < 1.5 * squares[1].sqrt(), "{squares:?}");
}
