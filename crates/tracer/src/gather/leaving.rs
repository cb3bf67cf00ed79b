//! What leaves the surfaces in every cell.

use glam::Vec3;
use rustc_hash::FxHashMap;

use super::GatherPoint;
use super::place::DIGITS;

/// Size of the coarsest cells: a 16th of the scene.
pub(super) const COARSEST: u32 = DIGITS - 4;
/// Paths that a cell must have met before they share what they found. Fewer would be mostly one's own noise.
pub(super) const LEAST_PATHS: u32 = 12;
/// Share of paths in full cells from which on there are smaller ones.
const FULL: f32 = 0.5;

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
pub(crate) struct LeavingLight {
    /// The coarsest cells first; each level's are half as large as those before.
    levels: Vec<FxHashMap<u64, Cell>>,
}

impl LeavingLight {
    /// Adds what paths found at `points`, always in their order; there are smaller cells then where many are full.
    pub(crate) fn learn<I: Iterator<Item = GatherPoint>>(&mut self, points: impl Fn() -> I) {
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
    pub(crate) fn arriving(&self, point: &GatherPoint) -> Vec3 {
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
    for (point, leaving) in points.filter_map(|point| Some((point, point.leaving()?))) {
        let cell = cells.entry(point.place.cell(level)).or_default();
        cell.add(leaving);
        all += 1;
        full += u32::from(cell.is_full());
    }
    full as f32 / all.max(1) as f32
}
