//! Distances between noisy patches (equations 10 and 11), for all pixels of a rectangle at once.

use stack::Size;

use crate::box_filter::window_sums;
use crate::rectangle::Rectangle;

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

/// How patches are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchComparison {
    /// Patches have (2·`patch_radius` + 1)² pixels.
    pub patch_radius: usize,
    /// ε of eq. 10.
    pub epsilon: f32,
    /// Share of the distance that noise alone makes, and which is taken off: 1 as in eq. 10, 0 for planes whose
    /// variances are a scale and no noise.
    pub noise_taken_off: f32,
}

/// Computes distance images; keeps its buffers between calls.
#[derive(Debug)]
pub struct PatchDistance<'a> {
    planes: NoisyPlanes<'a>,
    comparison: PatchComparison,
    row: Vec<f32>,
    partial: Vec<f32>,
    across: Vec<f32>,
}

impl<'a> PatchDistance<'a> {
    /// Compares patches of `planes`.
    pub fn new(planes: NoisyPlanes<'a>, comparison: PatchComparison) -> Self {
        Self { planes, comparison, row: Vec::new(), partial: Vec::new(), across: Vec::new() }
    }

    /// D(P(c), P(c + `offset`)) of eq. 11 for every pixel c of `centres`, mean over the group's channels; row by row
    /// into `out`. Pixels of a patch count where both ends lie inside the image. `centres` must lie inside and stay
    /// there when moved by `offset`.
    #[inline(always)]
    pub fn compute(&mut self, centres: Rectangle, offset: [isize; 2], out: &mut Vec<f32>) {
        let valid =
            centres.grown(self.comparison.patch_radius, self.planes.size).where_inside(offset, self.planes.size);
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
    #[inline(always)]
    fn reach(&self, centre: usize, first: usize, end: usize) -> std::ops::Range<usize> {
        centre.saturating_sub(self.comparison.patch_radius).max(first)
            ..(centre + self.comparison.patch_radius + 1).min(end)
    }

    /// Sums over the pixels of a patch become their mean, 0 where it is negative.
    #[inline(always)]
    fn divide(&self, sums: &mut [f32], x0: usize, valid: Rectangle, rows: f32) {
        let whole = 1.0 / (rows * (2 * self.comparison.patch_radius + 1) as f32);
        let inner_start = (valid.x0 + self.comparison.patch_radius).saturating_sub(x0).min(sums.len());
        let inner_end = valid.x1.saturating_sub(x0 + self.comparison.patch_radius).clamp(inner_start, sums.len());
        for sum in &mut sums[inner_start..inner_end] {
            *sum = (*sum * whole).max(0.0);
        }
        for i in (0..inner_start).chain(inner_end..sums.len()) {
            let columns = self.reach(x0 + i, valid.x0, valid.x1).len();
            sums[i] = (sums[i] / (rows * columns as f32)).max(0.0);
        }
    }

    /// For every row of `valid`: pixel distances summed over the patches' width, for every column of `centres`.
    #[inline(always)]
    fn sum_rows(&mut self, centres: Rectangle, valid: Rectangle, offset: [isize; 2]) {
        let width = centres.width();
        let padded = width + 2 * self.comparison.patch_radius;
        self.across.resize(width * valid.height(), 0.0);
        self.row.resize(padded, 0.0);
        self.partial.resize(padded, 0.0);
        self.row.fill(0.0);
        let start = valid.x0 + self.comparison.patch_radius - centres.x0;
        for (y, across) in (valid.y0..valid.y1).zip(self.across.chunks_exact_mut(width.max(1))) {
            let here = self.planes.size.index(valid.x0, y);
            let there = here.wrapping_add_signed(offset[0] + offset[1] * self.planes.size.width as isize);
            let row = &mut self.row[start..start + valid.width()];
            pixel_distances(self.planes, here, there, self.comparison, row);
            window_sums(&self.row, 2 * self.comparison.patch_radius + 1, &mut self.partial, across);
        }
    }
}

/// D(c, q) of eq. 10 summed over channels, for consecutive pixels c from `here` and q from `there`.
#[inline(always)]
fn pixel_distances(planes: NoisyPlanes, here: usize, there: usize, comparison: PatchComparison, out: &mut [f32]) {
    if let ([a, b, c], [va, vb, vc]) = (planes.values, planes.variances) {
        // Colours, and most features: all three channels at once.
        return three_channels([a, b, c], [va, vb, vc], [here, there], comparison, out);
    }
    out.fill(0.0);
    let count = out.len();
    for (values, variances) in planes.values.iter().zip(planes.variances) {
        let (y_c, y_q) = (&values[here..][..count], &values[there..][..count]);
        let (var_c, var_q) = (&variances[here..][..count], &variances[there..][..count]);
        for i in 0..count {
            out[i] += distance(y_c[i], y_q[i], var_c[i], var_q[i], comparison);
        }
    }
}

#[inline(always)]
fn three_channels(
    values: [&Vec<f32>; 3],
    variances: [&Vec<f32>; 3],
    [here, there]: [usize; 2],
    comparison: PatchComparison,
    out: &mut [f32],
) {
    let count = out.len();
    let [y_c, var_c] = [values, variances].map(|planes| planes.map(|plane| &plane[here..][..count]));
    let [y_q, var_q] = [values, variances].map(|planes| planes.map(|plane| &plane[there..][..count]));
    for i in 0..count {
        let of_channel = |c: usize| distance(y_c[c][i], y_q[c][i], var_c[c][i], var_q[c][i], comparison);
        out[i] = of_channel(0) + of_channel(1) + of_channel(2);
    }
}

/// D(c, q) of eq. 10 for one channel.
#[inline(always)]
fn distance(y_c: f32, y_q: f32, var_c: f32, var_q: f32, comparison: PatchComparison) -> f32 {
    let difference = y_c - y_q;
    let least = if var_c < var_q { var_c } else { var_q };
    (difference * difference - comparison.noise_taken_off * (var_c + least)) / (comparison.epsilon + var_c + var_q)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    /// Eq. 11 as it stands, pixel by pixel, in double precision.
    pub fn distance_twin(planes: NoisyPlanes, c: [isize; 2], q: [isize; 2], comparison: PatchComparison) -> f64 {
        let reach = comparison.patch_radius as isize;
        let [epsilon, taken_off] = [comparison.epsilon, comparison.noise_taken_off].map(f64::from);
        let (w, h) = (planes.size.width as isize, planes.size.height as isize);
        let at = |[x, y]: [isize; 2]| {
            (0..w).contains(&x).then_some(()).and((0..h).contains(&y).then(|| (x + y * w) as usize))
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (Some(c), Some(q)) = (at([c[0] + dx, c[1] + dy]), at([q[0] + dx, q[1] + dy])) else { continue };
                for (values, variances) in planes.values.iter().zip(planes.variances) {
                    let [y_c, y_q] = [c, q].map(|p| f64::from(values[p]));
                    let [var_c, var_q] = [c, q].map(|p| f64::from(variances[p]));
                    let noise = taken_off * (var_c + var_c.min(var_q));
                    sum += ((y_c - y_q).powi(2) - noise) / (epsilon + var_c + var_q);
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

    fn comparison(patch_radius: usize) -> PatchComparison {
        PatchComparison { patch_radius, epsilon: 1e-4, noise_taken_off: 1.0 }
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
                PatchDistance::new(planes, comparison(patch_radius)).compute(centres, offset, &mut out);
                for (i, distance) in out.iter().enumerate() {
                    let (x, y) = (centres.x0 + i % centres.width(), centres.y0 + i / centres.width());
                    let c = [x as isize, y as isize];
                    let q = [c[0] + offset[0], c[1] + offset[1]];
                    let expected = distance_twin(planes, c, q, comparison(patch_radius));
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
        PatchDistance::new(planes, comparison(3)).compute(centres, [1, 0], &mut out);
        assert_eq!(out, vec![0.0; 72]);
    }
}
