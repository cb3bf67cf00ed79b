//! Features, normalised and freed of noise before the regression uses them (the paper's sections 4.2 and 6).

mod normalise;
mod paths;
mod propagation;

use std::ops::Range;

use rayon::prelude::*;
use stack::{Cancelled, Fault, Feature, FeatureRole, FeatureStack, Monitor, Size};

use crate::nl_means::{Guide, nl_means};
use crate::patch_distance::{NoisyPlanes, PatchComparison};
use crate::variance::smoothed;
use normalise::NormalisedFeature;
pub(crate) use normalise::{normalised, normalised_halves};
use propagation::{Shape, propagation_filter, tile_count};

/// Features ready for regression: one plane per channel, all on comparable scales.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureSet {
    /// Width and height of every plane.
    pub size: Size,
    /// One plane per feature channel, row-major: within [−1, 1] as [`prefilter`] makes them, on natural scales in `best`.
    pub planes: Vec<Vec<f32>>,
    /// Which planes belong together (position, albedo, normal, …).
    pub groups: Vec<Range<usize>>,
}

stack::knob_choice! {
    /// How features are freed of noise.
    pub enum FeatureFilter {
        /// Not at all.
        Off = "off",
        /// The propagation filter on single pixels, after Chang and Wang 2015.
        Pixel = "pixel",
        /// The propagation filter on patches, the paper's.
        Patch = "patch",
        /// Non-local means, after Rousselle et al. 2013.
        NlMeans = "nl-means",
    }
}

stack::knob_choice! {
    /// What the variance of a feature that comes in buckets is estimated from.
    pub enum VarianceSource {
        /// The two half-buffers, as in the paper.
        Halves = "halves",
        /// The spread of all buckets, which is less noisy where there are more than two.
        Buckets = "buckets",
    }
}

stack::knobs! {
    /// How features are freed of noise before the regression.
    pub struct PrefilterSettings("prefilter") {
        /// Which filter: patch is the paper's, pixel compares single pixels (figures 6 and 7), nl-means is that of
        /// Rousselle et al. 2013, which Kalantari et al. 2015 use as well (figure 7), off leaves the noise in.
        filter: FeatureFilter = FeatureFilter::Patch, ..;
        /// Whether visibility is among the features (section 6); figure 3 is about what it is worth.
        visibility: bool = true, ..;
        /// Radius r of the pixels that are averaged (section 6): of a diamond, or with nl-means of a square.
        radius: usize = 5, 0..=32;
        /// Radius of the patches that are compared, in pixels: 3 makes patches of 7×7 (eq. 11).
        patch_radius: usize = 3, 0..=16;
        /// ε of the distance between pixels (eq. 10), in units of variance of features within [−1, 1]: keeps it finite
        /// where there is no noise, and lets differences well below √ε be averaged there.
        epsilon: f32 = 1e-4, 1e-30..=1.0;
        /// Bandwidth k of nl-means: weights are exp(−D/k²). Larger averages more.
        nl_bandwidth: f32 = 1.0, 0.01..=100.0;
        /// Where variance comes from: halves as in the paper, or buckets.
        variance_from: VarianceSource = VarianceSource::Halves, ..;
        /// Radius of the box that smooths the variance, in pixels.
        variance_radius: usize = 1, 0..=16;
    }
}

/// Features could not be prepared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PrefilterError {
    /// There is nothing to explain radiance by.
    #[error(
        "the stack has none of the features position, albedo, normal, visibility and depth: add some, or choose a \
         method that needs none"
    )]
    NoFeatures,
    /// A feature has another number of channels than its role.
    #[error(
        "feature '{feature}' has {found} channels where {expected} are expected: check which layers it is read from"
    )]
    Channels {
        /// Name of its layer.
        feature: &'static str,
        /// Channels its role has.
        expected: usize,
        /// Channels it has.
        found: usize,
    },
    /// A feature has another size than the stack.
    #[error("feature '{feature}' is {found} pixels large where the stack is {expected}: render both at one size")]
    Size {
        /// Name of its layer.
        feature: &'static str,
        /// Size of the stack.
        expected: Size,
        /// Its own size.
        found: Size,
    },
    /// The monitor stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl PrefilterError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::NoFeatures | Self::Channels { .. } | Self::Size { .. } => Fault::Input,
            Self::Cancelled(_) => Fault::Interrupted,
        }
    }
}

