//! What the halves say about each candidate's error, smoothed on several scales.

use rayon::prelude::*;
use stack::Image;

use super::Contest;
use crate::best::edge_avoiding::EdgeAvoidingKernel;
use crate::best::settings::ChoiceSettings;
use crate::eight::{LANES, Lanes};
use crate::ln::ln;
use crate::per_pixel::{ByEight, Pixels, planes_by_eight};

/// Candidates there are to choose from, and that the network knows.
pub const CANDIDATES: usize = 6;
/// Candidates there are where only a few are made.
pub const FEW: usize = 4;
/// Candidates in the middle, of medium bandwidth with a large and a small window: what all are compared with.
const MIDDLE: [usize; 2] = [2, 4];

/// Dilations of the kernel, one after the other; each makes a level.
const DILATIONS: [usize; LEVELS] = [1, 2, 4];
/// Levels there are.
pub const LEVELS: usize = 3;

/// One dilation more, for noisy surroundings.
const WIDEST: usize = 8;

/// How far from a pixel what the rule looks at reaches: twice the dilations, one after the other.
pub const REACH_OF_RULE: usize = 2 * (DILATIONS[0] + DILATIONS[1]);

/// And all that.
pub const REACH: usize = REACH_OF_RULE + 2 * (DILATIONS[2] + WIDEST);

/// From the first of these V on, evidence is taken from farther around, from the second on that alone.
const NOISY: [f32; 2] = [0.3, 1.0];

/// The level that the rule looks at.
const LEVEL_OF_RULE: usize = 1;

/// How much evidence is gathered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scales {
    /// Errors and noise, on the rule's scale.
    OfTheRule,
    /// Everything, on every scale; of all candidates.
    All,
}

/// Evidence on every scale.
pub struct Evidence {
    levels: Vec<Level>,
}

/// Evidence on one scale. All of it is squared and relative: what (luminance² + 0.01) and the noise leave of it, see
/// `Raw::precisions`.
pub struct Level {
    candidates: usize,
    planes: Vec<Vec<f32>>,
}

impl Level {
    /// V: what noise adds to an error, six values (two halves, three channels) of the variance of a half.
    pub fn noise(&self) -> &[f32] {
        &self.planes[0]
    }

    /// E: error of a candidate's halves as predictions of the other noisy half.
    pub fn error(&self, candidate: usize) -> &[f32] {
        &self.planes[1 + candidate]
    }

    /// E of all candidates.
    pub fn errors(&self) -> &[Vec<f32>] {
        &self.planes[1..=self.candidates]
    }

    /// D: (A − B)² of a candidate's halves.
    pub fn spread(&self, candidate: usize) -> &[f32] {
        &self.planes[1 + CANDIDATES + candidate]
    }

    /// R: twice the squared distance of a candidate from the mean of two in the middle.
    pub fn distance(&self, candidate: usize) -> &[f32] {
        &self.planes[1 + 2 * CANDIDATES + candidate]
    }
}

impl Evidence {
    /// That of `contest`, on these scales.
    pub fn new(contest: &Contest, settings: &ChoiceSettings, scales: Scales) -> Self {
        let raw = Raw { contest, precision: settings.precision };
        let pixels = contest.pilot.pixels();
        let candidates = contest.candidates.len();
        let mut planes = match scales {
            Scales::OfTheRule if candidates == FEW => Vec::from(planes_by_eight::<{ 1 + FEW }>(pixels, &raw)),
            Scales::OfTheRule => Vec::from(planes_by_eight::<{ 1 + CANDIDATES }>(pixels, &raw)),
            Scales::All => Vec::from(planes_by_eight::<ALL>(pixels, &raw)),
        };
        let dilations = match scales {
            Scales::OfTheRule => &DILATIONS[..=LEVEL_OF_RULE],
            Scales::All => &DILATIONS[..],
        };
        let kernel = contest.kernel(settings);
        let mut levels: Vec<Level> = Vec::with_capacity(dilations.len());
        for dilation in dilations {
            let finer = levels.last().map_or(&planes, |level| &level.planes);
            levels.push(Level { candidates, planes: kernel.smooth(finer, *dilation) });
            planes = Vec::new();
        }
        if matches!(scales, Scales::All) {
            look_farther_in_noise(&mut levels, &kernel);
        }
        Self { levels }
    }

    /// The level of the rule.
    pub fn level_of_rule(&self) -> &Level {
        &self.levels[LEVEL_OF_RULE]
    }

    /// All levels, the finest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }
}

/// Planes of all evidence: V, and E, D and R of every candidate; for the rule, V and E.
const ALL: usize = 1 + 3 * CANDIDATES;

