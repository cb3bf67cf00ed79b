//! What a fit gets to see of its neighbours.

use stack::Size;

use super::*;
use crate::patch_distance::PatchComparison;
use crate::rectangle::Rectangle;

const SIZE: Size = Size::new(7, 5);

/// A feature, two responses, the noise and the importance, each of which tells the pixel from all others.
fn planes() -> Vec<Vec<f32>> {
    (0..5).map(|plane| (0..SIZE.pixels()).map(|i| (1 + i + 100 * plane) as f32).collect()).collect()
}

const LAYOUT: Layout = Layout { features: 1, responses: 1..3, noise: 3, importance: Some(4) };

/// The region around a tile, and the window of radius 1 around `centre` in which `distances` tell what weighs how much.
fn fetched(centre: [usize; 2], distances: &[Lanes], layout: &Layout) -> (Region, Window) {
    let planes = planes();
    let tile = Rectangle { x0: 2, y0: 1, x1: 7, y1: 5 };
    let planes: Vec<&[f32]> = planes.iter().map(Vec::as_slice).collect();
    let region = Region::cut(&planes, SIZE, tile, 1);
    let comparison = PatchComparison { patch_radius: 0, epsilon: 1.0, noise_taken_off: 0.0 };
    let guides = Guides { size: SIZE, values: &[], variances: &[], comparison, radius: 1 };
    let mut window = Window::new(&guides, region.width());
    window.weigh(distances, 1.0, &[IN_WINDOW; 3]);
    window.fetch(pulp::Scalar, &region, centre, layout);
    (region, window)
}

/// Falloff of a row: what it is padded with is beyond all reach.
const IN_WINDOW: Lanes = {
    let mut row = [f32::INFINITY; LANES];
    (row[0], row[1], row[2]) = (0.0, 0.0, 0.0);
    row
};

const ALIKE: Lanes = [0.0; LANES];
const UNLIKE: Lanes = [50.0; LANES];

#[test]
fn lists_are_relative_to_the_centre() {
    let (_, window) = fetched([3, 2], &[ALIKE; 3], &LAYOUT);
    assert_eq!((window.features(), window.places()), (1, &[0, 7, 14][..]));
    for column in &window.columns()[..3] {
        let rows: Vec<&[f32]> = column.iter().map(|row| &row[..3]).collect();
        assert_eq!(rows, [[-8.0, -7.0, -6.0], [-1.0, 0.0, 1.0], [6.0, 7.0, 8.0]]);
    }
    assert!(window.kernel().iter().all(|row| row == &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
}

#[test]
fn rows_without_any_weight_are_left_out() {
    let (_, window) = fetched([3, 2], &[UNLIKE, ALIKE, UNLIKE], &LAYOUT);
    assert_eq!(window.places(), [7]);
    assert_eq!(window.columns()[0][0][..3], [-1.0, 0.0, 1.0]);
}

#[test]
fn a_feature_that_does_not_vary_is_left_out() {
    let alone = [UNLIKE, [50.0, 0.0, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0], UNLIKE];
    let (_, window) = fetched([3, 2], &alone, &LAYOUT);
    assert_eq!(window.features(), 0);
    assert_eq!(window.columns()[0][0][..3], [-1.0, 0.0, 1.0], "the first response comes first");
}

#[test]
fn importance_is_relative_to_the_centre() {
    let own = 1.0 / 418.0;
    let (_, window) = fetched([3, 2], &[ALIKE; 3], &LAYOUT);
    assert_eq!(window.weights()[0][..4], [410.0 * own, 411.0 * own, 412.0 * own, 0.0]);
    let (_, window) = fetched([3, 2], &[ALIKE; 3], &Layout { importance: None, ..LAYOUT });
    assert_eq!(window.weights(), window.kernel());
}

#[test]
fn noise_is_added_up_with_squared_weights() {
    let sum: f32 = [310.0, 311.0, 312.0, 317.0, 318.0, 319.0, 324.0, 325.0, 326.0].iter().sum();
    let half = [std::f32::consts::LN_2; LANES];
    let (region, window) = fetched([3, 2], &[half; 3], &LAYOUT);
    let noise = window.noise(pulp::Scalar, &region, [3, 2], &LAYOUT);
    assert!((noise - 0.25 * sum).abs() < 1e-3, "{noise}");
}

#[test]
fn what_is_far_or_negligible_has_no_weight() {
    let distances = [[0.0, 1.0, 1e9, 0.0, 0.0, 0.0, 0.0, 0.0], [50.0; LANES], [9.2, 9.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    let (_, window) = fetched([3, 2], &distances, &LAYOUT);
    let [first, last] = window.kernel() else { panic!("two rows count") };
    assert_eq!(first[0], 1.0);
    assert!((first[1] - (-1.0_f32).exp()).abs() < 1e-6);
    assert_eq!(first[2], 0.0, "far away");
    assert!(last[0] > 0.0 && last[1] == 0.0, "negligible");
}
