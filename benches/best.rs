//! Every step of the preset `best`, on one thread, and how far each is from what this machine could do at most: from
//! copying the numbers it reads and writes, and from the multiply-adds that its formulas cannot do without.
//!
//! No step can be run without those before it, so each is timed within a whole reconstruction.

mod support;

use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use reconstruct::best::BestSettings;
use reconstruct::{Settings, reconstruct};
use stack::{FeatureStack, Size};
use support::stage_times::StageTimes;
use support::study::Study;
use support::yardsticks;

const SIZE: Size = Size::new(128, 128);
const BUCKETS: usize = 8;
/// One sample for each bucket.
const SPP: u32 = BUCKETS as u32;
/// How often everything is run for the table; the least counts.
const RUNS: usize = 3;

/// Channels of albedo, normal, position, visibility.
const GROUPS: [usize; 4] = [3, 3, 3, 1];
/// Channels of all these, and with what paths meet next.
const SEEN: usize = 10;
const FEATURES: usize = SEEN + 2;
/// What tells surfaces apart: all but visibility.
const SURFACES: usize = FEATURES - 1;
/// Multiply-adds of an exponential.
const EXPONENTIAL: usize = 9;

/// What a step cannot do without, for each pixel.
struct Work {
    stage: &'static str,
    /// Numbers that it reads and writes: stacks, features, pictures; nothing that it keeps in between.
    numbers: usize,
    multiply_adds: Option<usize>,
}

/// Of all steps, in their order. Events are as many as there happen to be: spreading them has no least work.
fn works(settings: &BestSettings) -> [Work; 7] {
    let [candidates, kernels] = [6, 4];
    let fit = &settings.regression;
    let first = collaborative([fit.first_radius, 2], fit.stride, [2, 1], [FEATURES, 3]);
    let tiny = fit.second_radius.min((4.3 * fit.tiny_sigma).ceil() as usize);
    let second = collaborative([fit.second_radius, 1], fit.stride, [1, kernels], [FEATURES, 6])
        + collaborative([tiny, 1], fit.stride, [1, 1], [FEATURES, 6]);
    let work = |stage, numbers, multiply_adds| Work { stage, numbers, multiply_adds };
    let (halves, halves_and_mean) = (6, 3);
    [
        work("prefilter", FEATURES * (halves_and_mean + 1), Some(prefilter(settings))),
        work("spikes", 3 * BUCKETS + 17, None),
        work("first pass", FEATURES + halves + 3 + 1 + halves, Some(first)),
        work("spread", 8 + SURFACES + 3 + 7, None),
        work("cascade", 3 * (BUCKETS + 2) + SURFACES + 6, Some(cascade(settings))),
        work("second pass", FEATURES + halves + 3 + 2 + 3 + 6 * (candidates - 1), Some(second)),
        work("choice", 6 * candidates + halves + 3 + SURFACES + 6, Some(choice(candidates))),
    ]
}

/// Non-local means: distances of all channels, their sums over patches, an exponential, and the weighted sums; and the fits
/// of what paths meet next, at every sixth pixel in windows of 19×19.
fn prefilter(settings: &BestSettings) -> usize {
    let [window, patch] = [settings.features.radius, settings.features.patch_radius].map(|radius| 2 * radius + 1);
    let of_group = |channels: usize| 4 * channels + 2 * patch + EXPONENTIAL + 1 + channels;
    window * window * GROUPS.map(of_group).iter().sum::<usize>()
        + collaborative([9, 2], 6, [2, 1], [SEEN, FEATURES - SEEN])
}

/// Fits on the lattice alone: for each of the `guides`, distances to the window's pixels over patches of some `patch`
/// radius, and for each of the `kernels` weights, moments and predictions of a fit of some `responses` on some `features`.
fn collaborative(
    [radius, patch]: [usize; 2],
    stride: usize,
    [guides, kernels]: [usize; 2],
    [features, responses]: [usize; 2],
) -> usize {
    let [window, patch] = [radius, patch].map(|radius| (2 * radius + 1).pow(2));
    let moments = features + (features + responses) + features * (features + 1) / 2 + features * responses;
    let fit = window * (EXPONENTIAL + moments + responses * (features + 1));
    guides * (kernels * fit + window * patch * 9) / (stride * stride)
}

