//! What is made up where a stack lacks things, on all threads: noise measured on the picture, and the picture, freed of noise
//! by groups of alike patches, as a feature everywhere or on mirrors only.

mod support;

use std::borrow::Cow;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use reconstruct::completion::{CompletionSettings, complete};
use stack::{FeatureRole, FeatureStack, Noise, Silent, Size};
use support::study::Study;

const SIZE: Size = Size::new(128, 128);

/// One picture of which no noise is known, with the features that a renderer writes which stops at mirrors.
fn mean_with_features() -> FeatureStack {
    let mut stack = Study::new(SIZE).stack(8);
    let keep = [FeatureRole::Position, FeatureRole::Albedo, FeatureRole::Normal];
    stack.features.retain(|feature| keep.contains(&feature.role));
    stack.features.iter_mut().for_each(|feature| feature.estimate.noise = Noise::Unknown);
    stack.components.iter_mut().for_each(|component| component.radiance.noise = Noise::Unknown);
    stack
}

fn completion(criterion: &mut Criterion) {
    let features = mean_with_features();
    let mut colour = features.clone();
    colour.features.clear();
    let mut mirrors = features.clone();
    for feature in mirrors.features.iter_mut().filter(|feature| feature.role == FeatureRole::Albedo) {
        for plane in feature.estimate.mean.channels_mut() {
            plane[..SIZE.pixels() / 8].fill(0.0);
        }
    }
    let mut group = support::brief_group(criterion, "completion");
    group.throughput(Throughput::Elements(SIZE.pixels() as u64));
    for (name, stack) in [("features", &features), ("an eighth mirrors", &mirrors), ("colour alone", &colour)] {
        group.bench_function(name, |bencher| {
            bencher.iter(|| complete(Cow::Borrowed(stack), &CompletionSettings::DEFAULT, &Silent))
        });
    }
    group.finish();
}

criterion_group!(benches, completion);
criterion_main!(benches);
