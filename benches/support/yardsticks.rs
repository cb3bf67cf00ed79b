//! The plainest work there is: what one thread of this machine can do at all.

use std::hint::black_box;
use std::time::Instant;

use super::random::Random;

/// How often a dot product goes through its slices, so that adding up its sums in the end does not count.
pub const PASSES: usize = 16;
/// Numbers in such a slice: the innermost cache holds two.
pub const NUMBERS: usize = 2048;
/// Numbers that are copied from memory to memory.
const COPIED: usize = 1 << 24;
/// How often copies and dot products, which are short, are tried; the least time counts.
const TRIALS: [usize; 2] = [20, 5000];

/// Two slices for [`dot`].
pub fn factors() -> [Vec<f32>; 2] {
    let mut random = Random(3);
    [(); 2].map(|()| (0..NUMBERS).map(|_| random.unit()).collect())
}

/// Scalar product of two slices, times [`PASSES`], with the widest instructions there are.
pub fn dot(a: &[f32], b: &[f32]) -> f32 {
    pulp::Arch::new().dispatch(|| sum_of_products(a, b))
}

/// Thirty-two sums side by side keep the processor's units busy.
#[inline(always)]
fn sum_of_products(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0; 32];
    for _ in 0..PASSES {
        for (a, b) in a.chunks_exact(32).zip(b.chunks_exact(32)) {
            for i in 0..32 {
                sums[i] += a[i] * b[i];
            }
        }
    }
    sums.iter().sum()
}

/// Seconds to copy a number from memory to memory.
pub fn copied_number() -> f64 {
    let (from, mut to) = (vec![1.0_f32; COPIED], vec![0.0_f32; COPIED]);
    least(TRIALS[0], || black_box(&mut to).copy_from_slice(black_box(&from))) / COPIED as f64
}

/// Seconds of a multiply-add on what the innermost cache holds.
pub fn multiply_add() -> f64 {
    let [a, b] = factors();
    let run = || {
        black_box(dot(black_box(&a), black_box(&b)));
    };
    least(TRIALS[1], run) / (PASSES * NUMBERS) as f64
}

fn least(trials: usize, mut run: impl FnMut()) -> f64 {
    let timed = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..trials).map(timed).fold(f64::INFINITY, f64::min)
}
