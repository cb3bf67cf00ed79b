//! What a fit gets to see of its neighbours.

use stack::Size;

use super::*;
use crate::rectangle::Rectangle;

const SIZE: Size = Size::new(7, 5);

/// A feature, two responses, the noise and the importance, each of which tells the pixel from all others.
fn planes() -> Vec<Vec<f32>> {
    (0..5).map(|plane| (0..SIZE.pixels()).map(|i| (1 + i + 100 * plane) as f32).collect()).collect()
}

/// The window of radius 1 around `centre`.
fn window(centre: [usize; 2], weighed: bool) -> Window {
    let planes = planes();
    let tile = Rectangle { x0: 2, y0: 1, x1: 7, y1: 5 };
    let region = Region::cut(planes.iter().map(Vec::as_slice), SIZE, tile, 1);
    let mut window = Window::new(3);
    window.fetch(&region, centre, 1, 2, weighed);
    window
}

#[test]
fn lists_are_relative_to_the_centre() {
    let window = window([3, 2], false);
    for column in [0, FEATURES, FEATURES + 1] {
        assert_eq!(window.column(column)[..9], [-8.0, -7.0, -6.0, -1.0, 0.0, 1.0, 6.0, 7.0, 8.0]);
        assert_eq!(window.column(column)[9..], [0.0; 7]);
    }
    assert_eq!(window.column(1), [0.0; 16], "a feature that there is not");
}

#[test]
fn importance_is_relative_to_the_centre() {
    let mut weights = [0.0; 16];
    window([3, 2], true).weigh_residuals(&[2.0; 16], &mut weights);
    let own = 1.0 / 418.0;
    assert_eq!(weights[..3], [2.0 * (410.0 * own), 2.0 * (411.0 * own), 2.0 * (412.0 * own)]);
    window([3, 2], false).weigh_residuals(&[2.0; 16], &mut weights);
    assert_eq!(weights, [2.0; 16]);
}

#[test]
fn noise_is_added_up_with_squared_weights() {
    let sum: f32 = [310.0, 311.0, 312.0, 317.0, 318.0, 319.0, 324.0, 325.0, 326.0].iter().sum();
    assert_eq!(window([3, 2], true).noise(&[2.0; 16]), 4.0 * sum);
}

#[test]
fn what_lies_outside_the_image_has_no_weight() {
    let mut weights = [0.0; 4];
    weigh(&[0.0, 1.0, 1e9, 50.0], 0.5, &[0.0, 0.5, 0.0, 0.0], &mut weights);
    assert_eq!(weights[0], 1.0);
    assert!((weights[1] - (-1.0_f32).exp()).abs() < 1e-6);
    assert_eq!(weights[2..], [0.0; 2], "far away, and negligible");
}
