//! What the time that is left is enough for.

use std::time::{Duration, Instant};

/// How much longer the last reconstruction takes than one while iterating, at the most: 1.3 times with `best`, 1.6 with `paper`,
/// whose windows are larger.
const LAST: f64 = 2.0;

/// Where the time of a loop went, and when it ends.
#[derive(Clone, Copy, Debug)]
pub struct TimeLeft {
    start: Instant,
    limit: Duration,
    /// Seconds that tracing took, and the samples it took them for.
    traced: (f64, u64),
    /// Seconds that reconstructions while iterating took, and how many there were.
    estimated: (f64, u32),
}

impl TimeLeft {
    /// The loop begins now and ends after `limit`; [`Duration::MAX`] is no limit.
    pub fn new(limit: Duration) -> Self {
        Self { start: Instant::now(), limit, traced: (0.0, 0), estimated: (0.0, 0) }
    }

    /// Whether there is a limit at all.
    pub const fn is_limited(&self) -> bool {
        self.limit.as_nanos() < Duration::MAX.as_nanos()
    }

    /// Seconds since the loop began.
    pub fn spent(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Notes that `samples` more were traced since `begun`.
    pub fn note_traced(&mut self, begun: Instant, samples: u64) {
        self.traced = (self.traced.0 + begun.elapsed().as_secs_f64(), self.traced.1 + samples);
    }

    /// Notes that a picture was reconstructed since `begun`.
    pub fn note_estimated(&mut self, begun: Instant) {
        self.estimated = (self.estimated.0 + begun.elapsed().as_secs_f64(), self.estimated.1 + 1);
    }

    /// How many samples can still be traced at the speed so far for the last reconstruction to end in time.
    pub fn samples(&self) -> u64 {
        if self.is_limited() { self.samples_after(self.spent()) } else { u64::MAX }
    }

    /// [`Self::samples`] when so many seconds have gone.
    fn samples_after(&self, spent: f64) -> u64 {
        let last = LAST * self.estimated.0 / f64::from(self.estimated.1.max(1));
        let left = self.limit.as_secs_f64() - spent - last;
        let (seconds, samples) = self.traced;
        match samples {
            _ if left <= 0.0 => 0,
            // Nothing is known of the speed yet.
            0 => u64::MAX,
            _ => (left * samples as f64 / seconds) as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fit_into_the_time_that_the_last_reconstruction_leaves() {
        let mut time = TimeLeft::new(Duration::from_secs(100));
        assert_eq!(time.samples_after(10.0), u64::MAX);
        time.traced = (10.0, 500);
        assert_eq!(time.samples_after(10.0), 4500);
        time.estimated = (30.0, 2);
        assert_eq!(time.samples_after(20.0), 2500);
        assert_eq!([70.0, 90.0].map(|spent| time.samples_after(spent)), [0, 0]);
        assert_eq!(TimeLeft::new(Duration::MAX).samples(), u64::MAX);
    }
}
