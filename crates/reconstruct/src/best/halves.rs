//! Arithmetic of pictures that come in halves.

use stack::{Image, Size};

use crate::per_pixel::plane;

/// Two images of `size` whose six planes are `planes`, however they are grouped.
pub fn halves_of(size: Size, planes: Vec<Vec<Vec<f32>>>) -> [Image; 2] {
    let mut planes = planes.into_iter().flatten();
    [0, 1].map(|_| Image::from_channels(size, planes.by_ref().take(3).collect()))
}

/// Sum of two images.
pub fn sum_of([a, b]: &[Image; 2]) -> Image {
    let mut sum = a.clone();
    sum.add(b);
    sum
}

/// Mean of two halves.
pub fn mean_of(halves: &[Image; 2]) -> Image {
    let [a, b] = halves.each_ref().map(Image::channels);
    let mean = |(a, b): (&Vec<f32>, &Vec<f32>)| plane(a.len(), |pixel| 0.5 * (a[pixel] + b[pixel]));
    Image::from_channels(halves[0].size(), a.iter().zip(b).map(mean).collect())
}

/// Mean over RGB of every pixel.
pub fn luminance(image: &Image) -> Vec<f32> {
    plane(image.pixels(), |pixel| image.mean_at(pixel))
}
