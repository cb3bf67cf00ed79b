//! Feeds mutated files to the readers of Tamis.
//!
//! ```sh
//! cargo run --profile fuzz -p fuzz -- TARGET COUNT [SEED]
//! ```
//!
//! or, to read single files again, `-- TARGET FILE...`.
//!
//! Every input must end in a scene, a picture or an error: a panic, more than 10 seconds, or more memory than the input's size
//! explains is a fault, and its input is kept in `fuzz/faults`, as is one that took more than 2 seconds. The same seed makes the
//! same inputs.

mod mutation;
mod target;
mod watchdog;

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use std::{env, fs, io};

use mutation::{Mutator, Random};
use peak_alloc::PeakAlloc;
use target::Target;
use watchdog::Watchdog;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let target = words.first().and_then(|name| Target::named(name));
    let parsed = || {
        let seed = words.get(2).map_or(Some(0), |word| word.parse().ok())?;
        Some((words.get(1)?.parse().ok()?, seed))
    };
    let outcome = match (target, parsed()) {
        (Some(target), Some((count, seed))) => run(target, count, seed),
        (Some(target), None) if words.len() > 1 => replay(target, &words[1..]),
        _ => {
            eprintln!(
                "usage: fuzz TARGET COUNT [SEED], or fuzz TARGET FILE..., TARGET being one of {}",
                Target::names()
            );
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(3)
        }
    }
}

/// Reads `files` and says what becomes of each; a panic ends it.
fn replay(target: Target, files: &[String]) -> io::Result<u64> {
    let folder = target.prepare(Path::new(env!("CARGO_MANIFEST_DIR")))?;
    for file in files {
        fs::copy(file, folder.path().join(target.file()))?;
        let start = Instant::now();
        let said = target.read(folder.path()).err().unwrap_or("read".into());
        println!("{file}: {said} ({:.2} s)", start.elapsed().as_secs_f64());
    }
    Ok(0)
}

/// Tries `count` inputs; how many were faults.
fn run(target: Target, count: u64, seed: u64) -> io::Result<u64> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let seeds = corpus(&home.join("corpus").join(target.name()))?;
    let folder = target.prepare(home)?;
    for bytes in &seeds {
        fs::write(folder.path().join(target.file()), bytes)?;
        target.read(folder.path()).map_err(|why| io::Error::other(format!("the corpus must be readable: {why}")))?;
    }
    let watchdog = Watchdog::start(folder.path().join(target.file()));
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    let (mut faults, mut accepted, mut worst, mut longest) = (0, 0, 0.0_f64, Duration::ZERO);
    for number in 0..count {
        let mut random = Random::new(seed, number);
        let bytes = Mutator::new(&seeds, &mut random).make();
        let path = folder.path().join(target.file());
        fs::write(&path, &bytes)?;
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        watchdog.begin();
        let outcome = catch_unwind(|| target.read(folder.path()));
        let took = watchdog.end();
        longest = longest.max(took);
        if took > watchdog::SLOW {
            let kept = keep(home, target, seed, number, &bytes)?;
            eprintln!("{} {number}: slow, {:.2} s; kept in {}", target.name(), took.as_secs_f64(), kept.display());
        }
        let taken = MEMORY.peak_usage().saturating_sub(before);
        let allowed = target.allowed_bytes(bytes.len());
        worst = worst.max(taken as f64 / allowed as f64);
        let what = match outcome {
            Err(_) => "panic".to_string(),
            Ok(_) if taken > allowed => format!("{taken} bytes of memory for {} of input", bytes.len()),
            Ok(was_read) => {
                accepted += u64::from(was_read.is_ok());
                continue;
            }
        };
        faults += 1;
        let kept = keep(home, target, seed, number, &bytes)?;
        eprintln!("{} {number}: {what}; kept in {}", target.name(), kept.display());
    }
    println!(
        "{}: {count} inputs of seed {seed}, {accepted} read, {} refused, {faults} faults; longest {:.2} s, at most {:.0} % of \
         the memory allowed",
        target.name(),
        count - accepted - faults,
        longest.as_secs_f64(),
        100.0 * worst
    );
    Ok(faults)
}

/// The files of a folder, in the order of their names.
fn corpus(folder: &Path) -> io::Result<Vec<Vec<u8>>> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    paths.sort();
    paths.iter().map(fs::read).collect()
}

fn keep(home: &Path, target: Target, seed: u64, number: u64, bytes: &[u8]) -> io::Result<PathBuf> {
    let folder = home.join("faults");
    fs::create_dir_all(&folder)?;
    let path = folder.join(format!("{}-{seed}-{number}", target.name()));
    fs::write(&path, bytes)?;
    Ok(path)
}
