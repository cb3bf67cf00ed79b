//! Distances between noisy patches (equations 10 and 11), for all pixels of a rectangle at once.

use stack::Size;

use crate::box_filter::window_sums;

/// The planes of one feature group, with their noise.
#[derive(Clone, Copy, Debug)]
pub struct NoisyPlanes<'a> {
    /// Width and height of every plane.
    pub size: Size,
    /// Values, one plane per channel.
    pub values: &'a [Vec<f32>],
    /// Variance of each value, finite and ≥ 0.
    pub variances: &'a [Vec<f32>],
}

/// Columns `x0..x1` and rows `y0..y1` of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// One past the last column.
    pub x1: usize,
    /// One past the last row.
    pub y1: usize,
}

impl Rectangle {
    /// Pixels in a row.
    pub fn width(self) -> usize {
        self.x1.saturating_sub(self.x0)
    }

    /// Rows.
    pub fn height(self) -> usize {
        self.y1.saturating_sub(self.y0)
    }

    /// The pixels at most `by` away from this one in each direction, inside an image of `size`.
    pub fn grown(self, by: usize, size: Size) -> Self {
        Self {
            x0: self.x0.saturating_sub(by),
            y0: self.y0.saturating_sub(by),
            x1: (self.x1 + by).min(size.width),
            y1: (self.y1 + by).min(size.height),
        }
    }

    /// Those of its pixels that are still inside an image of `size` when moved by `offset`.
    pub fn where_inside(self, [dx, dy]: [isize; 2], size: Size) -> Self {
        let low = |least: usize, d: isize| least.max((-d).max(0) as usize);
        let high = |most: usize, d: isize, length: usize| most.min(length.saturating_sub(d.max(0) as usize));
        Self {
            x0: low(self.x0, dx),
            y0: low(self.y0, dy),
            x1: high(self.x1, dx, size.width),
            y1: high(self.y1, dy, size.height),
        }
    }
}

/// Computes distance images; keeps its buffers between calls.
#[derive(Debug)]
pub struct PatchDistance<'a> {
    planes: NoisyPlanes<'a>,
    patch_radius: usize,
    epsilon: f32,
    row: Vec<f32>,
    partial: Vec<f32>,
    across: Vec<f32>,
}

impl<'a> PatchDistance<'a> {
    /// Compares patches of (2·`patch_radius` + 1)² pixels; `epsilon` is that of eq. 10.
    pub fn new(planes: NoisyPlanes<'a>, patch_radius: usize, epsilon: f32) -> Self {
        Self { planes, patch_radius, epsilon, row: Vec::new(), partial: Vec::new(), across: Vec::new() }
    }

    /// D(P(c), P(c + `offset`)) of eq. 11 for every pixel c of `centres`, mean over the group's channels; row by row
    /// into `out`. Pixels of a patch count where both ends lie inside the image. `centres` must lie inside and stay
    /// there when moved by `offset`.
    pub fn compute(&mut self, centres: Rectangle, offset: [isize; 2], out: &mut Vec<f32>) {
        let valid = centres.grown(self.patch_radius, self.planes.size).where_inside(offset, self.planes.size);
        self.sum_rows(centres, valid, offset);
        out.clear();
        out.resize(centres.width() * centres.height(), 0.0);
        for (y, out) in (centres.y0..centres.y1).zip(out.chunks_exact_mut(centres.width().max(1))) {
            let rows = self.reach(y, valid.y0, valid.y1);
            let counts = (rows.len() * self.planes.values.len()) as f32;
            for row in rows {
                let sums = &self.across[(row - valid.y0) * centres.width()..][..centres.width()];
                for (total, sum) in out.iter_mut().zip(sums) {
                    *total += sum;
                }
            }
            self.divide(out, centres.x0, valid, counts);
        }
    }

    /// Rows (or columns) of the patch around `centre` that lie in `first..end`.
    fn reach(&self, centre: usize, first: usize, end: usize) -> std::ops::Range<usize> {
        centre.saturating_sub(self.patch_radius).max(first)..(centre + self.patch_radius + 1).min(end)
    }

    /// Sums over the pixels of a patch become their mean, 0 where it is negative.
    fn divide(&self, sums: &mut [f32], x0: usize, valid: Rectangle, rows: f32) {
        let whole = 1.0 / (rows * (2 * self.patch_radius + 1) as f32);
        let inner_start = (valid.x0 + self.patch_radius).saturating_sub(x0).min(sums.len());
        let inner_end = valid.x1.saturating_sub(x0 + self.patch_radius).clamp(inner_start, sums.len());
        for sum in &mut sums[inner_start..inner_end] {
            *sum = (*sum * whole).max(0.0);
        }
        for i in (0..inner_start).chain(inner_end..sums.len()) {
            let columns = self.reach(x0 + i, valid.x0, valid.x1).len();
            sums[i] = (sums[i] / (rows * columns as f32)).max(0.0);
        }
    }

