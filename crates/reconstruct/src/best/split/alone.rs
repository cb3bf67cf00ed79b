//! The two layers of a picture that has no buckets: split by its neighbours alone, halves drawn from its variance.

use stack::Image;

use super::layers::{Events, LEAST_VARIANCE, Layers, LowLayer};
use crate::lone_light::share_like_neighbours;
use crate::recorruption::{coin, recorrupted_halves};
use crate::variance::{known_everywhere, steadied};

/// Splits `mean`, of the given `variance`. There are no buckets that a firefly could be missing from, so a pixel is cut
/// where it sticks out of its neighbours. Each event belongs to one half, by lot, as it would if the samples had been
/// dealt to halves.
pub fn split_alone(mean: &Image, variance: &Image) -> Layers {
    let kept = share_like_neighbours(mean);
    let low = scaled(mean, |i| kept[i]);
    let variance = scaled(&known_everywhere(variance.clone(), mean), |i| kept[i] * kept[i]);
    let cut = |side: bool| scaled(mean, |i| if coin(i as u64) == side { 1.0 - kept[i] } else { 0.0 });
    let energy: Vec<f32> =
        kept.iter().enumerate().map(|(i, kept)| (1.0 - kept) * mean.rgb(i).iter().sum::<f32>()).collect();
    Layers {
        low: LowLayer {
            halves: recorrupted_halves(&low, &variance),
            variance: steadied(scaled(&variance, |_| 2.0), LEAST_VARIANCE),
        },
        events: Events { light: [cut(true), cut(false)], squares: energy.iter().map(|e| e * e).collect(), energy },
    }
}

/// `image` with every pixel times its `factor`.
fn scaled(image: &Image, factor: impl Fn(usize) -> f32) -> Image {
    let planes = image.channels().iter();
    let planes = planes.map(|plane| plane.iter().enumerate().map(|(i, v)| v * factor(i)).collect());
    Image::from_channels(image.size(), planes.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::best::test_scene::{flat, image};
    use stack::Size;

    const SIZE: Size = Size::new(20, 16);

    fn split(mean: &Image) -> Layers {
        split_alone(mean, &flat(SIZE, 0.01))
    }

    #[test]
    fn a_lone_spike_goes_to_one_half_and_nothing_is_lost() {
        let spike = SIZE.index(9, 8);
        let mut mean = flat(SIZE, 1.0);
        mean.channels_mut().iter_mut().for_each(|plane| plane[spike] = 50.0);
        let layers = split(&mean);
        let [a, b] = [0, 1].map(|half: usize| layers.events.light[half].rgb(spike)[0]);
        assert!((a == 0.0) != (b == 0.0) && (a + b - 48.0).abs() < 1e-4, "{a} {b}");
        assert!((layers.events.energy[spike] - 144.0).abs() < 1e-3);
        assert!((layers.events.concentration(spike) - 1.0).abs() < 1e-6);
        for i in 0..SIZE.pixels() {
            let low = 0.5 * (layers.low.halves[0].rgb(i)[1] + layers.low.halves[1].rgb(i)[1]);
            let events = layers.events.light[0].rgb(i)[1] + layers.events.light[1].rgb(i)[1];
            assert!((low + events - mean.rgb(i)[1]).abs() < 1e-5, "{i}");
            assert_eq!(layers.events.energy[i] > 0.0, i == spike);
        }
    }

    #[test]
    fn a_pixel_by_itself_is_whole() {
        let one = image(Size::new(1, 1), |_, _, _| 3.0);
        let layers = split_alone(&one, &image(Size::new(1, 1), |_, _, _| 0.0));
        assert_eq!(layers.low.halves, [one.clone(), one]);
    }
}
