use glam::Vec3;
use stack::{ComponentRole, FeatureRole, Noise, place};

use super::*;

const WINDOW: Window = Window { x: 3, y: -2, size: Size::new(20, 18) };

fn settings(sequences: u32, buckets: u32) -> TraceSettings {
    TraceSettings { sequences, buckets, ..TraceSettings::DEFAULT }
}

/// A sample whose every value tells where it belongs.
fn record(pixel: usize, index: u32) -> SampleRecord {
    let value = (pixel % 7) as f32 + (index * index % 11) as f32;
    SampleRecord {
        scattered: Vec3::new(value, 2.0 * value, 3.0 * value),
        emission: Vec3::splat(0.5 * value),
        indirect: Vec3::new(0.25 * value, value, 0.75 * value),
        gathered: Vec3::new(value, 0.0, 0.5 * value),
        to_gather: None,
        features: FeatureRecord {
            position: Vec3::new(value, 0.0, -value),
            albedo: Vec3::splat(value / 20.0),
            normal: Vec3::Z,
            visibility: (index % 2) as f32,
            depth: 4.0 * value,
            proximity: 1.0 / (1.0 + value),
            lit: (index % 3 / 2) as f32,
        },
    }
}

fn add(film: &mut Film, samples: std::ops::Range<u32>) {
    let [sequences, buckets] = film.dealing();
    let mut tiles: Vec<TileSums> = Tile::all(film.window.size)
        .into_iter()
        .map(|tile| {
            let mut sums = TileSums::new(tile.clone(), buckets, 0);
            for (i, (_, _, pixel)) in tile.pixels().enumerate() {
                for index in samples.clone() {
                    sums.add(i, place(index, sequences, buckets).bucket, &record(pixel, index));
                }
            }
            sums
        })
        .collect();
    film.add_pass(&mut tiles);
}

fn filled(sequences: u32, buckets: u32) -> Film {
    let mut film = Film::new(WINDOW, Size::new(64, 64), &settings(sequences, buckets));
    for start in [0, 8, 16] {
        add(&mut film, start..start + 8);
    }
    add(&mut film, 24..29);
    film
}

#[test]
fn means_are_plain_means_for_every_dealing() {
    for (sequences, buckets) in [(1, 1), (1, 8), (2, 8), (8, 8), (2, 2)] {
        let stack = filled(sequences, buckets).into_stack();
        let depth = &stack.feature(FeatureRole::Depth).unwrap().estimate.mean;
        for pixel in [0, 17, 359] {
            let expected = (0..29).map(|i| record(pixel, i).features.depth).sum::<f32>() / 29.0;
            assert!((depth.channels()[0][pixel] - expected).abs() < 1e-4);
            let radiance = stack.beauty().rgb(pixel);
            let expected = (0..29).map(|i| record(pixel, i).scattered.y + record(pixel, i).emission.y).sum::<f32>();
            assert!((radiance[1] - expected / 29.0).abs() < 1e-4, "{sequences} {buckets}");
        }
    }
}

#[test]
fn features_are_kept_as_the_halves_of_even_and_odd_buckets() {
    let stack = filled(2, 8).into_stack();
    let estimate = &stack.feature(FeatureRole::Visibility).unwrap().estimate;
    let Noise::Buckets(halves) = &estimate.noise else { panic!("two halves") };
    // With two sequences, odd samples fill odd buckets.
    assert_eq!([halves[0].channels()[0][5], halves[1].channels()[0][5]], [0.0, 1.0]);
    let scattered = &stack.component(ComponentRole::Scattered).unwrap().radiance;
    assert!(matches!(&scattered.noise, Noise::Buckets(buckets) if buckets.len() == 8));
}

#[test]
fn one_bucket_says_nothing_about_noise() {
    let stack = filled(1, 1).into_stack();
    assert!(stack.components.iter().all(|c| c.radiance.noise == Noise::Unknown));
    assert!(stack.features.iter().all(|f| f.estimate.noise == Noise::Unknown));
}

#[test]
fn a_film_survives_the_way_to_a_stack_and_back() {
    for (sequences, buckets) in [(1, 1), (2, 8), (8, 8)] {
        let film = filled(sequences, buckets);
        let stack = film.to_stack();
        assert_eq!((stack.window, stack.film), (WINDOW, Size::new(64, 64)));
        let mut again = Film::from_stack(stack).unwrap();
        assert_eq!(again, film);
        let mut straight = film;
        add(&mut again, 29..32);
        add(&mut straight, 29..32);
        assert_eq!(again, straight);
    }
}

#[test]
fn a_stack_that_lacks_something_is_refused() {
    let whole = filled(8, 8).into_stack();
    let mut stack = whole.clone();
    stack.features.remove(2);
    let refused = Film::from_stack(stack).unwrap_err();
    assert!(refused.to_string().contains("layer 'normal' should be there, found none"), "{refused}");
    let mut stack = whole.clone();
    stack.components[0].radiance.noise = Noise::Unknown;
    let refused = Film::from_stack(stack).unwrap_err();
    assert!(refused.to_string().contains("parts of layer 'noisy' should be 8, found 1"), "{refused}");
    let mut stack = whole.clone();
    stack.samples = SampleCounts::uniform(WINDOW.size.pixels(), vec![4, 4]);
    assert!(Film::from_stack(stack).is_err());
    let mut stack = whole;
    stack.samples.total.pop();
    assert!(Film::from_stack(stack).is_err());
}

#[test]
fn a_slice_starts_where_it_should() {
    let mut film = Film::new(WINDOW, Size::new(64, 64), &settings(8, 8)).starting_at(5);
    add(&mut film, 5..8);
    let stack = film.to_stack();
    assert_eq!(film.next_samples(2), SampleMap { first: vec![8; 360], count: vec![2; 360] });
    let Noise::Buckets(buckets) = &stack.component(ComponentRole::Scattered).unwrap().radiance.noise else {
        panic!("buckets")
    };
    assert_eq!(buckets[6].channels()[0][1], record(1, 6).scattered.x);
    assert_eq!(buckets[0].channels()[0][1], 0.0);
}

#[test]
fn only_what_is_missing_is_asked_for() {
    let mut film = Film::new(WINDOW, Size::new(64, 64), &settings(8, 8)).starting_at(5);
    add(&mut film, 5..8);
    film.counts.total[7] = 9;
    let map = film.samples_up_to(8);
    assert_eq!((map.first[0], map.count[0], map.first[7], map.count[7]), (8, 5, 14, 0));
    assert_eq!(film.samples(), 359 * 3 + 9);
}
