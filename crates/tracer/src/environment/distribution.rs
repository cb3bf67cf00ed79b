//! Choosing directions of a map: a distribution that is constant over cells of it.
//!
//! A cell is a texel, or a block of texels of maps with more than [`MOST_COLUMNS`] columns. Its probability is the
//! integral of the *interpolated* radiance over it, so that a cell next to a bright texel is chosen as often as it shines,
//! and never is a cell without probability that shines at all. Within a cell directions are uniform over solid angle.
//! What is evaluated is the map itself; the density is exactly that of the choice, so the estimate is unbiased whatever
//! the cells are.

use std::f64::consts::PI;

use glam::Vec2;

/// Cells along the horizon at most.
const MOST_COLUMNS: usize = 2048;

/// Probabilities of cells, first of a row of them, then of a cell in it.
#[derive(Debug)]
pub(super) struct Distribution {
    width: usize,
    height: usize,
    /// Texels along each side of a cell; cells in the last row and column may have fewer.
    block: usize,
    columns: usize,
    /// Probability of all rows before each, and 1.
    rows: Vec<f32>,
    /// The same within each row: `columns` + 1 numbers a row.
    cells: Vec<f32>,
}

/// A place in the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Share of the way round the horizon.
    pub(super) u: f32,
    /// Cosine with the zenith.
    pub(super) cosine: f32,
    /// Density per solid angle.
    pub(super) pdf: f32,
}

impl Distribution {
    /// The distribution for a map of texels; `None` when all are black.
    pub(super) fn new(width: usize, height: usize, texels: &[[f32; 3]]) -> Option<Self> {
        let block = width.div_ceil(MOST_COLUMNS);
        let (columns, rows) = (width.div_ceil(block), height.div_ceil(block));
        let mut weights = vec![0.0_f64; columns * rows];
        for y in 0..height {
            let solid_angle = cosine(y, height) - cosine(y + 1, height);
            let radiances = interpolated_row(width, height, texels, y);
            for (x, radiance) in radiances.into_iter().enumerate() {
                weights[y / block * columns + x / block] += solid_angle * radiance;
            }
        }
        let sums: Vec<f64> = weights.chunks(columns).map(|row| row.iter().sum()).collect();
        let cells = weights.chunks(columns).flat_map(cumulative).collect();
        let total: f64 = sums.iter().sum();
        (total > 0.0 && total.is_finite()).then(|| Self {
            width,
            height,
            block,
            columns,
            rows: cumulative(&sums),
            cells,
        })
    }

    /// Chooses a cell by `u` in [0, 1)² and a place in it.
    pub(super) fn sample_cell(&self, u: Vec2) -> Place {
        let (row, down) = find(&self.rows, u.y);
        let (column, along) = find(self.row(row), u.x);
        let [left, right] = self.edges(column, self.width).map(|x| x as f32 / self.width as f32);
        let [top, bottom] = self.edges(row, self.height).map(|y| cosine(y, self.height));
        Place {
            u: left + along * (right - left),
            cosine: (top + f64::from(down) * (bottom - top)) as f32,
            pdf: self.pdf(row, column),
        }
    }

    /// Density per solid angle at the place `uv` of the map.
    pub(super) fn cell_pdf(&self, uv: Vec2) -> f32 {
        let cell = |c: f32, count: usize| ((c * count as f32) as usize).min(count - 1) / self.block;
        self.pdf(cell(uv.y, self.height), cell(uv.x, self.width))
    }

    fn pdf(&self, row: usize, column: usize) -> f32 {
        let of_row = self.row(row);
        let probability = (self.rows[row + 1] - self.rows[row]) * (of_row[column + 1] - of_row[column]);
        let [top, bottom] = self.edges(row, self.height).map(|y| cosine(y, self.height));
        let [left, right] = self.edges(column, self.width);
        let solid_angle = 2.0 * PI * (right - left) as f64 / self.width as f64 * (top - bottom);
        probability / solid_angle as f32
    }

    fn row(&self, row: usize) -> &[f32] {
        &self.cells[row * (self.columns + 1)..(row + 1) * (self.columns + 1)]
    }

    /// First texel of cell `cell`, and the first after it, along a side of `count` texels.
    fn edges(&self, cell: usize, count: usize) -> [usize; 2] {
        [cell * self.block, ((cell + 1) * self.block).min(count)]
    }
}

/// Cosine with the zenith of the upper edge of row `y`.
fn cosine(y: usize, height: usize) -> f64 {
    (PI * y as f64 / height as f64).cos()
}

/// Mean, over the area of each texel of row `y`, of what bilinear lookup returns there, averaged over the channels: a
/// texel has ¾ of it along each axis, its neighbours ⅛ each.
fn interpolated_row(width: usize, height: usize, texels: &[[f32; 3]], y: usize) -> Vec<f64> {
    let grey = |row: usize, x: usize| texels[row * width + x].iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0;
    let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
    let column = |x: usize| 0.125 * grey(above, x) + 0.75 * grey(y, x) + 0.125 * grey(below, x);
    let columns: Vec<f64> = (0..width).map(column).collect();
    let (before, after) = (|x: usize| (x + width - 1) % width, |x: usize| (x + 1) % width);
    (0..width).map(|x| 0.125 * columns[before(x)] + 0.75 * columns[x] + 0.125 * columns[after(x)]).collect()
}

/// Sums of the weights before each, as shares of all; even steps where all weights are zero.
fn cumulative(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let share = |w: &f64| if total > 0.0 { w / total } else { 1.0 / weights.len() as f64 };
    let mut sum = 0.0;
    let mut sums = vec![0.0_f32];
    sums.extend(weights.iter().map(|w| {
        sum += share(w);
        sum.min(1.0) as f32
    }));
    sums[weights.len()] = 1.0;
    sums
}

/// The interval of `sums` that `u` falls into, and how far into it, in [0, 1).
fn find(sums: &[f32], u: f32) -> (usize, f32) {
    let index = sums.partition_point(|&sum| sum <= u).clamp(1, sums.len() - 1) - 1;
    let (from, to) = (sums[index], sums[index + 1]);
    (index, if to > from { ((u - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 })
}
