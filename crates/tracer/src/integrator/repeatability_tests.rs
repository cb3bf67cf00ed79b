//! The same samples make the same picture, bit for bit, however the work was cut.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use stack::{ComponentRole, FeatureRole, FeatureStack, Monitor, Silent, Size, Window};

use super::test_scenes::{Pieces, diffuse, grey, lamp, looking_down};
use super::{TraceError, TraceSettings, trace};
use crate::film::Film;
use crate::material::Surface;
use crate::scene::Scene;

const SIZE: Size = Size::new(40, 36);

fn scene() -> Scene {
    Pieces::default()
        .sphere(0.8, (Surface::Glass { ior: 1.5, transmittance: grey(1.0), alpha: 0.0 }, 0.0))
        .quad(Vec3::new(-2.0, -1.0, 2.0), Vec3::X * 4.0, -Vec3::Z * 4.0, (diffuse(0.6), 0.0))
        .quad(Vec3::new(-1.5, 1.0, -0.5), Vec3::X * 0.5, Vec3::Z * 0.5, lamp(8.0))
        .under(Some(0.2))
}

fn empty(window: Window) -> Film {
    Film::new(window, SIZE, &TraceSettings::DEFAULT)
}

/// Traces the next `count` samples.
fn continue_film(film: &mut Film, count: u32, monitor: &dyn Monitor) -> Result<(), TraceError> {
    let map = film.next_samples(count);
    trace(&scene(), &looking_down(SIZE), film, &map, &TraceSettings::DEFAULT, monitor).map(|_| ())
}

fn straight(count: u32) -> Film {
    let mut film = empty(Window::whole(SIZE));
    continue_film(&mut film, count, &Silent).unwrap();
    film
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let films = [1, 2, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| straight(13))
    });
    assert_eq!(films[0], films[1]);
    assert_eq!(films[0], films[2]);
}

/// Cancels once `after` samples have been reported.
struct CancelAfter {
    after: u64,
    seen: AtomicU64,
}

impl Monitor for CancelAfter {
    fn advance(&self, units: u64) {
        self.seen.fetch_add(units, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.seen.load(Ordering::Relaxed) > self.after
    }
}

#[test]
fn an_interrupted_render_goes_on_as_if_nothing_had_happened() {
    let pixels = SIZE.pixels() as u64;
    let monitor = CancelAfter { after: pixels * 20, seen: AtomicU64::new(0) };
    let mut film = empty(Window::whole(SIZE));
    let Err(TraceError::Cancelled(report)) = continue_film(&mut film, 40, &monitor) else { panic!("not cancelled") };
    assert_eq!(report.samples, pixels * 16, "two whole passes");
    assert!(film.counts().total.iter().all(|n| *n == 16));
    // Written to a file, read again, continued: but for light that is gathered anew.
    let mut read = Film::from_stack(film.to_stack()).unwrap();
    let straight = straight(40);
    for film in [&mut film, &mut read] {
        continue_film(film, 24, &Silent).unwrap();
    }
    assert_eq!(film, straight);
    assert!(planes(&read.into_stack()).eq(planes(&straight.into_stack())));
}

/// All planes of a stack that depend on nothing but their pixel's samples.
fn planes(stack: &FeatureStack) -> impl Iterator<Item = &stack::Estimate> {
    let features = stack.features.iter().map(|f| &f.estimate);
    stack.components.iter().map(|c| &c.radiance).chain(&stack.indirect).chain(features)
}

#[test]
fn a_crop_equals_that_part_of_the_whole() {
    let whole = straight(8).into_stack();
    let window = Window { x: 11, y: 5, size: Size::new(19, 23) };
    let mut film = empty(window);
    continue_film(&mut film, 8, &Silent).unwrap();
    let crop = film.into_stack();
    for (of_whole, of_crop) in planes(&whole).zip(planes(&crop)) {
        for (of_whole, of_crop) in of_whole.mean.channels().iter().zip(of_crop.mean.channels()) {
            for y in 0..23 {
                for x in 0..19 {
                    assert_eq!(of_whole[SIZE.index(x + 11, y + 5)], of_crop[window.size.index(x, y)]);
                }
            }
        }
    }
}

#[test]
fn pixels_may_get_different_numbers_of_samples() {
    let mut film = straight(4);
    let mut map = film.next_samples(0);
    for (pixel, count) in map.count.iter_mut().enumerate() {
        *count = (pixel % 3) as u32 * 10;
    }
    let report = trace(&scene(), &looking_down(SIZE), &mut film, &map, &TraceSettings::DEFAULT, &Silent).unwrap();
    assert_eq!(report.samples, map.samples());
    let stack = film.into_stack();
    let fine = straight(24).into_stack();
    for pixel in 0..SIZE.pixels() {
        assert_eq!(stack.samples.total[pixel], 4 + map.count[pixel]);
        if pixel % 3 == 2 {
            // The same samples, rounded in other places.
            let (a, b) = (stack.beauty().mean_at(pixel), fine.beauty().mean_at(pixel));
            assert!((a - b).abs() <= 1e-5 * b, "{a} {b}");
        }
    }
}

#[test]
fn seeds_make_different_noise_of_the_same_picture() {
    let render = |seed| {
        let settings = TraceSettings { seed, ..TraceSettings::DEFAULT };
        let mut film = empty(Window::whole(SIZE));
        let map = film.next_samples(8);
        trace(&scene(), &looking_down(SIZE), &mut film, &map, &settings, &Silent).unwrap();
        film.into_stack()
    };
    let (a, b) = (render(1), render(2));
    assert_ne!(a.component(ComponentRole::Scattered), b.component(ComponentRole::Scattered));
    let depth = |stack: &FeatureStack| stack.feature(FeatureRole::Depth).unwrap().estimate.mean.mean_at(20);
    assert!((depth(&a) - depth(&b)).abs() < 0.05 * depth(&a));
}