/// Takes the features of `stack` that the regression explains radiance by (position, or depth where there is none; albedo,
/// normal, visibility), maps them to [−1, 1] and filters each with weights of its own. A feature whose noise is unknown is only
/// mapped.
///
/// # Errors
/// When there are no features, when one does not fit its role or the stack, and when the monitor cancels.
pub fn prefilter(
    stack: &FeatureStack,
    settings: &PrefilterSettings,
    monitor: &dyn Monitor,
) -> Result<FeatureSet, PrefilterError> {
    let mut features = regressors(stack)?;
    features.retain(|feature| settings.visibility || feature.role != FeatureRole::Visibility);
    if features.is_empty() {
        return Err(PrefilterError::NoFeatures);
    }
    let tiles = tile_count(stack.size()) as u64;
    monitor.begin("prefilter", tiles * features.len() as u64);
    let noisy: Vec<NormalisedFeature> =
        features.par_iter().map(|feature| normalised(feature, &stack.samples, settings.variance_from)).collect();
    let mut set = FeatureSet { size: stack.size(), planes: Vec::new(), groups: Vec::new() };
    for feature in noisy {
        let planes = match filtered(&feature, stack.size(), settings, monitor)? {
            Some(planes) => planes,
            None => {
                monitor.advance(tiles);
                feature.planes
            }
        };
        set.groups.push(set.planes.len()..set.planes.len() + planes.len());
        set.planes.extend(planes);
    }
    Ok(set)
}

/// The features that a regression explains radiance by, checked: position, or depth where there is none, and all others
/// but those of what paths meet next.
pub(crate) fn regressors(stack: &FeatureStack) -> Result<Vec<&Feature>, PrefilterError> {
    let positioned = stack.feature(FeatureRole::Position).is_some();
    let is_regressor = |role: FeatureRole| !role.is_of_next_surface() && (role != FeatureRole::Depth || !positioned);
    let regressors: Vec<&Feature> = stack.features.iter().filter(|feature| is_regressor(feature.role)).collect();
    if regressors.is_empty() {
        return Err(PrefilterError::NoFeatures);
    }
    for feature in &regressors {
        check(feature, stack.size())?;
    }
    Ok(regressors)
}

/// Whether `feature` has as many channels as its role and the `size` of the stack.
pub(crate) fn check(feature: &Feature, size: Size) -> Result<(), PrefilterError> {
    let (name, mean) = (feature.role.layer(), &feature.estimate.mean);
    let (expected, found) = (feature.role.channels().len(), mean.channels().len());
    if found != expected {
        return Err(PrefilterError::Channels { feature: name, expected, found });
    }
    if mean.size() != size {
        return Err(PrefilterError::Size { feature: name, expected: size, found: mean.size() });
    }
    Ok(())
}

