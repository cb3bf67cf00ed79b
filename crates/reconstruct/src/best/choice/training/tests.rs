//! The slope against finite differences, and what training promises.

use stack::{FeatureStack, Silent, Size};

use super::super::inputs::Block;
use super::*;
use crate::best::settings::BestSettings;
use crate::best::test_scene::{stack_of, walls, with_noise};
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(32, 24);

fn example(seed: u64) -> Example {
    let clean = walls(SIZE);
    let stack: FeatureStack = stack_of(&clean, seed);
    let mut noise = TestNoise(seed + 1);
    let references = [0, 1].map(|_| {
        let mut reference = stack.clone();
        reference.components[0].radiance.mean = with_noise(&clean, 0.01, &mut noise);
        reference
    });
    let [example] =
        Example::all_of(&stack, &references, &BestSettings::default(), seed, &Silent).unwrap().try_into().unwrap();
    example
}

/// A network that says a lot, for inputs as they are.
fn network(examples: &[Example]) -> Chooser {
    let mut chooser = start(examples, 3);
    chooser.parameters = TestNoise(8).normals(PARAMETERS, 0.0, 0.2);
    chooser
}

#[test]
fn the_slope_is_that_of_finite_differences() {
    let examples = [example(20)];
    let mut chooser = network(&examples);
    // With a norm this large no error is far, so that the slope is that of the error.
    let error = |chooser: &Chooser| slope_with_norm(&examples[0], chooser, 1e6);
    let found = error(&chooser);
    let largest = found.gradient.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
    for i in (0..PARAMETERS).step_by(11).chain(HIDDEN * NODE..PARAMETERS) {
        let mut moved = |change: f32| {
            let kept = chooser.parameters[i];
            chooser.parameters[i] = kept + change;
            let moved = error(&chooser).error;
            chooser.parameters[i] = kept;
            moved
        };
        let expected = (moved(1e-2) - moved(-1e-2)) / 2e-2;
        assert!((found.gradient[i] - expected).abs() < 0.02 * largest, "{i}: {} {expected}", found.gradient[i]);
    }
}

fn slope_with_norm(example: &Example, chooser: &Chooser, norm: f32) -> Slope {
    let mut sum = Slope::nothing();
    for number in 0..8 {
        slope_of_block(&Judged { norm, ..example.judged(number) }, chooser, &mut sum);
    }
    sum
}

#[test]
fn weights_of_a_block_add_up_to_one() {
    let examples = [example(21)];
    let chooser = network(&examples);
    let sums = examples[0].blocks.iter().flat_map(|block: &Block| {
        let weights = chooser.weights(block);
        (0..weights[0].len()).map(move |lane| weights.iter().map(|weight| weight[lane]).sum::<f32>())
    });
    sums.for_each(|sum| assert!((sum - 1.0).abs() < 1e-5, "{sum}"));
}

#[test]
fn candidates_are_told_apart_by_their_place() {
    let examples = [example(22)];
    let mut chooser = start(&examples, 1);
    // Hidden node 0 hears of candidate 4 only, and speaks for it.
    chooser.parameters.fill(0.0);
    (chooser.parameters[4], chooser.parameters[HIDDEN * NODE]) = (3.0, 50.0);
    for weights in examples[0].blocks.iter().map(|block| chooser.weights(&Block { rule: [[0.0; 16]; 6], ..*block })) {
        assert!(weights[4].iter().all(|weight| *weight > 0.999));
    }
}

#[test]
fn training_lowers_the_error_and_does_not_depend_on_threads() {
    let (examples, unseen) = ([example(23), example(25)], [example(27)]);
    let settings = TrainingSettings { steps: 60, blocks: 8, rate: 0.01, decay: 1e-4, seed: 4 };
    let trained = train(&examples, &settings, &Silent).unwrap();
    let blocks = unseen[0].blocks.len();
    let [before, after] = [start(&examples, 4), trained.clone()].map(|c| mean_slope(&unseen, &c, 0, blocks).error);
    assert!(after < 0.97 * before, "{after} {before}");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| train(&examples, &settings, &Silent).unwrap()), trained);
}
