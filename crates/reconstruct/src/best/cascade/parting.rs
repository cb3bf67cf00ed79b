//! What independent parts of a picture agree on.

use stack::Image;

use crate::eight::{LANES, Lanes};
use crate::per_pixel::{ByEight, Pixels, plane};

/// Most parts that a picture comes in.
pub const MOST_PARTS: usize = 8;

/// A number of each of eight pixels and of every part.
type OfParts = [Lanes; MOST_PARTS];

/// How details are judged.
pub struct Parting {
    /// The share of each part in the mean of every pixel.
    shares: Vec<Vec<f32>>,
    /// What squares are multiplied by.
    relative: Vec<f32>,
    significance: f32,
}

impl Parting {
    /// Parts with these `shares`; squares are multiplied by `relative`.
    pub fn new(shares: Vec<Vec<f32>>, relative: Vec<f32>, significance: f32) -> Self {
        Self { shares, relative, significance }
    }

    /// How many parts there are.
    pub fn parts(&self) -> usize {
        self.shares.len()
    }

    /// How often a signal is estimated: with each part left out, or once where there are but two.
    pub fn signals(&self) -> usize {
        if self.parts() > 2 { self.parts() } else { 1 }
    }

    /// m² − c v of the mean m of so many `filled` parts, whose variance is v and c the significance; 0 where one part
    /// says nothing of it.
    #[inline(always)]
    fn signal(&self, filled: f32, share: f32, first: f32, second: f32) -> f32 {
        let mean = first / share;
        let variance = (second / share - mean * mean).max(0.0) / (filled - 1.0);
        let signal = mean * mean - self.significance * variance;
        if filled >= 2.0 { signal } else { 0.0 }
    }

    /// Sums for each signal.
    #[inline(always)]
    fn sums(&self, parts: &OfParts) -> OfParts {
        if self.signals() == 1 { [sum(parts); MOST_PARTS] } else { sums_of_others(parts) }
    }
}

/// Residuals on two scales: the luminance of each part, then the mean of parts in three channels. What is told of their
/// difference: its mean in three channels, and of its luminance the relative square and signals.
pub struct Residuals<'a> {
    pub parting: &'a Parting,
    pub fine: &'a [Vec<f32>],
    pub coarse: &'a [Vec<f32>],
}

impl Residuals<'_> {
    /// What plane `number` has on this scale.
    #[inline(always)]
    fn detail(&self, number: usize, pixels: Pixels) -> Lanes {
        let (fine, coarse) = (pixels.of(&self.fine[number]), pixels.of(&self.coarse[number]));
        let mut detail = [0.0; LANES];
        (0..LANES).for_each(|i| detail[i] = fine[i] - coarse[i]);
        detail
    }
}

/// As many numbers as there are signals, and four.
impl<const N: usize> ByEight<N> for Residuals<'_> {
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; N] {
        let parting = self.parting;
        let mut numbers = [[0.0; LANES]; N];
        let none = [[0.0; LANES]; MOST_PARTS];
        let (mut shares, mut filled, mut firsts, mut seconds) = (none, none, none, none);
        for part in 0..parting.parts() {
            let share = pixels.of(&parting.shares[part]);
            let detail = self.detail(part, pixels);
            shares[part] = share;
            for i in 0..LANES {
                filled[part][i] = if share[i] > 0.0 { 1.0 } else { 0.0 };
                firsts[part][i] = share[i] * detail[i];
                seconds[part][i] = firsts[part][i] * detail[i];
            }
        }
        for c in 0..3 {
            numbers[c] = self.detail(parting.parts() + c, pixels);
        }
        let (relative, mean) = (pixels.of(&parting.relative), sum(&firsts));
        (0..LANES).for_each(|i| numbers[3][i] = relative[i] * mean[i] * mean[i]);
        let [share, filled, first, second] = [&shares, &filled, &firsts, &seconds].map(|of| parting.sums(of));
        for k in 0..parting.signals() {
            for i in 0..LANES {
                let signal = parting.signal(filled[k][i], share[k][i], first[k][i], second[k][i]);
                numbers[4 + k][i] = relative[i] * signal;
            }
        }
        numbers
    }
}

#[inline(always)]
fn sum(parts: &OfParts) -> Lanes {
    let mut sum = [0.0; LANES];
    for part in parts {
        (0..LANES).for_each(|i| sum[i] += part[i]);
    }
    sum
}

/// For each part the sum of all others: of those before it and those behind. Taking a firefly off the sum of all would
/// leave its rounding.
#[inline(always)]
fn sums_of_others(parts: &OfParts) -> OfParts {
    let mut others = [[0.0; LANES]; MOST_PARTS];
    let (mut before, mut behind) = ([0.0; LANES], [0.0; LANES]);
    for k in 0..MOST_PARTS {
        let back = MOST_PARTS - 1 - k;
        for i in 0..LANES {
            others[k][i] += before[i];
            before[i] += parts[k][i];
            others[back][i] += behind[i];
            behind[i] += parts[back][i];
        }
    }
    others
}

/// One over the squared luminance of a picture.
pub fn relative_to(brightness: &Image) -> Vec<f32> {
    plane(brightness.pixels(), |pixel| {
        let luminance = brightness.mean_at(pixel);
        1.0 / (luminance * luminance + 1e-2)
    })
}
