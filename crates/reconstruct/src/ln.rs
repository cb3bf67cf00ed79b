//! Natural logarithm of many numbers.

use std::f32::consts::LN_2;

/// Bits of √½: a number's mantissa is taken between this and √2.
const ROOT_OF_HALF: u32 = 0x3F35_04F3;

/// ln x for positive x, within 3·10⁻⁷ of its value or of 1, whichever is larger; what is less than the least normal
/// number counts as that.
///
/// Like [`exp_of_negative`](crate::exp::exp_of_negative) it vectorises on any machine and gives the same bits on all.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    let bits = x.max(f32::MIN_POSITIVE).to_bits();
    let exponent = (bits.wrapping_sub(ROOT_OF_HALF) as i32) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub((exponent as u32) << 23));
    // ln m = 2 artanh((m − 1)/(m + 1)), whose series converges fast for so small arguments.
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let square = t * t;
    let series = 1.0 + square * (1.0 / 3.0 + square * (0.2 + square * (1.0 / 7.0 + square * (1.0 / 9.0))));
    exponent as f32 * LN_2 + 2.0 * t * series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_library_function() {
        for i in -4000..4000 {
            let x = (i as f32 * 0.02).exp();
            let exact = f64::from(x).ln();
            assert!((f64::from(ln(x)) - exact).abs() <= 3e-7 * exact.abs().max(1.0), "{x}");
        }
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn nothing_is_no_less_than_the_least_number() {
        for x in [0.0, -1.0, 1e-42] {
            assert!((ln(x) + 87.336_54).abs() < 1e-4);
        }
    }
}
