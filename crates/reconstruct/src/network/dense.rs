//! Nodes of a dense layer for `L` pixels (lanes) at once, and the way back. With one lane it is a plain node.

use rayon::prelude::*;

use crate::exp::exp_of_negative;

/// All of so many `pixels`, `L` at a time; the last is repeated where they do not fill the last lanes.
pub fn lanes_of<const L: usize>(pixels: usize) -> impl IndexedParallelIterator<Item = [usize; L]> {
    (0..pixels.div_ceil(L))
        .into_par_iter()
        .map(move |block| std::array::from_fn(|lane| (block * L + lane).min(pixels - 1)))
}

/// `start` + Σ w x, added in the order of the inputs.
#[inline(always)]
pub fn weighted_sum<const L: usize>(start: [f32; L], weights: &[f32], inputs: &[[f32; L]]) -> [f32; L] {
    let mut sum = start;
    for (weight, input) in weights.iter().zip(inputs) {
        for (sum, value) in sum.iter_mut().zip(input) {
            *sum += weight * value;
        }
    }
    sum
}

/// Adds dE/dw = Σ over lanes of slope · x to the `gradient` of a node's weights; `slope` is dE/d(weighted sum).
#[inline(always)]
pub fn add_products<const L: usize>(gradient: &mut [f64], slope: &[f32; L], inputs: &[[f32; L]]) {
    for (sum, input) in gradient.iter_mut().zip(inputs) {
        *sum += f64::from(sum_of_lanes::<L>(std::array::from_fn(|lane| slope[lane] * input[lane])));
    }
}

/// Sum over the lanes, a power of two of them: halves are added until one is left.
#[inline(always)]
pub fn sum_of_lanes<const L: usize>(mut lanes: [f32; L]) -> f32 {
    const { assert!(L.is_power_of_two()) };
    let mut half = L / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}

/// The hyperbolic tangent, within 10⁻⁶.
#[inline(always)]
pub fn tanh(x: f32) -> f32 {
    let e = exp_of_negative(-2.0 * x.abs());
    ((1.0 - e) / (1.0 + e)).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_are_those_of_every_lane() {
        let inputs = [[1.0, 2.0, 3.0, 4.0], [0.5, 0.0, -1.0, 2.0]];
        assert_eq!(weighted_sum([1.0; 4], &[2.0, 4.0], &inputs), [5.0, 5.0, 3.0, 17.0]);
        let mut gradient = [1.0, 1.0];
        add_products(&mut gradient, &[1.0, 1.0, 2.0, -1.0], &inputs);
        assert_eq!(gradient, [6.0, -2.5]);
        assert_eq!(sum_of_lanes([1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0]), 255.0);
    }

    #[test]
    fn every_pixel_has_its_lane() {
        assert_eq!(lanes_of::<4>(6).collect::<Vec<_>>(), [[0, 1, 2, 3], [4, 5, 5, 5]]);
        assert_eq!(lanes_of::<4>(0).count(), 0);
    }

    #[test]
    fn tanh_follows_the_library_function() {
        for i in -2000..2000 {
            let x = i as f32 * 0.01;
            assert!((f64::from(tanh(x)) - f64::from(x).tanh()).abs() < 1e-6, "{x}");
        }
    }
}
