//! A monitor that notes how a stage's time was spent on its steps.

use std::sync::Mutex;

use stack::Monitor;

/// Seconds of all threads together, per step in the order of their first report.
#[derive(Default)]
pub struct StepTimes(Mutex<Vec<(&'static str, f64)>>);

impl StepTimes {
    /// What was noted.
    pub fn into_seconds(self) -> Vec<(&'static str, f64)> {
        self.0.into_inner().expect("nobody panicked")
    }
}

impl Monitor for StepTimes {
    fn spent(&self, step: &'static str, seconds: f64) {
        let mut steps = self.0.lock().expect("nobody panicked");
        match steps.iter_mut().find(|(name, _)| *name == step) {
            Some((_, sum)) => *sum += seconds,
            None => steps.push((step, seconds)),
        }
    }
}
