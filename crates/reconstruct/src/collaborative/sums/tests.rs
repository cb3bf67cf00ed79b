//! Sums of predictions.

use super::super::plane::PADDED;
use super::*;

const SIZE: Size = Size::new(5, 4);

/// A part whose every pixel holds `value` with `weight`.
fn part(size: Size, value: f32, weight: f32) -> Sums {
    let mut part = Sums::zeros(size);
    for i in 0..size.pixels() {
        let mut prediction = [0.0; PADDED];
        prediction[..RESPONSES].fill(value * weight);
        prediction[RESPONSES] = weight;
        *part.at_mut(i) = prediction;
    }
    part
}

#[test]
fn overlapping_parts_make_weighted_means() {
    let mut sums = Sums::zeros(SIZE);
    sums.add(Rectangle { x0: 0, y0: 0, x1: 3, y1: 4 }, &part(Size::new(3, 4), 2.0, 1.0));
    sums.add(Rectangle { x0: 2, y0: 1, x1: 5, y1: 3 }, &part(Size::new(3, 2), 6.0, 3.0));
    let light = sums.lighter_than(1.0);
    for half in sums.into_halves() {
        for (i, light) in light.iter().enumerate() {
            let (x, y) = (i % 5, i / 5);
            let expected = match (x < 3, x > 1 && (1..3).contains(&y)) {
                (true, true) => 5.0,
                (true, false) => 2.0,
                (false, true) => 6.0,
                (false, false) => 0.0,
            };
            assert_eq!(half.rgb(i), [expected; 3], "{x} {y}");
            assert_eq!(*light, expected == 0.0, "weight of {x} {y}");
        }
    }
}

#[test]
fn halves_hold_three_responses_each() {
    let mut sums = Sums::zeros(Size::new(1, 1));
    *sums.at_mut(0) = [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 2.0, 0.0];
    let [a, b] = sums.into_halves();
    assert_eq!((a.rgb(0), b.rgb(0)), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
}
