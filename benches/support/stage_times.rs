//! A monitor that notes how long each stage took.

use std::sync::Mutex;
use std::time::Instant;

use stack::Monitor;

/// When each stage began, in order; the last one ends when it is asked for.
#[derive(Default)]
pub struct StageTimes(Mutex<Vec<(&'static str, Instant)>>);

impl StageTimes {
    /// Marks the end of the last stage.
    pub fn end(&self) {
        self.begin("", 0);
    }

    /// Seconds of all stages called `stage`.
    pub fn of(&self, stage: &str) -> f64 {
        let begun = self.0.lock().expect("nobody panicked");
        let of_pair = |pair: &[(&str, Instant)]| pair[1].1.duration_since(pair[0].1).as_secs_f64();
        begun.windows(2).filter(|pair| pair[0].0 == stage).map(of_pair).sum()
    }
}

impl Monitor for StageTimes {
    fn begin(&self, stage: &'static str, _units: u64) {
        self.0.lock().expect("nobody panicked").push((stage, Instant::now()));
    }
}
