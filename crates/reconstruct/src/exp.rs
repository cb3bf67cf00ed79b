//! Exponential function for filter weights.

use std::f32::consts::LOG2_E;

/// Adding and taking off 1.5·2²³ rounds a small `f32` to the nearest whole number.
const ROUND: f32 = 12_582_912.0;

/// Below 2⁻¹²⁵ results would become denormal.
const LEAST_EXPONENT: f32 = -125.0;

/// eˣ for x ≤ 0, within 3·10⁻⁷ of its value; from about −86.6 down it stays at 2⁻¹²⁵.
///
/// Written with additions, multiplications and bit shifts only: loops over it vectorise on any machine, and it gives
/// the same bits on all of them, which the libraries' functions do not.
#[inline(always)]
pub fn exp_of_negative(x: f32) -> f32 {
    let power = (x * LOG2_E).max(LEAST_EXPONENT);
    let rounded = power + ROUND;
    let whole = rounded.to_bits().wrapping_sub(ROUND.to_bits());
    let f = power - (rounded - ROUND);
    f32::from_bits(exp2_of_fraction(f).to_bits().wrapping_add(whole << 23))
}

/// 2ᶠ for |f| ≤ ½: the series of e^(f ln 2) to the sixth power.
#[inline(always)]
fn exp2_of_fraction(f: f32) -> f32 {
    const C: [f32; 6] =
        [std::f32::consts::LN_2, 0.240_226_5, 0.055_504_11, 0.009_618_129, 0.001_333_355_8, 0.000_154_035_3];
    1.0 + f * (C[0] + f * (C[1] + f * (C[2] + f * (C[3] + f * (C[4] + f * C[5])))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_library_function() {
        for i in 0..=86_000 {
            let x = -(i as f32) * 1e-3;
            // The exponent itself is rounded: its error grows with |x|.
            let allowed = f64::from(3e-7 + x.abs() * 1.2e-7);
            let exact = f64::from(x).exp();
            assert!((f64::from(exp_of_negative(x)) - exact).abs() <= allowed * exact, "{x}");
        }
    }

    #[test]
    fn is_one_at_zero_and_negligible_far_below() {
        assert_eq!(exp_of_negative(0.0), 1.0);
        for x in [-90.0, -1e6, -1e30, f32::NEG_INFINITY] {
            assert!(exp_of_negative(x) > 0.0 && exp_of_negative(x) < 1e-37);
        }
    }
}
