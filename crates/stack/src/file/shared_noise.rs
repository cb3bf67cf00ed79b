//! Whether neighbouring pixels share their noise: as where every sample counts for all pixels that a wide filter reaches from it.
//!
//! Second differences of white noise go together with those one and two pixels on by −2/3 and 1/6. Noise that is shared has
//! neither; what a picture shows beside noise has not, either, so only places are looked at where features are flat.

use crate::{FeatureRole, Image, Size};

use super::loaded::Loaded;
use super::role::Role;

/// Second differences of features that count as flat …
const FLAT: f32 = 0.02;
/// … and differences of the pixels on both sides.
const LEVEL: f32 = 0.1;

/// Pairs that say something.
const LEAST_PAIRS: usize = 1000;

/// Rows, and columns, that are looked at: of a large picture some tell as much as all.
const MOST_LINES: usize = 512;

/// Relative second difference, in the median, below which there is no noise to speak of.
const LEAST_NOISE: f32 = 0.004;

/// What second differences reach in units of their median, so that fireflies do not decide.
const MOST: f32 = 3.0;

/// White noise reaches 0.09 to 0.18 two pixels on in renders of Mitsuba (box), Cycles, Tungsten and LuxCore, of 4 to 8192 samples;
/// filters wider than a pixel −0.01 (Lanczos) to −0.5 (a tent of two pixels).
const TWO_ON: f64 = 0.05;

/// Whether the noise of the colour is shared, as far as albedo or normal leave flat places to look at.
pub fn shares_noise(render: &Loaded) -> bool {
    let features = [FeatureRole::Albedo, FeatureRole::Normal].map(|role| render.plane(Role::Feature(role)));
    let features: Vec<&Image> = features.into_iter().flatten().map(|plane| &plane.mean).collect();
    let Some(colour) = render.plane(Role::Colour).filter(|_| !features.is_empty()) else { return false };
    two_on(&colour.mean, &features).is_some_and(|correlation| correlation < TWO_ON)
}

/// How second differences of brightness go together with those two pixels on, −1 to 1, along rows and columns.
fn two_on(colour: &Image, features: &[&Image]) -> Option<f64> {
    let size = colour.size();
    let brightness: Vec<f32> = (0..size.pixels()).map(|p| colour.channels().iter().map(|c| c[p]).sum()).collect();
    let lines: Vec<Line> = rows(size).chain(columns(size)).collect();
    let differences: Vec<Vec<Option<f32>>> =
        lines.iter().map(|line| second_differences(&brightness, features, *line)).collect();
    let mut sizes: Vec<f32> = differences.iter().flatten().flatten().map(|d| d.abs()).collect();
    if sizes.len() < LEAST_PAIRS {
        return None;
    }
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f32::total_cmp).1;
    if median < LEAST_NOISE {
        return None;
    }
    let (mut together, mut squares, mut pairs) = (0.0, 0.0, 0);
    for line in &differences {
        for (a, b) in line.iter().zip(line.iter().skip(2)) {
            let (Some(a), Some(b)) = (a, b) else { continue };
            let [a, b] = [a, b].map(|d| f64::from(d.clamp(-MOST * median, MOST * median)));
            together += a * b;
            squares += (a * a + b * b) / 2.0;
            pairs += 1;
        }
    }
    (pairs >= LEAST_PAIRS).then(|| together / squares)
}

/// Pixels that lie side by side: the first, how far it is to the next, and how many.
type Line = (usize, usize, usize);

/// At most [`MOST_LINES`] of `count` lines.
fn spaced(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(MOST_LINES).max(1))
}

fn rows(size: Size) -> impl Iterator<Item = Line> {
    spaced(size.height).map(move |y| (y * size.width, 1, size.width))
}

fn columns(size: Size) -> impl Iterator<Item = Line> {
    spaced(size.width).map(move |x| (x, size.width, size.height))
}

/// Second differences along a line, relative to brightness, where features are flat and there is light.
fn second_differences(brightness: &[f32], features: &[&Image], (first, step, count): Line) -> Vec<Option<f32>> {
    let at = |place: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| first + (place + k) * step);
        let flat = features
            .iter()
            .flat_map(|feature| feature.channels())
            .all(|f| (f[a] - 2.0 * f[b] + f[c]).abs() < FLAT && (f[a] - f[c]).abs() < LEVEL);
        let light = brightness[a] + brightness[b] + brightness[c];
        (flat && light > 0.0).then(|| 3.0 * (brightness[a] - 2.0 * brightness[b] + brightness[c]) / light)
    };
    (0..count.saturating_sub(2)).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(64, 48);

    fn white() -> Vec<f32> {
        let mut state = 1_u64;
        let next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            1.0 + (state >> 40) as f32 / (1_u64 << 24) as f32
        };
        (0..SIZE.pixels()).map(next).collect()
    }

    /// Each pixel with a share of its neighbours in all directions.
    fn spread(plane: &[f32], share: f32) -> Vec<f32> {
        let at = |x: usize, y: usize| plane[y.min(SIZE.height - 1) * SIZE.width + x.min(SIZE.width - 1)];
        let places = (0..SIZE.pixels()).map(|pixel| (pixel % SIZE.width, pixel / SIZE.width));
        let around = |(x, y): (usize, usize)| {
            let row = |y: usize| at(x, y) + share * (at(x.saturating_sub(1), y) + at(x + 1, y));
            row(y) + share * (row(y.saturating_sub(1)) + row(y + 1))
        };
        places.map(around).collect()
    }

    fn told(plane: Vec<f32>, feature: f32) -> Option<f64> {
        let edge = |pixel: usize| if pixel.is_multiple_of(3) { feature } else { 0.0 };
        let albedo = Image::from_channels(SIZE, vec![(0..SIZE.pixels()).map(edge).collect(); 3]);
        two_on(&Image::from_channels(SIZE, vec![plane; 3]), &[&albedo])
    }

    #[test]
    fn white_noise_is_told_from_filtered() {
        let white_noise = told(white(), 0.0).unwrap();
        assert!((white_noise - 1.0 / 6.0).abs() < 0.05, "{white_noise}");
        // About what a Gaussian of half a pixel does.
        let filtered = told(spread(&white(), 0.2), 0.0).unwrap();
        assert!(filtered < 0.0, "{filtered}");
    }

    #[test]
    fn without_noise_or_flat_places_nothing_is_told() {
        assert_eq!(told(vec![1.0; SIZE.pixels()], 0.0), None);
        assert_eq!(told(spread(&white(), 0.2), 1.0), None, "every third pixel is at an edge");
        assert_eq!(told(vec![0.0; SIZE.pixels()], 0.0), None, "no light");
    }
}
