//! The split into two layers: what is cut, and that nothing is lost.

use stack::{ComponentRole, Dealing, Estimate, Size};

use super::super::test_scene::{component, flat, image};
use super::caps::binomial;
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(14, 11);

fn settings() -> SplitSettings {
    SplitSettings::default()
}

fn eight_each(size: Size) -> SampleCounts {
    SampleCounts::uniform(size.pixels(), vec![4; 8])
}

/// Eight buckets of exponentially distributed radiance; those without samples hold nothing that may be used.
fn skewed(counts: &SampleCounts, seed: u64) -> Vec<Image> {
    let mut noise = TestNoise(seed);
    let mut bucket = |b: usize| {
        let mut value = |pixel: usize| {
            let drawn = -(1.0 - noise.uniform()).ln() as f32;
            if counts.in_group(pixel, b, 8) > 0 { drawn.powi(3) } else { f32::NAN }
        };
        Image::from_channels(SIZE, (0..3).map(|_| (0..SIZE.pixels()).map(&mut value).collect()).collect())
    };
    (0..8).map(&mut bucket).collect()
}

/// Low layer plus events, against the mean of all samples.
fn check_sum(layers: &Layers, mean: &Image, counts: &SampleCounts) {
    for i in (0..mean.pixels()).filter(|i| counts.total[*i] > 0) {
        let [a, b] = [0, 1].map(|half| counts.in_group(i, half, 2) as f32);
        for c in 0..3 {
            let [low_a, low_b] = [0, 1].map(|half: usize| layers.low.halves[half].rgb(i)[c]);
            let [light_a, light_b] = [0, 1].map(|half: usize| layers.events.light[half].rgb(i)[c]);
            let mean = mean.rgb(i)[c];
            let sum = (a * low_a + b * low_b) / (a + b) + light_a + light_b;
            assert!((sum - mean).abs() < 1e-5 * (1.0 + mean), "pixel {i} of {}: {sum} {mean}", counts.total[i]);
        }
    }
}

#[test]
fn both_layers_add_up_to_the_mean() {
    let dealing = Dealing::Numbered { sequences: 8, buckets: 8 };
    let mixed: Vec<u32> = (0..SIZE.pixels()).map(|i| [1, 4, 13, 2, 64][i % 5]).collect();
    for total in [vec![1; SIZE.pixels()], vec![4; SIZE.pixels()], vec![13; SIZE.pixels()], mixed] {
        let counts = SampleCounts { first: 0, total, dealing: dealing.clone() };
        let component = component(skewed(&counts, 90), &counts);
        let layers = split(&component, &counts, &settings()).unwrap();
        check_sum(&layers, &component.radiance.mean, &counts);
        assert!(layers.low.variance.channels().iter().flatten().all(|v| v.is_finite() && *v > 0.0));
    }
}

#[test]
fn a_pixel_without_samples_is_black_and_of_known_variance() {
    let mut total = vec![13; SIZE.pixels()];
    total[20] = 0;
    let counts = SampleCounts { first: 0, total, dealing: Dealing::Numbered { sequences: 8, buckets: 8 } };
    let layers = split(&component(skewed(&counts, 91), &counts), &counts, &settings()).unwrap();
    assert_eq!(
        [&layers.low.halves[0], &layers.events.light[0], &layers.events.light[1]].map(|i| i.rgb(20)),
        [[0.0; 3]; 3]
    );
    assert!(layers.low.variance.rgb(20).iter().all(|v| v.is_finite() && *v > 0.0));
}

#[test]
fn a_half_without_samples_repeats_the_other() {
    let counts = SampleCounts::uniform(SIZE.pixels(), vec![3, 0]);
    let buckets = vec![flat(SIZE, 0.5), flat(SIZE, f32::NAN)];
    let layers = split(&component(buckets, &counts), &counts, &settings()).unwrap();
    assert_eq!(layers.low.halves, [flat(SIZE, 0.5), flat(SIZE, 0.5)]);
}

