//! The pilot bandwidth of a pixel, from the density of its neighbours in the reduced space (section 4.4).

use pulp::Simd;

use super::field::Field;
use super::lanes::{Lanes, MOST_LANES};
use super::matrix::multiply;
use super::reduce::Reduction;
use super::window::Window;

stack::knobs! {
    /// The shared bandwidth h (section 4.4).
    pub struct BandwidthSettings("bandwidth") {
        /// Shared bandwidth h, the same for every pixel; 0 estimates it from the neighbours' density (eqs. 13, 14).
        fixed: f32 = 0.0, 0.0..=10.0;
    }
}

/// All neighbours in the reduced space, and the bandwidths that follow from how close they are.
#[derive(Debug)]
pub(crate) struct Projection<S: Simd> {
    simd: S,
    /// Numbers per row of `coordinates`.
    pub(crate) columns: usize,
    /// z_i − z_c of every neighbour, one row each; neighbours are in row-major order, padding columns included.
    pub(crate) coordinates: Vec<Lanes<S>>,
    /// Shared bandwidth h.
    pub(crate) shared: Lanes<S>,
    differences: Vec<Lanes<S>>,
}

impl<S: Simd> Projection<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let zeros = |n| vec![Lanes::splat(simd, 0.0); n];
        let width = field.features.next_multiple_of(2).max(2);
        let neighbours = field.columns() * (2 * field.radius + 1);
        Self {
            simd,
            columns: 2,
            coordinates: zeros(neighbours * width),
            shared: Lanes::splat(simd, 0.0),
            differences: zeros(field.columns() * width),
        }
    }

    /// Projects every neighbour and finds the shared bandwidth.
    #[inline(always)]
    pub(crate) fn find(
        &mut self,
        field: &Field,
        window: &Window<S>,
        reduction: &Reduction<S>,
        settings: &BandwidthSettings,
    ) {
        self.columns = reduction.columns;
        let per_row = field.columns() * self.columns;
        let mut close = Lanes::splat(self.simd, 0.0);
        for (row, y) in window.rows.clone().enumerate() {
            let differences = &mut self.differences[..field.columns() * reduction.width];
            window.differences(field, y, &reduction.listed, reduction.width, differences);
            let coordinates = &mut self.coordinates[row * per_row..][..per_row];
            multiply(self.simd, coordinates, differences, reduction.width, &reduction.basis, self.columns);
            close += count_close(self.simd, coordinates, self.columns, &window.inside);
        }
        self.shared = shared_bandwidth(self.simd, close, &reduction.rank, settings);
    }

    /// z_i − z_c of neighbour `index`.
    #[inline(always)]
    pub(crate) fn of(&self, index: usize) -> &[Lanes<S>] {
        &self.coordinates[index * self.columns..][..self.columns]
    }
}

/// How many neighbours of a row of the window have |z_j| < 1 for all j: those with a weight when h·b_j = 1.
#[inline(always)]
fn count_close<S: Simd>(simd: S, coordinates: &[Lanes<S>], columns: usize, inside: &[Lanes<S>]) -> Lanes<S> {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let mut count = zero;
    for (z, inside) in coordinates.chunks_exact(columns).zip(inside) {
        let mut farthest = zero;
        for coordinate in z {
            farthest = farthest.max(coordinate.abs());
        }
        count += farthest.less_than(one).select(*inside, zero);
    }
    count
}

/// h of each pixel.
#[inline(always)]
fn shared_bandwidth<S: Simd>(
    simd: S,
    close: Lanes<S>,
    rank: &[usize; MOST_LANES],
    settings: &BandwidthSettings,
) -> Lanes<S> {
    let mut shared = [settings.fixed; MOST_LANES];
    if settings.fixed == 0.0 {
        for (lane, close) in close.to_array().iter().enumerate() {
            shared[lane] = pilot_bandwidth(*close, rank[lane]);
        }
    }
    Lanes::load(simd, &shared)
}

/// h = (4/(N_c (k + 2)))^{1/(k + 4)}: eqs. 13 and 14 with identity covariance. `close` is N_c, at least 1.
pub fn pilot_bandwidth(close: f32, rank: usize) -> f32 {
    let k = rank as f32;
    (4.0 / (close.max(1.0) * (k + 2.0))).powf(1.0 / (k + 4.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bandwidths_by_hand() {
        assert_eq!(pilot_bandwidth(1.0, 2), 1.0);
        assert!((pilot_bandwidth(529.0, 2) - 0.351_64).abs() < 1e-4);
        assert!((pilot_bandwidth(64.0, 0) - 0.420_45).abs() < 1e-4);
        assert!((pilot_bandwidth(100.0, 4) - (1.0f32 / 150.0).powf(0.125)).abs() < 1e-6);
    }
}
