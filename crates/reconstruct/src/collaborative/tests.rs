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

/// All responses of `problem` with its guide, once per kernel.
fn run(problem: &Problem, radius: usize, stride: usize, least: f32, importance: Option<&[f32]>) -> Vec<Predicted> {
    let (planes, values) = (problem.planes(), [problem.values()]);
    let responses = planes.responses();
    let all = [&responses[..]];
    let fitted = Fitted { importance, ..problem.fitted(&planes, &all, least, stride) };
    collaborate(&fitted, &problem.guides(&values, radius), &KERNELS, &Silent).unwrap()
}

#[test]
fn agree_with_one_exact_fit_at_a_time() {
    let problem = Problem::random(Size::new(11, 8), 60);
    let (planes, values) = (problem.planes(), [problem.values()]);
    let (responses, guides) = (planes.responses(), problem.guides(&values, 2));
    for (importance, per_noise) in [(None, 0.0), (Some(&problem.importance[..]), 0.4)] {
        let all = [&responses[..]];
        let mut fitted = problem.fitted(&planes, &all, 0.01, 1);
        (fitted.importance, fitted.ridge.per_noise) = (importance, per_noise);
        let found = collaborate(&fitted, &guides, &KERNELS, &Silent).unwrap();
        for (predicted, kernel) in found.iter().zip(&KERNELS) {
            let expected = collaborate_twin(&fitted, &problem.rows, &guides, kernel);
            for (i, expected) in expected.iter().enumerate() {
                for (found, expected) in predicted.iter().flatten().map(|plane| plane[i]).zip(expected) {
                    assert!((f64::from(found) - expected).abs() < 1e-3, "{i} {kernel:?}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn each_guide_weighs_its_own_responses() {
    let problem = Problem::random(Size::new(21, 15), 67);
    let other = Problem::random(Size::new(21, 15), 68);
    let planes = problem.planes();
    let responses = planes.responses();
    let apart: [&[&[f32]]; 2] = [&responses[..4], &responses[4..]];
    let with = |values: &[&[Vec<f32>]], responses: &[&[&[f32]]]| {
        let fitted = problem.fitted(&planes, responses, 1e-3, 2);
        collaborate(&fitted, &problem.guides(values, 4), &KERNELS, &Silent).unwrap()
    };
    let together = with(&[problem.values(), other.values()], &apart);
    let alone = [with(&[problem.values()], &apart[..1]), with(&[other.values()], &apart[1..])];
    for (kernel, predicted) in together.iter().enumerate() {
        for (guide, planes) in predicted.iter().enumerate() {
            let differences = planes.iter().flatten().zip(alone[guide][kernel][0].iter().flatten());
            assert!(differences.into_iter().all(|(a, b)| (a - b).abs() < 1e-5), "guide {guide}, kernel {kernel}");
        }
    }
}

#[test]
fn data_linear_in_the_features_come_back_at_every_pixel() {
    for (width, height) in [(26, 19), (1, 1), (23, 1), (1, 17), (2, 2)] {
        let problem = Problem::linear(Size::new(width, height), 61);
        for stride in 1..=3 {
            let found = run(&problem, 4, stride, 1e-6, Some(&problem.importance));
            for (predicted, kernel) in found.iter().zip(&KERNELS) {
                let difference = problem.largest_difference(predicted);
                assert!(difference < 5e-3, "{width}x{height}, every {stride}, {kernel:?}: {difference}");
            }
        }
    }
}

#[test]
fn constants_stay_constants() {
    let mut problem = Problem::random(Size::new(25, 17), 62);
    (0..problem.size.pixels()).for_each(|i| problem.set_responses(i, 0.7));
    for (stride, least) in [(1, 1e-5), (2, 1.0), (3, 1e-5)] {
        for predicted in run(&problem, 3, stride, least, None) {
            assert!(problem.largest_difference(&predicted) < 1e-5);
        }
    }
}

#[test]
fn the_same_importance_everywhere_is_none() {
    let problem = Problem::random(Size::new(20, 15), 63);
    let with = |importance: Option<&[f32]>| run(&problem, 3, 2, 1e-3, importance);
    assert!(with(None) == with(Some(&[4.0; 300])));
}

#[test]
fn a_pixel_unlike_all_others_gets_a_fit_of_its_own() {
    let size = Size::new(20, 14);
    for [x, y] in [[3, 3], [0, 0], [19, 13], [8, 5]] {
        let lone = size.index(x, y);
        let values = (0..size.pixels()).map(|i| if i == lone { 100.0 } else { 0.0 }).collect();
        let mut problem = Problem::random(size, 64).guided_by(values);
        (0..size.pixels()).for_each(|i| problem.set_responses(i, if i == lone { 9.0 } else { 1.0 }));
        let (planes, values) = (problem.planes(), [problem.values()]);
        let responses = planes.responses();
        let mut guides = problem.guides(&values, 4);
        guides.comparison.patch_radius = 0;
        let all = [&responses[..]];
        for covered in [1.0, 0.0] {
            // Nothing of the lattice reaches it: it is not left to that, either.
            let fitted = Fitted { covered, ..problem.fitted(&planes, &all, 1e-3, 3) };
            let found = collaborate(&fitted, &guides, &KERNELS[..1], &Silent).unwrap();
            assert!(problem.largest_difference(&found[0]) < 1e-5, "the lone pixel at {x} {y} or those around it");
        }
    }
}

#[test]
fn with_little_to_be_covered_by_fits_are_fewer() {
    let problem = Problem::random(Size::new(40, 28), 70);
    let (planes, values) = (problem.planes(), [problem.values()]);
    let responses = planes.responses();
    let all = [&responses[..]];
    let [all, few] = [1.0, 0.0].map(|covered| {
        let fitted = Fitted { covered, ..problem.fitted(&planes, &all, 1e-3, 3) };
        collaborate(&fitted, &problem.guides(&values, 4), &KERNELS[..1], &Silent).unwrap()
    });
    assert_ne!(all, few);
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let problem = Problem::random(Size::new(120, 70), 65);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&problem, 3, 2, 1e-3, None))
    };
    assert!(with(1) == with(4));
}

#[test]
fn what_no_fit_of_the_lattice_reaches_gets_one_of_its_own() {
    let problem = Problem::random(Size::new(40, 30), 69);
    let (planes, values) = (problem.planes(), [problem.values()]);
    let responses = planes.responses();
    let all = [&responses[..]];
    let fitted = Fitted { covered: 0.0, ..problem.fitted(&planes, &all, 1e-3, 8) };
    let found = collaborate(&fitted, &problem.guides(&values, 3), &KERNELS[1..2], &Silent).unwrap();
    assert!(found[0][0].iter().all(|plane| plane.iter().all(|v| *v != 0.0)));
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
    let (planes, values) = (problem.planes(), [problem.values()]);
    let (responses, guides) = (planes.responses(), problem.guides(&values, 2));
    for (stride, covered) in [(1, 1.0), (3, 1.0), (3, 0.0)] {
        let all = [&responses[..]];
        let fitted = Fitted { covered, ..problem.fitted(&planes, &all, 1e-3, stride) };
        let counting = Counting::default();
        collaborate(&fitted, &guides, &KERNELS[..1], &counting).unwrap();
        assert_eq!(counting.units.into_inner(), units(problem.size, stride));
        let stopping = Counting { stop: true, ..Counting::default() };
        assert_eq!(collaborate(&fitted, &guides, &KERNELS, &stopping).unwrap_err(), Cancelled);
    }
}
