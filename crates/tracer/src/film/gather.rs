//! Light that leaves surfaces, averaged over all paths that meet them nearby.
//!
//! Most of the noise of indirect light is not in which way a path goes on from the surface that is seen, but in what it
//! finds there: whether a light sample arrives, whether a caustic is hit. What leaves a diffuse surface is the same in all
//! directions and changes slowly, so paths share it (path space filtering, Keller, Dahm and Binder 2014; in cells of
//! space found by hashing, Binder, Fricke and Keller 2019). Cells become smaller as there are more paths to share: the
//! average is biased, but consistent.

use glam::Vec3;
use rustc_hash::FxHashMap;

use crate::interaction::Interaction;
use crate::scene::Bounds;

/// Binary digits of a place along each axis.
const DIGITS: u32 = 20;
/// Size of the coarsest cells: a 16th of the scene.
const COARSEST: u32 = DIGITS - 4;
/// Paths that a cell must have met before they share what they found. Fewer would be mostly one's own noise.
const LEAST_PATHS: u32 = 12;
/// Largest cell that paths share, against what one path stands for: the directions of its kind, as far away as it went.
/// Larger ones would blur what lies next to a surface or is seen in its gloss.
const WIDEST: f32 = 0.35;
/// Share of paths in full cells from which on there are smaller ones.
const FULL: f32 = 0.5;
/// Albedos are not taken to be smaller: what leaves is kept as a multiple of them.
const DARKEST: f32 = 0.02;

/// A point on a diffuse surface that a path went on to from the surface that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherPoint {
    place: Place,
    /// Radiance at the camera ÷ (radiance that leaves the point ÷ its albedo).
    weight: Vec3,
    /// Radiance at the camera that the path by itself found to come from here.
    pub(crate) found: Vec3,
    /// How many levels of cells, from the smallest, may stand for the point.
    levels: u8,
}

impl GatherPoint {
    /// The point `hit` of a surface of that `albedo`, reached with `throughput` by a path that stands for a solid angle of
    /// `spread`², in a scene of those `bounds`.
    pub(crate) fn new(hit: &Interaction, albedo: Vec3, throughput: Vec3, spread: f32, bounds: Bounds) -> Self {
        let steps = (1 << DIGITS) as f32 / (bounds.max - bounds.min).max_element();
        let side = if hit.geometric_normal.dot(hit.outgoing) < 0.0 { -1.0 } else { 1.0 };
        Self {
            place: Place::new((hit.position - bounds.min) * steps, side * hit.geometric_normal),
            weight: throughput * albedo.max(Vec3::splat(DARKEST)),
            found: Vec3::ZERO,
            levels: levels_within(WIDEST * spread * hit.distance * steps),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.weight.is_finite() && self.found.is_finite()
    }

    /// What leaves the point ÷ its albedo, as the path found it; zero where it could not tell.
    fn leaving(&self) -> Vec3 {
        let leaving = self.found / self.weight;
        Vec3::select(self.weight.cmpgt(Vec3::ZERO), leaving, Vec3::ZERO)
    }
}

/// How many levels have cells no larger than `size`, in steps of a place.
fn levels_within(size: f32) -> u8 {
    // Saturates at 0.
    (size.log2().floor() + 1.0) as u8
}

/// A place in the scene and the way its surface faces: 3 × 20 digits of its coordinates, 3 of the axis. In two words, so
/// that a point takes no more than it must: there are several for each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place([u32; 2]);

impl Place {
    /// Coordinates in steps from the scene's corner.
    fn new(position: Vec3, normal: Vec3) -> Self {
        let axis = normal.abs().max_position();
        let facing = 2 * axis as u64 + u64::from(normal[axis] < 0.0);
        let last = ((1 << DIGITS) - 1) as f32;
        let digits = position.to_array().map(|x| x.clamp(0.0, last) as u64);
        let all = digits.into_iter().fold(facing, |all, digits| (all << DIGITS) | digits);
        Self([(all >> 32) as u32, all as u32])
    }

    /// The cell it lies in: its digits without the last `level` of each axis.
    const fn cell(self, level: u32) -> u64 {
        let kept = ((1 << DIGITS) - 1) >> level << level;
        let axes = kept | kept << DIGITS | kept << (2 * DIGITS);
        let [high, low] = self.0;
        ((high as u64) << 32 | low as u64) & (axes | 0b111 << (3 * DIGITS))
    }
}

/// What leaves surfaces in a cell, divided by their albedo.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cell {
    mean: Vec3,
    paths: u32,
}

impl Cell {
    fn add(&mut self, leaving: Vec3) {
        self.paths += 1;
        self.mean += (leaving - self.mean) / self.paths as f32;
    }

    const fn is_full(&self) -> bool {
        self.paths >= LEAST_PATHS
    }
}

/// What leaves surfaces, as far as paths have found out.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LeavingLight {
    /// The coarsest cells first; each level's are half as large as those before.
    levels: Vec<FxHashMap<u64, Cell>>,
}

