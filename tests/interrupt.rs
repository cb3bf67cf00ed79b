//! Ctrl-C keeps what there is, and never replaces a finished picture.
#![cfg(unix)]

mod support;

use std::process::Command;
use std::time::{Duration, Instant};

use support::Workplace;

#[test]
fn an_interrupted_render_keeps_its_samples_apart() {
    let workplace = Workplace::new();
    workplace.must("render box.obj --size 32x32 --spp 2 -o a.exr --quiet");
    let finished = workplace.bytes("a.exr");
    // How soon there are samples to keep depends on what else the machine does.
    let kept = [1, 4, 16, 64].into_iter().any(|seconds| {
        interrupt_after(&workplace, Duration::from_secs(seconds));
        assert_eq!(workplace.bytes("a.exr"), finished);
        workplace.files().contains(&"a.partial.exr".into())
    });
    assert!(kept, "nothing was kept after a minute");
    workplace.must("denoise a.partial.exr -o b.exr --quiet");
    let run = workplace.must("render box.obj --size 200x200 --spp 1 --method ld -o a.exr --resume");
    assert!(run.stderr().contains("from a.partial.exr"), "it holds more than a.exr: {}", run.stderr());
    assert!(workplace.bytes("a.exr") != finished && !workplace.files().contains(&"a.partial.exr".into()));
}

fn interrupt_after(workplace: &Workplace, wait: Duration) {
    let mut child = workplace.command("render box.obj --size 200x200 --spp 50000 -o a.exr --quiet").spawn().unwrap();
    std::thread::sleep(wait);
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let asked = Instant::now();
    let status = child.wait().unwrap();
    assert!(asked.elapsed() < Duration::from_secs(60), "it took {:?} to stop", asked.elapsed());
    assert_eq!(status.code(), Some(130));
}
