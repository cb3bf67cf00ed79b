//! Blocks whose polynomials cannot follow the picture give way to it.

use stack::Image;

use crate::box_filter::box_mean;

/// Squared distances of up to this many variances are noise.
const EXPLAINED: f32 = 4.0;

/// Draws `fit` towards the noisy `colour` where it is further from it than the `variance` of its mean explains: the
/// result is y + w (x − y) with w = 4v/max(4v, (x − y)²) over 3×3 pixels, means over RGB. The error map `mse` is mixed in
/// the same way with the variance.
pub(crate) fn hold_to_input(fit: &mut Image, mse: &mut [f32], colour: &Image, variance: &Image) {
    let (size, pixels) = (fit.size(), fit.pixels());
    let noise = box_mean(&(0..pixels).map(|pixel| variance.mean_at(pixel)).collect::<Vec<_>>(), size, 1);
    let distance = |pixel: usize| {
        let (x, y) = (fit.rgb(pixel), colour.rgb(pixel));
        (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f32>() / 3.0
    };
    let distances = box_mean(&(0..pixels).map(distance).collect::<Vec<_>>(), size, 1);
    for pixel in 0..pixels {
        let explained = EXPLAINED * noise[pixel];
        if distances[pixel] > explained {
            let weight = explained / distances[pixel];
            for (x, y) in fit.channels_mut().iter_mut().zip(colour.channels()) {
                x[pixel] = y[pixel] + weight * (x[pixel] - y[pixel]);
            }
            mse[pixel] = weight * mse[pixel] + (1.0 - weight) * noise[pixel];
        }
    }
}

#[cfg(test)]
mod tests {
    use stack::Size;

    use super::*;

    fn flat(value: f32) -> Image {
        Image::from_channels(Size::new(4, 4), vec![vec![value; 16]; 3])
    }

    #[test]
    fn noise_changes_nothing_and_contradiction_almost_everything() {
        let (mut near, mut mse) = (flat(1.1), vec![0.01; 16]);
        hold_to_input(&mut near, &mut mse, &flat(1.0), &flat(0.01));
        assert_eq!((near, mse), (flat(1.1), vec![0.01; 16]));
        let (mut far, mut mse) = (flat(3.0), vec![0.0; 16]);
        hold_to_input(&mut far, &mut mse, &flat(1.0), &flat(0.01));
        // A squared distance of 4 against 0.04.
        assert!(far.channels()[0].iter().all(|v| (v - 1.02).abs() < 1e-5));
        assert!(mse.iter().all(|v| (v - 0.0099).abs() < 1e-6));
    }
}
