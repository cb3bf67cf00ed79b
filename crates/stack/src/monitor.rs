//! How long-running work reports progress and learns that it should stop.

/// Listens to a stage of work. Libraries report through it; only the command line draws bars and measures time.
pub trait Monitor: Sync {
    /// A stage begins (and the one before it has ended); it will report `units` units of work.
    fn begin(&self, stage: &'static str, units: u64) {
        let _ = (stage, units);
    }

    /// `units` more units of the current stage are done.
    fn advance(&self, units: u64) {
        let _ = units;
    }

    /// Of the current stage, `seconds` of all threads together went to `step`.
    fn spent(&self, step: &'static str, seconds: f64) {
        let _ = (step, seconds);
    }

    /// Something worth telling the user, in one line.
    fn note(&self, line: &str) {
        let _ = line;
    }

    /// Whether to stop as soon as possible. Once true, it stays true.
    fn cancelled(&self) -> bool {
        false
    }
}

/// A monitor that neither listens nor cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Monitor for Silent {}

/// The work was stopped by its [`Monitor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Cancelled;
