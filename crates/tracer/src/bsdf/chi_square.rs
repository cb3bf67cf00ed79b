//! Pearson's χ² test of a sampler of directions against its density.

use std::f64::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// Bins over cos θ and φ of the whole sphere.
const ROWS: usize = 32;
const COLUMNS: usize = 32;
/// Quadrature points per side of a bin.
const FINE: usize = 24;
const SAMPLES: usize = 100_000;

/// Random numbers without structure (SplitMix64): points that avoid one another would pass too easily.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let n = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let n = (n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((n ^ (n >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn point(&mut self) -> Vec2 {
        Vec2::new(self.next(), self.next())
    }
}

/// Integrals of `pdf` over the bins.
fn expected(pdf: &impl Fn(Vec3) -> f32) -> Vec<f64> {
    let mut bins = vec![0.0; ROWS * COLUMNS];
    let (rows, columns) = (ROWS * FINE, COLUMNS * FINE);
    let cell = 2.0 * TAU / (rows * columns) as f64;
    for row in 0..rows {
        for column in 0..columns {
            let z = -1.0 + 2.0 * (row as f64 + 0.5) / rows as f64;
            let phi = TAU * (column as f64 + 0.5) / columns as f64;
            let radius = (1.0 - z * z).sqrt();
            let direction = Vec3::new((radius * phi.cos()) as f32, (radius * phi.sin()) as f32, z as f32);
            bins[row / FINE * COLUMNS + column / FINE] += f64::from(pdf(direction)) * cell;
        }
    }
    bins
}

fn bin_of(direction: Vec3) -> usize {
    let row = ((f64::from(direction.z) + 1.0) / 2.0 * ROWS as f64) as usize;
    let phi = f64::from(direction.y).atan2(f64::from(direction.x)).rem_euclid(TAU);
    row.min(ROWS - 1) * COLUMNS + ((phi / TAU * COLUMNS as f64) as usize).min(COLUMNS - 1)
}

/// Integral of `pdf` over the sphere.
pub(crate) fn integral(pdf: impl Fn(Vec3) -> f32) -> f64 {
    expected(&pdf).iter().sum()
}

/// Probability that a right sampler deviates from `pdf` as much as `sample` does. What `pdf` leaves to one is what
/// `sample` refuses (`None`).
pub(crate) fn p_value(pdf: impl Fn(Vec3) -> f32, mut sample: impl FnMut(&mut Random) -> Option<Vec3>) -> f64 {
    let mut expected = expected(&pdf);
    expected.push((1.0 - expected.iter().sum::<f64>()).max(0.0));
    let mut found = vec![0.0; expected.len()];
    let mut random = Random(17);
    for _ in 0..SAMPLES {
        found[sample(&mut random).map_or(ROWS * COLUMNS, bin_of)] += 1.0;
    }
    let (statistic, degrees) = pooled(&found, &expected);
    upper_gamma(0.5 * degrees, 0.5 * statistic)
}

/// χ² and its degrees of freedom; bins with fewer than 5 expected samples are pooled.
fn pooled(found: &[f64], expected: &[f64]) -> (f64, f64) {
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|a, b| expected[*a].total_cmp(&expected[*b]));
    let (mut statistic, mut bins) = (0.0, 0.0);
    let (mut pool_found, mut pool_expected) = (0.0, 0.0);
    for i in order {
        pool_found += found[i];
        pool_expected += expected[i] * SAMPLES as f64;
        if pool_expected >= 5.0 {
            statistic += (pool_found - pool_expected).powi(2) / pool_expected;
            bins += 1.0;
            (pool_found, pool_expected) = (0.0, 0.0);
        }
    }
    (statistic, bins - 1.0)
}

/// Regularised upper incomplete gamma function Q(a, x) (Press et al., *Numerical Recipes*, section 6.2).
fn upper_gamma(a: f64, x: f64) -> f64 {
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..2_000 {
            term *= x / (a + f64::from(n));
            sum += term;
        }
        return 1.0 - front * sum;
    }
    // Lentz's continued fraction.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for n in 1..10_000 {
        let an = -f64::from(n) * (f64::from(n) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
    }
    front * h
}

/// ln Γ(x) by Stirling's series, x moved above 10.
fn ln_gamma(x: f64) -> f64 {
    if x < 10.0 {
        return ln_gamma(x + 1.0) - x.ln();
    }
    let series = 1.0 / (12.0 * x) - 1.0 / (360.0 * x.powi(3)) + 1.0 / (1260.0 * x.powi(5));
    (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + series
}

#[test]
fn the_gamma_function_has_its_known_values() {
    assert!((ln_gamma(0.5) - 0.5 * PI.ln()).abs() < 1e-9);
    let q = upper_gamma(1.0, 2.0);
    assert!((q - (-2.0_f64).exp()).abs() < 1e-9, "{q}");
    // χ² with 10 degrees of freedom exceeds 18.307 once in twenty times.
    assert!((upper_gamma(5.0, 18.307 / 2.0) - 0.05).abs() < 1e-5);
    assert!((upper_gamma(500.0, 500.0) - 0.494).abs() < 1e-3);
}

#[test]
fn the_test_can_fail() {
    let uniform = |_: Vec3| 0.25 * std::f32::consts::FRAC_1_PI;
    let right = p_value(uniform, |r| Some(crate::sampler::warp::sample_sphere(r.point())));
    assert!(right > 0.01, "{right}");
    let squeezed = |r: &mut Random| {
        let u = r.point();
        Some(crate::sampler::warp::sample_sphere(Vec2::new(u.x.powf(1.05), u.y)))
    };
    assert!(p_value(uniform, squeezed) < 1e-6);
}
