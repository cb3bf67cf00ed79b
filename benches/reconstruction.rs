//! Every step of the reconstruction, and the plainest work there is beside it. All on all threads, except the yardsticks.
//!
//! Criterion says how many pixels a second; a thousand divided by `Melem/s` are ms/Mpix. The steps inside the regression,
//! which no function runs alone, are printed in ms/Mpix of one thread.

mod support;

use std::hint::black_box;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use reconstruct::adaptive::{AdaptiveSettings, ErrorEstimate, sample_map};
use reconstruct::prefilter::{FeatureSet, PrefilterSettings, prefilter};
use reconstruct::regression::{RegressionInput, RegressionSettings, regress};
use reconstruct::spikes::{SpikeFree, SpikeSettings, remove_spikes};
use reconstruct::variance::known_everywhere;
use reconstruct::{Fit, MethodSettings, Settings, reconstruct};
use stack::{ComponentRole, FeatureStack, Image, Silent, Size};
use support::step_times::StepTimes;
use support::study::Study;
use support::yardsticks;

const SIZE: Size = Size::new(128, 128);
/// One sample for each of the eight buckets.
const SPP: u32 = 8;
/// Windows of 11×11 pixels, as between rounds of samples, and of 23×23, as for the final picture.
const RADII: [usize; 2] = [5, 11];

/// The stack and what each stage hands to the next.
struct Stages {
    stack: FeatureStack,
    noisy: Image,
    noise: Image,
    features: FeatureSet,
    cleaned: SpikeFree,
}

impl Stages {
    fn new() -> Self {
        let stack = Study::new(SIZE).stack(SPP);
        let scattered = &stack.component(ComponentRole::Scattered).expect("every film has it").radiance;
        let noisy = scattered.mean.clone();
        let noise = scattered.variance_of_mean(&stack.samples).expect("eight buckets");
        let noise = known_everywhere(noise, &noisy);
        let features = prefilter(&stack, &PrefilterSettings::DEFAULT, &Silent).expect("five features");
        let cleaned = remove_spikes(&noisy, &noise, &SpikeSettings::DEFAULT, &Silent).expect("nobody cancels");
        Self { stack, noisy, noise, features, cleaned }
    }

    fn regression_input(&self) -> RegressionInput<'_> {
        let SpikeFree { colour, variance, .. } = &self.cleaned;
        RegressionInput { colour, variance, features: &self.features, active: None }
    }

    /// Floats per pixel that the regression reads: colour, variance, features.
    fn planes(&self) -> usize {
        6 + self.features.planes.len()
    }
}

fn window_of(radius: usize) -> (String, RegressionSettings) {
    let mut settings = RegressionSettings::default();
    settings.window.radius = radius;
    let side = 2 * radius + 1;
    (format!("regress {side}x{side}"), settings)
}

fn stages(criterion: &mut Criterion) {
    let stages = Stages::new();
    let mut group = support::brief_group(criterion, "reconstruction");
    group.throughput(Throughput::Elements(SIZE.pixels() as u64));
    group.bench_function("spikes", |bencher| {
        bencher.iter(|| remove_spikes(&stages.noisy, &stages.noise, &SpikeSettings::DEFAULT, &Silent));
    });
    group.bench_function("prefilter", |bencher| {
        bencher.iter(|| prefilter(&stages.stack, &PrefilterSettings::DEFAULT, &Silent));
    });
    for (name, settings) in RADII.map(window_of) {
        group.bench_function(name, |bencher| {
            bencher.iter(|| regress(&stages.regression_input(), &settings, &Silent));
        });
    }
    for (name, fit) in [("best", Fit::Collaborative), ("paper", Fit::Local)] {
        group.bench_function(name, |bencher| bencher.iter(|| reconstruct(&stages.stack, &whole(fit), &Silent)));
    }
    distribution(&mut group, &stages.stack);
    group.finish();
    print_steps(&stages);
    yardsticks(criterion, stages.planes());
}

fn whole(fit: Fit) -> Settings {
    Settings { method: MethodSettings { fit, ..MethodSettings::DEFAULT }, ..Settings::default() }
}

/// Where the next samples go.
fn distribution(group: &mut BenchmarkGroup<'_, WallTime>, stack: &FeatureStack) {
    let result = reconstruct(stack, &Settings::default(), &Silent).expect("a stack of our own");
    let estimate = ErrorEstimate {
        mse: &result.mse,
        picture: &result.picture,
        rank: result.rank.as_deref(),
        counts: &stack.samples,
    };
    let budget = 8 * SIZE.pixels() as u64;
    group.bench_function("sample map", |bencher| {
        bencher.iter(|| sample_map(&estimate, budget, &AdaptiveSettings::DEFAULT));
    });
}

/// Prints how the regression's time is spent: the least of three runs, on one thread.
fn print_steps(stages: &Stages) {
    let thread = support::one_thread();
    for (name, settings) in RADII.map(window_of) {
        let run = || {
            let times = StepTimes::default();
            let regressed = thread.install(|| regress(&stages.regression_input(), &settings, &times));
            regressed.expect("nobody cancels");
            times.into_seconds()
        };
        let runs = [run(), run(), run()];
        for (i, (step, _)) in runs[0].iter().enumerate() {
            let least = runs.iter().map(|run| run[i].1).fold(f64::INFINITY, f64::min);
            println!("{name}, step {step}: {:.0} ms/Mpix", 1e9 * least / SIZE.pixels() as f64);
        }
    }
    println!();
}

/// What one thread can do at all: a copy of all the regression reads, from memory to memory, and
/// multiply-adds on what the innermost cache holds.
fn yardsticks(criterion: &mut Criterion, planes: usize) {
    let mut group = support::brief_group(criterion, "yardsticks");
    let pixels = 1 << 20;
    let from = vec![1.0_f32; planes * pixels];
    let mut to = vec![0.0_f32; planes * pixels];
    group.throughput(Throughput::Elements(pixels as u64));
    group.bench_function("copy of all planes, per pixel", |bencher| {
        bencher.iter(|| black_box(&mut to).copy_from_slice(black_box(&from)));
    });
    let [a, b] = yardsticks::factors();
    group.throughput(Throughput::Elements((yardsticks::PASSES * yardsticks::NUMBERS) as u64));
    group.bench_function("dot product, per multiply-add", |bencher| {
        bencher.iter(|| yardsticks::dot(black_box(&a), black_box(&b)));
    });
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
