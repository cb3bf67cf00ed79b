//! How large the page shows pictures.

use std::borrow::Cow;

use stack::{Image, Size};

use super::encoded_picture::Coding;
use crate::exposure;

/// Pixels of a picture that are shown one by one.
const MOST_PIXELS: usize = 4 << 20;

/// Pixels in a row or column that a browser can draw.
const MOST_SIDE: usize = 1 << 14;

/// How all pictures of a page are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Size of the files' pictures.
    pub size: Size,
    /// So many pixels in each direction become one.
    pub factor: usize,
    /// Stops by which the pictures are lifted at first: as a PNG of the reference would be.
    pub stops: f32,
    /// What the codes of their values stand for.
    pub coding: Coding,
}

impl Scale {
    /// The scale for pictures of the size and brightness of `reference`.
    pub fn of(reference: &Image) -> Self {
        let (size, stops) = (reference.size(), exposure::choose(reference));
        Self { size, factor: factor(size), stops, coding: Coding::around(stops) }
    }

    /// Size of the pictures on the page.
    pub fn shown(&self) -> Size {
        Size::new(self.size.width.div_ceil(self.factor), self.size.height.div_ceil(self.factor))
    }

    /// `picture` as it is shown: itself, or the means of its blocks.
    pub fn reduce<'a>(&self, picture: &'a Image) -> Cow<'a, Image> {
        if self.factor == 1 {
            return Cow::Borrowed(picture);
        }
        let plane = |plane: &Vec<f32>| self.blocks(|pixels| mean(plane, pixels)).collect();
        Cow::Owned(Image::from_channels(self.shown(), picture.channels().iter().map(plane).collect()))
    }

    /// Which of the pixels on the page are judged: those all of whose pixels are.
    pub fn reduce_judged(&self, judged: &[bool]) -> Vec<bool> {
        self.blocks(|pixels| pixels.iter().all(|pixel| judged[*pixel])).collect()
    }

    /// Makes a value of the pixels behind each pixel on the page.
    fn blocks<T>(&self, of: impl Fn(&[usize]) -> T) -> impl Iterator<Item = T> {
        let (size, shown, factor) = (self.size, self.shown(), self.factor);
        let range = move |i: usize, end: usize| i * factor..((i + 1) * factor).min(end);
        let mut pixels = Vec::new();
        (0..shown.pixels()).map(move |pixel| {
            let (x, y) = (pixel % shown.width, pixel / shown.width);
            let rows = range(y, size.height);
            pixels.clear();
            pixels.extend(rows.flat_map(|y| range(x, size.width).map(move |x| y * size.width + x)));
            of(&pixels)
        })
    }
}

fn mean(plane: &[f32], pixels: &[usize]) -> f32 {
    let sum: f64 = pixels.iter().map(|pixel| f64::from(plane[*pixel])).sum();
    (sum / pixels.len() as f64) as f32
}

/// The smallest factor by which a picture of `size` can be shown.
fn factor(size: Size) -> usize {
    let fits = |factor: usize| {
        let [width, height] = [size.width, size.height].map(|side| side.div_ceil(factor));
        width * height <= MOST_PIXELS && width.max(height) <= MOST_SIDE
    };
    (1..).find(|factor| fits(*factor)).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_large_pictures_are_reduced() {
        let factors = [(1, 1), (2048, 2048), (2500, 1600), (2049, 2048), (4096, 4096), (20_000, 1), (8192, 4096)]
            .map(|(width, height)| factor(Size::new(width, height)));
        assert_eq!(factors, [1, 1, 1, 2, 2, 2, 3]);
    }

    #[test]
    fn blocks_are_means_also_where_they_are_cut() {
        let size = Size::new(5, 3);
        let picture = Image::from_channels(size, vec![(0..15).map(|i| i as f32).collect(); 3]);
        let scale = Scale { factor: 2, ..Scale::of(&picture) };
        let reduced = scale.reduce(&picture);
        assert_eq!(reduced.size(), Size::new(3, 2));
        assert_eq!(reduced.channels()[2], [3.0, 5.0, 6.5, 10.5, 12.5, 14.0]);
        let judged: Vec<bool> = (0..15).map(|i| i != 6 && i != 14).collect();
        assert_eq!(scale.reduce_judged(&judged), [false, true, true, true, true, false]);
        assert!(matches!(Scale::of(&picture).reduce(&picture), Cow::Borrowed(_)));
    }
}
