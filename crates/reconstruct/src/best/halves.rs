//! Arithmetic of pictures that come in halves.

use stack::Image;

/// Sum of two images.
pub fn sum_of([a, b]: &[Image; 2]) -> Image {
    let mut sum = a.clone();
    sum.add(b);
    sum
}

/// Mean of two halves.
pub fn mean_of(halves: &[Image; 2]) -> Image {
    let [a, b] = [0, 1].map(|half: usize| halves[half].channels());
    let channels = a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect());
    Image::from_channels(halves[0].size(), channels.collect())
}

/// Mean over RGB of every pixel.
pub fn luminance(image: &Image) -> Vec<f32> {
    (0..image.pixels()).map(|pixel| image.mean_at(pixel)).collect()
}
