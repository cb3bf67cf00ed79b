//! What the filter compares: the paper's primary features, and the noise in units of which their differences are taken.

use stack::{Feature, FeatureRole, FeatureStack, Image, Monitor, Size};

use super::statistics::squared_step;
use crate::box_filter::{box_mean, fill_unknown};
use crate::prefilter::{FeatureFilter, FeatureSet, PrefilterSettings, prefilter, regressors};
use crate::reconstruction::ReconstructError;
use crate::rivals::measured_features::measured;

/// Kinds of features: place (position, or depth), albedo, normal, visibility.
pub const FEATURES: usize = 4;
/// Where position or depth stand.
pub(super) const PLACE: usize = 0;
/// Where albedo stands.
pub(super) const ALBEDO: usize = 1;
/// Where visibility stands.
pub(super) const VISIBILITY: usize = 3;

/// δ: added to the variance of every feature, in units of features in [−1, 1].
const FEATURE_FLOOR: f32 = 1e-4;
/// ζ: added to the variance of colours, relative to the mean squared colour of the picture.
const COLOUR_FLOOR: f32 = 1e-10;

/// The planes of a stack that the filter looks at.
#[derive(Clone, Debug)]
pub struct Primary {
    /// Width and height of every plane.
    pub(super) size: Size,
    /// Radiance, finite.
    pub(super) colour: [Vec<f32>; 3],
    /// ψ² of colours: variance of the mean, averaged over RGB and 3×3 pixels, with ζ.
    pub(super) colour_variance: Vec<f32>,
    /// Prefiltered, normalised features; no plane of a kind that the stack has not.
    pub(super) features: [Vec<Vec<f32>>; FEATURES],
    /// Variance of each kind before filtering, averaged over its planes and 3×3 pixels; no value of a kind that is not
    /// there.
    pub(super) feature_variance: [Vec<f32>; FEATURES],
    /// ψ² + δ of each kind; for the place, whose unit is the scene's, plus the squared step between neighbours.
    pub(super) feature_scale: [Vec<f32>; FEATURES],
    /// Samples of each pixel.
    pub(super) samples: Vec<f32>,
}

impl Primary {
    /// Prepares `radiance`, three channels with the `variance` of its mean, and the features of `stack`, which the
    /// paper's own filter (non-local means) frees of noise.
    ///
    /// # Errors
    /// When there is no feature, one does not fit, or `monitor` cancels.
    pub fn new(
        stack: &FeatureStack,
        radiance: &Image,
        variance: &Image,
        settings: &PrefilterSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReconstructError> {
        let size = stack.size();
        let settings = PrefilterSettings { filter: FeatureFilter::NlMeans, visibility: true, ..*settings };
        let mut primary = Self {
            size,
            colour: finite(radiance),
            colour_variance: Vec::new(),
            features: Default::default(),
            feature_variance: Default::default(),
            feature_scale: Default::default(),
            samples: stack.samples.total.iter().map(|n| *n as f32).collect(),
        };
        primary.colour_variance = primary.noise_of_colour(variance);
        let filtered = prefilter(stack, &settings, monitor)?;
        for (feature, planes) in regressors(stack)?.into_iter().zip(&filtered.groups) {
            primary.add(stack, feature, &filtered, planes.clone())?;
        }
        Ok(primary)
    }

    fn noise_of_colour(&self, variance: &Image) -> Vec<f32> {
        let variance: Vec<f32> = (0..self.size.pixels()).map(|pixel| variance.mean_at(pixel)).collect();
        let variance = variance.iter().map(|v| if v.is_finite() { *v } else { f32::NAN }).collect::<Vec<_>>();
        let squares = self.colour.iter().flatten().map(|v| f64::from(*v) * f64::from(*v)).sum::<f64>();
        let floor = (squares / (3 * self.size.pixels()).max(1) as f64) as f32 * COLOUR_FLOOR;
        let floor = floor.max(f32::MIN_POSITIVE);
        box_mean(&variance, self.size, 1).iter().map(|v| v.max(0.0) + floor).collect()
    }

    fn add(
        &mut self,
        stack: &FeatureStack,
        feature: &Feature,
        filtered: &FeatureSet,
        planes: std::ops::Range<usize>,
    ) -> Result<(), ReconstructError> {
        let kind = kind_of(feature.role);
        let noise = measured(stack, &[feature.role])?.variances;
        let share = 1.0 / noise.len() as f32;
        let mean: Vec<f32> =
            (0..self.size.pixels()).map(|p| noise.iter().map(|plane| plane[p]).sum::<f32>() * share).collect();
        let variance = box_mean(&mean, self.size, 1);
        let planes = filtered.planes[planes].to_vec();
        let mut scale: Vec<f32> = variance.iter().map(|v| v + FEATURE_FLOOR).collect();
        if kind == PLACE {
            // A pixel is a pixel, however large the scene: δ would be metres in one and nothing in another.
            scale = variance.iter().zip(squared_step(&planes, self.size)).map(|(v, s)| v + s + 1e-8).collect();
        }
        self.features[kind] = planes;
        self.feature_variance[kind] = variance;
        self.feature_scale[kind] = scale;
        Ok(())
    }
}

fn kind_of(role: FeatureRole) -> usize {
    match role {
        FeatureRole::Position | FeatureRole::Depth => PLACE,
        FeatureRole::Albedo => ALBEDO,
        FeatureRole::Normal => 2,
        // What lies next is no feature of any rival.
        FeatureRole::Visibility | FeatureRole::Proximity | FeatureRole::Lit => VISIBILITY,
    }
}

/// The channels of `radiance`; a value that is not finite is taken from its neighbours.
fn finite(radiance: &Image) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|c| {
        let mut plane: Vec<f32> =
            radiance.channels()[c].iter().map(|v| if v.is_finite() { *v } else { f32::NAN }).collect();
        fill_unknown(&mut plane, radiance.size());
        plane.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
        plane
    })
}
