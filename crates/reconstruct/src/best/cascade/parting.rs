//! What independent parts of a picture agree on.

use stack::Image;

use crate::best::settings::CascadeSettings;
use crate::eight::{LANES, Lanes};
use crate::per_pixel::{ByEight, Pixels};

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
    pub fn new(shares: Vec<Vec<f32>>, relative: Vec<f32>, settings: &CascadeSettings) -> Self {
        let significance = if shares.len() > 2 { settings.significance } else { settings.significance_of_two };
        Self { shares, relative, significance }
    }

    /// The share of each part in the mean of every pixel.
    pub fn shares(&self) -> &[Vec<f32>] {
        &self.shares
    }

    /// How often a signal is estimated: with each part left out, or once where there are but two.
    pub fn signals(&self) -> usize {
        if self.shares.len() > 2 { self.shares.len() } else { 1 }
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

/// Residuals on two scales, three planes for each part. What is told of their difference: its mean in three channels, its
/// relative square, and its signals.
pub struct Residuals<'a> {
    pub parting: &'a Parting,
    pub fine: &'a [Vec<f32>],
    pub coarse: &'a [Vec<f32>],
}

impl ByEight<{ 4 + MOST_PARTS }> for Residuals<'_> {
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; 4 + MOST_PARTS] {
        let Self { parting, fine, coarse } = *self;
        let mut numbers = [[0.0; LANES]; 4 + MOST_PARTS];
        let mut shares = [[0.0; LANES]; MOST_PARTS];
        shares.iter_mut().zip(&parting.shares).for_each(|(share, plane)| *share = pixels.of(plane));
        let mut filled = [[0.0; LANES]; MOST_PARTS];
        for (filled, share) in filled.iter_mut().zip(&shares) {
            (0..LANES).for_each(|i| filled[i] = if share[i] > 0.0 { 1.0 } else { 0.0 });
        }
        let (share, filled) = (parting.sums(&shares), parting.sums(&filled));
        for c in 0..3 {
            let (mut firsts, mut seconds) = ([[0.0; LANES]; MOST_PARTS], [[0.0; LANES]; MOST_PARTS]);
            for part in 0..parting.shares.len() {
                let (fine, coarse) = (pixels.of(&fine[3 * part + c]), pixels.of(&coarse[3 * part + c]));
                for i in 0..LANES {
                    let value = fine[i] - coarse[i];
                    firsts[part][i] = shares[part][i] * value;
                    seconds[part][i] = firsts[part][i] * value;
                }
            }
            let mean = sum(&firsts);
            let (first, second) = (parting.sums(&firsts), parting.sums(&seconds));
            numbers[c] = mean;
            (0..LANES).for_each(|i| numbers[3][i] += mean[i] * mean[i]);
            for k in 0..parting.signals() {
                for i in 0..LANES {
                    numbers[4 + k][i] += parting.signal(filled[k][i], share[k][i], first[k][i], second[k][i]);
                }
            }
        }
        let relative = pixels.of(&parting.relative);
        for numbers in &mut numbers[3..] {
            (0..LANES).for_each(|i| numbers[i] *= relative[i]);
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
    (0..brightness.pixels())
        .map(|pixel| {
            let luminance = brightness.mean_at(pixel);
            1.0 / (luminance * luminance + 1e-2)
        })
        .collect()
}
