//! Work cut into pieces that depend on nothing but their input: done on all threads, told piece by piece, and stopped
//! between two of them.

use rayon::prelude::*;
use stack::{Cancelled, Monitor};

/// What `work` makes of each of `pieces`, in their order. Reports one unit per piece.
///
/// # Errors
/// When `monitor` cancels.
pub fn of_each<P: Send, R: Send>(
    pieces: impl IntoParallelIterator<Item = P, Iter: IndexedParallelIterator>,
    monitor: &dyn Monitor,
    work: impl Fn(P) -> R + Sync,
) -> Result<Vec<R>, Cancelled> {
    let watched = |piece| {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        let made = work(piece);
        monitor.advance(1);
        Ok(made)
    };
    pieces.into_par_iter().map(watched).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    /// Cancels after so many pieces.
    struct Patience {
        pieces: u64,
        done: AtomicU64,
    }

    impl Monitor for Patience {
        fn advance(&self, units: u64) {
            self.done.fetch_add(units, Ordering::Relaxed);
        }

        fn cancelled(&self) -> bool {
            self.done.load(Ordering::Relaxed) >= self.pieces
        }
    }

    #[test]
    fn results_come_in_order_and_each_piece_is_a_unit() {
        let monitor = Patience { pieces: 1000, done: AtomicU64::new(0) };
        let squares = of_each(0..100_usize, &monitor, |piece| piece * piece).unwrap();
        assert_eq!(squares, (0..100).map(|piece| piece * piece).collect::<Vec<usize>>());
        assert_eq!(monitor.done.into_inner(), 100);
    }

    #[test]
    fn no_piece_is_begun_after_it_was_cancelled() {
        let monitor = Patience { pieces: 3, done: AtomicU64::new(0) };
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let outcome = alone.install(|| of_each(0..100, &monitor, |piece| piece));
        assert_eq!((outcome, monitor.done.into_inner()), (Err(Cancelled), 3));
    }
}
