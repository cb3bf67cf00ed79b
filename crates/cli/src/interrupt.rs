//! Ctrl-C: the first asks the work to stop, the second ends the process at once.

use std::sync::atomic::{AtomicBool, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);

/// Starts to listen.
pub fn listen() {
    // A handler may already be there (a second command in one process): then it sets the same flag.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            stack::file::exit_without_litter(130);
        }
    });
}

/// Whether to stop.
pub fn requested() -> bool {
    STOP.load(Ordering::Relaxed)
}
