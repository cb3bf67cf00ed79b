//! A stack of alike patches, transformed.

use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::LazyLock;

use pulp::Simd;

use crate::eight::{Eight, LANES, Lanes};

/// Side of a patch: as many pixels as are worked on side by side.
pub const PATCH: usize = LANES;

/// The pixels of a patch, row by row.
pub type Patch = [Lanes; PATCH];

/// A group that says nothing weighs much, but not all.
const LEAST_LEFT: f32 = 1e-3;

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

/// Its inverse.
static BACK: LazyLock<Patch> =
    LazyLock::new(|| std::array::from_fn(|place| std::array::from_fn(|frequency| COSINES[frequency][place])));

/// Coefficients of a stack of patches: orthonormal, so that white noise keeps its variance in each.
#[derive(Clone, Debug)]
pub struct Group(Vec<Patch>);

impl Group {
    /// Transforms as many `patches` as some power of two.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, mut patches: Vec<Patch>) -> Self {
        let (there, back) = (&*COSINES, &*BACK);
        // Loops, here and below: closures are not compiled for the widest instructions there are.
        for patch in &mut patches {
            *patch = product(simd, &product(simd, there, patch), back);
        }
        let mut other = patches.clone();
        let mut sums = patches.len();
        while sums > 1 {
            sums /= 2;
            for i in 0..sums {
                (other[i], other[sums + i]) = butterfly(&patches[2 * i], &patches[2 * i + 1]);
            }
            patches[..2 * sums].copy_from_slice(&other[..2 * sums]);
        }
        Self(patches)
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
    pub fn into_patches<S: Simd>(self, simd: S) -> Vec<Patch> {
        let mut patches = self.0;
        let mut other = patches.clone();
        let mut sums = 1;
        while sums < patches.len() {
            for i in 0..sums {
                (other[2 * i], other[2 * i + 1]) = butterfly(&patches[i], &patches[sums + i]);
            }
            sums *= 2;
            patches[..sums].copy_from_slice(&other[..sums]);
        }
        let (there, back) = (&*COSINES, &*BACK);
        for patch in &mut patches {
            *patch = product(simd, &product(simd, back, patch), there);
        }
        patches
    }
}

/// Sums and differences, over √2.
#[inline(always)]
fn butterfly(a: &Patch, b: &Patch) -> (Patch, Patch) {
    let (mut sum, mut difference) = (*a, *a);
    for row in 0..PATCH {
        for i in 0..PATCH {
            sum[row][i] = FRAC_1_SQRT_2 * (a[row][i] + b[row][i]);
            difference[row][i] = FRAC_1_SQRT_2 * (a[row][i] - b[row][i]);
        }
    }
    (sum, difference)
}

/// The product of two matrices.
#[inline(always)]
fn product<S: Simd>(simd: S, a: &Patch, b: &Patch) -> Patch {
    let mut rows = [Eight::splat(simd, 0.0); PATCH];
    for (row, b) in rows.iter_mut().zip(b) {
        *row = Eight::of(simd, b);
    }
    let mut product = [[0.0; PATCH]; PATCH];
    for (to, factors) in product.iter_mut().zip(a) {
        let mut sum = Eight::splat(simd, 0.0);
        for (factor, row) in factors.iter().zip(rows) {
            sum = Eight::splat(simd, *factor).mul_add(simd, row, sum);
        }
        sum.store(to);
    }
    product
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

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
            let back = Group::new(Scalar, patches.clone()).into_patches(Scalar);
            let pairs = patches.iter().flatten().flatten().zip(back.iter().flatten().flatten());
            assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-5, "{count}");
        }
    }

    #[test]
    fn it_keeps_lengths_and_gathers_what_is_alike_in_one_number() {
        let patches = noise(16);
        let square = |patches: &[Patch]| patches.iter().flatten().flatten().map(|v| v * v).sum::<f32>();
        let group = Group::new(Scalar, patches.clone());
        assert!((square(&group.0) / square(&patches) - 1.0).abs() < 1e-5);
        let flat = Group::new(Scalar, vec![[[3.0; PATCH]; PATCH]; 16]);
        assert!((flat.0[0][0][0] - 3.0 * (16.0 * 64.0_f32).sqrt()).abs() < 1e-3);
        assert!(square(&flat.0) - flat.0[0][0][0].powi(2) < 1e-3);
    }
}
