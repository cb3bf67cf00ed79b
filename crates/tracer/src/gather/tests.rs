use glam::Vec3;

use super::leaving::{COARSEST, LEAST_PATHS};
use super::place::{DIGITS, Place};
use super::point::{WIDEST, levels_within};
use super::{GatherPoint, LeavingLight};

/// A point on the floor of a scene of size 1, reached from `distance` away, where a path found `found`.
fn point(position: Vec3, distance: f32, found: f32) -> GatherPoint {
    let steps = (1 << DIGITS) as f32;
    let (place, levels) = (Place::new(position * steps, Vec3::Y, false), levels_within(WIDEST * distance * steps));
    GatherPoint { place, weight: Vec3::splat(0.5), found: Vec3::splat(found), levels }
}

/// `count` points in a cell at the corner, whose paths found 0, 1, 2 …
fn together(count: u32) -> Vec<GatherPoint> {
    (0..count).map(|i| point(Vec3::splat(1e-4), 1.0, i as f32)).collect()
}

fn learned(points: &[GatherPoint]) -> LeavingLight {
    let mut light = LeavingLight::in_parts(1);
    light.learn(|| points.iter().copied());
    light
}

#[test]
fn paths_of_a_full_cell_share_what_they_found() {
    let points = together(LEAST_PATHS);
    let mean = (LEAST_PATHS - 1) as f32 / 2.0;
    let light = learned(&points);
    assert!(points.iter().all(|point| (light.arriving(point) - mean).abs().max_element() < 1e-5));
    // What leaves is the same, whatever share of it arrives.
    let dark = GatherPoint { weight: Vec3::splat(0.25), ..points[3] };
    assert!((light.arriving(&dark) - 0.5 * mean).abs().max_element() < 1e-5);
}

#[test]
fn few_paths_and_near_ones_keep_their_own() {
    // They fill a cell of the largest size, and none that is smaller.
    let largest = 0.5_f32.powi((DIGITS - COARSEST) as i32);
    let at = |i: u32, distance| {
        point(largest * Vec3::new(0.1 + 0.25 * (i % 4) as f32, 0.1, 0.1 + 0.25 * (i / 4) as f32), distance, i as f32)
    };
    let spread = |count: u32| learned(&(0..count).map(|i| at(i, 1.0)).collect::<Vec<_>>());
    let [few, light] = [LEAST_PATHS - 1, LEAST_PATHS].map(spread);
    let [near, far] = [0.99, 1.01].map(|cells| at(7, cells * largest / WIDEST));
    assert_eq!([few.arriving(&far), light.arriving(&near)], [far.found; 2]);
    assert_ne!(light.arriving(&far), far.found);
    let elsewhere = point(Vec3::new(0.9, 1e-4, 1e-4), 1.0, 77.0);
    assert_eq!(light.arriving(&elsewhere), elsewhere.found);
}

#[test]
fn light_is_taken_from_cells_it_was_brought_to() {
    // A bright spot fills a cell of its own; beside it paths are few, and dark.
    let spot: Vec<_> = (0..100).map(|_| point(Vec3::splat(1e-4), 1.0, 8.0)).collect();
    let largest = 0.5_f32.powi((DIGITS - COARSEST) as i32);
    let dark = (0..LEAST_PATHS).map(|i| point(largest * Vec3::new(0.3 + 0.05 * i as f32, 0.6, 0.1), 1.0, 0.0));
    let points: Vec<_> = spot.into_iter().chain(dark).collect();
    let light = learned(&points);
    assert!(points.iter().all(|point| (light.arriving(point) - point.found).abs().max_element() < 1e-4));
}

#[test]
fn more_paths_share_smaller_cells() {
    // What is found rises along x: the error of sharing is that of the cell's size.
    let rise = |count: u32| -> Vec<GatherPoint> {
        let at = |i| f64::from(i) * 0.618_034 % 1.0;
        (0..count).map(|i| point(Vec3::new(at(i) as f32, 1e-4, 1e-4), 1.0, at(i) as f32)).collect()
    };
    let error = |count| {
        let (points, mut light) = (rise(count), LeavingLight::in_parts(1));
        for pass in points.chunks(2000) {
            light.learn(|| pass.iter().copied());
        }
        points.iter().map(|point| (light.arriving(point) - point.found).x.abs()).fold(0.0, f32::max)
    };
    let [few, many] = [2000, 64_000].map(error);
    assert!(many < 0.1 * few && few < 0.5_f32.powi((DIGITS - COARSEST) as i32), "{few} {many}");
}

