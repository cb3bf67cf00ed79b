//! Events along a line: a thin highlight that few samples met with.
//!
//! An event's surroundings are a disc, over which the light of such a highlight is lost. Here it is found where a strip of
//! pixels holds many more events, of both halves, than the surface around leads to expect.

use std::borrow::Cow;
use std::f32::consts::PI;

use rayon::prelude::*;
use stack::{Image, Size};

use crate::best::edge_avoiding::EdgeAvoidingKernel;
use crate::best::features::CleanFeatures;
use crate::best::settings::SpreadSettings;
use crate::best::split::Events;
use crate::per_pixel::plane;

/// Half the length and half the width of a strip, in pixels. Longer ones leave curved highlights, shorter ones hold too few
/// events.
const HALF_LENGTH: f32 = 5.3;
const HALF_WIDTH: f32 = 1.5;

/// Columns and rows to either side of a pixel that its strips reach, and those of the square around it, whose pixels are the
/// bits of a number.
const REACH: usize = 5;
const SIDE: usize = 2 * REACH + 1;

/// Directions of strips, evenly over half a turn.
const DIRECTIONS: usize = 8;

/// Distances from the middle line of a strip, in pixels, up to which light counts by so much: a highlight is brightest in its
/// middle.
const PROFILE: [(f32, f32); 3] = [(0.5, 1.0), (1.0, 0.6), (HALF_WIDTH, 0.3)];

/// Events that either half must have in a strip.
const LEAST_OF_HALF: u32 = 2;

/// Widenings of the kernel that tells how many events a surface leads to expect.
const LEVELS: u32 = 4;

/// What makes lines of `events` brighter to those that spread them, mean over RGB: at each pixel, light of the brightest
/// strip through it that holds significantly more events than the surfaces of `features` have around it, times its weight.
/// `None` if there is no such strip.
pub fn brightness_of_lines(events: &Events, features: &CleanFeatures, settings: &SpreadSettings) -> Option<Vec<f32>> {
    if settings.lines == 0.0 {
        return None;
    }
    let size = features.set.size;
    let seen = events.light.each_ref().map(|half| (0..size.pixels()).map(|pixel| half.mean_at(pixel) > 0.0).collect());
    let search = Search { size, strips: strips(), significance: settings.lines_significance, seen };
    // The kernel takes most of the time, and few pictures have lines.
    if !(0..size.height).into_par_iter().any(|y| search.crowded(y).next().is_some()) {
        return None;
    }
    let kernel = EdgeAvoidingKernel::on_surfaces(features, settings.feature_scale);
    let counts = plane(size.pixels(), |pixel| search.seen.iter().map(|seen| f32::from(u8::from(seen[pixel]))).sum());
    let expected = (0..LEVELS).fold(vec![counts], |counts, level| kernel.smooth(&counts, 1 << level)).remove(0);
    let light = plane(size.pixels(), |pixel| events.light.iter().map(|half| half.mean_at(pixel)).sum());
    let mut brightness = vec![0.0_f32; size.pixels()];
    brightness.par_chunks_mut(size.width).enumerate().for_each(|(y, row)| {
        for (x, count, strip) in search.crowded(y) {
            if search.is_significant(count, strip.sum(&expected, size, [x, y])) {
                row[x] = row[x].max(settings.lines * strip.light(&light, size, [x, y]));
            }
        }
    });
    brightness.iter().any(|light| *light > 0.0).then_some(brightness)
}

/// `picture`, as much brighter as the `lines` are.
pub fn with_lines<'a>(picture: &'a Image, lines: &Option<Vec<f32>>) -> Cow<'a, Image> {
    let Some(lines) = lines else { return Cow::Borrowed(picture) };
    let mut sum = picture.clone();
    for plane in sum.channels_mut() {
        plane.iter_mut().zip(lines).for_each(|(value, line)| *value += line);
    }
    Cow::Owned(sum)
}

