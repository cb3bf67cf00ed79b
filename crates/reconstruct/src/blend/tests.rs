use super::*;
use crate::best::test_scene::{error, flat, stack_of, walls, with_noise};
use crate::reconstruct;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(72, 60);

struct Scene {
    truth: Image,
    stack: FeatureStack,
    rebuilt: Reconstruction,
}

fn scene() -> Scene {
    let truth = walls(SIZE);
    let stack = stack_of(&truth, 4);
    let rebuilt = reconstruct(&stack, &Settings::default(), &Silent).unwrap();
    Scene { truth, stack, rebuilt }
}

impl Scene {
    fn blend(&self, other: &Image) -> Blend {
        blend(&self.stack, &self.rebuilt, other, &Settings::default(), &Silent).unwrap()
    }

    /// Squared error with another picture over that without.
    fn ratio(&self, other: &Image) -> f32 {
        error(&self.blend(other).picture, &self.truth) / error(&self.rebuilt.picture, &self.truth)
    }
}

#[test]
fn an_exact_picture_helps_and_useless_ones_do_no_harm() {
    let scene = scene();
    let exact = scene.ratio(&scene.truth);
    let black = scene.ratio(&flat(SIZE, 0.0));
    let noisy = scene.ratio(&scene.stack.beauty());
    let other = scene.ratio(&with_noise(&scene.truth, 0.3, &mut TestNoise(9)));
    assert!(exact < 0.8, "{exact}");
    // No denoiser leaves noise that nothing else has: it may cost a little more.
    for (useless, ratio, limit) in [("black", black, 1.02), ("noisy", noisy, 1.02), ("with other noise", other, 1.05)] {
        assert!(ratio < limit, "{useless}: {ratio}");
    }
    let black = scene.blend(&flat(SIZE, 0.0));
    assert!(error(&black.picture, &scene.rebuilt.picture) < 4e-4 * error(&scene.rebuilt.picture, &flat(SIZE, 0.0)));
}

#[test]
fn our_own_picture_mixed_in_changes_nothing() {
    let scene = scene();
    let picture = scene.blend(&scene.rebuilt.picture).picture;
    assert_eq!(picture, scene.rebuilt.picture);
}

#[test]
fn units_do_not_matter() {
    let Scene { truth, stack, rebuilt } = scene();
    let with = |factor: f32| {
        let stack = stack.clone().exposed(factor);
        let (rebuilt, other) = (rebuilt.clone().exposed(factor), truth.clone().exposed(factor));
        blend(&stack, &rebuilt, &other, &Settings::default(), &Silent).unwrap()
    };
    // Both so dark that all they are relative to would be but the constants that keep it finite.
    let [dark, darker] = [-14, -22].map(|exponent| with(2.0_f32.powi(exponent)));
    assert!(dark.weights == darker.weights);
}

#[test]
fn values_that_are_not_finite_are_left_out() {
    let scene = scene();
    let mut other = scene.truth.clone();
    let hole = SIZE.index(30, 20);
    other.channels_mut()[0][hole] = f32::NAN;
    other.channels_mut()[2][hole + 7] = f32::INFINITY;
    let blended = scene.blend(&other);
    assert!(blended.picture.channels().iter().flatten().all(|v| v.is_finite()));
    assert_eq!(blended.picture.channels()[0][hole], scene.rebuilt.picture.channels()[0][hole]);
}

#[test]
fn no_strength_leaves_the_other_picture_alone() {
    let scene = scene();
    let mut settings = Settings::default();
    settings.guide.strength = 0.0;
    let blended = blend(&scene.stack, &scene.rebuilt, &scene.truth, &settings, &Silent).unwrap();
    assert_eq!((blended.picture.clone(), blended.mean_weight()), (scene.rebuilt.picture, 0.0));
}

#[test]
fn a_picture_of_another_size_is_refused() {
    let error = check_size(&flat(Size::new(5, 4), 1.0), SIZE).unwrap_err();
    assert!(matches!(error.fault(), Fault::Input));
    let text = error.to_string();
    assert!(text.contains("5x4") && text.contains("72x60"), "{text}");
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let scene = scene();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scene.blend(&scene.truth))
    };
    assert_eq!(with(1), with(3));
}