#[test]
fn cells_lie_within_coarser_ones_and_face_one_way() {
    let place = |x: f32, normal| Place::new(Vec3::new(x, 3.0, 1e9), normal, false);
    for level in 0..DIGITS {
        let wide = (1_u32 << level) as f32;
        assert_eq!(place(0.0, Vec3::Z).cell(level), place(wide - 1.0, Vec3::Z).cell(level));
        assert_ne!(place(0.0, Vec3::Z).cell(level), place(wide, Vec3::Z).cell(level));
        assert_ne!(place(0.0, Vec3::Z).cell(level), place(0.0, Vec3::NEG_Z).cell(level));
        assert_ne!(place(0.0, Vec3::Z).cell(level), place(0.0, Vec3::X).cell(level));
    }
}

#[test]
fn paths_on_coated_surfaces_take_together_what_they_brought() {
    // Those that weigh more find more.
    let weighing = |is_coated: bool| -> Vec<_> {
        let place = Place::new(Vec3::splat(1e-4), Vec3::Y, is_coated);
        (1..=LEAST_PATHS)
            .map(|i| GatherPoint {
                place,
                weight: Vec3::splat(i as f32),
                found: Vec3::splat((i * i) as f32),
                ..together(1)[0]
            })
            .collect()
    };
    let sums = |points: &[GatherPoint]| {
        let light = learned(points);
        [points.iter().map(|p| light.arriving(p).x).sum::<f32>(), points.iter().map(|p| p.found.x).sum()]
    };
    let [taken, brought] = sums(&weighing(true));
    assert!((taken / brought - 1.0).abs() < 1e-5, "{taken} {brought}");
    // They do not share with the diffuse ones among them.
    let both = [weighing(true), weighing(false)].concat();
    let light = learned(&both);
    assert_eq!(light.arriving(&both[0]), learned(&weighing(true)).arriving(&both[0]));
    assert_ne!(light.arriving(&both[0]), light.arriving(&both[LEAST_PATHS as usize]));
}

#[test]
fn paths_blind_to_a_colour_do_not_darken_it() {
    let points = together(LEAST_PATHS);
    let red = GatherPoint { weight: Vec3::X, found: Vec3::X, ..points[0] };
    let light = learned(&points);
    assert_eq!(learned(&[vec![red; 100], points].concat()), light);
    assert_eq!(light.arriving(&red) * Vec3::new(0.0, 1.0, 1.0), Vec3::ZERO);
    assert!(red.is_finite() && !GatherPoint { found: Vec3::NAN, ..red }.is_finite());
}

#[test]
fn the_number_of_parts_changes_no_bit() {
    // Over the whole floor, most of them in a corner: cells of several sizes fill.
    let mut random = crate::bvh::random::Random(3);
    let mut some = |count: usize| -> Vec<GatherPoint> {
        (0..count)
            .map(|i| {
                let [at, found] = [0, 1].map(|_| 0.5 + 0.5 * random.point());
                point(at * at * at, 0.05 + found.y, found.x + i as f32)
            })
            .collect()
    };
    let passes = [some(4000), some(4000), some(40)];
    let arriving = |parts: usize| -> Vec<[u32; 3]> {
        let mut light = LeavingLight::in_parts(parts);
        passes.iter().for_each(|points| light.learn(|| points.iter().copied()));
        passes.iter().flatten().map(|point| light.arriving(point).to_array().map(f32::to_bits)).collect()
    };
    let whole = arriving(1);
    assert!(
        whole
            .iter()
            .zip(passes.iter().flatten())
            .any(|(bits, point)| *bits != point.found.to_array().map(f32::to_bits))
    );
    assert!([2, 3, 8, 64].into_iter().all(|parts| arriving(parts) == whole));
}
