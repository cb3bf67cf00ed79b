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

    /// Share of the paths so far that were in cells which are full now.
    fn share_full(&self) -> f32 {
        let paths = |full: bool| self.cells.values().filter(move |cell| cell.is_full() == full).map(|cell| cell.paths);
        let [full, others] = [true, false].map(|full| paths(full).map(f64::from).sum::<f64>());
        (full / (full + others).max(1.0)) as f32
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
        if self.levels.is_empty() {
            self.begin(&points);
        } else {
            self.smallest().add(points());
        }
        let (smallest, larger) = self.levels.split_last_mut().expect("at least one level");
        let goes_on = |point: &GatherPoint| larger.last().is_some_and(|next| next.may_share(point));
        let mut rest: Vec<_> = points().filter(|point| goes_on(point) && smallest.full_cell(point).is_none()).collect();
        for level in larger.iter_mut().rev() {
            level.add(rest.iter().copied());
            // What is too near for cells of a size is for larger ones, too.
            rest.retain(|point| level.may_share(point) && level.full_cell(point).is_none());
        }
        if smallest.share_full() >= FULL && smallest.size > 0 {
            self.levels.push(Level::halved(self.levels.len() as u32));
        }
    }

    /// The first cells: of all sizes that fill, and of one that does not, which alone has learned already.
    fn begin<I: Iterator<Item = GatherPoint>>(&mut self, points: &impl Fn() -> I) {
        for times in 0..=COARSEST {
            self.levels.push(Level::halved(times));
            let mut level = Level::halved(times);
            level.add(points());
            if level.share_full() < FULL || times == COARSEST {
                *self.smallest() = level;
                return;
            }
        }
    }

    fn smallest(&mut self) -> &mut Level {
        self.levels.last_mut().expect("at least one level")
    }

    /// Radiance that arrives at the camera from `point`: that of its smallest full cell, or where that is too large, what
    /// its path found by itself.
    pub(crate) fn arriving(&self, point: &GatherPoint) -> Vec3 {
        let allowed = self.levels.iter().rev().take_while(|level| level.may_share(point));
        let cell = allowed.filter_map(|level| level.full_cell(point)).next();
        cell.map_or(point.found, |cell| point.weight * cell.mean)
    }
}
