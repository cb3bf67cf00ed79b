use serde_json::json;

use super::*;
use crate::{Component, ComponentRole, Feature, FeatureRole, Size, Window, place};

const SIZE: Size = Size::new(3, 2);

/// What sample `index` of `pixel` with a seed is worth.
fn sample(pixel: usize, index: u32, seed: u64) -> f32 {
    1.0 + ((pixel as u32 * 31 + index * 17 + seed as u32 * 5) % 23) as f32 * 0.1
}

/// The means over `group` of `groups` of the samples `first..first + total[pixel]`; NaN where there are none.
fn mean_of(counts: &SampleCounts, seed: u64, group: u32, groups: u32) -> Image {
    let Dealing::Numbered { sequences, buckets } = counts.dealing else { panic!("numbered") };
    let value = |pixel: usize| {
        let all = counts.first..counts.first + counts.total[pixel];
        let own: Vec<f32> = all
            .filter(|i| place(*i, sequences, buckets).bucket % groups == group)
            .map(|i| sample(pixel, i, seed))
            .collect();
        own.iter().sum::<f32>() / own.len() as f32
    };
    Image::from_channels(SIZE, vec![(0..SIZE.pixels()).map(value).collect(); 3])
}

fn slice(first: u32, total: Vec<u32>, seed: u64, [sequences, buckets]: [u32; 2]) -> Slice {
    let counts = SampleCounts { first, total, dealing: Dealing::Numbered { sequences, buckets } };
    let means = |groups: u32| {
        let images = (0..groups).map(|group| mean_of(&counts, seed, group, groups)).collect();
        Estimate::from_buckets(images, &counts)
    };
    let end = first + counts.total.iter().max().unwrap();
    let record = Record { view: json!({"scene": "box", "fov": 45}), held: vec![Held { first, end, seed }] };
    let settings = json!({});
    let header = StackHeader {
        first,
        sequences,
        buckets,
        per_bucket: None,
        settings,
        record: Some(record),
        samples_unknown: false,
    };
    let stack = FeatureStack {
        window: Window::whole(SIZE),
        film: SIZE,
        components: vec![Component { role: ComponentRole::Scattered, radiance: means(buckets) }],
        indirect: Some(means(buckets)),
        gathered: None,
        features: vec![Feature { role: FeatureRole::Albedo, estimate: means(buckets.min(2)) }],
        passthrough: vec![],
        samples: counts,
    };
    Slice { path: format!("{seed}-{first}.exr").into(), stack, header }
}

fn uniform(range: std::ops::Range<u32>, seed: u64, dealing: [u32; 2]) -> Slice {
    slice(range.start, vec![range.end - range.start; SIZE.pixels()], seed, dealing)
}

fn sum(slices: &[Slice]) -> (FeatureStack, StackHeader) {
    let mut sum = Sum::new(slices[0].clone()).unwrap();
    slices[1..].iter().for_each(|slice| sum.add(slice.clone()).unwrap());
    sum.finish()
}

fn refusal(slices: &[Slice]) -> MergeError {
    let mut sum = Sum::new(slices[0].clone()).unwrap();
    slices[1..].iter().find_map(|slice| sum.add(slice.clone()).err()).unwrap()
}

/// Demands that two estimates hold the same but for rounding, where they hold anything.
fn agree(a: &Estimate, a_counts: &SampleCounts, b: &Estimate, b_counts: &SampleCounts) {
    let near = |a: &Image, b: &Image, counted: &dyn Fn(usize) -> bool| {
        for pixel in (0..SIZE.pixels()).filter(|pixel| counted(*pixel)) {
            let [a, b] = [a.mean_at(pixel), b.mean_at(pixel)];
            assert!((a - b).abs() <= 1e-6 * b, "pixel {pixel}: {a} {b}");
        }
    };
    near(&a.mean, &b.mean, &|_| true);
    let (Noise::Buckets(a), Noise::Buckets(b)) = (&a.noise, &b.noise) else { return assert_eq!(a.noise, b.noise) };
    assert_eq!(a.len(), b.len());
    for group in 0..a.len() {
        let samples = |counts: &SampleCounts, pixel| counts.in_group(pixel, group, a.len());
        (0..SIZE.pixels()).for_each(|p| assert_eq!(samples(a_counts, p), samples(b_counts, p), "bucket {group}"));
        near(&a[group], &b[group], &|pixel| samples(a_counts, pixel) > 0);
    }
}

#[test]
fn slices_add_up_to_one_render() {
    for dealing in [[8, 8], [2, 8], [1, 8], [2, 2], [1, 1]] {
        let parts = [0..5, 5..7, 7..30].map(|range| uniform(range, 3, dealing));
        let (stack, header) = sum(&parts);
        let whole = uniform(0..30, 3, dealing);
        assert_eq!((&stack.samples, &header), (&whole.stack.samples, &whole.header), "{dealing:?}");
        for (a, b) in estimates(&stack).into_iter().zip(estimates(&whole.stack)) {
            agree(a, &stack.samples, b, &whole.stack.samples);
        }
    }
}

#[test]
fn buckets_without_samples_say_nothing_and_one_sample_each_does() {
    let parts = [0..1, 1..2, 2..3].map(|range| uniform(range, 0, [8, 8]));
    let Noise::Buckets(buckets) = &parts[0].stack.components[0].radiance.noise else { panic!("buckets") };
    assert!(buckets[4].mean_at(0).is_nan(), "what nothing was added to");
    let (stack, _) = sum(&parts);
    let Noise::Buckets(buckets) = &stack.components[0].radiance.noise else { panic!("buckets") };
    let values: Vec<f32> = buckets.iter().map(|bucket| bucket.mean_at(2)).collect();
    assert!((0..3).all(|i| (values[i] - sample(2, i as u32, 0)).abs() < 1e-6) && values[3..] == [0.0; 5], "{values:?}");
}

