//! The method once more, one pixel at a time, in f64, with exact singular value decompositions and no shortcuts: what
//! the fast code is tested against.

use nalgebra::{DMatrix, DVector};
use stack::{Image, Size};

use super::{Lambda, Order, RegressionInput, RegressionSettings};
use crate::prefilter::FeatureSet;

/// Numbers that look random, within [0, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Mean 0, variance 1.
    pub(crate) fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.next()).sum::<f32>() - 6.0
    }
}

/// A small picture with everything a window can meet: gradients, a diagonal edge, a texture, a curved shadow, noise.
pub(crate) struct Scene {
    pub(crate) colour: Image,
    pub(crate) clean: Image,
    pub(crate) variance: Image,
    pub(crate) features: FeatureSet,
}

impl Scene {
    pub(crate) fn new(size: Size, noise: f32) -> Self {
        let mut random = Random(7);
        let mut planes = vec![vec![0.0; size.pixels()]; 10];
        let mut channels = vec![vec![0.0; size.pixels()]; 3];
        for y in 0..size.height {
            for x in 0..size.width {
                let (u, v) = (x as f32 / size.width as f32, y as f32 / size.height as f32);
                let right = u + 0.3 * v > 0.6;
                let texture = if (x / 4 + y / 4) % 2 == 0 { 0.3 } else { -0.2 };
                let shadow = (4.0 * (v - 0.5)).tanh();
                let (bump, turn) = ((6.0 * u).sin() * 0.3, if right { 1.0 } else { -1.0 });
                let at = size.index(x, y);
                let values = [
                    2.0 * u - 1.0,
                    2.0 * v - 1.0,
                    if right { 0.5 } else { -0.5 },
                    texture,
                    if right { 0.7 } else { -0.7 },
                    0.25,
                    bump,
                    turn * 0.8,
                    (1.0 - bump * bump).sqrt() * 0.5,
                    shadow,
                ];
                for (plane, value) in planes.iter_mut().zip(values) {
                    plane[at] = value;
                }
                let light = 1.0 + shadow * 0.6 + 0.3 * bump;
                for (c, channel) in channels.iter_mut().enumerate() {
                    channel[at] = light * (0.6 + 0.2 * c as f32 * texture + if right { 0.2 } else { 0.0 });
                }
            }
        }
        let clean = Image::from_channels(size, channels.clone());
        for channel in &mut channels {
            for value in channel.iter_mut() {
                *value += noise * random.normal();
            }
        }
        Self {
            colour: Image::from_channels(size, channels),
            clean,
            variance: Image::from_channels(size, vec![vec![noise * noise; size.pixels()]; 3]),
            features: FeatureSet { size, planes, groups: vec![0..3, 3..6, 6..9, 9..10] },
        }
    }

    pub(crate) fn input(&self) -> RegressionInput<'_> {
        RegressionInput { colour: &self.colour, variance: &self.variance, features: &self.features, active: None }
    }
}

/// The low-rank part by its singular values and vectors, and the sparse part.
pub(crate) struct Split {
    /// Singular values of A, the largest first.
    pub(crate) singular: Vec<f64>,
    /// Column j is right singular vector j.
    pub(crate) vectors: DMatrix<f64>,
    /// E.
    pub(crate) sparse: DMatrix<f64>,
}

