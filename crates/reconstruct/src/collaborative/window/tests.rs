//! What a fit gets to see of its neighbours.

use super::*;

const SCALAR: pulp::Scalar = pulp::Scalar;

fn rows() -> Vec<Row> {
    (0..6).map(|pixel| std::array::from_fn(|j| (pixel * pixel + j) as f32)).collect()
}

fn neighbours() -> Neighbours {
    let mut neighbours = Neighbours::default();
    neighbours.push(5, 1, 0.5);
    neighbours.push(2, 0, 0.25);
    neighbours
}

#[test]
fn rows_are_relative_to_the_centre() {
    let mut found = neighbours();
    found.fetch(SCALAR, &rows(), None, 3);
    assert_eq!(found.rows, [[16.0; WIDTH], [-5.0; WIDTH]], "25 − 9 and 4 − 9");
    assert_eq!(found.weights, found.kernel);
}

#[test]
fn importance_weighs_residuals_relative_to_the_centre() {
    let mut found = neighbours();
    found.fetch(SCALAR, &rows(), Some(&[1.0, 1.0, 8.0, 4.0, 1.0, 2.0]), 3);
    assert_eq!(found.weights, [0.25, 0.5]);
    assert_eq!(found.kernel, [0.5, 0.25], "predictions are averaged without it");
}

#[test]
fn nothing_of_an_earlier_window_stays() {
    let mut found = neighbours();
    found.fetch(SCALAR, &rows(), None, 3);
    found.clear();
    found.push(4, 7, 1.0);
    found.fetch(SCALAR, &rows(), None, 4);
    assert_eq!((found.rows, found.weights, found.pixels), (vec![[0.0; WIDTH]], vec![1.0], vec![4]));
}