/// Evidence that is not smoothed yet.
struct Raw<'a> {
    contest: &'a Contest<'a>,
    /// Weight of noise against error.
    precision: f32,
}

impl Raw<'_> {
    /// What a squared error counts: n/(1 + 3 n v), n = 1/(luminance² + 0.01) with the mean luminance of all candidates,
    /// v the variance of a half.
    #[inline(always)]
    fn precisions(&self, variance: &Lanes, pixels: Pixels) -> Lanes {
        let images = self.contest.candidates.iter().flatten();
        let (mut sum, mut count) = ([0.0; LANES], 0.0);
        for plane in images.flat_map(Image::channels) {
            let values = pixels.of(plane);
            (0..LANES).for_each(|i| sum[i] += values[i]);
            count += 1.0;
        }
        let mut precisions = [0.0; LANES];
        for i in 0..LANES {
            let luminance = sum[i] / count;
            let relative = 1.0 / (luminance * luminance + 1e-2);
            precisions[i] = relative / (1.0 + self.precision * relative * variance[i]);
        }
        precisions
    }

    /// V, E and, where there is room, D and R, before they are weighed.
    #[inline(always)]
    fn unweighed<const N: usize>(&self, variance: &Lanes, pixels: Pixels) -> [Lanes; N] {
        let Contest { candidates, low, .. } = self.contest;
        let mut numbers = [[0.0; LANES]; N];
        numbers[0] = variance.map(|v| 6.0 * v);
        for c in 0..3 {
            let [noisy_a, noisy_b] = channel(&low.halves, c, pixels);
            let v = pixels.of(&low.variance.channels()[c]);
            let mut centre = [0.0; LANES];
            if N == ALL {
                for k in MIDDLE {
                    let [a, b] = channel(&candidates[k], c, pixels);
                    (0..LANES).for_each(|i| centre[i] += 0.25 * (a[i] + b[i]));
                }
            }
            for (k, candidate) in candidates.iter().enumerate() {
                let [a, b] = channel(candidate, c, pixels);
                for i in 0..LANES {
                    let (of_a, of_b) = (a[i] - noisy_b[i], b[i] - noisy_a[i]);
                    numbers[1 + k][i] += of_a * of_a + of_b * of_b - 2.0 * v[i];
                }
                if N == ALL {
                    for i in 0..LANES {
                        let spread = a[i] - b[i];
                        numbers[1 + CANDIDATES + k][i] += spread * spread;
                        let distance = 0.5 * (a[i] + b[i]) - centre[i];
                        numbers[1 + 2 * CANDIDATES + k][i] += 2.0 * (distance * distance);
                    }
                }
            }
        }
        numbers
    }
}

/// Where noise is high, what few pixels say is chance, and the candidate that shows it wins: on a smooth surface that rare
/// light falls on, blotches. There all levels give way to one more that looks farther.
fn look_farther_in_noise(levels: &mut [Level], kernel: &EdgeAvoidingKernel) {
    let Some(coarsest) = levels.last() else { return };
    // A mean is not above all of what it is the mean of.
    if coarsest.noise().iter().all(|noise| *noise <= NOISY[0]) {
        return;
    }
    let widest = Level { candidates: coarsest.candidates, planes: kernel.smooth(&coarsest.planes, WIDEST) };
    let steps = ln(NOISY[1] / NOISY[0]);
    let share = |noise: &f32| (ln(noise.max(NOISY[0]) / NOISY[0]) / steps).min(1.0);
    let shares: Vec<f32> = widest.noise().par_iter().map(share).collect();
    for level in levels {
        level.planes.par_iter_mut().zip(&widest.planes).for_each(|(plane, widest)| {
            for ((value, wide), share) in plane.iter_mut().zip(widest).zip(&shares) {
                *value += share * (wide - *value);
            }
        });
    }
}

/// Channel `c` of both halves.
#[inline(always)]
fn channel([a, b]: &[Image; 2], c: usize, pixels: Pixels) -> [Lanes; 2] {
    [pixels.of(&a.channels()[c]), pixels.of(&b.channels()[c])]
}

impl<const N: usize> ByEight<N> for Raw<'_> {
    #[inline(always)]
    fn numbers(&self, pixels: Pixels) -> [Lanes; N] {
        let mut variance = [0.0; LANES];
        for plane in self.contest.low.variance.channels() {
            let values = pixels.of(plane);
            (0..LANES).for_each(|i| variance[i] += values[i] / 3.0);
        }
        let precisions = self.precisions(&variance, pixels);
        let mut numbers = self.unweighed::<N>(&variance, pixels);
        for numbers in &mut numbers {
            (0..LANES).for_each(|i| numbers[i] *= precisions[i]);
        }
        numbers
    }
}
