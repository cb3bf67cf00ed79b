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
#[derive(Clone, Debug, PartialEq)]
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

    /// Whether so many of the paths so far were in cells which are full now that there should be smaller ones.
    fn is_filled(&self) -> bool {
        let paths = |full: bool| self.cells.values().filter(move |cell| cell.is_full() == full).map(|cell| cell.paths);
        let [full, others] = [true, false].map(|full| paths(full).map(f64::from).sum::<f64>());
        self.size > 0 && (full / (full + others).max(1.0)) as f32 >= FULL
    }
}

/// What leaves surfaces, as far as paths have found out.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LeavingLight {
    /// The largest cells first; each level's are half as large as those before.
    levels: Vec<Level>,
}

impl LeavingLight {
    /// Adds what paths found at `points`, always in their order; there are smaller cells next time where many are full.
    ///
    /// A path adds to the cells that it will take light from, and to none larger: then what paths take from a cell is on
    /// average what they brought, and no light is lost where the lit part of a cell has cells of its own.
    pub(crate) fn learn<I: Iterator<Item = GatherPoint>>(&mut self, points: impl Fn() -> I) {
        if points().next().is_none() {
            return;
        }
        match self.levels.last_mut() {
            Some(smallest) => smallest.add(points()),
            None => self.begin(&points),
        }
        let Some((smallest, larger)) = self.levels.split_last_mut() else { return };
        let mut rest: Vec<_> = points().filter(|point| smallest.leaves_out(point)).collect();
        for level in larger.iter_mut().rev() {
            level.add(rest.iter().copied());
            // What is too near for cells of a size is for larger ones, too.
            rest.retain(|point| level.leaves_out(point));
        }
        if smallest.is_filled() {
            self.levels.push(Level::halved(self.levels.len() as u32));
        }
    }

    /// The first cells: of all sizes that fill, and of one that does not, which alone has learned already.
    fn begin<I: Iterator<Item = GatherPoint>>(&mut self, points: &impl Fn() -> I) {
        for times in 0.. {
            let mut smallest = Level::halved(times);
            smallest.add(points());
            if !smallest.is_filled() {
                self.levels.push(smallest);
                return;
            }
            self.levels.push(Level::halved(times));
        }
    }

    /// Radiance that arrives at the camera from `point`: that of its smallest full cell, or where that is too large, what
    /// its path found by itself.
    pub(crate) fn arriving(&self, point: &GatherPoint) -> Vec3 {
        let cell = self.levels.iter().rev().find_map(|level| level.full_cell(point));
        cell.map_or(point.found, |cell| point.weight * cell.mean)
    }
}
