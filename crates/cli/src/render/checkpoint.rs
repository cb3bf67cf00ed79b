//! `--checkpoint`: samples that are kept while a render goes on, for machines that stop.

use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::Result;
use stack::FeatureStack;

use crate::progress::Progress;

/// A file that keeps the samples there are, from time to time.
pub struct Checkpoint<'a> {
    file: PathBuf,
    every: Duration,
    write: &'a dyn Fn(&FeatureStack) -> Result<()>,
    state: Mutex<State>,
}

struct State {
    last: Instant,
    written: bool,
}

impl<'a> Checkpoint<'a> {
    /// One that `write` writes to `file`, at most once in so long a time.
    pub fn new(file: PathBuf, every: Duration, write: &'a dyn Fn(&FeatureStack) -> Result<()>) -> Self {
        Self { file, every, write, state: Mutex::new(State { last: Instant::now(), written: false }) }
    }

    /// Whether it is time to keep samples again.
    pub fn is_due(&self) -> bool {
        self.state.lock().is_ok_and(|state| state.last.elapsed() >= self.every)
    }

    /// Keeps the samples of `stack`. That it cannot is said; the render goes on, it may have more luck.
    pub fn reach(&self, stack: &FeatureStack, progress: &Progress) {
        let Ok(mut state) = self.state.lock() else { return };
        let (mean, ..) = stack.samples.mean_min_max();
        match (self.write)(stack) {
            Ok(()) => {
                state.written = true;
                progress.whisper(&format!("{mean:.1} spp are kept in {}", self.file.display()));
            }
            Err(error) => progress.say(&format!("--checkpoint: {error:#}; rendering goes on")),
        }
        state.last = Instant::now();
    }

    /// Whether anything was kept.
    pub fn is_written(&self) -> bool {
        self.state.lock().is_ok_and(|state| state.written)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use stack::Size;

    use super::*;
    use crate::args::ReportArgs;

    #[test]
    fn samples_are_kept_when_it_is_time() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.partial.exr");
        let progress = Progress::new(&ReportArgs { quiet: true, ..ReportArgs::default() });
        let stack = tracer::film::Film::new(
            stack::Window::whole(Size::new(2, 2)),
            Size::new(2, 2),
            &tracer::integrator::TraceSettings::DEFAULT,
        )
        .to_stack();
        for (every, expected) in [(Duration::ZERO, 3), (Duration::from_secs(3600), 0)] {
            let count = Cell::new(0);
            let write = |_: &FeatureStack| {
                count.set(count.get() + 1);
                Ok(std::fs::write(&file, "samples")?)
            };
            let checkpoint = Checkpoint::new(file.clone(), every, &write);
            (0..3).filter(|_| checkpoint.is_due()).for_each(|_| checkpoint.reach(&stack, &progress));
            assert_eq!((count.get(), file.exists()), (expected, expected > 0));
            assert_eq!(checkpoint.is_written(), expected > 0);
            let _ = std::fs::remove_file(&file);
        }
        let refuse = |_: &FeatureStack| Err(anyhow::anyhow!("disk full"));
        let failing = Checkpoint::new(file.clone(), Duration::ZERO, &refuse);
        failing.reach(&stack, &progress);
        assert!(!failing.is_written(), "what it has not written is left alone");
    }
}
