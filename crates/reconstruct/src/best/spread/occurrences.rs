//! Where events are, and how densely.

use std::ops::Range;

use stack::Size;

use crate::best::split::Events;
use crate::exp::exp_of_negative;

/// Deviations to choose from, in pixels.
const SIGMAS: [f32; 9] = [0.4, 0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 7.0, 9.0];

/// Radius of the disc in which events are counted, in deviations.
const COUNTED: f32 = 1.5;

/// The events of one pixel.
#[derive(Clone, Debug)]
pub struct Occurrence {
    /// Column and row of the pixel.
    pub place: [usize; 2],
    /// Light of either half, three channels each.
    pub light: [f32; 6],
    /// See [`Events::concentration`].
    pub concentration: f32,
    /// Where what separates it begins.
    separators: usize,
    energy: f32,
    squares: f32,
}

/// All of them, row by row: they are few among the pixels.
pub struct Occurrences {
    all: Vec<Occurrence>,
    /// Where each row begins, and where the last one ends.
    rows: Vec<usize>,
    /// What separates pixels, occurrence after occurrence.
    separators: Vec<f32>,
    /// Numbers of each.
    count: usize,
    /// Events that surroundings must hold.
    enough: f32,
}

impl Occurrences {
    /// The pixels of an image of `size` that have `events`, and what `separators` say of them.
    pub fn new(events: &Events, separators: &[Vec<f32>], size: Size, enough: f32) -> Self {
        let mut found =
            Self { all: Vec::new(), rows: vec![0], separators: Vec::new(), count: separators.len(), enough };
        let planes = || events.light.iter().flat_map(|half| half.channels());
        for y in 0..size.height {
            for x in 0..size.width {
                let pixel = size.index(x, y);
                let energy = events.energy[pixel];
                if energy > 0.0 {
                    let mut light = [0.0; 6];
                    light.iter_mut().zip(planes()).for_each(|(light, plane)| *light = plane[pixel]);
                    let (concentration, squares) = (events.concentration(pixel), events.squares[pixel]);
                    let first = found.separators.len();
                    found.separators.extend(separators.iter().map(|plane| plane[pixel]));
                    found.all.push(Occurrence {
                        place: [x, y],
                        light,
                        concentration,
                        separators: first,
                        energy,
                        squares,
                    });
                }
            }
            found.rows.push(found.all.len());
        }
        found
    }

    /// Those in some `columns` of row `y`.
    #[inline(always)]
    pub fn of_row(&self, y: usize, columns: Range<usize>) -> &[Occurrence] {
        let row = &self.all[self.rows[y]..self.rows[y + 1]];
        let before = |end: usize| row.partition_point(|occurrence| occurrence.place[0] < end);
        &row[before(columns.start)..before(columns.end)]
    }

    /// The least deviation with which the surroundings of an `event` hold enough of them: Σγe squared over Σγe² counts
    /// them, γ their likeness.
    #[inline(always)]
    pub fn sigma(&self, event: &Occurrence) -> f32 {
        const REACH: usize = (COUNTED * SIGMAS[SIGMAS.len() - 1]) as usize;
        let [x, y] = event.place;
        let mut rings = [[0.0_f32; 2]; SIGMAS.len()];
        for row in y.saturating_sub(REACH)..(y + REACH + 1).min(self.rows.len() - 1) {
            for near in self.of_row(row, x.saturating_sub(REACH)..x + REACH + 1) {
                let squared = (near.place[0].abs_diff(x).pow(2) + row.abs_diff(y).pow(2)) as f32;
                let ring = SIGMAS.partition_point(|sigma| squared > (COUNTED * sigma).powi(2));
                if let Some(ring) = rings.get_mut(ring) {
                    let likeness = self.likeness(event, near);
                    ring[0] += likeness * near.energy;
                    ring[1] += likeness * near.squares;
                }
            }
        }
        let mut sums = [0.0; 2];
        for (ring, sigma) in rings.iter().zip(SIGMAS) {
            sums = [sums[0] + ring[0], sums[1] + ring[1]];
            if sums[0] * sums[0] >= self.enough * sums[1] {
                return sigma;
            }
        }
        SIGMAS[SIGMAS.len() - 1]
    }

    #[inline(always)]
    fn likeness(&self, p: &Occurrence, q: &Occurrence) -> f32 {
        let [p, q] = [p, q].map(|occurrence| &self.separators[occurrence.separators..][..self.count]);
        exp_of_negative(-p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum::<f32>())
    }
}
