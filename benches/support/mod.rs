//! What the benches share.
#![allow(dead_code, reason = "each bench file uses its own part of this")]

pub mod random;
pub mod stage_times;
pub mod step_times;
pub mod study;
pub mod yardsticks;

use std::path::{Path, PathBuf};
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The file `name` of this repository.
pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// A group of benches that is content with ten measurements in a second: differences of a few per cent drown in the
/// noise of a desktop machine anyway.
pub fn brief_group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
    group
}

/// A pool of one thread, for work that would spread over all.
pub fn one_thread() -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(1).build().expect("a thread")
}
