//! What leaves the surfaces in every cell.

use glam::Vec3;
use rayon::prelude::*;
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
    /// How much all paths together count.
    counts: Vec3,
    paths: u32,
}

impl Cell {
    fn add(&mut self, [leaving, counts]: [Vec3; 2]) {
        self.paths += 1;
        self.counts += counts;
        self.mean += (leaving - counts * self.mean) / self.counts;
    }

    const fn is_full(&self) -> bool {
        self.paths >= LEAST_PATHS
    }
}

/// Cells of one size.
#[derive(Clone, Debug)]
struct Level {
    /// In digits of a place that do not matter.
    size: u32,
    cells: FxHashMap<u64, Cell>,
}

impl Level {
    /// Empty cells, halved `times` times.
    fn halved(times: u32) -> Self {
        Self { size: COARSEST - times, cells: FxHashMap::default() }
    }

    /// Whether cells of this size may stand for `point`.
    fn may_share(&self, point: &GatherPoint) -> bool {
        self.size < u32::from(point.levels)
    }

    /// The cell of `point`, if it is full and may stand for it.
    fn full_cell(&self, point: &GatherPoint) -> Option<&Cell> {
        let cell = self.may_share(point).then(|| self.cells.get(&point.place.cell(self.size)))?;
        cell.filter(|cell| cell.is_full())
    }

    /// Adds what paths found at `points`.
    fn add(&mut self, points: impl Iterator<Item = GatherPoint>) {
        for point in points {
            if let Some(leaving) = point.leaving().filter(|_| self.may_share(&point)) {
                self.cells.entry(point.place.cell(self.size)).or_default().add(leaving);
            }
        }
    }

    /// Whether `point` could take light from cells of this size, but its cell is not full.
    fn leaves_out(&self, point: &GatherPoint) -> bool {
        self.may_share(point) && self.full_cell(point).is_none()
    }

    /// How many of the paths so far were in cells which are full now, and how many in others.
    fn paths(&self) -> [u64; 2] {
        let paths = |full: bool| self.cells.values().filter(move |cell| cell.is_full() == full).map(|cell| cell.paths);
        [true, false].map(|full| paths(full).map(u64::from).sum())
    }
}

/// What leaves surfaces in some of the largest cells, and in the smaller ones within them.
#[derive(Clone, Debug, Default)]
struct Part {
    /// The largest cells first; each level's are half as large as those before.
    levels: Vec<Level>,
}

impl Part {
    /// Adds to the smallest cells what paths found at `points`.
    fn learn_smallest(&mut self, points: impl Iterator<Item = GatherPoint>) {
        if let Some(smallest) = self.levels.last_mut() {
            smallest.add(points);
        }
    }

    /// Adds to larger cells what the smallest leave out.
    fn learn_larger(&mut self, points: impl Iterator<Item = GatherPoint>) {
        let Some((smallest, larger)) = self.levels.split_last_mut() else { return };
        let mut rest: Vec<_> = points.filter(|point| smallest.leaves_out(point)).collect();
        for level in larger.iter_mut().rev() {
            level.add(rest.iter().copied());
            // What is too near for cells of a size is for larger ones, too.
            rest.retain(|point| level.leaves_out(point));
        }
    }
}

/// What leaves surfaces, as far as paths have found out.
///
/// Its parts learn side by side. A cell is in one of them, and meets its paths in their order: how many parts there are changes
/// no bit.
#[derive(Clone, Debug)]
pub(crate) struct LeavingLight {
    parts: Vec<Part>,
}

/// Whether they know the same, in however many parts.
impl PartialEq for LeavingLight {
    fn eq(&self, other: &Self) -> bool {
        let cells = |light: &Self| -> FxHashMap<(u32, u64), Cell> {
            let levels = light.parts.iter().flat_map(|part| &part.levels);
            levels.flat_map(|level| level.cells.iter().map(|(place, cell)| ((level.size, *place), *cell))).collect()
        };
        self.levels() == other.levels() && cells(self) == cells(other)
    }
}

impl LeavingLight {
    /// What is known before there are paths, in so many parts.
    pub(crate) fn in_parts(parts: usize) -> Self {
        Self { parts: vec![Part::default(); parts.max(1)] }
    }

    /// Adds what paths found at `points`, always in their order; there are smaller cells next time where many are full.
    ///
    /// A path adds to the cells that it will take light from, and to none larger: then what paths take from a cell is on
    /// average what they brought, and no light is lost where the lit part of a cell has cells of its own.
    pub(crate) fn learn<I: Iterator<Item = GatherPoint>>(&mut self, points: impl Fn() -> I + Sync) {
        if points().next().is_none() {
            return;
        }
        match self.levels() {
            0 => self.begin(&points),
            _ => self.each_part(|part, is_of_part| part.learn_smallest(points().filter(is_of_part))),
        }
        self.each_part(|part, is_of_part| part.learn_larger(points().filter(is_of_part)));
        if self.is_filled() {
            self.add_level();
        }
    }

    /// The first cells: of all sizes that fill, and of one that does not, which alone has learned already.
    fn begin<I: Iterator<Item = GatherPoint>>(&mut self, points: &(impl Fn() -> I + Sync)) {
        loop {
            self.add_level();
            self.each_part(|part, is_of_part| part.learn_smallest(points().filter(is_of_part)));
            if !self.is_filled() {
                return;
            }
            self.parts.iter_mut().filter_map(|part| part.levels.last_mut()).for_each(|level| level.cells.clear());
        }
    }

    /// Does something with each part and what tells its points from others.
    fn each_part(&mut self, work: impl Fn(&mut Part, &dyn Fn(&GatherPoint) -> bool) + Sync) {
        let parts = self.parts.len();
        self.parts.par_iter_mut().enumerate().for_each(|(i, part)| match parts {
            1 => work(part, &|_| true),
            _ => work(part, &|point| part_of(point, parts) == i),
        });
    }

    fn levels(&self) -> usize {
        self.parts[0].levels.len()
    }

    fn add_level(&mut self) {
        let times = self.levels() as u32;
        self.parts.iter_mut().for_each(|part| part.levels.push(Level::halved(times)));
    }

    /// Whether so many of the paths so far were in smallest cells which are full now that there should be smaller ones.
    fn is_filled(&self) -> bool {
        let smallest = || self.parts.iter().filter_map(|part| part.levels.last());
        let [full, others] = smallest().map(Level::paths).fold([0, 0], |[a, b], [c, d]| [a + c, b + d]);
        let share = full as f64 / ((full + others) as f64).max(1.0);
        smallest().all(|level| level.size > 0) && share as f32 >= FULL
    }

    /// Radiance that arrives at the camera from `point`: that of its smallest full cell, or where that is too large, what
    /// its path found by itself.
    pub(crate) fn arriving(&self, point: &GatherPoint) -> Vec3 {
        let part = &self.parts[part_of(point, self.parts.len())];
        let cell = part.levels.iter().rev().find_map(|level| level.full_cell(point));
        cell.map_or(point.found, |cell| point.weight * cell.mean)
    }
}

/// Which of so many parts `point` belongs to: that of its largest cell, which holds all its smaller ones.
fn part_of(point: &GatherPoint, parts: usize) -> usize {
    // Neighbours far apart: the upper half of a product with a large odd number depends on all digits.
    let mixed = point.place.cell(COARSEST).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    mixed as usize % parts
}
