//! Where the light of events goes.

use super::super::test_scene::{energy, features, flat, image, two_halves};
use super::*;
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(61, 55);
const CENTRE: [usize; 2] = [30, 27];

fn events_at(pixels: &[usize], size: Size) -> Events {
    let light = [flat(size, 0.0), flat(size, 0.0)];
    let mut events = Events { light, energy: vec![0.0; size.pixels()], squares: vec![0.0; size.pixels()] };
    for pixel in pixels {
        events.light[0].channels_mut().iter_mut().for_each(|plane| plane[*pixel] = 1.0);
        (events.energy[*pixel], events.squares[*pixel]) = (3.0, 9.0);
    }
    events
}

fn plain(events: &Events) -> Image {
    let size = events.light[0].size();
    let nothing = features(size, vec![vec![0.0; size.pixels()]]);
    sum_of(&spread(events, &flat(size, 1.0), &nothing, &SpreadSettings::default()).halves)
}

/// Largest distance from the centre at which there is light.
fn reach(light: &Image) -> f32 {
    let lit = (0..SIZE.pixels()).filter(|i| light.rgb(*i)[0] > 0.0);
    lit.map(|i| ((i % SIZE.width).abs_diff(CENTRE[0]) as f32).hypot((i / SIZE.width).abs_diff(CENTRE[1]) as f32))
        .fold(0.0, f32::max)
}

#[test]
fn all_light_stays_in_the_picture() {
    let size = Size::new(90, 70);
    let mut noise = TestNoise(80);
    let guides = features(size, (0..3).map(|_| noise.normals(size.pixels(), 0.0, 0.3)).collect());
    let picture = Image::from_channels(size, (0..3).map(|_| noise.normals(size.pixels(), 1.0, 0.3)).collect());
    let mut chosen: Vec<usize> = (0..size.pixels()).filter(|_| noise.uniform() < 0.02).collect();
    chosen.extend([0, size.width - 1, size.pixels() - 1, size.index(63, 63), size.index(64, 64)]);
    let mut events = events_at(&chosen, size);
    events.light[0].channels_mut()[1].iter_mut().for_each(|v| *v *= 1e3 * noise.uniform() as f32);
    events.light[1] = events.light[0].clone();
    let light = spread(&events, &picture, &guides, &SpreadSettings::default()).halves;
    assert_eq!(light[0], light[1]);
    for (before, after) in events.light[0].channels().iter().zip(light[0].channels()) {
        let [before, after] = [before, after].map(|plane| plane.iter().map(|v| f64::from(*v)).sum::<f64>());
        assert!((after / before - 1.0).abs() < 1e-5, "{before} became {after}");
    }
}

#[test]
fn a_lone_event_is_spread_as_the_widest_gaussian() {
    let light = plain(&events_at(&[SIZE.index(CENTRE[0], CENTRE[1])], SIZE));
    let at = |dx: usize, dy: usize| light.rgb(SIZE.index(CENTRE[0] + dx, CENTRE[1] + dy))[0];
    for (dx, dy) in [(1, 0), (5, 3), (0, 12), (14, 14)] {
        let expected = (-((dx * dx + dy * dy) as f32) / (2.0 * 81.0)).exp();
        assert!((at(dx, dy) / at(0, 0) - expected).abs() < 1e-4, "{dx} {dy}");
    }
}

#[test]
fn the_denser_events_are_the_narrower_they_are_spread() {
    let centre = SIZE.index(CENTRE[0], CENTRE[1]);
    let reaches = [1, 2, 4, 60].map(|gap: usize| {
        let near = |i: &usize| {
            (i % SIZE.width).abs_diff(CENTRE[0]).is_multiple_of(gap)
                && (i / SIZE.width).abs_diff(CENTRE[1]).is_multiple_of(gap)
        };
        let mut events = events_at(&(0..SIZE.pixels()).filter(near).collect::<Vec<usize>>(), SIZE);
        // Only the one in the middle has light to show.
        events.light[0] = image(SIZE, |x, y, _| if [x, y] == CENTRE { 1.0 } else { 0.0 });
        assert!(events.energy[centre] > 0.0);
        reach(&plain(&events))
    });
    // Nine equal events lie within 1.5 pixels when all pixels hold one: a deviation of 1, and no light beyond 2.5.
    assert!(reaches[0] <= 2.5, "{reaches:?}");
    assert!(reaches.is_sorted() && reaches[0] < reaches[1] && reaches[2] < reaches[3], "{reaches:?}");
    assert!(reaches[3] > 20.0, "{reaches:?}");
}

