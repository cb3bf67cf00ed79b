//! Exposures at which HDR-FLIP looks at two pictures, and the tone mapping there (Andersson et al. 2021).

/// The ACES curve as fitted by K. Narkowicz, without its factor of 0.6: (a x² + b x)/(c x² + d x + e), as a, b, c, d, e.
const ACES: [f64; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// Displayed luminance that the brightest and the median pixel are brought to.
const TARGET: f64 = 0.85;

/// Displayed value, from 0 to 1, of a linear radiance lifted by `stops`.
pub fn tone_map(radiance: f64, stops: f64) -> f32 {
    let [a, b, c, d, e] = ACES;
    let x = radiance * stops.exp2();
    let shown = (a * x * x + b * x) / (c * x * x + d * x + e);
    shown.clamp(0.0, 1.0) as f32
}

/// Even steps of about a stop from the exposure that shows the brightest luminance at [`TARGET`] to the one that shows
/// the median there, at least two. None when all is black.
pub fn exposures(mut luminances: Vec<f64>) -> Vec<f64> {
    luminances.sort_unstable_by(f64::total_cmp);
    let Some(&brightest) = luminances.last().filter(|brightest| **brightest > 0.0) else { return Vec::new() };
    // More than half of the picture may be black.
    let median = luminances[luminances.len() / 2].max(f64::from(f32::EPSILON));
    let first = (shown_at_target() / brightest).log2();
    let last = (shown_at_target() / median).log2().max(first);
    let count = (last - first).ceil().max(2.0);
    (0..count as usize).map(|i| first + i as f64 * (last - first) / (count - 1.0)).collect()
}

/// The value that the curve maps to [`TARGET`]: the larger root of a quadratic.
fn shown_at_target() -> f64 {
    let [a, b, c, d, e] = ACES;
    let (square, linear, constant) = (a - TARGET * c, b - TARGET * d, -TARGET * e);
    let middle = -0.5 * linear / square;
    middle + (middle * middle - constant / square).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brightest_and_the_median_pixel_end_at_the_target() {
        let found = exposures(vec![0.0, 0.1, 0.5, 3.0, 40.0]);
        assert!((tone_map(40.0, found[0]) - 0.85).abs() < 1e-6);
        assert!((tone_map(0.5, found[found.len() - 1]) - 0.85).abs() < 1e-6);
        assert_eq!(found.len(), 7, "six stops and a third");
        assert_eq!(tone_map(0.0, 3.0), 0.0);
        assert_eq!(tone_map(f64::from(f32::MAX), 20.0), 1.0);
    }

    #[test]
    fn black_has_none_and_one_grey_has_two() {
        assert!(exposures(vec![0.0; 9]).is_empty() && exposures(vec![]).is_empty());
        let found = exposures(vec![1e-12; 9]);
        assert_eq!((found.len(), found[0]), (2, found[1]));
    }
}