    /// For every row of `valid`: pixel distances summed over the patches' width, for every column of `centres`.
    fn sum_rows(&mut self, centres: Rectangle, valid: Rectangle, offset: [isize; 2]) {
        let width = centres.width();
        let padded = width + 2 * self.patch_radius;
        self.across.resize(width * valid.height(), 0.0);
        self.row.resize(padded, 0.0);
        self.partial.resize(padded, 0.0);
        self.row.fill(0.0);
        let start = valid.x0 + self.patch_radius - centres.x0;
        for (y, across) in (valid.y0..valid.y1).zip(self.across.chunks_exact_mut(width.max(1))) {
            let here = self.planes.size.index(valid.x0, y);
            let there = here.wrapping_add_signed(offset[0] + offset[1] * self.planes.size.width as isize);
            let row = &mut self.row[start..start + valid.width()];
            pixel_distances(self.planes, here, there, self.epsilon, row);
            window_sums(&self.row, 2 * self.patch_radius + 1, &mut self.partial, across);
        }
    }
}

/// D(c, q) of eq. 10 summed over channels, for consecutive pixels c from `here` and q from `there`.
fn pixel_distances(planes: NoisyPlanes, here: usize, there: usize, epsilon: f32, out: &mut [f32]) {
    out.fill(0.0);
    let count = out.len();
    for (values, variances) in planes.values.iter().zip(planes.variances) {
        let (y_c, y_q) = (&values[here..][..count], &values[there..][..count]);
        let (var_c, var_q) = (&variances[here..][..count], &variances[there..][..count]);
        for i in 0..count {
            let difference = y_c[i] - y_q[i];
            let least = if var_c[i] < var_q[i] { var_c[i] } else { var_q[i] };
            out[i] += (difference * difference - (var_c[i] + least)) / (epsilon + var_c[i] + var_q[i]);
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    /// Eq. 11 as it stands, pixel by pixel, in double precision.
    pub fn distance_twin(planes: NoisyPlanes, c: [isize; 2], q: [isize; 2], patch_radius: isize, epsilon: f64) -> f64 {
        let (w, h) = (planes.size.width as isize, planes.size.height as isize);
        let at = |[x, y]: [isize; 2]| {
            (0..w).contains(&x).then_some(()).and((0..h).contains(&y).then(|| (x + y * w) as usize))
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for dy in -patch_radius..=patch_radius {
            for dx in -patch_radius..=patch_radius {
                let (Some(c), Some(q)) = (at([c[0] + dx, c[1] + dy]), at([q[0] + dx, q[1] + dy])) else { continue };
                for (values, variances) in planes.values.iter().zip(planes.variances) {
                    let [y_c, y_q] = [c, q].map(|p| f64::from(values[p]));
                    let [var_c, var_q] = [c, q].map(|p| f64::from(variances[p]));
                    sum += ((y_c - y_q).powi(2) - (var_c + var_c.min(var_q))) / (epsilon + var_c + var_q);
                    count += 1.0;
                }
            }
        }
        f64::max(0.0, sum / count)
    }

    /// Noisy planes for tests: values and variances.
    pub fn random_planes(size: Size, channels: usize, seed: u64) -> [Vec<Vec<f32>>; 2] {
        let mut noise = TestNoise(seed);
        let mut planes = || (0..channels).map(|_| noise.normals(size.pixels(), 0.0, 0.3)).collect::<Vec<_>>();
        let values = planes();
        let variances = planes().into_iter().map(|p| p.into_iter().map(|v| 0.5 * v * v + 0.01).collect()).collect();
        [values, variances]
    }

    #[test]
    fn a_distance_image_agrees_with_the_formula_everywhere() {
        let size = Size::new(17, 12);
        let [values, variances] = random_planes(size, 3, 5);
        let planes = NoisyPlanes { size, values: &values, variances: &variances };
        let whole = Rectangle { x0: 0, y0: 0, x1: 17, y1: 12 };
        let part = Rectangle { x0: 5, y0: 4, x1: 9, y1: 10 };
        let mut out = Vec::new();
        for (patch_radius, offset) in [(0, [2, -1]), (1, [0, 3]), (3, [-4, 1]), (3, [5, 0]), (5, [0, -3])] {
            for centres in [whole, part].map(|r| r.where_inside(offset, size)) {
                PatchDistance::new(planes, patch_radius, 1e-4).compute(centres, offset, &mut out);
                for (i, distance) in out.iter().enumerate() {
                    let (x, y) = (centres.x0 + i % centres.width(), centres.y0 + i / centres.width());
                    let c = [x as isize, y as isize];
                    let q = [c[0] + offset[0], c[1] + offset[1]];
                    let expected = distance_twin(planes, c, q, patch_radius as isize, 1e-4);
                    assert!((f64::from(*distance) - expected).abs() < 2e-5 * (1.0 + expected), "{c:?} {offset:?}");
                }
            }
        }
    }

    #[test]
    fn equal_images_are_at_distance_zero() {
        let size = Size::new(9, 9);
        let (values, variances) = (vec![vec![0.7; 81]], vec![vec![0.1; 81]]);
        let planes = NoisyPlanes { size, values: &values, variances: &variances };
        let centres = Rectangle { x0: 0, y0: 0, x1: 8, y1: 9 };
        let mut out = Vec::new();
        PatchDistance::new(planes, 3, 1e-10).compute(centres, [1, 0], &mut out);
        assert_eq!(out, vec![0.0; 72]);
    }
}
