//! Adaptive polynomial rendering (Moon, McDonagh, Mitchell, Gross 2016: *Adaptive Polynomial Rendering*).
//!
//! A block of pixels is explained by a polynomial of their position and by their features, which enter linearly
//! (section 3). Orders 0 to 3 are fitted to every block (`block`); the one of least estimated error is kept, the error
//! being squared bias plus variance, estimated in stages: first from the noisy block, then from the picture that the
//! stage before made (section 4). A block reconstructs all its pixels; where blocks overlap, their predictions are averaged
//! by the inverse of their errors. Spikes are parted from the picture first and their energy is given back at the end
//! (`outliers`).
//!
//! Where we know of no formula or program of the authors', this is ours: how a spike is told from detail; features come
//! from the propagation filter that ours uses, not from polynomials of their own; and blocks that contradict the pixels
//! they predict beyond their noise lose weight (`row`) and give way to them (`guard`), without which a few pixels at
//! lamps and black frames outweigh all others.

mod block;
mod factor;
mod guard;
mod outliers;
mod row;
#[cfg(test)]
mod tests;

use stack::{Cancelled, FeatureStack, Image, Monitor};

use crate::Settings;
use crate::pieces::of_each;
use crate::prefilter::{FeatureSet, prefilter};
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::regression::RegressionInput;
use crate::regression::field::Field;
use block::{Fitted, ORDERS};
use row::{Predictions, RowOfBlocks, SUMS};

stack::knobs! {
    /// Adaptive polynomial rendering (Moon et al. 2016).
    pub struct AprSettings("apr") {
        /// Radius r of the blocks of (2r+1)² pixels.
        radius: usize = 7, 2..=31;
        /// Blocks stand around the pixels of every n-th row; this is n.
        stride: usize = 2, 1..=16;
        /// Highest order of the polynomials (section 3).
        highest_order: usize = 3, 0..=3;
        /// Stages of the error estimate (section 4).
        stages: usize = 2, 1..=5;
        /// A pixel is parted as an outlier that exceeds its neighbours' mean by this many of their standard deviations.
        outlier: f32 = 5.0, 1.0..=1e6;
    }
}

/// Rows of blocks whose sums are held before they are added to the picture, in order.
const WAVE: usize = 32;

/// Rebuilds `radiance`, three channels with the `variance` of its mean. The error map is the blocks' own estimate.
///
/// # Errors
/// When there is no feature, one does not fit, or `monitor` cancels.
pub fn rebuild(
    stack: &FeatureStack,
    radiance: &Image,
    variance: &Image,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Reconstruction, ReconstructError> {
    let features = prefilter(stack, &settings.prefilter, monitor)?;
    let AprSettings { radius, outlier, .. } = settings.apr;
    let parted = outliers::part(radiance, variance, outlier, radius);
    let fit = fit_polynomials(&parted.colour, &parted.variance, &features, &settings.apr, monitor)?;
    let (mut picture, mut mse) = (fit.picture, fit.mse);
    guard::hold_to_input(&mut picture, &mut mse, &parted.colour, &parted.variance);
    picture.add(&parted.energy);
    for channel in picture.channels_mut() {
        channel.iter_mut().for_each(|value| *value = value.max(0.0));
    }
    Ok(Reconstruction { mse, marked: parted.count, ..Reconstruction::plain(picture) })
}

/// A picture put together from blocks.
#[derive(Clone, Debug)]
struct PolynomialFit {
    picture: Image,
    /// Estimated mean squared error, mean over RGB.
    mse: Vec<f32>,
    /// How many blocks chose each order, in the last stage.
    #[cfg_attr(not(test), expect(dead_code, reason = "only tests look at it"))]
    chosen: [usize; ORDERS],
}

/// All stages. Reports one unit per row of blocks and stage as stage `regression`.
fn fit_polynomials(
    colour: &Image,
    variance: &Image,
    features: &FeatureSet,
    settings: &AprSettings,
    monitor: &dyn Monitor,
) -> Result<PolynomialFit, Cancelled> {
    let input = RegressionInput { colour, variance, features, active: None };
    let field = Field::new(&input, settings.radius);
    let nothing = FeatureSet { size: features.size, planes: Vec::new(), groups: Vec::new() };
    let rows = centre_rows(field.size.height, stride(settings));
    monitor.begin("regression", (rows.len() * settings.stages) as u64);
    let mut fit: Option<PolynomialFit> = None;
    for _ in 0..settings.stages.max(1) {
        let previous = fit.as_ref().map(|fit| {
            let input = RegressionInput { colour: &fit.picture, variance, features: &nothing, active: None };
            Field::new(&input, settings.radius)
        });
        let fitted = Fitted { field: &field, previous: previous.as_ref(), highest: settings.highest_order };
        fit = Some(one_stage(fitted, &rows, monitor)?);
    }
    fit.ok_or(Cancelled)
}

/// Distance between centres: no more than leaves every pixel in a block, those at the border, too.
fn stride(settings: &AprSettings) -> usize {
    settings.stride.min(settings.radius + 1)
}

/// Rows whose pixels are centres of blocks: every `stride`-th, spread evenly.
fn centre_rows(height: usize, stride: usize) -> Vec<usize> {
    let first = (stride / 2).min(height.saturating_sub(1));
    (first..height).step_by(stride).collect()
}

fn one_stage(fitted: Fitted, rows: &[usize], monitor: &dyn Monitor) -> Result<PolynomialFit, Cancelled> {
    let size = fitted.field.size;
    let processor = pulp::Arch::new();
    let mut sums = vec![vec![0.0; size.pixels()]; SUMS];
    let mut chosen = [0; ORDERS];
    for wave in rows.chunks(WAVE) {
        for predictions in of_each(wave, monitor, |y| processor.dispatch(RowOfBlocks { fitted, y: *y }))? {
            predictions.orders.iter().for_each(|order| chosen[*order] += 1);
            predictions.add_to(&mut sums, size.width, fitted.field.radius);
        }
    }
    Ok(averaged(sums, size, chosen))
}

impl Predictions {
    /// Adds the sums to those of the whole picture.
    fn add_to(&self, sums: &mut [Vec<f32>], width: usize, radius: usize) {
        for (row, y) in self.rows.clone().enumerate() {
            for (i, plane) in sums.iter_mut().enumerate() {
                let from = &self.sums[(row * SUMS + i) * self.stride + radius..][..width];
                plane[y * width..(y + 1) * width].iter_mut().zip(from).for_each(|(to, from)| *to += from);
            }
        }
    }
}

fn averaged(mut sums: Vec<Vec<f32>>, size: stack::Size, chosen: [usize; ORDERS]) -> PolynomialFit {
    let weights = sums.pop().unwrap_or_default();
    for plane in &mut sums {
        plane.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum /= weight);
    }
    let mse = sums.pop().unwrap_or_default();
    PolynomialFit { picture: Image::from_channels(size, sums), mse, chosen }
}