/// Pixels along a line through one of them.
struct Strip {
    /// Columns and rows away, and how much their light counts.
    taps: Vec<([isize; 2], f32)>,
    /// The same as bits, see [`bit`].
    mask: u128,
}

/// The bit of a pixel so many columns and rows from the upper left of a square.
fn bit(column: usize, row: usize) -> u128 {
    1 << (SIDE * column + row)
}

/// One strip for each direction.
fn strips() -> [Strip; DIRECTIONS] {
    std::array::from_fn(|direction| {
        let (sine, cosine) = (PI * direction as f32 / DIRECTIONS as f32).sin_cos();
        let mut strip = Strip { taps: Vec::new(), mask: 0 };
        for (column, row) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (column, row))) {
            let [x, y] = [column, row].map(|at| at as f32 - REACH as f32);
            let (along, across) = ((x * cosine + y * sine).abs(), (y * cosine - x * sine).abs());
            let weight = PROFILE.into_iter().find(|(end, _)| across < *end && along <= HALF_LENGTH);
            if let Some((_, weight)) = weight {
                strip.taps.push(([x as isize, y as isize], weight));
                strip.mask |= bit(column, row);
            }
        }
        strip
    })
}

impl Strip {
    /// Sum of `plane` along the strip through a pixel.
    fn sum(&self, plane: &[f32], size: Size, pixel: [usize; 2]) -> f32 {
        self.inside(size, pixel).map(|(at, _)| plane[at]).sum()
    }

    /// Mean of the `light` along the strip through a pixel.
    fn light(&self, light: &[f32], size: Size, pixel: [usize; 2]) -> f32 {
        let [sum, weights] = self
            .inside(size, pixel)
            .fold([0.0; 2], |[sum, weights], (at, weight)| [sum + weight * light[at], weights + weight]);
        sum / weights
    }

    /// Those of its pixels that are inside the picture, and how much their light counts.
    fn inside(&self, size: Size, [x, y]: [usize; 2]) -> impl Iterator<Item = (usize, f32)> {
        self.taps.iter().filter_map(move |([dx, dy], weight)| {
            let (column, row) = (x.checked_add_signed(*dx)?, y.checked_add_signed(*dy)?);
            (column < size.width && row < size.height).then(|| (size.index(column, row), *weight))
        })
    }
}

struct Search {
    size: Size,
    strips: [Strip; DIRECTIONS],
    /// See [`SpreadSettings::lines_significance`].
    significance: f32,
    /// Which pixels have events of a half.
    seen: [Vec<bool>; 2],
}

impl Search {
    /// Strips through pixels of row `y` that would hold significantly many events if none were expected: the pixel's
    /// column, their number, the strip.
    fn crowded(&self, y: usize) -> impl Iterator<Item = (usize, f32, &Strip)> {
        let squares = self.seen.each_ref().map(|seen| self.squares(seen, y));
        (0..self.size.width).flat_map(move |x| {
            let [a, b] = squares.each_ref().map(|squares| squares[x]);
            let few = |a: u128, b: u128| a.count_ones().min(b.count_ones()) < LEAST_OF_HALF;
            let strips = if few(a, b) { &[] } else { &self.strips[..] };
            strips.iter().filter_map(move |strip| {
                let [a, b] = [a, b].map(|square| square & strip.mask);
                let count = (a.count_ones() + b.count_ones()) as f32;
                (!few(a, b) && self.is_significant(count, 0.0)).then_some((x, count, strip))
            })
        })
    }

    /// The squares around the pixels of row `y`.
    fn squares(&self, seen: &[bool], y: usize) -> Vec<u128> {
        let Size { width, height } = self.size;
        let rows: Vec<(usize, usize)> = (0..SIDE).filter_map(|i| Some((i, (y + i).checked_sub(REACH)?))).collect();
        let rows = rows.iter().filter(|(_, row)| *row < height);
        let mut square = 0;
        let next = |x: usize| {
            square >>= SIDE;
            if x < width {
                let seen = rows.clone().filter(|(_, row)| seen[self.size.index(x, *row)]);
                square |= seen.map(|(i, _)| bit(SIDE - 1, *i)).sum::<u128>();
            }
            square
        };
        (0..width + REACH).map(next).skip(REACH).collect()
    }