impl LeavingLight {
    /// Adds what paths found at `points`, always in their order; there are smaller cells then where many are full.
    pub(super) fn learn<I: Iterator<Item = GatherPoint>>(&mut self, points: impl Fn() -> I) {
        let mut share = if points().next().is_some() { 1.0 } else { 0.0 };
        for (level, cells) in self.levels.iter_mut().enumerate() {
            share = add(cells, COARSEST - level as u32, points());
        }
        while share >= FULL && self.levels.len() <= COARSEST as usize {
            let mut cells = FxHashMap::default();
            share = add(&mut cells, COARSEST - self.levels.len() as u32, points());
            self.levels.push(cells);
        }
    }

    /// Radiance that arrives at the camera from `point`: that of its smallest full cell, or where that is too large, what
    /// its path found by itself.
    pub(super) fn arriving(&self, point: &GatherPoint) -> Vec3 {
        for (level, cells) in self.levels.iter().enumerate().rev() {
            let level = COARSEST - level as u32;
            if level >= u32::from(point.levels) {
                break;
            }
            if let Some(cell) = cells.get(&point.place.cell(level)).filter(|cell| cell.is_full()) {
                return point.weight * cell.mean;
            }
        }
        point.found
    }
}

/// Adds what paths found at `points` to the cells of a level. Share of the points that lie in full cells.
fn add(cells: &mut FxHashMap<u64, Cell>, level: u32, points: impl Iterator<Item = GatherPoint>) -> f32 {
    let (mut all, mut full) = (0_u32, 0_u32);
    for point in points {
        let cell = cells.entry(point.place.cell(level)).or_default();
        cell.add(point.leaving());
        all += 1;
        full += u32::from(cell.is_full());
    }
    full as f32 / all.max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point on the floor of a scene of size 1, reached from `distance` away, where a path found `found`.
    fn point(position: Vec3, distance: f32, found: f32) -> GatherPoint {
        let steps = (1 << DIGITS) as f32;
        let (place, levels) = (Place::new(position * steps, Vec3::Y), levels_within(WIDEST * distance * steps));
        GatherPoint { place, weight: Vec3::splat(0.5), found: Vec3::splat(found), levels }
    }

    /// `count` points in a cell at the corner, whose paths found 0, 1, 2 …
    fn together(count: u32) -> Vec<GatherPoint> {
        (0..count).map(|i| point(Vec3::splat(1e-4), 1.0, i as f32)).collect()
    }

    fn learned(points: &[GatherPoint]) -> LeavingLight {
        let mut light = LeavingLight::default();
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
        let points = together(LEAST_PATHS - 1);
        assert!(points.iter().all(|point| learned(&points).arriving(point) == point.found));
        let light = learned(&together(LEAST_PATHS));
        let finest = 0.5_f32.powi((DIGITS - COARSEST) as i32);
        let [near, far] = [0.99, 1.01].map(|cells| point(Vec3::splat(1e-4), cells * finest / WIDEST, 77.0));
        assert!(light.arriving(&near) == near.found && light.arriving(&far) != far.found);
        let elsewhere = point(Vec3::new(0.9, 1e-4, 1e-4), 1.0, 77.0);
        assert_eq!(light.arriving(&elsewhere), elsewhere.found);
    }

    #[test]
    fn more_paths_share_smaller_cells() {
        // What is found rises along x: the error of sharing is that of the cell's size.
        let rise = |count: u32| -> Vec<GatherPoint> {
            let at = |i| f64::from(i) * 0.618_034 % 1.0;
            (0..count).map(|i| point(Vec3::new(at(i) as f32, 1e-4, 1e-4), 1.0, at(i) as f32)).collect()
        };
        let error = |count| {
            let (points, mut light) = (rise(count), LeavingLight::default());
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
        let place = |x: f32, normal| Place::new(Vec3::new(x, 3.0, 1e9), normal);
        for level in 0..DIGITS {
            let wide = (1_u32 << level) as f32;
            assert_eq!(place(0.0, Vec3::Z).cell(level), place(wide - 1.0, Vec3::Z).cell(level));
            assert_ne!(place(0.0, Vec3::Z).cell(level), place(wide, Vec3::Z).cell(level));
            assert_ne!(place(0.0, Vec3::Z).cell(level), place(0.0, Vec3::NEG_Z).cell(level));
            assert_ne!(place(0.0, Vec3::Z).cell(level), place(0.0, Vec3::X).cell(level));
        }
    }

    #[test]
    fn colour_that_cannot_leave_stays_away() {
        let red = GatherPoint { weight: Vec3::X, found: Vec3::X, ..point(Vec3::ZERO, 1.0, 0.0) };
        let light = learned(&vec![red; LEAST_PATHS as usize]);
        assert_eq!(light.arriving(&red), Vec3::X);
        assert!(red.is_finite() && !GatherPoint { found: Vec3::NAN, ..red }.is_finite());
    }
}
