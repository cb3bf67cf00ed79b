//! A stack of alike patches, transformed.

use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::LazyLock;

use crate::eight::{LANES, Lanes};

/// Side of a patch: as many pixels as are worked on side by side.
pub const PATCH: usize = LANES;

/// The pixels of a patch, row by row.
pub type Patch = [Lanes; PATCH];

/// The orthonormal cosine transform of eight numbers (DCT-II): one row per frequency.
static COSINES: LazyLock<Patch> = LazyLock::new(|| {
    std::array::from_fn(|frequency| {
        let scale = (if frequency == 0 { 1.0 } else { 2.0 } / PATCH as f64).sqrt();
        std::array::from_fn(|place| {
            let angle = std::f64::consts::PI * (place as f64 + 0.5) * frequency as f64 / PATCH as f64;
            (scale * angle.cos()) as f32
        })
    })
});

/// Coefficients of a stack of patches: orthonormal, so that white noise keeps its variance in each.
#[derive(Clone, Debug)]
pub struct Group(Vec<Patch>);

impl Group {
    /// Transforms as many `patches` as some power of two.
    #[inline(always)]
    pub fn new(patches: impl Iterator<Item = Patch>) -> Self {
        let mut group: Vec<Patch> = patches.map(|patch| twice(&COSINES, &patch)).collect();
        let mut sums = group.len();
        while sums > 1 {
            let (low, high) = halves(&group[..sums]);
            sums /= 2;
            group[..sums].copy_from_slice(&low);
            group[sums..2 * sums].copy_from_slice(&high);
        }
        Self(group)
    }

    /// Sets all but the mean to zero that is below `threshold`, and returns how many are left.
    #[inline(always)]
    pub fn drop_below(&mut self, threshold: f32) -> f32 {
        let mean = self.0[0][0][0];
        let mut left = 0.0;
        for value in self.0.iter_mut().flatten().flatten() {
            let kept = if value.abs() < threshold { 0.0 } else { 1.0 };
            *value *= kept;
            left += kept;
        }
        self.0[0][0][0] = mean;
        f32::max(left, 1.0)
    }

    /// Multiplies every coefficient by p²/(p² + 1), p being that of `pilot`, and returns the variance that noise of
    /// variance 1 keeps, summed.
    #[inline(always)]
    pub fn shrink_like(&mut self, pilot: &Self) -> f32 {
        let mut left = [0.0; PATCH];
        for (values, pilot) in self.0.iter_mut().flatten().zip(pilot.0.iter().flatten()) {
            for ((value, pilot), left) in values.iter_mut().zip(pilot).zip(&mut left) {
                let power = pilot * pilot;
                let factor = power / (power + 1.0);
                *value *= factor;
                *left += factor * factor;
            }
        }
        left.iter().sum::<f32>().max(LEAST_LEFT)
    }

    /// The patches of which these are the coefficients.
    #[inline(always)]
    pub fn into_patches(self) -> Vec<Patch> {
        let mut group = self.0;
        let mut sums = 1;
        while sums < group.len() {
            let pair = |i: usize| <[Patch; 2]>::from(butterfly(&group[i], &group[sums + i]));
            let pairs: Vec<Patch> = (0..sums).flat_map(pair).collect();
            sums *= 2;
            group[..sums].copy_from_slice(&pairs);
        }
        let back = transposed(&COSINES);
        group.iter().map(|patch| twice(&back, patch)).collect()
    }
}

/// A group that says nothing weighs much, but not all.
const LEAST_LEFT: f32 = 1e-3;

/// Sums and differences of neighbours, over √2.
#[inline(always)]
fn halves(group: &[Patch]) -> (Vec<Patch>, Vec<Patch>) {
    group.chunks_exact(2).map(|pair| butterfly(&pair[0], &pair[1])).unzip()
}

#[inline(always)]
fn butterfly(a: &Patch, b: &Patch) -> (Patch, Patch) {
    let both = |value: fn(f32, f32) -> f32| {
        std::array::from_fn(|row| std::array::from_fn(|i| FRAC_1_SQRT_2 * value(a[row][i], b[row][i])))
    };
    (both(|a, b| a + b), both(|a, b| a - b))
}

/// `matrix` applied to columns, then to rows; the result stands on its side, which the way back puts right.
#[inline(always)]
fn twice(matrix: &Patch, patch: &Patch) -> Patch {
    product(matrix, &transposed(&product(matrix, patch)))
}

#[inline(always)]
fn product(matrix: &Patch, patch: &Patch) -> Patch {
    std::array::from_fn(|row| {
        let mut sums = [0.0; PATCH];
        for (factor, values) in matrix[row].iter().zip(patch) {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += factor * value;
            }
        }
        sums
    })
}

#[inline(always)]
fn transposed(patch: &Patch) -> Patch {
    std::array::from_fn(|row| std::array::from_fn(|column| patch[column][row]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    fn noise(count: usize) -> Vec<Patch> {
        let mut noise = TestNoise(7);
        (0..count).map(|_| [[0.0; PATCH]; PATCH].map(|row: Lanes| row.map(|_| noise.normal() as f32))).collect()
    }

    #[test]
    fn the_way_back_leads_to_the_same_patches() {
        for count in [1, 2, 8, 32] {
            let patches = noise(count);
            let back = Group::new(patches.iter().copied()).into_patches();
            let pairs = patches.iter().flatten().flatten().zip(back.iter().flatten().flatten());
            assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-5, "{count}");
        }
    }

    #[test]
    fn it_keeps_lengths_and_gathers_what_is_alike_in_one_number() {
        let patches = noise(16);
        let square = |patches: &[Patch]| patches.iter().flatten().flatten().map(|v| v * v).sum::<f32>();
        let group = Group::new(patches.iter().copied());
        assert!((square(&group.0) / square(&patches) - 1.0).abs() < 1e-5);
        let flat = Group::new([[[3.0; PATCH]; PATCH]; 16].into_iter());
        assert!((flat.0[0][0][0] - 3.0 * (16.0 * 64.0_f32).sqrt()).abs() < 1e-3);
        assert!(square(&flat.0) - flat.0[0][0][0].powi(2) < 1e-3);
    }
}
