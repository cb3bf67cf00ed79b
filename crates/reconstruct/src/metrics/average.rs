//! Averages of per-pixel errors.

/// Share of pixels that [`trimmed_mean`] keeps.
const KEPT: f64 = 0.999;

/// Mean of `errors`; `None` when there are none.
pub fn mean(errors: &[f64]) -> Option<f64> {
    (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64)
}

/// Mean without the worst 0.1 %: over the ⌊0.999 n⌋ smallest of n errors, at least one. `None` when there are none.
/// What is left shows how good the picture is apart from a few fireflies.
pub fn trimmed_mean(mut errors: Vec<f64>) -> Option<f64> {
    errors.sort_unstable_by(f64::total_cmp);
    let kept = ((errors.len() as f64 * KEPT) as usize).max(1);
    errors.truncate(kept);
    mean(&errors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_thousandth_is_left_out() {
        let mut errors = vec![1.0; 2000];
        (errors[7], errors[1500], errors[1999]) = (1e9, 1e6, 1001.0);
        assert_eq!(trimmed_mean(errors.clone()), Some((1997.0 + 1001.0) / 1998.0));
        assert_eq!(trimmed_mean(errors[..10].to_vec()), Some(1.0), "⌊9.99⌋ of ten");
        assert_eq!(trimmed_mean(vec![3.0]), Some(3.0));
        assert_eq!((trimmed_mean(vec![]), mean(&[])), (None, None));
    }
}
