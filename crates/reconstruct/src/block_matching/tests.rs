//! Block matching on pictures whose truth is known.

use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(64, 48);

/// Mean squared error of what is made of `clean` with noise of variance 1.
fn error(clean: impl Fn(usize, usize) -> f32) -> f32 {
    let clean: Vec<f32> = (0..SIZE.pixels()).map(|i| clean(i % SIZE.width, i / SIZE.width)).collect();
    let mut noise = TestNoise(3);
    let noisy: Vec<f32> = clean.iter().map(|value| value + noise.normal() as f32).collect();
    let found = block_matched(&[noisy], &[true; SIZE.pixels()], SIZE).unwrap();
    found[0].iter().zip(&clean).map(|(a, b)| (a - b).powi(2)).sum::<f32>() / SIZE.pixels() as f32
}

#[test]
fn little_noise_is_left_on_a_flat_picture() {
    let left = error(|_, _| 5.0);
    assert!(left < 0.02, "{left}");
}

#[test]
fn edges_and_repeated_patterns_are_kept() {
    let edge = error(|x, y| if 3 * x > 2 * y + 40 { 20.0 } else { 0.0 });
    assert!(edge < 0.2, "{edge}");
    let stripes = error(|x, y| if (x + y) % 6 < 3 { 4.0 } else { -4.0 });
    assert!(stripes < 0.2, "{stripes}");
}

#[test]
fn pictures_down_to_one_patch_and_no_smaller() {
    let of = |width: usize, height: usize| {
        let size = Size::new(width, height);
        block_matched(&[TestNoise(4).normals(size.pixels(), 2.0, 1.0)], &vec![true; size.pixels()], size)
    };
    assert!(of(7, 30).is_none() && of(30, 1).is_none());
    for [width, height] in [[8, 8], [9, 8], [8, 40], [23, 11]] {
        let found = of(width, height).unwrap();
        assert!(found[0].len() == width * height && found[0].iter().all(|v| v.is_finite()));
    }
}

#[test]
fn each_patch_is_in_its_own_group_among_equals_too() {
    for plane in
        block_matched(&[vec![0.0; SIZE.pixels()], vec![7.0; SIZE.pixels()]], &[true; SIZE.pixels()], SIZE).unwrap()
    {
        assert!(plane.iter().all(|v| (v - plane[0]).abs() < 1e-3), "some pixel is in no group");
    }
    let found = matching::alike(&[0.0; SIZE.pixels()], SIZE, Corner { x: 30, y: 20 }, REACH, FIRST_GROUP);
    assert_eq!(found[0], Corner { x: 30, y: 20 });
}

#[test]
fn far_from_what_is_wanted_noise_stays() {
    let noisy = TestNoise(5).normals(SIZE.pixels(), 2.0, 1.0);
    let wanted: Vec<bool> = (0..SIZE.pixels()).map(|i| i % SIZE.width < 8).collect();
    let found = block_matched(std::slice::from_ref(&noisy), &wanted, SIZE).unwrap().remove(0);
    for (i, value) in found.iter().enumerate() {
        match i % SIZE.width {
            0..8 => assert!((value - 2.0).abs() < 0.6, "{value}"),
            // A group's patches are at most that far from its first.
            x if x > 8 + PATCH + REACH => assert_eq!(*value, noisy[i]),
            _ => {}
        }
    }
}
