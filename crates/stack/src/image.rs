//! Planar images and the rectangle of the film they cover.

use serde::{Deserialize, Serialize};

/// Width and height of an image, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Size {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Size {
    /// A size of `width` × `height` pixels.
    pub const fn new(width: usize, height: usize) -> Self {
        Self { width, height }
    }

    /// How many pixels there are.
    pub const fn pixels(self) -> usize {
        self.width * self.height
    }

    /// Index of the pixel in column `x`, row `y` of a row-major plane.
    #[inline]
    pub const fn index(self, x: usize, y: usize) -> usize {
        y * self.width + x
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// The part of the film an image covers: an offset from the film's top left corner, and a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// Column of the leftmost pixel on the film.
    pub x: i32,
    /// Row of the topmost pixel on the film.
    pub y: i32,
    /// Size of the window.
    pub size: Size,
}

impl Window {
    /// The window that covers a whole film of `size`.
    pub const fn whole(size: Size) -> Self {
        Self { x: 0, y: 0, size }
    }
}

/// A planar image: some channels of `f32`, each row-major with its origin at the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    size: Size,
    channels: Vec<Vec<f32>>,
}

impl Image {
    /// An image of zeros.
    pub fn zeros(size: Size, channels: usize) -> Self {
        Self { size, channels: planes_of_zeros(size.pixels(), channels) }
    }

    /// Wraps `channels`, each of which must hold `size.pixels()` values.
    ///
    /// # Panics
    /// When a channel has another length: that is a mistake in the calling code.
    pub fn from_channels(size: Size, channels: Vec<Vec<f32>>) -> Self {
        for channel in &channels {
            assert_eq!(channel.len(), size.pixels(), "a channel must cover the image");
        }
        Self { size, channels }
    }

    /// Width and height.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// How many pixels each channel holds.
    pub const fn pixels(&self) -> usize {
        self.size.pixels()
    }

    /// All channels, in order.
    pub fn channels(&self) -> &[Vec<f32>] {
        &self.channels
    }

    /// All channels, to write.
    pub fn channels_mut(&mut self) -> &mut [Vec<f32>] {
        &mut self.channels
    }

    /// Takes the channels out.
    pub fn into_channels(self) -> Vec<Vec<f32>> {
        self.channels
    }

    /// The values of pixel `index` in the first three channels.
    ///
    /// # Panics
    /// When the image has fewer than three channels.
    #[inline]
    pub fn rgb(&self, index: usize) -> [f32; 3] {
        [self.channels[0][index], self.channels[1][index], self.channels[2][index]]
    }

    /// Mean of all channels at pixel `index`; of three colour channels, what the paper and we call luminance.
    #[inline]
    pub fn mean_at(&self, index: usize) -> f32 {
        self.channels.iter().map(|c| c[index]).sum::<f32>() / self.channels.len() as f32
    }

    /// Adds `other` to this image, value by value.
    ///
    /// # Panics
    /// When sizes or channel counts differ.
    pub fn add(&mut self, other: &Image) {
        assert_eq!((self.size, self.channels.len()), (other.size, other.channels.len()));
        for (mine, theirs) in self.channels.iter_mut().zip(&other.channels) {
            for (a, b) in mine.iter_mut().zip(theirs) {
                *a += b;
            }
        }
    }
}

/// So many planes of zeros. Each is allocated by itself: the system hands out large ones zeroed, whereas copies of one are
/// written on a single thread.
pub fn planes_of_zeros(pixels: usize, planes: usize) -> Vec<Vec<f32>> {
    (0..planes).map(|_| vec![0.0; pixels]).collect()
}
