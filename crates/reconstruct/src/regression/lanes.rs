//! Neighbouring pixels worked on side by side.
//!
//! Every pixel of the regression solves small dense problems of its own. Written for one pixel they are chains of
//! dependent divisions and square roots on matrices too small to vectorise; written for as many *adjacent pixels* as
//! the processor has lanes, each line of code reads as for one pixel and does the work of eight. Lanes never mix, and
//! no operation is fused, so a pixel's result has the same bytes whatever the width.

use std::ops::{Add, AddAssign, Div, Mul, Sub};

use pulp::Simd;

/// One number for each of the pixels worked on side by side.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    value: S::f32s,
}

/// A yes or no for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    value: S::m32s,
}

/// Upper bound of [`Lanes::COUNT`] on any machine.
pub(crate) const MOST_LANES: usize = 16;

impl<S: Simd> Lanes<S> {
    /// How many pixels are worked on side by side.
    pub(crate) const COUNT: usize = S::F32_LANES;

    /// `value` in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f32) -> Self {
        Self { simd, value: simd.splat_f32s(value) }
    }

    /// The first [`Self::COUNT`] numbers of `from`.
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[f32]) -> Self {
        Self { simd, value: S::as_simd_f32s(&from[..Self::COUNT]).0[0] }
    }

    /// Writes the lanes to the first [`Self::COUNT`] places of `to`.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f32]) {
        S::as_mut_simd_f32s(&mut to[..Self::COUNT]).0[0] = self.value;
    }

    /// The lanes as an array; places past [`Self::COUNT`] are zero.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; MOST_LANES] {
        let mut array = [0.0; MOST_LANES];
        self.store(&mut array);
        array
    }

    /// The smaller of two numbers, lane by lane.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self { value: self.simd.min_f32s(self.value, other.value), ..self }
    }

    /// The larger of two numbers, lane by lane.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { value: self.simd.max_f32s(self.value, other.value), ..self }
    }

    /// The value nearest to `self` within ±`limit`.
    #[inline(always)]
    pub(crate) fn clip(self, limit: Self) -> Self {
        self.min(limit).max(Self::splat(self.simd, 0.0) - limit)
    }

    /// The larger of each lane and zero.
    #[inline(always)]
    pub(crate) fn positive_part(self) -> Self {
        self.max(Self::splat(self.simd, 0.0))
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        // Not `abs_f32s`: it is not always inlined, and a call from vector code is dear.
        self.max(Self::splat(self.simd, 0.0) - self)
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self { value: self.simd.sqrt_f32s(self.value), ..self }
    }

    #[inline(always)]
    pub(crate) fn squared(self) -> Self {
        self * self
    }

    /// 1/x, and 0 where x is 0.
    #[inline(always)]
    pub(crate) fn reciprocal_or_zero(self) -> Self {
        let zero = Self::splat(self.simd, 0.0);
        self.equals(zero).select(zero, Self::splat(self.simd, 1.0) / self)
    }

    #[inline(always)]
    pub(crate) fn less_than(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, value: self.simd.less_than_f32s(self.value, other.value) }
    }

    #[inline(always)]
    pub(crate) fn equals(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, value: self.simd.equal_f32s(self.value, other.value) }
    }
}

impl<S: Simd> Mask<S> {
    /// `yes` where the mask is set, `no` elsewhere.
    #[inline(always)]
    pub(crate) fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        Lanes { simd: self.simd, value: self.simd.select_f32s(self.value, yes.value, no.value) }
    }

    /// Whether it is set in any lane.
    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.simd.first_true_m32s(self.value) < S::F32_LANES
    }

    /// 1 where the mask is set, 0 elsewhere and past the last lane.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; MOST_LANES] {
        self.select(Lanes::splat(self.simd, 1.0), Lanes::splat(self.simd, 0.0)).to_array()
    }

    /// Set where both are.
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self { value: self.simd.and_m32s(self.value, other.value), ..self }
    }

    /// Set where either is.
    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self { value: self.simd.or_m32s(self.value, other.value), ..self }
    }

    /// Set where this one is not.
    #[inline(always)]
    pub(crate) fn not(self) -> Self {
        Self { value: self.simd.not_m32s(self.value), ..self }
    }
}

macro_rules! lane_operators {
    ($($Trait:ident $method:ident $operation:ident),*) => { $(
        impl<S: Simd> $Trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { value: self.simd.$operation(self.value, other.value), ..self }
            }
        }
        impl<S: Simd> $Trait<f32> for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f32) -> Self {
                self.$method(Self::splat(self.simd, other))
            }
        }
    )* };
}
lane_operators!(Add add add_f32s, Sub sub sub_f32s, Mul mul mul_f32s, Div div div_f32s);

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
