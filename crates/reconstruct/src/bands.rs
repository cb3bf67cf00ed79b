//! Bands of rows that are worked on one after the other, so that what a step needs by the way is never there for the
//! whole picture.

use std::ops::Range;

use stack::{Image, Size};

/// Some rows of a picture, and those that a step looks at to work on them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Band {
    /// The rows that are worked on.
    pub rows: Range<usize>,
    /// The same, and those around them.
    pub around: Range<usize>,
}

/// Cuts `height` rows into bands of `rows`, each with `margin` rows on either side where there are any.
pub fn bands(height: usize, rows: usize, margin: usize) -> Vec<Band> {
    let band = |start: usize| {
        let end = start.saturating_add(rows).min(height);
        Band { rows: start..end, around: start.saturating_sub(margin)..end.saturating_add(margin).min(height) }
    };
    (0..height).step_by(rows.max(1)).map(band).collect()
}

impl Band {
    /// Whether there is nothing else.
    pub fn is_whole(&self, height: usize) -> bool {
        self.around == (0..height)
    }

    /// Copies its rows from `part`, which has those around them, too, to the same place in `whole`.
    pub fn put(&self, part: &Image, whole: &mut Image) {
        let width = whole.size().width;
        let from = (self.rows.start - self.around.start) * width;
        let to = self.rows.start * width..self.rows.end * width;
        for (whole, part) in whole.channels_mut().iter_mut().zip(part.channels()) {
            whole[to.clone()].copy_from_slice(&part[from..][..to.len()]);
        }
    }
}

/// The values of some `rows` of a `plane` of `size`.
pub fn rows_of(plane: &[f32], size: Size, rows: &Range<usize>) -> Vec<f32> {
    plane[rows.start * size.width..rows.end * size.width].to_vec()
}

/// Some rows of an image.
pub fn image_rows(image: &Image, rows: &Range<usize>) -> Image {
    let planes = image.channels().iter().map(|plane| rows_of(plane, image.size(), rows)).collect();
    Image::from_channels(Size::new(image.size().width, rows.len()), planes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_in_one_band_and_margins_end_at_the_border() {
        let found = bands(10, 4, 3);
        let band = |rows, around| Band { rows, around };
        assert_eq!(found, [band(0..4, 0..7), band(4..8, 1..10), band(8..10, 5..10)]);
        assert!(bands(10, usize::MAX, 3)[0].is_whole(10));
        assert_eq!(bands(0, 4, 3), []);
    }

    #[test]
    fn what_is_cut_out_comes_back_to_its_place() {
        let size = Size::new(3, 10);
        let image = Image::from_channels(size, vec![(0..30).map(|i| i as f32).collect(); 2]);
        let mut copy = Image::zeros(size, 2);
        for band in bands(10, 4, 3) {
            band.put(&image_rows(&image, &band.around), &mut copy);
        }
        assert_eq!(copy, image);
    }
}
