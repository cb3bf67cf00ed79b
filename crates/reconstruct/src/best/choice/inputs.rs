//! What the network is told about some pixels and their candidates.

use super::Contest;
use super::detail::{DETAILS, details};
use super::evidence::{CANDIDATES, Evidence, LEVELS, Level, Scales};
use crate::best::settings::ChoiceSettings;
use crate::ln::ln;

/// Pixels that are worked on at once.
pub const LANES: usize = 16;
/// A value of each of them.
pub type Lanes = [f32; LANES];

/// What is told about a candidate on one scale.
const OF_LEVEL: usize = 4;
/// What is told about a candidate.
pub const OWN: usize = LEVELS * OF_LEVEL;
/// What is told about a pixel, the same for all candidates.
pub const SHARED: usize = 3 + DETAILS;

/// Least error that the softness is relative to.
const LEAST_ERROR: f32 = 1e-5;
/// Least noise that anything is relative to.
const LEAST_NOISE: f32 = 1e-6;

/// Some pixels.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Of every candidate and every scale, the finest first: ln(E/V + 0.01), ln(1 + (E − min E)/temperature),
    /// ln(D/V + 0.001), ln(R/V + 0.001).
    pub own: [[Lanes; OWN]; CANDIDATES],
    /// ln V on the two coarser scales; ln of the least E on the rule's; detail.
    pub shared: [Lanes; SHARED],
    /// What the rule says.
    pub rule: [Lanes; CANDIDATES],
}

/// Everything the network may be told.
pub struct Inputs<'a> {
    evidence: Evidence,
    details: [Vec<f32>; DETAILS],
    settings: &'a ChoiceSettings,
}

impl<'a> Inputs<'a> {
    /// What `contest` tells.
    pub fn new(contest: &Contest, settings: &'a ChoiceSettings) -> Self {
        Self { evidence: Evidence::new(contest, settings, Scales::All), details: details(contest), settings }
    }

    /// What is told about these pixels.
    #[inline(always)]
    pub fn block(&self, pixels: &[usize; LANES]) -> Block {
        let mut own = [[[0.0; LANES]; OWN]; CANDIDATES];
        for (number, level) in self.evidence.levels().iter().enumerate() {
            let noise = at(level.noise(), pixels);
            let scores: [Lanes; CANDIDATES] = rule_scores(level, pixels, self.settings);
            for (k, own) in own.iter_mut().enumerate() {
                let own = &mut own[number * OF_LEVEL..][..OF_LEVEL];
                own[0] = relative(at(level.error(k), pixels), noise, 1e-2);
                own[1] = scores[k].map(|score| ln(1.0 - score));
                own[2] = relative(at(level.spread(k), pixels), noise, 1e-3);
                own[3] = relative(at(level.distance(k), pixels), noise, 1e-3);
            }
        }
        let level = self.evidence.level_of_rule();
        Block { own, shared: self.shared(level, pixels), rule: rule_scores(level, pixels, self.settings) }
    }

    #[inline(always)]
    fn shared(&self, level: &Level, pixels: &[usize; LANES]) -> [Lanes; SHARED] {
        let mut shared = [[0.0; LANES]; SHARED];
        let logarithm = |plane: Lanes| plane.map(|v| ln(v.max(0.0) + LEAST_ERROR));
        shared[0] = logarithm(at(level.noise(), pixels));
        shared[1] = logarithm(at(self.evidence.levels()[LEVELS - 1].noise(), pixels));
        shared[2] = logarithm(least_error(level, pixels));
        for (lanes, detail) in shared[3..].iter_mut().zip(&self.details) {
            *lanes = at(detail, pixels);
        }
        shared
    }
}

/// The rule's scores: −(E − min E)/(softness · min E + noise · V). The noise keeps the least error from mattering where
/// it is within what chance makes of it.
#[inline(always)]
pub fn rule_scores<const N: usize>(level: &Level, pixels: &[usize; LANES], settings: &ChoiceSettings) -> [Lanes; N] {
    let (least, noise) = (least_error(level, pixels), at(level.noise(), pixels));
    let mut scores = [[0.0; LANES]; N];
    for (k, scores) in scores.iter_mut().enumerate() {
        let error = at(level.error(k), pixels);
        for lane in 0..LANES {
            let temperature = settings.softness * least[lane].max(LEAST_ERROR) + settings.noise * noise[lane];
            scores[lane] = (least[lane] - error[lane]) / temperature;
        }
    }
    scores
}

#[inline(always)]
fn least_error(level: &Level, pixels: &[usize; LANES]) -> Lanes {
    let mut least = [f32::INFINITY; LANES];
    for plane in level.errors() {
        let error = at(plane, pixels);
        (0..LANES).for_each(|lane| least[lane] = least[lane].min(error[lane]));
    }
    least
}

/// ln(value/noise + `least`).
#[inline(always)]
fn relative(value: Lanes, noise: Lanes, least: f32) -> Lanes {
    let mut relative = [0.0; LANES];
    for lane in 0..LANES {
        relative[lane] = ln(value[lane].max(0.0) / (noise[lane] + LEAST_NOISE) + least);
    }
    relative
}

/// Values of `plane`.
#[inline(always)]
fn at(plane: &[f32], pixels: &[usize; LANES]) -> Lanes {
    let mut lanes = [0.0; LANES];
    for lane in 0..LANES {
        lanes[lane] = plane[pixels[lane]];
    }
    lanes
}
