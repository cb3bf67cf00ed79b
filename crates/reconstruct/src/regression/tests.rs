//! Promises of the regression as a whole.

use pulp::{Scalar, WithSimd};
use stack::{Image, Monitor, Silent, Size};

use super::field::Field;
use super::row::RowTask;
use super::twin::{Scene, pixel};
use super::*;

fn small_window() -> RegressionSettings {
    let mut settings = RegressionSettings::default();
    settings.window.radius = 5;
    settings
}

fn run(input: &RegressionInput, settings: &RegressionSettings) -> Regression {
    regress(input, settings, &Silent).unwrap()
}

#[test]
fn agrees_with_the_plain_method_in_double_precision() {
    let scene = Scene::new(Size::new(40, 33), 0.05);
    for radius in [5, 11] {
        let mut settings = RegressionSettings::default();
        settings.window.radius = radius;
        let fast = run(&scene.input(), &settings);
        let (mut pixels, mut same_rank) = (0, 0);
        for (x, y) in (0..40).step_by(3).flat_map(|x| [0, 7, 18, 32].map(|y| (x, y))) {
            let (exact, at) = (pixel(&scene.input(), &settings, x, y), x + 40 * y);
            pixels += 1;
            if exact.rank as f32 == fast.rank[at] {
                same_rank += 1;
                assert!((exact.bandwidth as f32 - fast.bandwidth[at]).abs() < 2e-3, "({x}, {y})");
                assert!((exact.mse as f32 - fast.mse[at]).abs() < 2e-4 + 0.01 * fast.mse[at], "({x}, {y})");
                for c in 0..3 {
                    let difference = exact.colour[c] as f32 - fast.picture.channels()[c][at];
                    assert!(difference.abs() < 2e-3, "radius {radius}, ({x}, {y}): {difference}");
                }
            }
        }
        assert!(same_rank * 20 >= pixels * 19, "radius {radius}: {same_rank} of {pixels} ranks agree");
    }
}

#[test]
fn exact_on_colours_linear_in_the_features() {
    let mut scene = Scene::new(Size::new(30, 26), 0.0);
    scene.features.planes.truncate(4);
    scene.features.groups.truncate(1);
    scene.features.groups.push(3..4);
    let planes = &scene.features.planes;
    let linear = |c: usize, i: usize| 3.0 + planes[0][i] - 0.5 * planes[1][i] + 0.3 * c as f32 * planes[3][i];
    let channels = (0..3).map(|c| (0..780).map(|i| linear(c, i)).collect()).collect();
    scene.colour = Image::from_channels(Size::new(30, 26), channels);
    let mut settings = small_window();
    settings.reduction.method = ReductionMethod::Svd;
    settings.reduction.energy = 1.0;
    settings.local_linear.ridge = 1e-7;
    let found = run(&scene.input(), &settings);
    for c in 0..3 {
        for (a, b) in found.picture.channels()[c].iter().zip(&scene.colour.channels()[c]) {
            assert!((a - b).abs() < 1e-5, "{a} is not {b}");
        }
    }
}

#[test]
fn a_constant_picture_stays_as_it_is() {
    let mut scene = Scene::new(Size::new(19, 12), 0.0);
    scene.colour = Image::from_channels(Size::new(19, 12), vec![vec![0.7; 228], vec![0.0; 228], vec![1e4; 228]]);
    assert_eq!(run(&scene.input(), &small_window()).picture, scene.colour);
}

#[test]
fn without_features_it_is_the_mean_of_the_window() {
    let mut scene = Scene::new(Size::new(9, 9), 0.1);
    scene.features.planes.clear();
    scene.features.groups.clear();
    let found = run(&scene.input(), &small_window());
    let mean: f32 = scene.colour.channels()[0].iter().sum::<f32>() / 81.0;
    assert!((found.picture.channels()[0][40] - mean).abs() < 1e-5);
    assert!((found.mse[40] - variance_and_bias(&scene, &found, 40)).abs() < 1e-6);
    assert!(found.rank.iter().all(|k| *k == 0.0));
}

/// Equation 7 for a mean of 81 pixels of equal variance.
fn variance_and_bias(scene: &Scene, found: &Regression, at: usize) -> f32 {
    let bias = |c: usize| found.picture.channels()[c][at] - scene.colour.channels()[c][at];
    (0..3).map(|c| (bias(c).powi(2) + scene.variance.channels()[c][at] / 81.0) / 3.0).sum()
}

#[test]
fn constant_features_are_as_good_as_none() {
    let mut scene = Scene::new(Size::new(17, 11), 0.1);
    let found_with = |scene: &Scene| run(&scene.input(), &small_window());
    for plane in &mut scene.features.planes {
        plane.fill(0.3);
    }
    let constant = found_with(&scene);
    scene.features.planes.clear();
    scene.features.groups.clear();
    assert_eq!(constant, found_with(&scene));
}

#[test]
fn one_feature_has_one_dimension() {
    let mut scene = Scene::new(Size::new(17, 11), 0.02);
    scene.features.planes.truncate(1);
    scene.features.groups = std::iter::once(0..1).collect();
    let found = run(&scene.input(), &small_window());
    assert!(found.rank.iter().all(|k| *k == 1.0));
    assert!(found.picture.channels()[0].iter().all(|v| v.is_finite()));
}

#[test]
fn a_picture_of_one_pixel_is_kept_with_its_variance() {
    let scene = Scene::new(Size::new(1, 1), 0.1);
    let found = run(&scene.input(), &RegressionSettings::default());
    assert_eq!(found.picture, scene.colour);
    assert!((found.mse[0] - 0.01).abs() < 1e-6);
    assert_eq!(found.kept, 1);
}

