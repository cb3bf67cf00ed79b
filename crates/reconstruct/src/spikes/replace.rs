//! Marked pixels replaced by the median of their neighbours (algorithm 1, lines 9–16).

use stack::{Image, Size};

/// Marks every pixel whose sparse part exceeds `threshold` in any channel, and every pixel of `colour` that is not
/// finite: nothing can be computed with it.
pub fn mark(colour: &Image, sparse: &Image, threshold: f32) -> Vec<bool> {
    let mut marked = vec![false; colour.pixels()];
    for (values, candidates) in colour.channels().iter().zip(sparse.channels()) {
        for ((mark, value), candidate) in marked.iter_mut().zip(values).zip(candidates) {
            *mark |= *candidate > threshold || !value.is_finite();
        }
    }
    marked
}

/// For every pixel, the one whose colour and variance it takes: itself unless it is marked, else the pixel of median
/// luminance among the unmarked ones of its 3×3 block (the lower median when they are an even number), or among all
/// nine when all are marked. `None` when nothing in the block is finite.
pub fn source_of(pixel: usize, colour: &Image, marked: &[bool]) -> Option<usize> {
    if !marked[pixel] {
        return Some(pixel);
    }
    let block = block_around(pixel, colour.size());
    median(block.clone().filter(|p| !marked[*p]), colour).or_else(|| median(block, colour))
}

/// The pixel of median luminance in the whole 3×3 block around `pixel`; `None` when nothing there is finite.
pub fn median_of_block(pixel: usize, colour: &Image) -> Option<usize> {
    median(block_around(pixel, colour.size()), colour)
}

/// The pixels of the 3×3 block around `pixel` that lie inside the image.
pub fn block_around(pixel: usize, size: Size) -> impl Iterator<Item = usize> + Clone {
    let (x, y) = (pixel % size.width, pixel / size.width);
    let columns = x.saturating_sub(1)..(x + 2).min(size.width);
    let rows = y.saturating_sub(1)..(y + 2).min(size.height);
    rows.flat_map(move |y| columns.clone().map(move |x| size.index(x, y)))
}

/// The pixel of median luminance, of those whose colour is finite.
fn median(pixels: impl Iterator<Item = usize>, colour: &Image) -> Option<usize> {
    let luminances = pixels.map(|p| (colour.mean_at(p), p)).filter(|(luminance, _)| luminance.is_finite());
    let mut ordered: Vec<(f32, usize)> = luminances.collect();
    ordered.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    ordered.get(ordered.len().saturating_sub(1) / 2).map(|(_, pixel)| *pixel)
}

/// `image` with every marked pixel taken from where `sources` says; zero where that is nowhere.
pub fn replaced(image: &Image, sources: &[Option<usize>]) -> Image {
    let replace = |channel: &Vec<f32>| sources.iter().map(|source| source.map_or(0.0, |p| channel[p])).collect();
    Image::from_channels(image.size(), image.channels().iter().map(replace).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: usize, values: &[f32]) -> Image {
        Image::from_channels(Size::new(width, values.len() / width), vec![values.to_vec(); 3])
    }

    #[test]
    fn any_channel_above_the_threshold_marks() {
        let colour = Image::zeros(Size::new(3, 1), 3);
        let mut sparse = colour.clone();
        sparse.channels_mut()[1][0] = 2.6;
        sparse.channels_mut()[2][1] = 2.5;
        sparse.channels_mut()[0][2] = -9.0;
        assert_eq!(mark(&colour, &sparse, 2.5), [true, false, false]);
    }

    #[test]
    fn a_spike_takes_the_median_of_its_unmarked_neighbours() {
        let colour = grey(3, &[5.0, 1.0, 8.0, 2.0, 100.0, 90.0, 7.0, 3.0, 6.0]);
        let mut marked = [false; 9];
        (marked[4], marked[5]) = (true, true);
        // 1 2 3 5 6 7 8: the median is 5, at pixel 0.
        assert_eq!(source_of(4, &colour, &marked), Some(0));
        // 1 8 3 6: the lower median is 3, at pixel 7.
        assert_eq!(source_of(5, &colour, &marked), Some(7));
        assert_eq!(source_of(8, &colour, &marked), Some(8), "unmarked pixels keep their own");
    }

    #[test]
    fn a_block_of_nothing_but_spikes_takes_its_own_median() {
        let colour = grey(3, &[5.0, 1.0, 8.0, 2.0, 4.0, 9.0, 7.0, 3.0, 6.0]);
        assert_eq!(source_of(4, &colour, &[true; 9]), Some(0));
        assert_eq!(source_of(0, &grey(1, &[4.0]), &[true]), Some(0));
    }

    #[test]
    fn broken_values_are_marked_and_never_taken() {
        let colour = grey(2, &[f32::NAN, f32::INFINITY, 3.0, f32::NAN]);
        let marked = mark(&colour, &Image::zeros(colour.size(), 3), 1.0);
        assert_eq!(marked, [true, true, false, true]);
        let sources: Vec<_> = (0..4).map(|p| source_of(p, &colour, &marked)).collect();
        assert_eq!(replaced(&colour, &sources), grey(2, &[3.0; 4]));
        let lost = grey(1, &[f32::NAN]);
        assert_eq!(replaced(&lost, &[source_of(0, &lost, &[true])]), grey(1, &[0.0]));
    }
}