#[test]
fn light_stays_on_its_own_side_of_a_border() {
    let events = events_at(&[SIZE.index(29, 20)], SIZE);
    let strict = SpreadSettings { feature_scale: 0.3, ..SpreadSettings::default() };
    let light = sum_of(&spread(&events, &flat(SIZE, 1.0), &two_halves(SIZE), &strict).halves);
    let right: f64 = (0..SIZE.pixels()).filter(|i| i % SIZE.width >= 31).map(|i| f64::from(light.rgb(i)[0])).sum();
    assert!(right < 0.01 * energy(&light), "{right}");
    let dark = image(SIZE, |x, _, _| if x < 31 { 1.0 } else { 0.001 });
    let nothing = features(SIZE, vec![vec![0.0; SIZE.pixels()]]);
    let bright = SpreadSettings { brightness: 2.0, ..strict };
    let light = sum_of(&spread(&events, &dark, &nothing, &bright).halves);
    let right: f64 = (0..SIZE.pixels()).filter(|i| i % SIZE.width >= 31).map(|i| f64::from(light.rgb(i)[0])).sum();
    assert!(right < 0.01 * energy(&light), "brightness is a border, too: {right}");
}

#[test]
fn brighter_pixels_take_more() {
    let events = events_at(&[SIZE.index(CENTRE[0], CENTRE[1])], SIZE);
    let nothing = features(SIZE, vec![vec![0.0; SIZE.pixels()]]);
    let picture = image(SIZE, |_, y, _| if y < CENTRE[1] { 0.99 } else { 1.99 });
    let settings = SpreadSettings { brightness: 0.0, share: 1.5, ..SpreadSettings::default() };
    let light = sum_of(&spread(&events, &picture, &nothing, &settings).halves);
    let [dark, bright] = [24, 30].map(|y| light.rgb(SIZE.index(CENTRE[0], y))[0]);
    assert!((bright / dark - 2.0_f32.powf(1.5)).abs() < 1e-3, "{bright} {dark}");
}

#[test]
fn even_events_are_nearly_as_bright_at_the_border() {
    let size = Size::new(100, 60);
    let lattice = (0..size.pixels()).filter(|i| (i % size.width) % 5 == 2 && (i / size.width) % 5 == 2);
    let events = events_at(&lattice.collect::<Vec<_>>(), size);
    let at_border = |settings: &SpreadSettings| {
        let nothing = features(size, vec![vec![0.0; size.pixels()]]);
        let light = sum_of(&spread(&events, &flat(size, 1.0), &nothing, settings).halves);
        // Mean of the middle rows.
        let column = |x: usize| (25..35).map(|y| light.rgb(size.index(x, y))[0]).sum::<f32>();
        column(0) / (45..55).map(|x| 0.1 * column(x)).sum::<f32>()
    };
    let (with, without) = (SpreadSettings::default(), SpreadSettings { levels: 0, ..SpreadSettings::default() });
    assert!(at_border(&with) > 0.9, "{} {}", at_border(&with), at_border(&without));
    assert!(at_border(&without) < 0.8, "{}", at_border(&without));
}

#[test]
fn no_events_give_no_light() {
    assert_eq!(plain(&events_at(&[], SIZE)), flat(SIZE, 0.0));
    assert_eq!(plain(&events_at(&[0], Size::new(1, 1))), flat(Size::new(1, 1), 1.0));
}

#[test]
fn blotches_that_one_half_shows_are_smoothed_and_common_light_stays() {
    let mut noise = TestNoise(81);
    let blotches = |noise: &mut TestNoise| {
        let coarse: Vec<f32> = noise.normals(SIZE.pixels(), 0.5, 0.15);
        image(SIZE, |x, y, _| coarse[SIZE.index(x / 6 * 6, y / 6 * 6)])
    };
    let nothing = features(SIZE, vec![vec![0.0; SIZE.pixels()]; 3]);
    let steady = |halves: [Image; 2]| {
        steadied(halves, &flat(SIZE, 1.0), &nothing, &SpreadSettings::default(), &stack::Silent).unwrap()
    };
    let deviation = |image: &Image| {
        let plane = &image.channels()[0];
        (plane.iter().map(|v| (v - 1.0).powi(2)).sum::<f32>() / plane.len() as f32).sqrt()
    };
    let apart = [blotches(&mut noise), blotches(&mut noise)];
    assert!(deviation(&steady(apart.clone())) < 0.5 * deviation(&sum_of(&apart)), "seen by one half only");
    let common = [apart[0].clone(), apart[0].clone()];
    let kept = deviation(&steady(common.clone())) / deviation(&sum_of(&common));
    assert!(kept > 0.95, "seen by both: {kept}");
}
