//! Russian roulette: dim paths end early, those that go on carry the light of those that did not.

/// A path goes on with at least this probability, so that no sample weighs more than twenty of its kind.
const LEAST_SURVIVAL: f32 = 0.05;

/// Probability that a path goes on whose largest throughput is `throughput`, light that interfaces took for the time
/// being put back.
#[inline]
pub(super) fn survival(throughput: f32) -> f32 {
    // In this order, a NaN survives and is counted at the end of its path.
    if throughput < LEAST_SURVIVAL { LEAST_SURVIVAL } else { throughput.min(1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survival_stays_between_its_bounds() {
        assert_eq!(survival(0.0), 0.05);
        assert_eq!(survival(0.4), 0.4);
        assert_eq!(survival(7.0), 1.0);
        assert_eq!(survival(f32::NAN), 1.0);
    }
}
