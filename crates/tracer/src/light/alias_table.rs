//! Choosing among many by weight, in constant time.

/// Chooses an index in proportion to its weight (Walker 1977, Vose 1991).
#[derive(Debug)]
pub(super) struct AliasTable {
    slots: Vec<Slot>,
    probabilities: Vec<f32>,
    total: f64,
}

/// One of equally likely slots: its own index, or another one.
#[derive(Clone, Copy, Debug)]
struct Slot {
    /// Of 2³² coins, those that keep the slot's own index.
    keep: u64,
    other: u32,
}

/// How many different coins there are.
const COINS: f64 = 4_294_967_296.0;

impl AliasTable {
    /// A table for `weights` ≥ 0.
    pub(super) fn new(weights: &[f64]) -> Self {
        let total: f64 = weights.iter().sum();
        let share = |w: &f64| if total > 0.0 { w / total } else { 0.0 };
        let probabilities = weights.iter().map(|w| share(w) as f32).collect();
        let n = weights.len() as f64;
        let mut filling: Vec<f64> = weights.iter().map(|w| share(w) * n).collect();
        let mut slots: Vec<Slot> = (0..weights.len() as u32).map(|i| Slot { keep: COINS as u64, other: i }).collect();
        let (mut under, mut over): (Vec<usize>, Vec<usize>) = (0..weights.len()).partition(|i| filling[*i] < 1.0);
        while let (Some(&small), Some(&large)) = (under.last(), over.last()) {
            under.pop();
            slots[small] = Slot { keep: (filling[small] * COINS) as u64, other: large as u32 };
            filling[large] -= 1.0 - filling[small];
            if filling[large] < 1.0 {
                over.pop();
                under.push(large);
            }
        }
        Self { slots, probabilities, total }
    }

    /// Sum of all weights.
    pub(super) const fn total(&self) -> f64 {
        self.total
    }

    /// Probability of `index`.
    #[inline]
    pub(super) fn probability(&self, index: usize) -> f32 {
        self.probabilities[index]
    }

    /// An index, from a whole number uniform over 2³². `None` when all weights are zero.
    #[inline]
    pub(super) fn sample_index(&self, choice: u32) -> Option<usize> {
        if self.total <= 0.0 {
            return None;
        }
        // The upper half of the product is the slot, the lower half a coin within it.
        let product = u64::from(choice) * self.slots.len() as u64;
        let (slot, coin) = ((product >> 32) as usize, product & 0xffff_ffff);
        let Slot { keep, other } = self.slots[slot];
        Some(if coin < keep { slot } else { other as usize })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_come_as_often_as_their_weights_say() {
        for weights in [vec![1.0], vec![0.0, 3.0, 1.0], vec![5.0, 1e-3, 0.0, 2.0, 2.0], vec![1.0; 1000]] {
            let table = AliasTable::new(&weights);
            let mut hits = vec![0_u32; weights.len()];
            const STEPS: u32 = 1 << 20;
            for i in 0..STEPS {
                hits[table.sample_index(i << 12 | 0x800).unwrap()] += 1;
            }
            for (i, hits) in hits.iter().enumerate() {
                let expected = weights[i] / weights.iter().sum::<f64>();
                assert!((f64::from(table.probability(i)) - expected).abs() < 1e-6);
                let found = f64::from(*hits) / f64::from(STEPS);
                assert!((found - expected).abs() < 5e-6, "{weights:?} {i}: {found} {expected}");
                assert!(*hits == 0 || weights[i] > 0.0);
            }
        }
    }

    #[test]
    fn nothing_is_chosen_from_nothing() {
        assert_eq!(AliasTable::new(&[]).sample_index(7), None);
        assert_eq!(AliasTable::new(&[0.0, 0.0]).sample_index(7), None);
    }
}
