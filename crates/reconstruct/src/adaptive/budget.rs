//! Samples handed out in proportion to a map, within a budget and a cap.

/// Relative error that shares carry, having been single precision: one that close above a whole number is that number.
const ROUNDING: f64 = 1e-6;

/// Least value of a pixel relative to the mean of all: so that samples which the others cannot take have somewhere to go.
const LEAST_SHARE: f64 = 1e-9;

/// Whole samples in proportion to `map` (finite, ≥ 0), rounded up and handed out from its largest value down until
/// `budget` is gone. No pixel gets more than `cap`; what that leaves over goes to the others, in proportion again. Equal
/// values take their turn in scattered order, so that no side of the image comes off worse.
///
/// The counts add up to the lesser of `budget` and `cap` × pixels.
pub fn hand_out(map: &[f64], budget: u64, cap: u32) -> Vec<u32> {
    let shares = shares_of(map, budget);
    let scale = scale_to_spend(&shares, budget, cap);
    let mut order: Vec<usize> = (0..map.len()).collect();
    order.sort_unstable_by(|a, b| shares[*b].total_cmp(&shares[*a]).then_with(|| scattered(*a).cmp(&scattered(*b))));
    let mut counts = vec![0; map.len()];
    let mut left = budget;
    for pixel in order {
        let count = rounded_up(shares[pixel] * scale, cap);
        counts[pixel] = u64::from(count).min(left) as u32;
        left -= u64::from(counts[pixel]);
    }
    counts
}

/// The budget divided in proportion to `map`; equally when it is zero everywhere.
fn shares_of(map: &[f64], budget: u64) -> Vec<f64> {
    let mean = map.iter().sum::<f64>() / map.len() as f64;
    let per_unit = budget as f64 / (map.len() as f64 * mean);
    if mean > 0.0 && per_unit.is_finite() {
        map.iter().map(|v| v.max(LEAST_SHARE * mean) * per_unit).collect()
    } else {
        vec![budget as f64 / map.len() as f64; map.len()]
    }
}

/// The least factor ≥ 1 by which shares must grow so that, rounded up and capped, they use up the budget.
fn scale_to_spend(shares: &[f64], budget: u64, cap: u32) -> f64 {
    let spent = |scale: f64| shares.iter().map(|s| u64::from(rounded_up(s * scale, cap))).sum::<u64>();
    let goal = budget.min(u64::from(cap) * shares.len() as u64);
    let (mut low, mut high) = (1.0, 1.0);
    while spent(high) < goal {
        low = high;
        high *= 2.0;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if spent(middle) < goal {
            low = middle
        } else {
            high = middle
        }
        if high - low < ROUNDING * high {
            break;
        }
    }
    high
}

fn rounded_up(share: f64, cap: u32) -> u32 {
    (share * (1.0 - ROUNDING)).ceil().min(f64::from(cap)) as u32
}

/// A rank that scatters consecutive pixels: multiplication by an odd number permutes the 32-bit numbers.
fn scattered(pixel: usize) -> u32 {
    (pixel as u32).wrapping_mul(0x9E37_79B9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn total(counts: &[u32]) -> u64 {
        counts.iter().map(|n| u64::from(*n)).sum()
    }

    #[test]
    fn shares_are_rounded_up_from_the_largest_down() {
        // 10 in proportion 4 : 3 : 2 : 1 of 12: 4.8 3.6 2.4 1.2 become 5 4 3, and nothing is left.
        assert_eq!(hand_out(&[1.0, 2.0, 3.0, 4.0], 12, 100), [0, 3, 4, 5]);
    }

    #[test]
    fn equal_errors_get_equal_samples() {
        for value in [0.0, 1e-30, 0.1, 1e30] {
            assert_eq!(hand_out(&[value; 7], 7 * 13, 100), [13; 7]);
        }
    }

    #[test]
    fn what_the_cap_leaves_goes_to_the_others() {
        assert_eq!(hand_out(&[100.0, 1.0, 1.0, 0.0], 12, 4), [4, 4, 4, 0]);
        assert_eq!(hand_out(&[100.0, 0.0, 0.0, 0.0], 12, 4)[0], 4);
        assert_eq!(total(&hand_out(&[100.0, 0.0, 0.0, 0.0], 12, 4)), 12);
        assert_eq!(hand_out(&[1.0, 2.0], 100, 4), [4, 4]);
    }

    #[test]
    fn leftovers_of_equal_errors_are_scattered() {
        let counts = hand_out(&[1.0; 1000], 500, 8);
        for part in counts.chunks(100) {
            assert!((40..=60).contains(&total(part)), "{}", total(part));
        }
    }

    proptest! {
        #[test]
        fn budget_and_cap_are_kept_and_order_is_respected(
            map in prop::collection::vec(0.0_f64..1e6, 1..200),
            budget in 0_u64..5000,
            cap in 1_u32..60,
        ) {
            let counts = hand_out(&map, budget, cap);
            prop_assert_eq!(total(&counts), budget.min(u64::from(cap) * map.len() as u64));
            prop_assert!(counts.iter().all(|n| *n <= cap));
            for (a, b) in (1..map.len()).map(|i| (i - 1, i)) {
                prop_assert!(map[a] <= map[b] || counts[a] >= counts[b], "more error, more samples");
            }
        }
    }
}
