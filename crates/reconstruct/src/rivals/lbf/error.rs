//! How far a filtered picture is off. The paper has no such estimate; this is ours.
//!
//! For a filter whose weights were no matter of chance, (ĉ − c)² + 2 cov(ĉ, c) − var(c) has the mean of the squared
//! error (Stein's unbiased estimate), and cov(ĉ, c) is the pixel's own share of the weights times var(c). It is as noisy as
//! the picture, so it is averaged over 7×7 pixels, and never below the variance of the filtered pixel. That weights
//! follow the noise of the colours is left out: it makes the estimate too low where the noise is strong.

use stack::Size;

use super::filter::FilteredRow;
use super::primary::Primary;
use crate::box_filter::box_mean;

/// Radius of the average.
const RADIUS: usize = 3;

/// Estimated squared error of every pixel, mean over RGB.
pub(super) fn estimated_error(primary: &Primary, rows: &[FilteredRow]) -> Vec<f32> {
    let size: Size = primary.size;
    let at = |pixel: usize| {
        let (row, x) = (&rows[pixel / size.width], pixel % size.width);
        let change = (0..3).map(|c| (row.colour[c][x] - primary.colour[c][pixel]).powi(2)).sum::<f32>() / 3.0;
        change + (2.0 / row.weight[x] - 1.0) * primary.colour_variance[pixel]
    };
    let risk: Vec<f32> = (0..size.pixels()).map(at).collect();
    let variance = rows.iter().flat_map(|row| &row.variance);
    box_mean(&risk, size, RADIUS).iter().zip(variance).map(|(risk, least)| risk.max(*least)).collect()
}
