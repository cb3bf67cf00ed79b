//! Tiles on any processor.

use pulp::{Scalar, Scalar256b};

use super::super::test_problem::Problem;
use super::*;

const KERNELS: [Kernel; 2] = [Kernel { bandwidth: 0.8, sigma: f32::INFINITY }, Kernel { bandwidth: 2.0, sigma: 1.5 }];

#[test]
fn the_same_bits_with_and_without_vector_instructions() {
    let problem = Problem::random(Size::new(14, 11), 50);
    let mut fitted = problem.fitted(1e-4, 1);
    (fitted.importance, fitted.ridge.per_noise) = (Some(&problem.importance[..]), 0.3);
    let guide = problem.guide(4);
    let tile = Rectangle { x0: 3, y0: 2, x1: 14, y1: 9 };
    let fits: Vec<[usize; 2]> = (2..9).flat_map(|y| (3..14).map(move |x| [x, y])).collect();
    let wants = |kernel: usize, x: usize, y: usize| kernel == 0 || (x + y).is_multiple_of(2);
    let place = tile.grown(4, problem.size);
    let task = || TileTask { fitted: &fitted, guide: &guide, kernels: &KERNELS, tile, place, fits: &fits, wants };
    let images = |parts: Vec<(Rectangle, Sums)>| parts.into_iter().map(|(place, sums)| (place, sums.into_halves()));
    let dispatched: Vec<_> = images(fit_tile(&fitted, &guide, &KERNELS, tile, wants)).collect();
    let scalar: Vec<_> = images(Scalar.vectorize(task())).collect();
    let eight_at_once: Vec<_> = images(Scalar256b.vectorize(task())).collect();
    assert!(dispatched == scalar, "one number at a time gives other bits");
    assert!(dispatched == eight_at_once, "eight numbers at a time give other bits");
}

#[test]
fn a_tile_that_nobody_wants_is_not_worked_on() {
    let problem = Problem::random(Size::new(9, 9), 51);
    let tile = Rectangle { x0: 0, y0: 0, x1: 9, y1: 9 };
    let parts = fit_tile(&problem.fitted(1e-4, 1), &problem.guide(2), &KERNELS, tile, |_, _, _| false);
    assert!(parts.is_empty());
}

#[test]
fn each_kernel_gets_the_fits_it_wants() {
    let problem = Problem::linear(Size::new(9, 9), 52);
    let tile = Rectangle { x0: 0, y0: 0, x1: 9, y1: 9 };
    let wants = |kernel: usize, x: usize, y: usize| [x, y] == if kernel == 0 { [1, 1] } else { [7, 7] };
    let parts = fit_tile(&problem.fitted(1e-4, 1), &problem.guide(1), &KERNELS, tile, wants);
    for ((place, sums), centre) in parts.iter().zip([1_usize, 7]) {
        assert_eq!(*place, tile);
        let touched = sums.lighter_than(1e-5);
        for (i, untouched) in touched.iter().enumerate() {
            let near = (i % 9).abs_diff(centre) <= 1 && (i / 9).abs_diff(centre) <= 1;
            assert!(*untouched || near, "pixel {i} lies outside the window around {centre}");
        }
        assert!(!touched[centre * 9 + centre]);
    }
}