#[test]
fn smooth_pictures_are_not_cut() {
    let smooth = image(SIZE, |x, y, c| 0.2 + 0.05 * x as f32 + 0.03 * y as f32 + 0.1 * c as f32);
    let counts = eight_each(SIZE);
    let layers = split(&component(vec![smooth.clone(); 8], &counts), &counts, &settings()).unwrap();
    assert!(layers.events.energy.iter().chain(&layers.events.squares).all(|e| *e == 0.0));
    assert_eq!(layers.events.light, [flat(SIZE, 0.0), flat(SIZE, 0.0)]);
    for (half, smooth) in layers.low.halves.iter().flat_map(|h| h.channels().iter().zip(smooth.channels())) {
        assert!(half.iter().zip(smooth).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}

#[test]
fn a_firefly_is_cut_to_the_cap_and_its_energy_becomes_an_event() {
    let (counts, at) = (eight_each(SIZE), SIZE.index(6, 5));
    let mut buckets = vec![flat(SIZE, 1.0); 8];
    for (plane, value) in buckets[3].channels_mut().iter_mut().zip([1500.0, 900.0, 600.0]) {
        plane[at] = value;
    }
    let layers = split(&component(buckets, &counts), &counts, &settings()).unwrap();
    // The surroundings reach 1, the cap is a multiple of that, and the bucket's luminance is 1000.
    let kept = settings().factor / 1000.0;
    let close = |a: f32, b: f32| (a - b).abs() < 1e-4 * b;
    for (c, value) in [1500.0, 900.0, 600.0].into_iter().enumerate() {
        assert!(close(layers.events.light[1].rgb(at)[c], (1.0 - kept) * value / 8.0));
        assert!(close(layers.low.halves[1].rgb(at)[c], (3.0 + kept * value) / 4.0), "its own half keeps the cap");
        assert_eq!(layers.low.halves[0].rgb(at)[c], 1.0, "and the other none of it");
    }
    let event = 4.0 * (1.0 - kept) * 3000.0;
    assert!(close(layers.events.energy[at], event) && close(layers.events.squares[at], event * event));
    let others = (0..SIZE.pixels()).filter(|i| *i != at);
    assert!(others.into_iter().all(|i| layers.events.energy[i] == 0.0 && layers.low.halves[1].rgb(i) == [1.0; 3]));
}

#[test]
fn light_that_all_buckets_agree_on_is_no_firefly() {
    let (counts, at) = (eight_each(SIZE), SIZE.index(6, 5));
    let bright = image(SIZE, |x, y, _| if SIZE.index(x, y) == at { 50.0 } else { 1.0 });
    let layers = split(&component(vec![bright; 8], &counts), &counts, &settings()).unwrap();
    assert_eq!((layers.events.energy[at], layers.low.halves[0].rgb(at)), (0.0, [50.0; 3]));
}

#[test]
fn where_two_fireflies_meet_there_is_no_detail() {
    let (counts, at) = (eight_each(SIZE), SIZE.index(6, 5));
    // The share of an excess of 50 over a cap of 2 that stays in the mean of eight buckets.
    let kept = |bright: &[usize], others: &[usize]| {
        let mut buckets = vec![flat(SIZE, 1.0); 8];
        let at_pixel = bright.iter().map(|bucket| (*bucket, at));
        for (bucket, pixel) in at_pixel.chain(others.iter().map(|pixel| (pixel % 8, *pixel))) {
            buckets[bucket].channels_mut().iter_mut().for_each(|plane| plane[pixel] = 52.0);
        }
        let layers = split(&component(buckets, &counts), &counts, &settings()).unwrap();
        let low = 0.5 * (layers.low.halves[0].rgb(at)[0] + layers.low.halves[1].rgb(at)[0]);
        (8.0 * low - (8.0 + bright.len() as f32)) / (50.0 * bright.len() as f32)
    };
    let others = [SIZE.index(4, 4), SIZE.index(7, 3), SIZE.index(8, 6)];
    let [two, among_others, three] = [kept(&[1, 4], &[]), kept(&[1, 4], &others), kept(&[1, 4, 6], &[])];
    assert!((0.2..0.5).contains(&two), "without other fireflies it may be either: {two}");
    assert!(among_others < 0.03 && three > 0.9, "{among_others} {three}");
}

#[test]
fn of_fireflies_that_meet_in_both_halves_nothing_is_left() {
    let (mut noise, pixel) = (TestNoise(96), SIZE.index(7, 5));
    let mut half = || -> Vec<f32> {
        let light = |i: usize, share: f64| if i == pixel { 5.0 } else { 0.1 + 0.02 * share as f32 };
        (0..SIZE.pixels()).map(|i| light(i, noise.uniform())).collect()
    };
    let (halves, samples) = ([half(), half()], SampleCounts::uniform(SIZE.pixels(), vec![8; 2]));
    let cut_at = |detail: f32| caps(SIZE, &halves, &samples, &SplitSettings { detail, ..settings() })[pixel];
    let [detail, chance] = [1e3, 1e-9].map(cut_at);
    assert!((4.99..5.01).contains(&detail), "{detail}");
    assert!((0.1..0.12).contains(&chance), "{chance}");
}

#[test]
fn where_more_events_happen_to_meet_little_more_of_their_light_is_kept() {
    let (size, mut noise) = (Size::new(72, 72), TestNoise(93));
    let mut bucket = || (0..size.pixels()).map(|_| if noise.uniform() < 0.03 { 20.0 } else { 1.0 }).collect();
    let luminances: Vec<Vec<f32>> = (0..8).map(|_| bucket()).collect();
    let samples = eight_each(size);
    // Variance of the logarithm of what buckets are cut at.
    let variance = |smoothing: usize| {
        let caps = caps(size, &luminances, &samples, &SplitSettings { smoothing, ..settings() });
        let mean = |f: &dyn Fn(f32) -> f32| caps.iter().map(|cap| f(cap.ln())).sum::<f32>() / caps.len() as f32;
        mean(&|v| v * v) - mean(&|v| v).powi(2)
    };
    let [evened_out, as_it_is] = [SplitSettings::DEFAULT.smoothing, 0].map(variance);
    assert!(evened_out < 0.3 * as_it_is, "{evened_out} {as_it_is}");
}

#[test]
fn buckets_of_few_samples_are_cut_higher_among_others_of_many() {
    let (size, mut noise) = (Size::new(72, 72), TestNoise(94));
    let few = |pixel: usize| (30..42).contains(&(pixel % 72)) && (30..42).contains(&(pixel / 72));
    let total = (0..size.pixels()).map(|pixel| if few(pixel) { 8 } else { 64 }).collect();
    let samples = SampleCounts { total, ..eight_each(size) };
    // A tenth of all samples meets a light of 10.
    let mut bucket = |pixel: usize| {
        let count = samples.total[pixel] / 8;
        (0..count).filter(|_| noise.uniform() < 0.1).count() as f32 * 10.0 / count as f32
    };
    let luminances: Vec<Vec<f32>> = (0..8).map(|_| (0..size.pixels()).map(&mut bucket).collect()).collect();
    let [raised, plain] = [SplitSettings::DEFAULT.few, 0.0]
        .map(|few| caps(size, &luminances, &samples, &SplitSettings { few, ..settings() }));
    let cut_from_few = |caps: &[f32]| {
        let pixels = || luminances.iter().flat_map(|l| (0..l.len()).filter(|i| few(*i)).map(|i| (l[i], caps[i])));
        1.0 - pixels().map(|(l, cap)| l.min(cap)).sum::<f32>() / pixels().map(|(l, _)| l).sum::<f32>()
    };
    let [with, without] = [&raised, &plain].map(|caps| cut_from_few(caps));
    assert!(with < 0.5 * without, "{with} {without}");
    assert!((0..size.pixels()).filter(|i| i % 72 < 10).all(|i| raised[i] == plain[i]), "far from those");
    let not_smoothed = [SplitSettings::DEFAULT.few, 0.0]
        .map(|few| caps(size, &luminances, &samples, &SplitSettings { few, smoothing: 0, ..settings() }));
    assert_ne!(not_smoothed[0], not_smoothed[1], "whether or not caps are evened out");
}

#[test]
fn what_is_never_taken_for_a_detail_is_cut_at_what_surroundings_reach() {
    let size = Size::new(9, 9);
    let mut luminances = vec![vec![0.1; size.pixels()]; 40];
    luminances.iter_mut().for_each(|bucket| bucket[40] = 10.0);
    let samples = SampleCounts::uniform(size.pixels(), vec![1; 40]);
    let found = caps(size, &luminances, &samples, &SplitSettings { detail: 0.0, ..settings() });
    assert!(found.iter().all(|cap| *cap > 0.1), "{}", found[40]);
}

#[test]
fn chances_of_a_number_of_events_add_up() {
    let chances: Vec<f32> = (0..=8).map(|k| binomial(k, 8, 0.3)).collect();
    assert!((chances.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    assert!((chances[2] - 28.0 * 0.09 * 0.7_f32.powi(6)).abs() < 1e-6);
    assert_eq!((binomial(0, 0, 0.5), binomial(2, 2, 0.25)), (1.0, 0.0625));
}

/// Variance of a half of one pixel whose buckets hold `values` and `samples`.
fn variance_of(values: &[f32], samples: &[u32]) -> f32 {
    let (size, counts) = (Size::new(1, 1), SampleCounts::uniform(1, samples.to_vec()));
    let buckets = values.iter().map(|v| flat(size, *v)).collect();
    split(&component(buckets, &counts), &counts, &settings()).unwrap().low.variance.rgb(0)[1]
}

#[test]
fn the_variance_follows_the_closed_form() {
    // Mean 2.5, squares 2.25 + 0.25 + 0.25 + 2.25 = 5, of the mean 5/(3·4), of a half twice that.
    let of_four = variance_of(&[1.0, 2.0, 3.0, 4.0], &[5, 5, 5, 5]);
    assert!((of_four - 2.0 * 5.0 / 12.0).abs() < 1e-5, "{of_four}");
    // Six samples: mean (3 + 4 + 3)/6 = 5/3; squares 3·4/9 + 2·1/9 + 16/9 = 30/9; (B − 1) n = 12.
    let unequal = variance_of(&[1.0, 2.0, f32::NAN, 3.0], &[3, 2, 0, 1]);
    assert!((unequal - 2.0 * 30.0 / 9.0 / 12.0).abs() < 1e-5, "{unequal}");
}

#[test]
fn the_variance_is_that_of_a_half_on_the_average() {
    let size = Size::new(60, 60);
    let (counts, mut noise) = (eight_each(size), TestNoise(92));
    let one = flat(size, 1.0);
    let buckets = (0..8).map(|_| super::super::test_scene::with_noise(&one, 0.2, &mut noise)).collect();
    let layers = split(&component(buckets, &counts), &counts, &settings()).unwrap();
    let mean = layers.low.variance.channels().iter().flatten().sum::<f32>() / (3 * size.pixels()) as f32;
    assert!((mean / (0.04 / 4.0) - 1.0).abs() < 0.05, "four buckets of variance 0.04: {mean}");
}

#[test]
fn without_buckets_a_variance_will_do_and_without_it_there_is_an_error() {
    let split_with = |noise: Noise| {
        let component =
            Component { role: ComponentRole::Scattered, radiance: Estimate { mean: flat(SIZE, 1.0), noise } };
        split(&component, &eight_each(SIZE), &settings())
    };
    let layers = split_with(Noise::VarianceOfMean(flat(SIZE, 0.1))).unwrap();
    assert!(layers.low.variance.channels().iter().flatten().all(|v| (v - 0.2).abs() < 1e-5), "that of a half");
    assert_ne!(layers.low.halves[0], layers.low.halves[1]);
    let error = split_with(Noise::Unknown).unwrap_err();
    assert!(matches!(error, ReconstructError::NoBuckets { layer: "noisy" }));
}

#[test]
fn unequal_halves_are_turned_into_equal_ones_that_know_nothing_of_each_other() {
    let (mut noise, count) = (TestNoise(5), 40_000);
    let (a, b) = (9.0_f32, 5.0_f32);
    let [x, y] = [a, b].map(|n| noise.normals(count, 2.0, (1.0 / n).sqrt()));
    let found: Vec<[f32; 2]> = x.iter().zip(&y).map(|(x, y)| balanced([*x, *y], [a, b])).collect();
    let moment = |f: &dyn Fn(&[f32; 2]) -> f32| found.iter().map(f).sum::<f32>() / count as f32;
    for half in 0..2 {
        let variance = moment(&|v| (v[half] - 2.0).powi(2));
        assert!((variance / (2.0 / (a + b)) - 1.0).abs() < 0.03, "{half}: {variance}");
    }
    assert!(moment(&|v| (v[0] - 2.0) * (v[1] - 2.0)).abs() < 0.02 * 2.0 / (a + b));
    let mean = |i: usize| (a * x[i] + b * y[i]) / (a + b);
    assert!(found.iter().enumerate().all(|(i, [p, q])| (0.5 * (p + q) - mean(i)).abs() < 1e-5));
    assert_eq!(balanced([1.0, 3.0], [4.0, 4.0]), [1.0, 3.0]);
    assert_eq!(balanced([1.0, 1.0], [4.0, 0.0]), [1.0, 1.0], "the other repeated");
    let uneven = |n| balanced([0.5, 3.0], n);
    assert_eq!(uneven([9.0, 1.0]), uneven([2.0, 1.0]), "no half counts for more than twice the other");
}
