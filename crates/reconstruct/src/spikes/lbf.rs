//! The spike removal of the learning-based filter, for the paper's figure 1.
//!
//! N. K. Kalantari, S. Bako, P. Sen, *A machine learning approach for filtering Monte Carlo noise*, 2015: a pixel whose
//! colour lies far outside the spread of its 3×3 block is replaced by the block's median. Its authors apply this to the
//! filtered picture; the paper's figure applies it to the noisy one, in front of the regression.

use stack::{Cancelled, Image, Monitor};

use super::Found;
use super::replace::{block_around, median_of_block};
use crate::pieces::of_each;

/// Marks every pixel that is more than `deviations` standard deviations away from the mean of its 3×3 block in any
/// channel, and every pixel that is not finite. A marked pixel is taken from the one of median luminance in the block.
/// Reports the stage `spikes`, one unit per row.
///
/// # Errors
/// When the monitor cancels.
pub(super) fn find(colour: &Image, deviations: f32, monitor: &dyn Monitor) -> Result<Found, Cancelled> {
    let size = colour.size();
    monitor.begin("spikes", size.height as u64);
    let row =
        |y: usize| -> Vec<bool> { (0..size.width).map(|x| is_spike(size.index(x, y), colour, deviations)).collect() };
    let marked = of_each(0..size.height, monitor, row)?.concat();
    let source = |(pixel, marked): (usize, &bool)| if *marked { median_of_block(pixel, colour) } else { Some(pixel) };
    let sources = marked.iter().enumerate().map(source).collect();
    Ok((marked, sources))
}

fn is_spike(pixel: usize, colour: &Image, deviations: f32) -> bool {
    colour.channels().iter().any(|channel| {
        let value = channel[pixel];
        let block = block_around(pixel, colour.size()).map(|p| channel[p]).filter(|v| v.is_finite());
        !value.is_finite() || is_far(value, block, deviations)
    })
}

/// Whether `value` is more than `deviations` standard deviations (of the block as a population) away from the mean of
/// its `block`.
fn is_far(value: f32, block: impl Iterator<Item = f32> + Clone, deviations: f32) -> bool {
    let count = block.clone().count() as f64;
    let mean = block.clone().map(f64::from).sum::<f64>() / count;
    let variance = block.map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / count;
    (f64::from(value) - mean).abs() > f64::from(deviations) * variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::{Silent, Size};

    /// Grey pictures of 5×5 pixels.
    fn grey(values: [f32; 25]) -> Image {
        Image::from_channels(Size::new(5, 5), vec![values.to_vec(); 3])
    }

    #[test]
    fn a_lone_bright_or_dark_pixel_is_a_spike() {
        for centre in [9.0, -9.0] {
            let mut values = std::array::from_fn(|i| 1.0 + 0.1 * (i % 3) as f32);
            values[12] = centre;
            let (marked, sources) = find(&grey(values), 2.0, &Silent).unwrap();
            assert_eq!((0..25).filter(|p| marked[*p]).collect::<Vec<_>>(), [12]);
            // With the pixel itself nine values: the median is the fifth.
            let mut block: Vec<f32> = [6, 7, 8, 11, 12, 13, 16, 17, 18].map(|p| values[p]).to_vec();
            block.sort_by(f32::total_cmp);
            assert_eq!(values[sources[12].unwrap()], block[4]);
        }
    }

    #[test]
    fn deviations_are_counted_as_they_say() {
        // Eight pixels of 0 and one of 9 in its block: mean 1, variance (8 + 64)/9 = 8, so that 9 is 8/√8 = 2.83 away.
        let mut values = [0.0; 25];
        values[12] = 9.0;
        let marks = |deviations| find(&grey(values), deviations, &Silent).unwrap().0.iter().filter(|m| **m).count();
        assert_eq!((marks(2.8), marks(2.84)), (1, 0));
    }

    #[test]
    fn one_channel_is_enough_and_broken_pixels_are_always_marked() {
        let mut picture = grey([1.0; 25]);
        picture.channels_mut()[2][12] = 5.0;
        picture.channels_mut()[0][0] = f32::NAN;
        let (marked, sources) = find(&picture, 2.0, &Silent).unwrap();
        assert_eq!((0..25).filter(|p| marked[*p]).collect::<Vec<_>>(), [0, 12]);
        assert!(sources[0].is_some_and(|p| p != 0));
    }

    /// What figure 1 is about: a line one pixel wide is signal, and this rule cannot know.
    #[test]
    fn ends_of_fine_lines_are_taken_for_spikes() {
        let values = std::array::from_fn(|i| if i / 5 == 2 && i % 5 < 3 { 1.0 } else { 0.0 });
        let (marked, _) = find(&grey(values), 1.8, &Silent).unwrap();
        assert!(marked[12], "the end of the line");
        assert!(!marked[11], "its middle");
    }
}
