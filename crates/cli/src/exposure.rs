//! From linear radiance to an 8-bit picture for the eye.

use stack::Image;

/// Share of pixels that the automatic exposure lets clip.
const CLIPPED: f64 = 0.03;

/// Darkest and lightest linear grey that the median of the picture may end at.
const MEDIAN: [f32; 2] = [0.12, 0.25];

/// What is darker than this share of the bright pixels is background: where there was nothing to see, a reconstruction may
/// leave traces of light.
const BACKGROUND: f32 = 1e-3;
/// Where such traces are all but a few pixels, these are too few to be found by counting: what is darker than this share of
/// what is seen is background, too.
const BACKGROUND_OF_SEEN: f32 = 1e-4;
/// Share of all light, each pixel's by its root, that is darker than what is seen. The root makes much of few pixels that are
/// a million times as bright as the others, and little of a lamp that is a thousand times as bright as the room.
const UNSEEN: f64 = 0.25;

/// A value that more than this share of the pixels has, but for rounding, is background, too: a sky that is the same everywhere.
const UNIFORM: f64 = 0.05;
/// How much larger a value is, at most, that is the same but for rounding.
const ROUNDING: f32 = 1.0 + 1e-6;

/// Which pixels of a picture hold any light in the samples that it was made from. Elsewhere is nothing to see, and what a
/// reconstruction leaves there by spreading light may be more than the half of all pixels.
pub struct Lit(Vec<bool>);

impl Lit {
    /// Those of the picture as it was sampled.
    pub fn of(noisy: &Image) -> Self {
        Self((0..noisy.pixels()).map(|pixel| noisy.rgb(pixel) != [0.0; 3]).collect())
    }
}

/// [`choose`] for the pixels that are `lit`; for all when none is.
pub fn choose_for(picture: &Image, lit: &Lit) -> f32 {
    let seen = |pixel: usize| lit.0[pixel];
    if lit.0.contains(&true) { choose_among(picture, seen) } else { choose(picture) }
}

/// Stops by which `picture` should be lifted to fill an 8-bit range: all but the brightest 3 % of its pixels stay below
/// white, as long as that leaves its median at a middle grey. Background that is black but for traces of light, and that of
/// one colour, do not count. 0 for a black picture.
pub fn choose(picture: &Image) -> f32 {
    choose_among(picture, |_| true)
}

/// The same for the pixels that count.
fn choose_among(picture: &Image, counts: impl Fn(usize) -> bool) -> f32 {
    let mut luminance: Vec<f32> = (0..picture.pixels())
        .filter(|pixel| counts(*pixel))
        .map(|pixel| picture.mean_at(pixel))
        .filter(|value| value.is_finite() && *value > 0.0)
        .collect();
    if luminance.is_empty() {
        return 0.0;
    }
    luminance.sort_by(f32::total_cmp);
    let background = f32::max(BACKGROUND * quantile(&luminance, 1.0 - CLIPPED), BACKGROUND_OF_SEEN * seen(&luminance));
    let lit = without_uniform(&luminance[luminance.partition_point(|&value| value < background)..]);
    let (bright, median) = (quantile(&lit, 1.0 - CLIPPED), quantile(&lit, 0.5));
    let factor = (1.0 / bright).clamp(MEDIAN[0] / median, MEDIAN[1] / median);
    (factor.log2() * 10.0).round() / 10.0
}

/// The least of the `sorted` values that is not among what is darker than what is seen.
fn seen(sorted: &[f32]) -> f32 {
    let root = |value: &f32| f64::from(*value).sqrt();
    let mut left = UNSEEN * sorted.iter().map(root).sum::<f64>();
    let is_seen = |value: &&f32| {
        left -= root(value);
        left < 0.0
    };
    sorted.iter().find(is_seen).copied().unwrap_or(0.0)
}

/// The `sorted` values without those of a background of one colour, unless there is nothing else.
fn without_uniform(sorted: &[f32]) -> Vec<f32> {
    let many = (UNIFORM * sorted.len() as f64) as usize;
    let (mut others, mut rest) = (Vec::with_capacity(sorted.len()), sorted);
    while let Some(first) = rest.first() {
        let (alike, larger) = rest.split_at(rest.partition_point(|value| *value <= first * ROUNDING));
        if alike.len() <= many.max(1) {
            others.extend_from_slice(alike);
        }
        rest = larger;
    }
    if others.is_empty() { sorted.to_vec() } else { others }
}