/// Singular values, the largest first, and right singular vectors (columns).
///
/// By way of the Gram matrix: `nalgebra`'s `svd` returns wrong values for matrices of lower rank when it is asked for
/// vectors too.
pub(crate) fn singular_directions(matrix: &DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let eigen = (matrix.transpose() * matrix).symmetric_eigen();
    let mut order: Vec<usize> = (0..matrix.ncols()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let values = order.iter().map(|j| eigen.eigenvalues[*j].max(0.0).sqrt()).collect();
    let columns: Vec<_> = order.iter().map(|j| eigen.eigenvectors.column(*j)).collect();
    (values, DMatrix::from_columns(&columns))
}

/// Inexact ALM, step by step as Lin et al. write it.
pub(crate) fn exact_alm(data: &DMatrix<f64>, iterations: usize, tolerance: f64, order: Order, lambda: f64) -> Split {
    let spectral = data.clone().svd(false, false).singular_values.max();
    let mut y = data / spectral.max(data.amax() / lambda);
    let mut mu = 1.25 / spectral;
    let mut a = DMatrix::zeros(data.nrows(), data.ncols());
    let mut split = Split { singular: vec![], vectors: a.clone(), sparse: a.clone() };
    let soft = |m: DMatrix<f64>, t: f64| m.map(|v| v - v.clamp(-t, t));
    for iteration in 1..=iterations {
        if order == Order::SparseFirst {
            split.sparse = soft(data - &a + &y / mu, lambda / mu);
        }
        let open = data - &split.sparse + &y / mu;
        let (values, vectors) = singular_directions(&open);
        split.singular = values.iter().map(|s| (s - 1.0 / mu).max(0.0)).collect();
        let shares = split.singular.iter().zip(&values).map(|(a, x)| if *x > 0.0 { a / x } else { 0.0 });
        let shares = DMatrix::from_diagonal(&DVector::from_iterator(values.len(), shares));
        a = open * &vectors * shares * vectors.transpose();
        split.vectors = vectors;
        if order == Order::LowRankFirst {
            split.sparse = soft(data - &a + &y / mu, lambda / mu);
        }
        let rest = data - &a - &split.sparse;
        y += &rest * mu;
        mu *= 1.5;
        if rest.norm() < tolerance * data.norm() {
            if order == Order::SparseFirst && iteration < iterations {
                split.sparse = soft(data - &a + &y / mu, lambda / mu);
            }
            break;
        }
    }
    split
}

pub(crate) fn lambda_of(lambda: Lambda, rows: usize, columns: usize) -> f64 {
    let (n, d) = (rows as f64, columns as f64);
    match lambda {
        Lambda::LongestSide => 1.0 / n.max(d).sqrt(),
        Lambda::ThreeOverRoot => 3.0 / n.sqrt(),
        Lambda::ShortestSide => 1.0 / d.sqrt(),
    }
}

/// What the regression says about one pixel.
pub(crate) struct Pixel {
    pub(crate) colour: [f64; 3],
    pub(crate) mse: f64,
    pub(crate) bandwidth: f64,
    pub(crate) rank: usize,
}

/// One pixel at the default settings (only radius, stride and iterations are heeded).
pub(crate) fn pixel(input: &RegressionInput, settings: &RegressionSettings, x: usize, y: usize) -> Pixel {
    let radius = settings.window.radius;
    let size = input.features.size;
    let (xs, ys) = (x.saturating_sub(radius)..=(x + radius).min(size.width - 1), y.saturating_sub(radius));
    let neighbours: Vec<(usize, usize)> =
        (ys..=(y + radius).min(size.height - 1)).flat_map(|j| xs.clone().map(move |i| (i, j))).collect();
    let scales = scales(input.features, &neighbours);
    let difference = |i: usize, j: usize| -> DVector<f64> {
        let value = |p: &Vec<f32>| f64::from(p[size.index(i, j)]) - f64::from(p[size.index(x, y)]);
        DVector::from_iterator(scales.len(), input.features.planes.iter().map(value)).component_mul(&scales)
    };
    let step = if radius > 5 { settings.reduction.stride } else { 1 };
    let lattice: Vec<_> = neighbours
        .iter()
        .filter(|(i, j)| i.abs_diff(x) % step == 0 && j.abs_diff(y) % step == 0)
        .map(|(i, j)| difference(*i, *j).transpose())
        .collect();
    let basis = basis(&DMatrix::from_rows(&lattice), settings);
    let z: Vec<DVector<f64>> = neighbours.iter().map(|(i, j)| basis.transpose() * difference(*i, *j)).collect();
    let rank = basis.ncols();
    let close = z.iter().filter(|z| z.iter().all(|v| v.abs() < 1.0)).count();
    let bandwidth = (4.0 / (close as f64 * (rank as f64 + 2.0))).powf(1.0 / (rank as f64 + 4.0));
    let colour = |c: usize, (i, j): (usize, usize)| f64::from(input.colour.channels()[c][size.index(i, j)]);
    let y_of = |c: usize| DVector::from_iterator(z.len(), neighbours.iter().map(|at| colour(c, *at)));
    let factors = curvature(&z, [0, 1, 2].map(y_of), rank);
    let narrow = DVector::from_iterator(rank, factors.iter().map(|b| 1.0 / (bandwidth * b)));
    let kernel = equivalent_kernel(&z, &narrow, settings.local_linear.ridge.into());
    let mut result = Pixel { colour: [0, 1, 2].map(|c| kernel.dot(&y_of(c))), mse: 0.0, bandwidth, rank };
    let variance = |c: usize, (i, j): (usize, usize)| f64::from(input.variance.channels()[c][size.index(i, j)]);
    for c in 0..3 {
        let noise: f64 = kernel.iter().zip(&neighbours).map(|(l, at)| l * l * variance(c, *at)).sum();
        result.mse += ((result.colour[c] - colour(c, (x, y))).powi(2) + noise) / 3.0;
    }
    result
}

/// One over each group's largest norm about the mean, at least 0.01.
fn scales(features: &FeatureSet, neighbours: &[(usize, usize)]) -> DVector<f64> {
    let mut scales = DVector::zeros(features.planes.len());
    let value = |f: usize, at: &(usize, usize)| f64::from(features.planes[f][features.size.index(at.0, at.1)]);
    for group in &features.groups {
        let means: Vec<f64> = group
            .clone()
            .map(|f| neighbours.iter().map(|at| value(f, at)).sum::<f64>() / neighbours.len() as f64)
            .collect();
        let norm = |at: &(usize, usize)| -> f64 {
            group.clone().zip(&means).map(|(f, m)| (value(f, at) - m).powi(2)).sum::<f64>().sqrt()
        };
        let largest = neighbours.iter().map(norm).fold(0.01, f64::max);
        group.clone().for_each(|f| scales[f] = 1.0 / largest);
    }
    scales
}

/// V_k.
fn basis(data: &DMatrix<f64>, settings: &RegressionSettings) -> DMatrix<f64> {
    let reduction = &settings.reduction;
    let lambda = lambda_of(reduction.lambda, data.nrows(), data.ncols());
    let split = exact_alm(data, reduction.iterations, reduction.tolerance.into(), reduction.order, lambda);
    let total: f64 = split.singular.iter().sum();
    let mut sum = 0.0;
    let by_energy = split.singular.iter().take_while(|s| {
        let before = sum;
        sum += **s;
        before <= f64::from(reduction.energy) * total
    });
    let by_energy = by_energy.count();
    let error = split.sparse.svd(false, false).singular_values.max();
    let by_error = split.singular.iter().filter(|s| **s > f64::from(reduction.perturbation) * error).count();
    split.vectors.columns(0, by_energy.max(by_error).max(2)).into_owned()
}

fn curvature(z: &[DVector<f64>], colours: [DVector<f64>; 3], rank: usize) -> Vec<f64> {
    let weights = z.iter().map(|z| z.iter().map(|v| (1.0 - v * v).max(0.0)).product::<f64>());
    let weights = DMatrix::from_diagonal(&DVector::from_iterator(z.len(), weights));
    let mut rows = DMatrix::zeros(z.len(), 2 * rank + 1);
    for (i, z) in z.iter().enumerate() {
        rows[(i, 0)] = 1.0;
        for j in 0..rank {
            rows[(i, 1 + j)] = z[j];
            rows[(i, 1 + rank + j)] = z[j] * z[j];
        }
    }
    let centre = z.iter().position(|z| z.norm() == 0.0).expect("the pixel is in its window");
    let ridge = 1e-3 * weights.trace();
    let normal = rows.transpose() * &weights * &rows + DMatrix::identity(2 * rank + 1, 2 * rank + 1) * ridge;
    let inverse = normal.try_inverse().expect("a ridge makes it regular");
    let mut sizes = DVector::zeros(rank);
    for y in colours {
        let right = rows.transpose() * &weights * y.add_scalar(-y[centre]);
        sizes += (&inverse * right).rows(1 + rank, rank).abs() * (2.0 / 3.0);
    }
    sizes.iter().map(|h| 1.0 / (h + 0.16).sqrt()).collect()
}

fn equivalent_kernel(z: &[DVector<f64>], narrow: &DVector<f64>, ridge: f64) -> DVector<f64> {
    let rank = narrow.len();
    let scaled: Vec<DVector<f64>> = z.iter().map(|z| z.component_mul(narrow)).collect();
    let weights = scaled.iter().map(|u| u.iter().map(|v| (1.0 - v * v).max(0.0)).product::<f64>());
    let weights = DMatrix::from_diagonal(&DVector::from_iterator(z.len(), weights));
    let rows = DMatrix::from_fn(z.len(), rank + 1, |i, j| if j == 0 { 1.0 } else { scaled[i][j - 1] });
    let mut normal = rows.transpose() * &weights * &rows;
    for j in 1..=rank {
        normal[(j, j)] += ridge * weights.trace();
    }
    let inverse = normal.try_inverse().expect("a ridge makes it regular");
    (inverse.row(0) * rows.transpose() * weights).transpose()
}

#[test]
fn singular_directions_agree_with_the_decomposition_of_nalgebra() {
    let mut random = Random(21);
    let matrix = DMatrix::from_fn(50, 6, |_, j| f64::from(random.normal()) / (j + 1) as f64);
    let (values, vectors) = singular_directions(&matrix);
    let svd = matrix.svd(false, true);
    let v_t = svd.v_t.expect("the right side was asked for");
    for j in 0..6 {
        assert!((values[j] - svd.singular_values[j]).abs() < 1e-9);
        assert!(((v_t.row(j) * vectors.column(j))[0].abs() - 1.0).abs() < 1e-9);
    }
}
