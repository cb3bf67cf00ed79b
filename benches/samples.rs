//! Samples a second of the path tracer, features and film included. `Kelem/s` are thousands of samples a second.

mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use stack::Size;
use support::study::Study;

const SIZE: Size = Size::new(96, 72);
const SPP: u32 = 4;

fn samples(criterion: &mut Criterion) {
    let study = Study::new(SIZE);
    let mut group = support::brief_group(criterion, "samples");
    group.throughput(Throughput::Elements(SIZE.pixels() as u64 * u64::from(SPP)));
    group.bench_function("study, all threads", |bencher| bencher.iter(|| study.trace(SPP)));
    group.bench_function("study, one thread", |bencher| {
        let thread = support::one_thread();
        bencher.iter(|| thread.install(|| study.trace(SPP)));
    });
    group.finish();
}

criterion_group!(benches, samples);
criterion_main!(benches);
