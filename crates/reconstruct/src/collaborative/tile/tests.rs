//! Tiles on any processor.

use pulp::{Scalar, Scalar256b};

use super::super::test_problem::Problem;
use super::*;

const CANDIDATES: [Candidate; 2] = [
    Candidate { guide: 0, kernel: Kernel { bandwidth: 0.8, sigma: f32::INFINITY } },
    Candidate { guide: 0, kernel: Kernel { bandwidth: 2.0, sigma: 1.5 } },
];

#[test]
fn the_same_bits_with_and_without_vector_instructions() {
    let problem = Problem::random(Size::new(14, 11), 50);
    let (planes, values) = (problem.planes(), [problem.values()]);
    let responses = planes.responses();
    let all = [&responses[..]];
    let mut fitted = problem.fitted(&planes, &all, 1e-4, 1);
    (fitted.importance, fitted.ridge.per_noise) = (Some(&problem.importance[..]), 0.3);
    let guides = problem.guides(&values, 4);
    let tile = Rectangle { x0: 3, y0: 2, x1: 14, y1: 9 };
    let fits: Vec<[usize; 2]> = (2..9).flat_map(|y| (3..14).map(move |x| [x, y])).collect();
    let wants = |candidate: usize, x: usize, y: usize| candidate == 0 || (x + y).is_multiple_of(2);
    let task = || TileTask { fitted: &fitted, guides: &guides, candidates: &CANDIDATES, tile, fits: &fits, wants };
    let means = |sums: Vec<Sums>| sums.into_iter().map(Sums::into_means).collect::<Vec<_>>();
    let dispatched = means(fit_tile(&fitted, &guides, &CANDIDATES, tile, wants).unwrap().sums);
    let scalar = means(Scalar.vectorize(task()));
    let eight_at_once = means(Scalar256b.vectorize(task()));
    assert!(dispatched == scalar, "one number at a time gives other bits");
    assert!(dispatched == eight_at_once, "eight numbers at a time give other bits");
}

#[test]
fn a_tile_that_nobody_wants_is_not_worked_on() {
    let problem = Problem::random(Size::new(9, 9), 51);
    let (planes, values) = (problem.planes(), [problem.values()]);
    let responses = planes.responses();
    let all = [&responses[..]];
    let tile = Rectangle { x0: 0, y0: 0, x1: 9, y1: 9 };
    let fitted = problem.fitted(&planes, &all, 1e-4, 1);
    assert!(fit_tile(&fitted, &problem.guides(&values, 2), &CANDIDATES, tile, |_, _, _| false).is_none());
}

#[test]
fn each_candidate_gets_the_fits_it_wants() {
    let problem = Problem::linear(Size::new(9, 9), 52);
    let (planes, values) = (problem.planes(), [problem.values()]);
    let responses = planes.responses();
    let all = [&responses[..]];
    let tile = Rectangle { x0: 0, y0: 0, x1: 9, y1: 9 };
    let wants = |candidate: usize, x: usize, y: usize| [x, y] == if candidate == 0 { [1, 1] } else { [7, 7] };
    let fitted = problem.fitted(&planes, &all, 1e-4, 1);
    let fits = fit_tile(&fitted, &problem.guides(&values, 1), &CANDIDATES, tile, wants).unwrap();
    assert_eq!(fits.tile, Rectangle { x0: 1, y0: 1, x1: 8, y1: 8 }, "no more than holds both");
    for (part, centre) in fits.sums.iter().zip([1_usize, 7]) {
        let mut sums = Sums::zeros(problem.size, responses.len());
        sums.add(fits.tile, 1, part);
        let touched = sums.lighter_than(1e-5);
        for (i, untouched) in touched.iter().enumerate() {
            let near = (i % 9).abs_diff(centre) <= 1 && (i / 9).abs_diff(centre) <= 1;
            assert!(*untouched || near, "pixel {i} lies outside the window around {centre}");
        }
        assert!(!touched[centre * 9 + centre]);
    }
}