#[test]
fn a_gap_is_counted_bucket_by_bucket_and_can_be_filled() {
    let [a, b, c] = [0..5, 5..16, 16..19].map(|range| uniform(range, 0, [8, 8]));
    let (stack, header) = sum(&[a.clone(), c.clone()]);
    assert_eq!(stack.samples.dealing, Dealing::PerBucket(vec![2, 2, 2, 1, 1, 0, 0, 0]));
    assert_eq!(header.per_bucket, Some(vec![2, 2, 2, 1, 1, 0, 0, 0]));
    assert_eq!(header.record.as_ref().unwrap().held.len(), 2);
    let outer = Slice { path: "outer.exr".into(), stack, header };
    let (filled, header) = sum(&[outer, b]);
    let whole = uniform(0..19, 0, [8, 8]);
    assert_eq!((&filled.samples, &header), (&whole.stack.samples, &whole.header));
    agree(&filled.components[0].radiance, &filled.samples, &whole.stack.components[0].radiance, &whole.stack.samples);
}

#[test]
fn adaptive_renders_and_other_seeds_are_weighed_pixel_by_pixel() {
    let adaptive = slice(0, vec![4, 9, 16, 5, 11, 8], 0, [8, 8]);
    for other in [uniform(16..20, 0, [8, 8]), uniform(0..4, 1, [8, 8])] {
        let (stack, header) = sum(&[adaptive.clone(), other.clone()]);
        let [first, second] = [&adaptive, &other].map(|slice| &slice.stack);
        assert_eq!(header.record.unwrap().held.len(), 2);
        for pixel in 0..SIZE.pixels() {
            let [n, m] = [first, second].map(|stack| stack.samples.total[pixel] as f32);
            let [a, b] = [first, second].map(|stack| stack.beauty().mean_at(pixel));
            assert_eq!(stack.samples.total[pixel] as f32, n + m);
            assert!((stack.beauty().mean_at(pixel) - (n * a + m * b) / (n + m)).abs() < 1e-5);
            for bucket in 0..8 {
                let sum = first.samples.in_group(pixel, bucket, 8) + second.samples.in_group(pixel, bucket, 8);
                assert_eq!(stack.samples.in_group(pixel, bucket, 8), sum);
            }
        }
    }
}

#[test]
fn numbers_that_follow_one_another_are_no_range_when_seeds_differ() {
    let (stack, header) = sum(&[uniform(0..4, 0, [8, 8]), uniform(4..8, 1, [8, 8])]);
    assert_eq!(header.record.unwrap().held.len(), 2);
    assert_eq!(stack.samples.dealing, Dealing::PerBucket(vec![1; 8]));
}

#[test]
fn one_slice_stays_what_it_is() {
    let alone = slice(0, vec![4, 9, 16, 5, 11, 8], 0, [8, 8]);
    let (stack, header) = sum(std::slice::from_ref(&alone));
    assert_eq!((stack.samples, header), (alone.stack.samples, alone.header));
}

#[test]
fn the_same_samples_and_other_pictures_are_refused() {
    let a = uniform(0..8, 0, [8, 8]);
    let again = refusal(&[a.clone(), uniform(8..12, 0, [8, 8]), uniform(11..20, 0, [8, 8])]);
    assert!(again.to_string().contains("samples 11..20 of seed 0, but 0-8.exr holds 8..12"), "{again}");
    assert_eq!(again.fault(), crate::Fault::Input);
    let mut other = uniform(8..9, 0, [8, 8]);
    other.header.record.as_mut().unwrap().view = json!({"scene": "box", "fov": 50});
    let refused = refusal(&[a.clone(), other]).to_string();
    assert!(refused.contains("fov: expected 45 as in 0-0.exr, found 50"), "{refused}");
    let mut other = uniform(8..9, 0, [8, 8]);
    other.stack.window.x = 2;
    assert!(refusal(&[a.clone(), other]).to_string().contains("expected 0,0 as in 0-0.exr, found 2,0"));
    let mut other = uniform(8..9, 0, [8, 8]);
    other.stack.features.clear();
    assert!(
        refusal(&[a.clone(), other]).to_string().contains("layers: expected noisy in 8, indirect in 8, albedo in 2")
    );
    let mut other = uniform(8..9, 0, [8, 8]);
    other.header.record = None;
    assert!(matches!(refusal(&[a, other]), MergeError::NoRecord { .. }));
}

#[test]
fn the_first_difference_is_named() {
    let of = |a, b| first_difference(&a, &b).map(|d| (d.field, d.expected, d.found));
    let named = |field: &str, a: &str, b: &str| Some((field.to_string(), a.to_string(), b.to_string()));
    assert_eq!(of(json!({"a": {"b": 1, "c": [2]}}), json!({"a": {"c": [2], "b": 1}})), None);
    assert_eq!(of(json!({"a": {"b": 1, "c": [2]}}), json!({"a": {"b": 1, "c": [3]}})), named("a.c", "[2]", "[3]"));
    assert_eq!(of(json!({"a": "x"}), json!({"a": "x", "b": "y"})), named("b", "none", "y"));
}