#[test]
fn a_pixel_unlike_its_neighbours_is_kept() {
    let mut scene = Scene::new(Size::new(15, 15), 0.1);
    for plane in &mut scene.features.planes {
        plane.fill(-0.5);
        plane[7 * 15 + 7] = 0.5;
    }
    let mut settings = small_window();
    settings.bandwidth.fixed = 0.5;
    let found = run(&scene.input(), &settings);
    assert_eq!(found.kept, 1);
    assert_eq!(found.picture.channels()[1][7 * 15 + 7], scene.colour.channels()[1][7 * 15 + 7]);
    assert!((found.mse[7 * 15 + 7] - 0.01).abs() < 1e-6);
}

#[test]
fn wild_features_leave_no_trace_of_nan() {
    let mut scene = Scene::new(Size::new(23, 17), 0.1);
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38, -1e38, 1e-38, f32::MIN_POSITIVE, 0.0];
    for (p, plane) in scene.features.planes.iter_mut().enumerate() {
        for (i, value) in plane.iter_mut().enumerate().filter(|(i, _)| (i * 7 + p * 3) % 5 == 0) {
            *value = wild[(i + p) % wild.len()];
        }
    }
    for normalise in [Normalisation::Window, Normalisation::None] {
        for method in [ReductionMethod::RobustPca, ReductionMethod::Svd] {
            let mut settings = small_window();
            settings.window.normalise = normalise;
            settings.reduction.method = method;
            let found = run(&scene.input(), &settings);
            let planes = found.picture.channels().iter().chain([&found.mse, &found.bandwidth]);
            assert!(planes.into_iter().all(|plane| plane.iter().all(|v| v.is_finite())));
        }
    }
}

#[test]
fn no_result_is_negative_where_no_input_is() {
    let mut scene = Scene::new(Size::new(40, 30), 0.0);
    for (c, channel) in scene.colour.channels_mut().iter_mut().enumerate() {
        for (i, value) in channel.iter_mut().enumerate() {
            *value = if (i * (7 + c)) % 11 == 0 { 5.0 } else { 0.0 };
        }
    }
    let found = run(&scene.input(), &small_window());
    assert!(found.picture.channels().iter().flatten().all(|v| *v >= 0.0));
}

#[test]
fn predicted_errors_match_true_ones_on_average() {
    let scene = Scene::new(Size::new(64, 48), 0.1);
    let found = run(&scene.input(), &small_window());
    let truth: f32 = (0..3)
        .flat_map(|c| found.picture.channels()[c].iter().zip(&scene.clean.channels()[c]))
        .map(|(a, b)| (a - b).powi(2) / 3.0)
        .sum();
    let ratio = found.mse.iter().sum::<f32>() / truth;
    // The bias estimate α̂ − y_c holds the noise of y_c itself, so eq. 7 overestimates by about the input's variance.
    let noise = 0.01 * found.mse.len() as f32;
    let without_own_noise = (found.mse.iter().sum::<f32>() - noise) / truth;
    assert!(ratio > 1.0, "{ratio}");
    assert!((0.4..1.6).contains(&without_own_noise), "{without_own_noise}");
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let scene = Scene::new(Size::new(45, 20), 0.1);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&scene.input(), &small_window()))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn same_bytes_one_pixel_at_a_time() {
    let mut scene = Scene::new(Size::new(45, 20), 0.1);
    scene.features.planes[3].iter_mut().skip(200).for_each(|v| *v = 0.1);
    let (settings, input) = (small_window(), scene.input());
    let field = Field::new(&input, 5);
    let found = run(&input, &settings);
    for y in [0, 4, 11] {
        let row = RowTask { input: &input, field: &field, settings: &settings, y }.with_simd(Scalar);
        for c in 0..3 {
            assert_eq!(row.colour[c], found.picture.channels()[c][y * 45..(y + 1) * 45]);
        }
        assert_eq!(row.mse, found.mse[y * 45..(y + 1) * 45]);
        assert_eq!(row.rank, found.rank[y * 45..(y + 1) * 45]);
    }
}

#[test]
fn inactive_pixels_keep_their_colour_and_change_nothing_else() {
    let scene = Scene::new(Size::new(30, 20), 0.1);
    let active: Vec<bool> = (0..600).map(|i| i % 7 == 3).collect();
    let part = run(&RegressionInput { active: Some(&active), ..scene.input() }, &small_window());
    let all = run(&scene.input(), &small_window());
    for i in 0..600 {
        let expected = if active[i] { &all.picture } else { &scene.colour };
        assert_eq!(part.picture.channels()[2][i], expected.channels()[2][i]);
        assert_eq!(part.mse[i], if active[i] { all.mse[i] } else { 0.0 });
    }
}

#[test]
fn stops_when_told_to() {
    struct Impatient;
    impl Monitor for Impatient {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let scene = Scene::new(Size::new(8, 8), 0.1);
    assert_eq!(regress(&scene.input(), &small_window(), &Impatient), Err(Cancelled));
}

#[test]
fn every_second_neighbour_tells_the_same_directions() {
    let scene = Scene::new(Size::new(48, 40), 0.05);
    let with = |stride: usize| {
        let mut settings = RegressionSettings::default();
        settings.reduction.stride = stride;
        run(&scene.input(), &settings)
    };
    let (all, half) = (with(1), with(2));
    let same = all.rank.iter().zip(&half.rank).filter(|(a, b)| a == b).count() as f32 / all.rank.len() as f32;
    let error = |found: &Regression| -> f32 {
        let pairs = found.picture.channels().iter().flatten().zip(scene.clean.channels().iter().flatten());
        pairs.map(|(a, b)| (a - b).powi(2)).sum()
    };
    assert!(same > 0.8, "{same} of the ranks are the same");
    assert!(error(&half) < 1.1 * error(&all), "{} against {}", error(&half), error(&all));
}
