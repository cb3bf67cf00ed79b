//! Are buckets independent, and does their spread measure the noise? Asked of 2,000 seeds.

use glam::Vec2;
use stack::{Dealing, Estimate, Image, SampleCounts, Size, place};

use super::{Decision, Sampler, Stream};

const SEEDS: usize = 2000;
const BUCKETS: u32 = 8;
const SPP: u32 = 32;

/// A colour ramp across the pixel: the smoothest integrand there is.
fn gradient(stream: &Stream) -> f32 {
    stream.sample_2d(Decision::FILM).x
}

/// A slanted edge through the pixel.
fn edge(stream: &Stream) -> f32 {
    let at = stream.sample_2d(Decision::FILM);
    if at.dot(Vec2::new(1.0, 0.4)) < 0.6 { 1.0 } else { 0.0 }
}

/// A product of five bounces, each with a cosine and a light that is seen or not.
fn five_bounces(stream: &Stream) -> f32 {
    (0..5)
        .map(|bounce| {
            let direction = stream.sample_2d(Decision::direction(bounce));
            let light = stream.sample_2d(Decision::light_point(bounce));
            let lit = if light.length_squared() < 0.9 { 1.0 } else { 0.4 };
            (1.5 * direction.x.sqrt() + 0.3 * direction.y) * lit
        })
        .product()
}

/// One "pixel" per seed, as the film would hold them.
fn render(integrand: Integrand, sequences: u32) -> (Estimate, SampleCounts) {
    let mut buckets = vec![vec![0.0_f32; SEEDS]; BUCKETS as usize];
    for seed in 0..SEEDS {
        for index in 0..SPP {
            let at = place(index, sequences, BUCKETS);
            let value = integrand(&Sampler::new(seed as u64).stream([3, 5], at));
            buckets[at.bucket as usize][seed] += value / (SPP / BUCKETS) as f32;
        }
    }
    let size = Size::new(SEEDS, 1);
    let buckets = buckets.into_iter().map(|bucket| Image::from_channels(size, vec![bucket])).collect();
    let counts =
        SampleCounts { first: 0, total: vec![SPP; SEEDS], dealing: Dealing::Numbered { sequences, buckets: BUCKETS } };
    (Estimate::from_buckets(buckets, &counts), counts)
}

fn covariance(a: &[f32], b: &[f32]) -> f64 {
    let mean = |x: &[f32]| x.iter().map(|v| f64::from(*v)).sum::<f64>() / x.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - ma) * (f64::from(*b) - mb)).sum::<f64>() / (a.len() - 1) as f64
}

/// Correlation of the halves A and B.
fn correlation(estimate: &Estimate, counts: &SampleCounts) -> f64 {
    let [a, b] = estimate.halves(counts).unwrap();
    let (a, b) = (&a.channels()[0], &b.channels()[0]);
    covariance(a, b) / (covariance(a, a) * covariance(b, b)).sqrt()
}

/// Variance that the buckets claim ÷ variance of the mean over seeds.
fn claimed_variance(estimate: &Estimate, counts: &SampleCounts) -> f64 {
    let variance = estimate.variance_of_mean(counts).unwrap();
    let claimed = variance.channels()[0].iter().map(|v| f64::from(*v)).sum::<f64>() / SEEDS as f64;
    let mean = &estimate.mean.channels()[0];
    claimed / covariance(mean, mean)
}

type Integrand = fn(&Stream) -> f32;

const INTEGRANDS: [(&str, Integrand); 3] = [("gradient", gradient), ("edge", edge), ("five bounces", five_bounces)];

#[test]
fn eight_sequences_make_independent_buckets() {
    for (name, integrand) in INTEGRANDS {
        let (estimate, counts) = render(integrand, 8);
        let (correlation, ratio) = (correlation(&estimate, &counts), claimed_variance(&estimate, &counts));
        eprintln!("K = 8, {name}: corr {correlation:.3}, claimed ÷ true variance {ratio:.3}");
        assert!(correlation.abs() < 0.08, "{name}: {correlation}");
        assert!((0.9..1.1).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn two_sequences_make_independent_halves() {
    for (name, integrand) in INTEGRANDS {
        let (estimate, counts) = render(integrand, 2);
        let correlation = correlation(&estimate, &counts);
        eprintln!("K = 2, {name}: corr {correlation:.3}");
        assert!(correlation.abs() < 0.08, "{name}: {correlation}");
    }
}

/// The reason for all this: one sequence makes halves that avoid one another, and the tests above can see it.
#[test]
fn one_sequence_does_not() {
    let (estimate, counts) = render(gradient, 1);
    assert!(correlation(&estimate, &counts) < -0.5);
    assert!(claimed_variance(&estimate, &counts) > 2.0);
}

#[test]
fn means_are_unbiased() {
    // Per bounce: E[1.5 √x + 0.3 y] · E[lit], the quarter disc of radius √0.9 being lit fully.
    let bounce = 1.15 * (0.4 + 0.6 * std::f64::consts::PI * 0.9 / 4.0);
    for ((name, integrand), exact) in INTEGRANDS.into_iter().zip([0.5, 0.4, bounce.powi(5)]) {
        let (estimate, _) = render(integrand, 8);
        let mean = &estimate.mean.channels()[0];
        let average = mean.iter().map(|v| f64::from(*v)).sum::<f64>() / SEEDS as f64;
        let error = (covariance(mean, mean) / SEEDS as f64).sqrt();
        assert!((average - exact).abs() < 4.0 * error, "{name}: {average} ± {error}");
    }
}
