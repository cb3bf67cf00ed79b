//! Weighted first and second moments of a window, for the normal equations.

use super::row::{FEATURES, Row, WIDTH};

/// A pixel of the window that has a say.
#[derive(Clone, Copy, Debug)]
pub struct Neighbour {
    /// Its index.
    pub pixel: u32,
    /// Its index in the sums of the tile.
    pub place: u32,
    /// Weight with which it takes the fit's prediction.
    pub kernel: f32,
    /// Weight of its residual in the fit.
    pub weight: f32,
}

/// Moments about the window's weighted mean, divided by the sum of weights.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// Covariances of each feature with all features and responses.
    pub covariance: [Row; FEATURES],
    /// Weighted mean relative to the centre.
    pub mean: Row,
    /// Sum of weights.
    pub weight: f32,
}

/// Half a row: as many numbers as common processors take at once.
const HALF: usize = WIDTH / 2;

/// Moments of `neighbours`, relative to `centre`. Fused multiplications are used on every machine alike.
#[inline(always)]
pub fn moments(rows: &[Row], centre: &Row, neighbours: &[Neighbour]) -> Moments {
    let (mut low, mut high) = ([[0.0; HALF]; HALF], [[0.0; HALF]; FEATURES]);
    let (mut low_sum, mut high_sum, mut weight) = ([0.0_f32; HALF], [0.0_f32; HALF], 0.0);
    // Two sweeps, because the sums of one fill the processor's registers.
    for neighbour in neighbours {
        let (z, _) = relative(&rows[neighbour.pixel as usize], centre);
        weight += neighbour.weight;
        add_product(&mut low_sum, neighbour.weight, &z);
        for j in 0..HALF {
            add_product(&mut low[j], neighbour.weight * z[j], &z);
        }
    }
    for neighbour in neighbours {
        let (first, z) = relative(&rows[neighbour.pixel as usize], centre);
        add_product(&mut high_sum, neighbour.weight, &z);
        for j in 0..HALF {
            add_product(&mut high[j], neighbour.weight * first[j], &z);
        }
        for j in HALF..FEATURES {
            add_product(&mut high[j], neighbour.weight * z[j - HALF], &z);
        }
    }
    centred(&low, &high, [low_sum, high_sum], weight)
}

/// `row` − `centre`, in halves.
#[inline(always)]
fn relative(row: &Row, centre: &Row) -> ([f32; HALF], [f32; HALF]) {
    let (mut low, mut high) = ([0.0; HALF], [0.0; HALF]);
    for l in 0..HALF {
        low[l] = row[l] - centre[l];
        high[l] = row[l + HALF] - centre[l + HALF];
    }
    (low, high)
}

#[inline(always)]
fn add_product(sum: &mut [f32; HALF], factor: f32, values: &[f32; HALF]) {
    for l in 0..HALF {
        sum[l] = factor.mul_add(values[l], sum[l]);
    }
}

/// Sums of products made into covariances.
#[inline(always)]
fn centred(low: &[[f32; HALF]; HALF], high: &[[f32; HALF]; FEATURES], sums: [[f32; HALF]; 2], weight: f32) -> Moments {
    let scale = 1.0 / weight.max(1e-20);
    let mut mean = [0.0; WIDTH];
    for l in 0..WIDTH {
        mean[l] = sums[l / HALF][l % HALF] * scale;
    }
    let mut covariance = [[0.0; WIDTH]; FEATURES];
    for j in 0..FEATURES {
        for l in 0..WIDTH {
            // The lower rows of the first half were not summed: they repeat columns of the second.
            let product = match (j < HALF, l < HALF) {
                (true, true) => low[j][l],
                (false, true) => high[l][j - HALF],
                (_, false) => high[j][l - HALF],
            };
            covariance[j][l] = product * scale - mean[j] * mean[l];
        }
    }
    Moments { covariance, mean, weight }
}
