//! Sums of predictions.

use super::*;

const SIZE: Size = Size::new(5, 4);

/// The window of radius 1 around the only pixel of a tile, every prediction `value` with `weight`.
fn part(value: f32, weight: f32) -> Sums {
    let mut part = Sums::zeros(Size::new(3, 3), 2);
    let row = |value: f32| [value, value, value, 0.0, 0.0, 0.0, 0.0, 0.0];
    let predictions = [[row(value * weight); 3], [row(2.0 * value * weight); 3]].concat();
    part.add_groups(pulp::Scalar, 0, &[0, 3, 6], &predictions, &[row(weight); 3]);
    part
}

fn pixel(x: usize, y: usize) -> Rectangle {
    Rectangle { x0: x, y0: y, x1: x + 1, y1: y + 1 }
}

#[test]
fn overlapping_parts_make_weighted_means() {
    let mut sums = Sums::zeros(SIZE, 2);
    sums.add(pixel(1, 1), 1, &part(2.0, 1.0));
    sums.add(pixel(3, 2), 1, &part(6.0, 3.0));
    let light = sums.lighter_than(1.0);
    let means = sums.into_means();
    for (i, light) in light.iter().enumerate() {
        let (x, y) = (i % 5, i / 5);
        let expected = match (x < 3 && y < 3, x > 1 && y > 0) {
            (true, true) => 5.0,
            (true, false) => 2.0,
            (false, true) => 6.0,
            (false, false) => 0.0,
        };
        assert_eq!([means[0][i], means[1][i]], [expected, 2.0 * expected], "{x} {y}");
        assert_eq!(*light, expected == 0.0, "weight of {x} {y}");
    }
}

#[test]
fn what_reaches_past_the_border_is_left_out() {
    let mut sums = Sums::zeros(SIZE, 2);
    sums.add(pixel(0, 0), 1, &part(2.0, 1.0));
    sums.add(pixel(4, 3), 1, &part(2.0, 1.0));
    assert_eq!(sums.lighter_than(1.0).iter().filter(|light| !**light).count(), 8);
}