    /// Whether a `count` of events exceeds the `expected` one significantly: twice the root of either has a variance of one,
    /// whatever it is (Anscombe 1948).
    fn is_significant(&self, count: f32, expected: f32) -> bool {
        let root = |count: f32| 2.0 * (count + 0.375).sqrt();
        root(count) - root(expected) > self.significance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::best::test_scene::{features, flat};
    use crate::test_noise::TestNoise;

    const SIZE: Size = Size::new(64, 48);

    /// Events of light 1 in either half at the pixels that `has` names.
    fn events(has: impl Fn(usize, usize, usize) -> bool) -> Events {
        let mut light = [flat(SIZE, 0.0), flat(SIZE, 0.0)];
        for (half, image) in light.iter_mut().enumerate() {
            for plane in image.channels_mut() {
                let has = |i: usize| has(half, i % SIZE.width, i / SIZE.width);
                plane.iter_mut().enumerate().for_each(|(i, v)| *v = f32::from(u8::from(has(i))));
            }
        }
        Events { light, energy: Vec::new(), squares: Vec::new() }
    }

    fn found(events: &Events) -> Option<Vec<f32>> {
        let nothing = features(SIZE, vec![vec![0.0; SIZE.pixels()]]);
        brightness_of_lines(events, &nothing, &SpreadSettings::default())
    }

    /// Pixels along a slope of one in two, of either half in turn.
    fn on_the_slope(half: usize, x: usize, y: usize) -> bool {
        (16..48).contains(&x) && y == 12 + x / 2 && x % 2 == half
    }

    #[test]
    fn light_is_found_along_the_line_and_only_there() {
        let light = found(&events(on_the_slope)).expect("a line");
        for x in 20..44 {
            let at = |dy: usize| light[SIZE.index(x, 12 + x / 2 + dy)];
            assert!(at(0) > 0.4 && at(0) >= at(1), "{x}: {} {}", at(0), at(1));
            assert_eq!(at(6), 0.0, "{x}");
        }
    }

    #[test]
    fn a_line_that_one_half_shows_is_chance() {
        let beside = |x: usize, y: usize| x.is_multiple_of(8) && y == 16 + x / 2;
        let of_one = |half, x, y| if half == 0 { on_the_slope(x % 2, x, y) } else { beside(x, y) };
        assert_eq!(found(&events(of_one)), None);
    }

    #[test]
    fn events_all_over_are_no_line_and_hide_one_that_is_no_denser() {
        let mut noise = TestNoise(82);
        let scattered: Vec<bool> = (0..2 * SIZE.pixels()).map(|_| noise.uniform() < 0.1).collect();
        let everywhere = |half: usize, x: usize, y: usize| scattered[half * SIZE.pixels() + SIZE.index(x, y)];
        let share = |light: Option<Vec<f32>>| {
            light.map_or(0.0, |light| light.iter().filter(|v| **v > 0.0).count() as f32 / SIZE.pixels() as f32)
        };
        let by_chance = share(found(&events(everywhere)));
        assert!(by_chance < 0.01, "{by_chance}");
        let hidden = share(found(&events(|half, x, y| everywhere(half, x, y) || on_the_slope(half, x, y))));
        assert!(hidden < 0.02, "{hidden}");
    }

    #[test]
    fn a_pixel_by_itself_is_no_line() {
        let one = Size::new(1, 1);
        let light = [flat(one, 1.0), flat(one, 1.0)];
        let all = Events { light, energy: Vec::new(), squares: Vec::new() };
        assert_eq!(brightness_of_lines(&all, &features(one, vec![vec![0.0]]), &SpreadSettings::default()), None);
    }
}
