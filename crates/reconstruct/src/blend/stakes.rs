//! What is at stake where two pictures differ in brightness.

use stack::Image;

use crate::ln::ln;

/// Added to squared luminance, as in relative errors.
const EPSILON: f32 = 1e-3;

/// Brightness beyond this ratio of squared luminance makes no more difference: a black picture must not win by being black.
const MOST: f32 = 100.0;

/// What is added to the logit of the other picture's weight at every pixel: ln (x² + ε)/(g² + ε), of luminance.
///
/// Errors count relative to the truth. If that is as the other picture g with probability p, and else as the picture x, a mixture m
/// costs p (m − g)²/(g² + ε) + (1 − p)(m − x)²/(x² + ε) in the mean. The least costs a weight whose odds are those of p
/// times (x² + ε)/(g² + ε): what is too bright by far, a firefly of one of the two, costs more than what is too dark.
pub fn stakes(picture: &Image, other: &Image) -> Vec<f32> {
    let square = |image: &Image, pixel: usize| image.mean_at(pixel).powi(2) + EPSILON;
    let ratio = |pixel| (square(picture, pixel) / square(other, pixel)).clamp(1.0 / MOST, MOST);
    (0..picture.pixels()).map(|pixel| ln(ratio(pixel))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn they_make_the_expected_relative_error_least() {
        let flat = |v: f32| Image::from_channels(Size::new(1, 1), vec![vec![v]; 3]);
        for (x, g, p) in [(0.3_f64, 0.2_f64, 0.5_f64), (1.0, 4.0, 0.3), (0.02, 0.05, 0.9)] {
            let stake = f64::from(stakes(&flat(x as f32), &flat(g as f32))[0]);
            let weight = 1.0 / (1.0 + ((1.0 - p) / p) * (-stake).exp());
            let cost = |w: f64| {
                let m = x + w * (g - x);
                p * (m - g).powi(2) / (g * g + 1e-3) + (1.0 - p) * (m - x).powi(2) / (x * x + 1e-3)
            };
            assert!(cost(weight) < cost(weight + 0.01) && cost(weight) < cost(weight - 0.01), "{x} {g}");
        }
        assert_eq!(stakes(&flat(50.0), &flat(0.0)), [ln(MOST)]);
    }
}