/// `feature` filtered; `None` when it is to be left as it is.
fn filtered(
    feature: &NormalisedFeature,
    size: Size,
    settings: &PrefilterSettings,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<Vec<f32>>>, Cancelled> {
    let variance = feature.variance.as_ref().and_then(|variance| smoothed(variance, settings.variance_radius));
    let Some(variance) = variance else { return Ok(None) };
    let planes = NoisyPlanes { size, values: &feature.planes, variances: variance.channels() };
    let PrefilterSettings { radius, patch_radius, epsilon, .. } = *settings;
    let propagate = |patch_radius| propagation_filter(planes, Shape { radius, patch_radius, epsilon }, monitor);
    let filtered = match settings.filter {
        FeatureFilter::Off => return Ok(None),
        FeatureFilter::Pixel => propagate(0),
        FeatureFilter::Patch => propagate(patch_radius),
        FeatureFilter::NlMeans => {
            let comparison = PatchComparison { patch_radius, epsilon, noise_taken_off: 1.0 };
            nl_means(&Guide { planes, comparison, radius }, settings.nl_bandwidth, planes.values, monitor)
        }
    };
    filtered.map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use stack::{Estimate, Image, Noise, SampleCounts, Silent, Window};

    const SIZE: Size = Size::new(48, 32);

    /// A feature whose two halves hold `value` with noise of deviation `sigma` each.
    fn noisy_feature(role: FeatureRole, value: f32, sigma: f32, counts: &SampleCounts) -> Feature {
        let mut noise = TestNoise(role as u64);
        let mut half = || {
            let channels = role.channels().iter().map(|_| noise.normals(SIZE.pixels(), value, sigma));
            Image::from_channels(SIZE, channels.collect())
        };
        Feature { role, estimate: Estimate::from_buckets(vec![half(), half()], counts) }
    }

    fn stack_of(roles: &[FeatureRole]) -> FeatureStack {
        let samples = SampleCounts::uniform(SIZE.pixels(), vec![8, 8]);
        let features = roles.iter().map(|role| noisy_feature(*role, 0.5, 0.05, &samples)).collect();
        FeatureStack {
            window: Window::whole(SIZE),
            film: SIZE,
            samples,
            components: Vec::new(),
            indirect: None,
            gathered: None,
            features,
            passthrough: Vec::new(),
        }
    }

    fn deviation(plane: &[f32]) -> f32 {
        let mean = plane.iter().sum::<f32>() / plane.len() as f32;
        (plane.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / plane.len() as f32).sqrt()
    }

    #[test]
    fn depth_stands_in_for_position_only() {
        use FeatureRole::{Albedo, Depth, Position, Visibility};
        let groups = |roles| prefilter(&stack_of(roles), &PrefilterSettings::DEFAULT, &Silent).unwrap().groups;
        assert_eq!(groups(&[Position, Albedo, Visibility, Depth]), [0..3, 3..6, 6..7]);
        assert_eq!(groups(&[Visibility, Depth]), [0..1, 1..2]);
    }

    #[test]
    fn noise_shrinks_by_patches_less_by_pixels_and_stays_when_off() {
        let stack = stack_of(&[FeatureRole::Visibility]);
        let left = |filter| {
            let settings = PrefilterSettings { filter, ..PrefilterSettings::DEFAULT };
            deviation(&prefilter(&stack, &settings, &Silent).unwrap().planes[0])
        };
        let (off, pixel, patch) = (left(FeatureFilter::Off), left(FeatureFilter::Pixel), left(FeatureFilter::Patch));
        let expected = 2.0 * 0.05 / 2.0_f32.sqrt();
        assert!((off / expected - 1.0).abs() < 0.1, "two halves, on a scale of 2: {off}");
        assert!(patch < 0.35 * off, "{patch}");
        assert!(pixel < off && pixel > patch, "{pixel}");
    }

    #[test]
    fn nl_means_shrink_noise_and_more_so_with_more_bandwidth() {
        let stack = stack_of(&[FeatureRole::Visibility]);
        let left = |filter, nl_bandwidth| {
            let settings = PrefilterSettings { filter, nl_bandwidth, ..PrefilterSettings::DEFAULT };
            deviation(&prefilter(&stack, &settings, &Silent).unwrap().planes[0])
        };
        let off = left(FeatureFilter::Off, 1.0);
        let [narrow, usual, wide] = [0.3, 1.0, 30.0].map(|k| left(FeatureFilter::NlMeans, k));
        assert!(usual < 0.35 * off && usual < narrow, "{off}, {narrow}, {usual}");
        // All 121 pixels of the window alike: the noise falls by √121, a little less at the border.
        assert!((0.8..1.6).contains(&(11.0 * wide / off)), "{wide}");
    }

    #[test]
    fn visibility_can_be_left_out() {
        use FeatureRole::{Normal, Visibility};
        let without = PrefilterSettings { visibility: false, ..PrefilterSettings::DEFAULT };
        let both = stack_of(&[Normal, Visibility]);
        let found = prefilter(&both, &without, &Silent).unwrap();
        assert_eq!(found, prefilter(&stack_of(&[Normal]), &PrefilterSettings::DEFAULT, &Silent).unwrap());
        let error = prefilter(&stack_of(&[Visibility]), &without, &Silent).unwrap_err();
        assert_eq!(error, PrefilterError::NoFeatures);
    }

    #[test]
    fn unknown_noise_leaves_a_feature_as_it_is() {
        let mut stack = stack_of(&[FeatureRole::Albedo, FeatureRole::Visibility]);
        let plain =
            prefilter(&stack, &PrefilterSettings { filter: FeatureFilter::Off, ..PrefilterSettings::DEFAULT }, &Silent)
                .unwrap();
        stack.features[0].estimate.noise = Noise::Unknown;
        let set = prefilter(&stack, &PrefilterSettings::DEFAULT, &Silent).unwrap();
        assert_eq!(set.planes[..3], plain.planes[..3]);
        assert_ne!(set.planes[3], plain.planes[3]);
        stack.features[1].estimate.noise =
            Noise::VarianceOfMean(Image::from_channels(SIZE, vec![vec![f32::NAN; 1536]]));
        assert_eq!(prefilter(&stack, &PrefilterSettings::DEFAULT, &Silent).unwrap(), plain);
    }

    #[test]
    fn errors_name_the_feature_and_the_fault() {
        let fail = |stack: &FeatureStack| prefilter(stack, &PrefilterSettings::DEFAULT, &Silent).unwrap_err();
        assert_eq!(fail(&stack_of(&[])).fault(), Fault::Input);
        let mut stack = stack_of(&[FeatureRole::Albedo]);
        stack.features[0].estimate.mean = Image::zeros(SIZE, 1);
        assert_eq!(fail(&stack), PrefilterError::Channels { feature: "albedo", expected: 3, found: 1 });
        stack.features[0].estimate.mean = Image::zeros(Size::new(2, 2), 3);
        assert!(fail(&stack).to_string().contains("2x2"));
    }

    #[test]
    fn cancelling_stops_the_filter() {
        struct Impatient;
        impl Monitor for Impatient {
            fn cancelled(&self) -> bool {
                true
            }
        }
        let error = prefilter(&stack_of(&[FeatureRole::Normal]), &PrefilterSettings::DEFAULT, &Impatient);
        assert_eq!(error.unwrap_err().fault(), Fault::Interrupted);
    }
}