/// The value that the share `share` of the `sorted` ones, of which there are some, does not exceed.
fn quantile(sorted: &[f32], share: f64) -> f32 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// sRGB bytes, row-major, of `picture` lifted by `stops`.
pub fn to_srgb8(picture: &Image, stops: f32) -> Vec<u8> {
    let factor = stops.exp2();
    let byte = |value: f32| (encode_srgb((value * factor).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
    (0..picture.pixels()).flat_map(|pixel| picture.rgb(pixel).map(byte)).collect()
}

/// The sRGB transfer function (IEC 61966-2-1).
fn encode_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn exposure_is_undone_by_scaling_the_light() {
        let planes = vec![(1..=100).map(|i| i as f32 / 100.0).collect::<Vec<f32>>(); 3];
        let picture = Image::from_channels(Size::new(10, 10), planes.clone());
        let brighter = planes.iter().map(|plane| plane.iter().map(|v| v * 8.0).collect()).collect();
        let brighter = Image::from_channels(Size::new(10, 10), brighter);
        assert!((choose(&picture) - choose(&brighter) - 3.0).abs() < 0.11);
        assert_eq!(choose(&Image::zeros(Size::new(2, 2), 3)), 0.0);
    }

    #[test]
    fn background_with_traces_of_light_does_not_count() {
        let of = |values: Vec<f32>| choose(&Image::from_channels(Size::new(values.len(), 1), vec![values; 3]));
        let lit: Vec<f32> = (1..=20).map(|i| i as f32 / 20.0).collect();
        let traces = (0..80).map(|i| if i % 2 == 0 { 0.0 } else { 1e-9 * i as f32 });
        assert_eq!(of(lit.iter().copied().chain(traces).collect()), of(lit));
    }

    #[test]
    fn few_pixels_before_traces_of_light_are_what_counts() {
        let of = |values: Vec<f32>| choose(&Image::from_channels(Size::new(values.len(), 1), vec![values; 3]));
        let object: Vec<f32> = (1..=100).map(|i| i as f32 / 100.0).collect();
        for spread in [1e-8, 1e-6] {
            let traces = (1..=9900).map(|i| spread * (i as f32 / 9900.0));
            let before_traces = of(object.iter().copied().chain(traces).collect());
            assert_eq!(before_traces, of(object.clone()), "1 % of the pixels, traces up to {spread}");
        }
    }

    #[test]
    fn where_all_samples_are_black_is_nothing_to_see() {
        let image = |values: &[f32]| Image::from_channels(Size::new(values.len(), 1), vec![values.to_vec(); 3]);
        let object: Vec<f32> = (1..=100).map(|i| i as f32 / 100.0).collect();
        let halo: Vec<f32> = (1..=900).map(|i| 0.01 * i as f32 / 900.0).collect();
        let [sampled, rebuilt] = [vec![0.0; 900], halo].map(|around| image(&[&object[..], &around].concat()));
        assert!(choose(&rebuilt) - choose(&image(&object)) > 2.0, "what is around is as bright as a dark room");
        assert_eq!(choose_for(&rebuilt, &Lit::of(&sampled)), choose(&image(&object)));
        assert_eq!(choose_for(&rebuilt, &Lit::of(&image(&[0.0; 1000]))), choose(&rebuilt));
    }

    #[test]
    fn neither_a_lamp_nor_a_firefly_takes_the_room_for_background() {
        let of = |values: Vec<f32>| choose(&Image::from_channels(Size::new(values.len(), 1), vec![values; 3]));
        let room: Vec<f32> = (1..=10000).map(|i| i as f32 / 10000.0).collect();
        for (pixels, brightness) in [(1, 1e7), (100, 1e4), (200, 5e3)] {
            let with_lamp = of(room.iter().copied().chain(std::iter::repeat_n(brightness, pixels)).collect());
            let off = with_lamp - of(room.clone());
            assert!((-0.11..=0.11).contains(&off), "{pixels} pixels of {brightness}: {off} stops");
        }
    }

    #[test]
    fn a_sky_of_one_colour_does_not_count() {
        let of = |values: Vec<f32>| choose(&Image::from_channels(Size::new(values.len(), 1), vec![values; 3]));
        let object: Vec<f32> = (1..=100).map(|i| i as f32 / 1000.0).collect();
        let sky = (0..300).map(|i| 0.7 + 6e-8 * (i % 5) as f32);
        let before_a_sky = object.iter().copied().chain(sky).collect();
        assert_eq!(of(before_a_sky), of(object));
        assert_eq!(of(vec![0.7; 300]), -1.5, "nothing but sky");
    }

    #[test]
    fn white_is_white_and_nan_is_black() {
        let picture = Image::from_channels(Size::new(1, 1), vec![vec![1.0], vec![f32::NAN], vec![0.5]]);
        assert_eq!(to_srgb8(&picture, 0.0), [255, 0, 188]);
    }
}
