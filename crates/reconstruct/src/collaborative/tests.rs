//! What collaborative fits promise as a whole.

use std::sync::atomic::{AtomicU64, Ordering};

use stack::Silent;

use super::test_problem::Problem;
use super::twin::collaborate_twin;
use super::*;

const KERNELS: [Kernel; 3] = [
    Kernel { bandwidth: 0.6, sigma: f32::INFINITY },
    Kernel { bandwidth: 1000.0, sigma: f32::INFINITY },
    Kernel { bandwidth: 2.0, sigma: 1.5 },
];

#[test]
fn agree_with_one_exact_fit_at_a_time() {
    let problem = Problem::random(Size::new(11, 8), 60);
    let guide = problem.guide(2);
    for (importance, per_noise) in [(None, 0.0), (Some(&problem.importance[..]), 0.4)] {
        let mut fitted = problem.fitted(0.01, 1);
        (fitted.importance, fitted.ridge.per_noise) = (importance, per_noise);
        let found = collaborate(&fitted, &guide, &KERNELS, &Silent).unwrap();
        for (halves, kernel) in found.iter().zip(&KERNELS) {
            let expected = collaborate_twin(&fitted, &guide, kernel);
            for (i, expected) in expected.iter().enumerate() {
                let found = halves.iter().flat_map(|half| half.rgb(i));
                for (found, expected) in found.zip(expected) {
                    assert!((f64::from(found) - expected).abs() < 1e-3, "{i} {kernel:?}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn data_linear_in_the_features_come_back_at_every_pixel() {
    for (width, height) in [(26, 19), (1, 1), (23, 1), (1, 17), (2, 2)] {
        let problem = Problem::linear(Size::new(width, height), 61);
        for stride in 1..=3 {
            let mut fitted = problem.fitted(1e-6, stride);
            fitted.importance = Some(&problem.importance);
            let found = collaborate(&fitted, &problem.guide(4), &KERNELS, &Silent).unwrap();
            for (halves, kernel) in found.iter().zip(&KERNELS) {
                let difference = problem.largest_difference(halves);
                assert!(difference < 5e-3, "{width}x{height}, every {stride}, {kernel:?}: {difference}");
            }
        }
    }
}

#[test]
fn constants_stay_constants() {
    let mut problem = Problem::random(Size::new(25, 17), 62);
    (0..problem.size.pixels()).for_each(|i| problem.set_responses(i, 0.7));
    for (stride, ridge) in [(1, 1e-5), (2, 1.0), (3, 1e-5)] {
        for halves in collaborate(&problem.fitted(ridge, stride), &problem.guide(3), &KERNELS, &Silent).unwrap() {
            assert!(problem.largest_difference(&halves) < 1e-5);
        }
    }
}

#[test]
fn the_same_importance_everywhere_is_none() {
    let problem = Problem::random(Size::new(20, 15), 63);
    let run = |importance: Option<&[f32]>| {
        let fitted = Fitted { importance, ..problem.fitted(1e-3, 2) };
        collaborate(&fitted, &problem.guide(3), &KERNELS, &Silent).unwrap()
    };
    assert!(run(None) == run(Some(&vec![4.0; 300])));
}

#[test]
fn a_pixel_unlike_all_others_gets_a_fit_of_its_own() {
    let size = Size::new(20, 14);
    for [x, y] in [[3, 3], [0, 0], [19, 13], [8, 5]] {
        let lone = size.index(x, y);
        let values = (0..size.pixels()).map(|i| if i == lone { 100.0 } else { 0.0 }).collect();
        let mut problem = Problem::random(size, 64).guided_by(values);
        (0..size.pixels()).for_each(|i| problem.set_responses(i, if i == lone { 9.0 } else { 1.0 }));
        let mut guide = problem.guide(4);
        guide.comparison.patch_radius = 0;
        for halves in collaborate(&problem.fitted(1e-3, 3), &guide, &KERNELS[..1], &Silent).unwrap() {
            assert!(problem.largest_difference(&halves) < 1e-5, "the lone pixel at {x} {y} or those around it");
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let problem = Problem::random(Size::new(120, 70), 65);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let fitted = problem.fitted(1e-3, 2);
        pool.install(|| collaborate(&fitted, &problem.guide(3), &KERNELS, &Silent).unwrap())
    };
    assert!(run(1) == run(4));
}

#[derive(Default)]
struct Counting {
    units: AtomicU64,
    stop: bool,
}

impl Monitor for Counting {
    fn advance(&self, units: u64) {
        self.units.fetch_add(units, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.stop
    }
}

#[test]
fn monitors_hear_of_every_unit_and_can_stop_it() {
    let problem = Problem::random(Size::new(60, 37), 66);
    for stride in [1, 3] {
        let fitted = problem.fitted(1e-3, stride);
        let counting = Counting::default();
        collaborate(&fitted, &problem.guide(2), &KERNELS[..1], &counting).unwrap();
        assert_eq!(counting.units.into_inner(), units(problem.size, stride));
        let stopping = Counting { stop: true, ..Counting::default() };
        assert_eq!(collaborate(&fitted, &problem.guide(2), &KERNELS, &stopping).unwrap_err(), Cancelled);
    }
}