/// A kernel of 25 taps, half of which are weighed, applied to some `planes`.
fn guided(guides: usize, planes: usize) -> usize {
    12 * (guides + EXPONENTIAL) + 25 * planes
}

/// Of spread events in two halves, and of the residual in eight parts: their luminances and the mean of colours are
/// smoothed, each detail's squares three times; of clouds in two halves, but for the squares of trusted levels. The last
/// is followed, in the same stage, by energy given back, with taps that are weighed already, and the error's two smoothings.
fn cascade(settings: &BestSettings) -> usize {
    let of_parts = |guides: usize, parts: usize, signals: usize| guided(guides, parts + 3 + 3 * (1 + signals));
    let (guides, parts, clouds) = (SURFACES + 3, settings.cascade.parts, &settings.clouds);
    let weighed = clouds.levels.min(settings.restore.levels);
    settings.spread.levels * of_parts(guides, 2, 1)
        + settings.cascade.levels * of_parts(SURFACES, parts, parts)
        + clouds.levels * guided(guides, 2 + 3)
        + clouds.levels.saturating_sub(clouds.trusted) * 3 * 2 * 25
        + settings.restore.levels * 9 * 25
        + (settings.restore.levels - weighed) * guided(guides, 0)
        + 2 * guided(guides, 1)
}

/// Evidence on three scales, and the network.
fn choice(candidates: usize) -> usize {
    let (guides, hidden, own, shared) = (SURFACES + 3, 24, 12, 7);
    let network = hidden * (shared + candidates * (own + 1));
    3 * guided(guides, 1 + 3 * candidates) + network
}

/// Seconds that each stage of a whole reconstruction took, all light at once.
fn times(stack: &FeatureStack) -> StageTimes {
    let (times, mut settings) = (StageTimes::default(), Settings::default());
    settings.best.light.apart = false;
    reconstruct(stack, &settings, &times).expect("a stack of our own");
    times.end();
    times
}

fn steps(criterion: &mut Criterion) {
    let stack = Study::new(SIZE).stack(SPP);
    let thread = support::one_thread();
    let works = works(&Settings::default().best);
    let mut group = support::brief_group(criterion, "best, one thread");
    group.throughput(Throughput::Elements(SIZE.pixels() as u64));
    for Work { stage, .. } in &works {
        let run = || thread.install(|| times(&stack)).of(stage);
        group.bench_function(*stage, |bencher| {
            bencher.iter_custom(|runs| (0..runs).map(|_| Duration::from_secs_f64(run())).sum());
        });
    }
    group.finish();
    print_limits(&works, (0..RUNS).map(|_| thread.install(|| times(&stack))).collect());
}

/// Prints how many times as long each step took as its copies and its multiply-adds alone.
fn print_limits(works: &[Work], runs: Vec<StageTimes>) {
    let [copy, multiply_add] = [yardsticks::copied_number(), yardsticks::multiply_add()];
    println!("a copied number {:.2} ns, a multiply-add {:.3} ns", 1e9 * copy, 1e9 * multiply_add);
    println!("| step | ms/Mpix | numbers | ÷ copy | multiply-adds | ÷ multiply-adds |\n|---|---|---|---|---|---|");
    for Work { stage, numbers, multiply_adds } in works {
        let seconds = runs.iter().map(|run| run.of(stage)).fold(f64::INFINITY, f64::min) / SIZE.pixels() as f64;
        let of_copies = seconds / (*numbers as f64 * copy);
        let of_products =
            |count: &usize| (count.to_string(), format!("{:.1}", seconds / (*count as f64 * multiply_add)));
        let (count, times) = multiply_adds.as_ref().map_or(("-".into(), "-".into()), of_products);
        println!("| {stage} | {:.0} | {numbers} | {of_copies:.0} | {count} | {times} |", 1e9 * seconds);
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
