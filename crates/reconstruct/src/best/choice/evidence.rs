//! What the halves say about each candidate's error, smoothed on several scales.

use rayon::prelude::*;
use stack::Image;

use super::Contest;
use crate::best::settings::ChoiceSettings;
use crate::best::split::Layers;

/// Candidates there are to choose from.
pub const CANDIDATES: usize = 6;
/// Candidates in the middle, of medium bandwidth with a large and a small window: what all are compared with.
const MIDDLE: [usize; 2] = [2, 4];

/// Dilations of the kernel, one after the other; each makes a level.
const DILATIONS: [usize; LEVELS] = [1, 2, 4];
/// Levels there are.
pub const LEVELS: usize = 3;

/// How far from a pixel all that reaches: twice the dilations, one after the other.
pub const REACH: usize = 2 * (DILATIONS[0] + DILATIONS[1] + DILATIONS[2]);

/// The level that the rule looks at.
const LEVEL_OF_RULE: usize = 1;

/// How much evidence is gathered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scales {
    /// Errors and noise, on the rule's scale.
    OfTheRule,
    /// Everything, on every scale.
    All,
}

/// Evidence on every scale.
pub struct Evidence {
    levels: Vec<Level>,
}

/// Evidence on one scale. All of it is squared and relative: what (luminance² + 0.01) and the noise leave of it, see
/// [`precisions`].
pub struct Level {
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
        &self.planes[1..=CANDIDATES]
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
    /// Gathers it.
    pub fn new(contest: &Contest, settings: &ChoiceSettings, scales: Scales) -> Self {
        let precision = precisions(contest.candidates, contest.layers, settings);
        let mut planes = vec![noise(contest.layers, &precision)];
        planes.extend(contest.candidates.iter().map(|halves| cross_errors(halves, contest.layers, &precision)));
        let mut dilations = &DILATIONS[..=LEVEL_OF_RULE];
        if scales == Scales::All {
            dilations = &DILATIONS;
            planes.extend(contest.candidates.iter().map(|halves| spreads(halves, &precision)));
            let middle = MIDDLE.map(|k| &contest.candidates[k]);
            planes.extend(contest.candidates.iter().map(|halves| distances(halves, middle, &precision)));
        }
        let kernel = contest.kernel(settings);
        let mut levels: Vec<Level> = Vec::with_capacity(dilations.len());
        for dilation in dilations {
            let finer = levels.last().map_or(&planes, |level| &level.planes);
            levels.push(Level { planes: kernel.smooth(finer, *dilation) });
            planes = Vec::new();
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

/// `value` of every pixel.
fn plane(precision: &[f32], value: impl Fn(usize) -> f32 + Sync) -> Vec<f32> {
    precision.par_iter().enumerate().map(|(pixel, precision)| precision * value(pixel)).collect()
}

/// What a squared error counts at each pixel: n/(1 + 3 n v), n = 1/(luminance² + 0.01) with the mean luminance of all
/// candidates, v the variance of a half.
fn precisions(candidates: &[[Image; 2]], layers: &Layers, settings: &ChoiceSettings) -> Vec<f32> {
    let images: Vec<&Image> = candidates.iter().flatten().collect();
    let precision = |pixel: usize| {
        let luminance = images.iter().map(|image| image.mean_at(pixel)).sum::<f32>() / images.len() as f32;
        let relative = 1.0 / (luminance * luminance + 1e-2);
        relative / (1.0 + settings.precision * relative * layers.variance.mean_at(pixel))
    };
    (0..layers.variance.pixels()).into_par_iter().map(precision).collect()
}

fn noise(layers: &Layers, precision: &[f32]) -> Vec<f32> {
    plane(precision, |pixel| 6.0 * layers.variance.mean_at(pixel))
}

fn cross_errors(halves: &[Image; 2], layers: &Layers, precision: &[f32]) -> Vec<f32> {
    plane(precision, |pixel| layers.cross_error(halves, pixel))
}

fn spreads([a, b]: &[Image; 2], precision: &[f32]) -> Vec<f32> {
    plane(precision, |pixel| squared_distance(a.rgb(pixel), b.rgb(pixel)))
}

fn distances([a, b]: &[Image; 2], middle: [&[Image; 2]; 2], precision: &[f32]) -> Vec<f32> {
    plane(precision, |pixel| {
        let centre = sum(middle.map(|[a, b]| sum([a.rgb(pixel), b.rgb(pixel)])));
        let own = sum([a.rgb(pixel), b.rgb(pixel)]);
        2.0 * squared_distance(own.map(|v| 0.5 * v), centre.map(|v| 0.25 * v))
    })
}

fn sum([a, b]: [[f32; 3]; 2]) -> [f32; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}

fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum()
}
