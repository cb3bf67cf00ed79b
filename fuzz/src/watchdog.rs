//! Ends the process when an input takes too long.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// What takes longer is kept, to be looked at.
pub const SLOW: Duration = Duration::from_secs(2);

/// Longest that an input may take.
const LONGEST: Duration = Duration::from_secs(10);

/// How often the clock is looked at.
const STEP: Duration = Duration::from_millis(200);

/// Looks at the clock from a thread of its own.
pub struct Watchdog {
    start: Instant,
}

/// Milliseconds since the start at which the current input began, plus one; 0 between inputs.
static BEGAN: AtomicU64 = AtomicU64::new(0);

impl Watchdog {
    /// Starts; `input` is where the current input can be found.
    pub fn start(input: PathBuf) -> Self {
        let start = Instant::now();
        // It counts its own steps: while the whole process is paused, no input takes time.
        thread::spawn(move || {
            let (mut watched, mut steps) = (0, 0);
            loop {
                thread::sleep(STEP);
                let began = BEGAN.load(Ordering::Relaxed);
                steps = if began == watched { steps + 1 } else { 0 };
                watched = began;
                if began > 0 && steps * STEP > LONGEST {
                    eprintln!("an input takes longer than {} s; it is in {}", LONGEST.as_secs(), input.display());
                    std::process::abort();
                }
            }
        });
        Self { start }
    }

    fn now(&self) -> u64 {
        self.start.elapsed().as_millis() as u64 + 1
    }

    /// An input begins.
    pub fn begin(&self) {
        BEGAN.store(self.now(), Ordering::Relaxed);
    }

    /// It has ended, after what is returned.
    pub fn end(&self) -> Duration {
        Duration::from_millis(self.now().saturating_sub(BEGAN.swap(0, Ordering::Relaxed)))
    }
}
