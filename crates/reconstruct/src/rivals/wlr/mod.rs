//! Weighted local regression (Moon, Carr, Yoon 2014: *Adaptive Rendering Based on Weighted Local Regression*).
//!
//! The steps are the same as those of our paper, which builds on it, and so is most of the code; what differs is here.
//! Features: column and row, depth, normal, albedo, as they were measured; a truncated singular value decomposition
//! drops what is noise (section 4). Bandwidths: five shared ones are tried, a model of bias and variance is fitted to the
//! results, and its minimum is used, smoothed over pixels (section 5, `error_model`). Neighbours: fireflies are held back
//! by two tricks of the authors' program (`trust`).

mod error_model;
mod row;
#[cfg(test)]
mod tests;
mod trust;

use pulp::WithSimd;
use stack::{Cancelled, FeatureRole, FeatureStack, Image, Monitor, Size};

use crate::Settings;
use crate::box_filter::box_mean;
use crate::pieces::of_each;
use crate::prefilter::FeatureSet;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::regression::RegressionInput;
use crate::regression::field::Field;
use crate::rivals::measured_features::{MeasuredFeatures, measured, whichever};
use error_model::ErrorModel;
use row::{Rebuild, RebuiltRow, Search, Shared};

stack::knobs! {
    /// Weighted local regression (Moon et al. 2014). Its window, curvature and ridge are those of ours.
    pub struct WlrSettings("wlr") {
        /// Directions are kept whose singular value exceeds this many times the norm of the features' noise (section 4).
        perturbation: f32 = 4.0, 0.0..=100.0;
        /// Added to that bound, so that empty directions go.
        thin: f32 = 0.01, 0.0..=10.0;
        /// A neighbour is left out whose grey value differs by more than this many standard deviations, those of both
        /// pixels added up.
        confidence: f32 = 3.0, 0.1..=1e6;
    }
}

/// Which of our paper's three versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// The method itself.
    Plain,
    /// With the pilot bandwidth of our paper instead of five bandwidths (its figure 2).
    Pilot,
    /// With visibility among the features (its figure 3).
    Visibility,
}

/// Columns and rows are counted in units of this many pixels.
const PIXEL_UNIT: f32 = 1.0 / 16.0;

/// Rebuilds `radiance`, three channels with the `variance` of its mean. The error map is that of the method's own model
/// at the bandwidth used; the pilot variant has the error of its one estimate.
///
/// # Errors
/// When there is no feature, one does not fit, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    radiance: &Image,
    variance: &Image,
    variant: Variant,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = features_of(stack, variant)?;
    let input = RegressionInput { colour: radiance, variance, features: &features.set, active: None };
    let radius = settings.regression.window.radius;
    let field = Field::new(&input, radius);
    let noise = noise_of_groups(&features, radius);
    let shared = Shared { field: &field, noise: &noise, wlr: &settings.wlr, regression: &settings.regression };
    Ok(match variant {
        Variant::Pilot => put_together(radiance.size(), &rebuilt_rows(shared, None, monitor)?),
        Variant::Plain | Variant::Visibility => {
            let rows = by_rows("bandwidth", field.size.height, monitor, |y| Search { shared, y })?;
            let models: Vec<ErrorModel> = rows.into_iter().flatten().collect();
            let best: Vec<f32> = models.iter().map(ErrorModel::best_bandwidth).collect();
            let bandwidth = smoothed(&best, field.size);
            let mut rebuilt = put_together(radiance.size(), &rebuilt_rows(shared, Some(&bandwidth), monitor)?);
            rebuilt.mse = models.iter().zip(&bandwidth).map(|(model, h)| model.mse(*h)).collect();
            rebuilt
        }
    })
}

/// Depth (position where there is none), normal, albedo, perhaps visibility; column and row.
fn features_of(stack: &FeatureStack, variant: Variant) -> Result<MeasuredFeatures, ReconstructError> {
    let place = whichever(stack, FeatureRole::Depth, FeatureRole::Position);
    let mut roles = vec![place, FeatureRole::Normal, FeatureRole::Albedo];
    if variant == Variant::Visibility {
        roles.push(FeatureRole::Visibility);
    }
    let mut features = measured(stack, &roles)?;
    features.add_exact(|x, _| x as f32 * PIXEL_UNIT);
    features.add_exact(|_, y| y as f32 * PIXEL_UNIT);
    Ok(features)
}

/// Mean over every window of each group's variance, summed over the group's channels.
fn noise_of_groups(features: &MeasuredFeatures, radius: usize) -> Vec<Vec<f32>> {
    let MeasuredFeatures { set: FeatureSet { size, groups, .. }, variances } = features;
    let summed = |group: &std::ops::Range<usize>| -> Vec<f32> {
        (0..size.pixels()).map(|i| variances[group.clone()].iter().map(|v| v[i]).sum()).collect()
    };
    groups.iter().map(|group| box_mean(&summed(group), *size, radius)).collect()
}

fn rebuilt_rows(
    shared: Shared,
    bandwidth: Option<&[f32]>,
    monitor: &dyn Monitor,
) -> Result<Vec<RebuiltRow>, Cancelled> {
    let size = shared.field.size;
    let of_row = |y: usize| bandwidth.map(|plane| &plane[y * size.width..(y + 1) * size.width]);
    by_rows("regression", size.height, monitor, |y| Rebuild { shared, y, bandwidth: of_row(y) })
}

/// What a task makes of each of so many `rows`. Reports one unit per row as stage `stage`.
fn by_rows<T: WithSimd<Output: Send>>(
    stage: &'static str,
    rows: usize,
    monitor: &dyn Monitor,
    task: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T::Output>, Cancelled> {
    let processor = pulp::Arch::new();
    monitor.begin(stage, rows as u64);
    of_each(0..rows, monitor, |y| processor.dispatch(task(y)))
}

fn put_together(size: Size, rows: &[RebuiltRow]) -> Reconstruction {
    let plane = |of: &dyn Fn(&RebuiltRow) -> &Vec<f32>| rows.iter().flat_map(|row| of(row).iter().copied()).collect();
    let picture = Image::from_channels(size, (0..3).map(|c| plane(&|row| &row.colour[c])).collect());
    let (bandwidth, rank) = (Some(plane(&|row| &row.bandwidth)), Some(plane(&|row| &row.rank)));
    Reconstruction { mse: plane(&|row| &row.mse), bandwidth, rank, ..Reconstruction::plain(picture) }
}

/// A Gaussian of one pixel's deviation over 7×7 pixels, as far as they lie inside the image.
fn smoothed(plane: &[f32], size: Size) -> Vec<f32> {
    let weights = [1.0, (-0.5_f32).exp(), (-2.0_f32).exp(), (-4.5_f32).exp()];
    let along = |plane: &[f32], step: usize, place: &dyn Fn(usize) -> (usize, usize)| -> Vec<f32> {
        let at = |i: usize| {
            let (place, length) = place(i);
            let (mut sum, mut weight) = (0.0, 0.0);
            for other in place.saturating_sub(3)..(place + 4).min(length) {
                let w = weights[other.abs_diff(place)];
                sum += w * plane[i + other * step - place * step];
                weight += w;
            }
            sum / weight
        };
        (0..plane.len()).map(at).collect()
    };
    let across = along(plane, 1, &|i| (i % size.width, size.width));
    along(&across, size.width, &|i| (i / size.width, size.height))
}
