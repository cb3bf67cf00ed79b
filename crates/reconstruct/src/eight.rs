//! Eight numbers worked on side by side, whatever the processor can take at once: sums that run over lanes have the
//! same bits everywhere.

use pulp::Simd;

/// How many.
pub const LANES: usize = 8;

/// A number of each of eight pixels, for loops that the compiler makes wide by itself.
pub type Lanes = [f32; LANES];

/// Eight numbers, in as many of the processor's registers as they need; the rest of the array is not used.
#[derive(Clone, Copy, Debug)]
pub struct Eight<S: Simd>([S::f32s; LANES]);

impl<S: Simd> Eight<S> {
    const REGISTERS: usize = {
        // Wider processors would silently leave numbers out.
        assert!(LANES.is_multiple_of(S::F32_LANES));
        LANES / S::F32_LANES
    };

    /// The same number eight times.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self([simd.splat_f32s(value); LANES])
    }

    /// The first eight numbers of `from`.
    #[inline(always)]
    pub fn load(simd: S, from: &[f32]) -> Self {
        let from = S::as_simd_f32s(&from[..LANES]).0;
        let mut eight = [simd.splat_f32s(0.0); LANES];
        eight[..Self::REGISTERS].copy_from_slice(&from[..Self::REGISTERS]);
        Self(eight)
    }

    /// All of `lanes`.
    #[inline(always)]
    pub fn of(simd: S, lanes: &Lanes) -> Self {
        Self::load(simd, lanes)
    }

    /// The same where there may be fewer: zeros stand for what is missing.
    #[inline(always)]
    pub fn load_some(simd: S, from: &[f32]) -> Self {
        if from.len() >= LANES {
            return Self::load(simd, from);
        }
        let mut padded = [0.0; LANES];
        padded[..from.len()].copy_from_slice(from);
        Self::load(simd, &padded)
    }

    /// Writes as many of them to `to` as it has places.
    #[inline(always)]
    pub fn store_some(self, to: &mut [f32]) {
        if to.len() >= LANES {
            return self.store(to);
        }
        let mut padded = [0.0; LANES];
        self.store(&mut padded);
        to.copy_from_slice(&padded[..to.len()]);
    }

    /// As an array.
    #[inline(always)]
    pub fn lanes(self) -> Lanes {
        let mut lanes = [0.0; LANES];
        self.store(&mut lanes);
        lanes
    }

    /// Writes them to the first eight places of `to`.
    #[inline(always)]
    pub fn store(self, to: &mut [f32]) {
        S::as_mut_simd_f32s(&mut to[..LANES]).0.copy_from_slice(&self.0[..Self::REGISTERS]);
    }

    /// Sum of two.
    #[inline(always)]
    pub fn add(mut self, simd: S, other: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.add_f32s(self.0[i], other.0[i]);
        }
        self
    }

    /// Difference of two.
    #[inline(always)]
    pub fn sub(mut self, simd: S, other: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.sub_f32s(self.0[i], other.0[i]);
        }
        self
    }

    /// Product of two.
    #[inline(always)]
    pub fn mul(mut self, simd: S, other: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.mul_f32s(self.0[i], other.0[i]);
        }
        self
    }

    /// Quotient of two.
    #[inline(always)]
    pub fn div(mut self, simd: S, other: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.div_f32s(self.0[i], other.0[i]);
        }
        self
    }

    /// The smaller of two.
    #[inline(always)]
    pub fn min(mut self, simd: S, other: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.min_f32s(self.0[i], other.0[i]);
        }
        self
    }

    /// The larger of two.
    #[inline(always)]
    pub fn max(mut self, simd: S, other: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.max_f32s(self.0[i], other.0[i]);
        }
        self
    }

    /// Their sum, by halves.
    #[inline(always)]
    pub fn sum(self) -> f32 {
        sum_of_lanes(&self.lanes())
    }

    /// `self` · `factor` + `sum`, rounded once.
    #[inline(always)]
    pub fn mul_add(mut self, simd: S, factor: Self, sum: Self) -> Self {
        for i in 0..Self::REGISTERS {
            self.0[i] = simd.mul_add_f32s(self.0[i], factor.0[i], sum.0[i]);
        }
        self
    }
}

/// Sum of eight numbers, by halves.
#[inline(always)]
pub fn sum_of_lanes(lanes: &[f32; LANES]) -> f32 {
    let four: [f32; 4] = std::array::from_fn(|i| lanes[i] + lanes[i + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}
