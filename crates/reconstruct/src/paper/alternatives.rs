//! Every alternative of the paper's method: each setting of its stages changes what it says, and nothing that does not
//! depend on it.

use stack::{
    Component, ComponentRole, Estimate, Feature, FeatureRole, FeatureStack, Image, Knobs, SampleCounts, Silent, Size,
    Window,
};

use crate::Settings;
use crate::prefilter::{FeatureSet, PrefilterSettings, prefilter};
use crate::regression::twin::Scene;
use crate::regression::{Regression, RegressionInput, RegressionSettings, regress};
use crate::spikes::{SpikeFree, SpikeSettings, remove_spikes};
use crate::test_noise::TestNoise;

const SIZE: Size = Size::new(36, 28);

/// What the stages find.
struct Found {
    spikes: SpikeFree,
    features: FeatureSet,
    regression: Regression,
}

/// What can differ between two runs. Rank and bandwidth rest on the features only, the picture on all.
const FINDINGS: [&str; 5] = ["spikes", "features", "rank", "bandwidth", "picture"];

type Flags = &'static [(&'static str, &'static str)];

/// Settings to start from, the flag and value to change, and which findings may change first: those after them follow or
/// not, those that are not named and come before must not.
struct Alternative(Flags, (&'static str, &'static str), &'static [&'static str]);

const SPIKES: &[&str] = &["spikes", "picture"];
const FEATURES: &[&str] = &["features", "rank", "bandwidth", "picture"];
const SPACE: &[&str] = &["rank", "bandwidth", "picture"];
const BANDWIDTH: &[&str] = &["bandwidth", "picture"];
const PICTURE: &[&str] = &["picture"];

const ALTERNATIVES: &[Alternative] = &[
    Alternative(&[], ("spike-removal", "false"), SPIKES),
    Alternative(&[], ("spike-method", "lbf"), SPIKES),
    Alternative(&[("spike-method", "lbf")], ("spike-deviations", "1.5"), SPIKES),
    Alternative(&[], ("spike-threshold", "0.5"), SPIKES),
    Alternative(&[], ("spike-threshold-unit", "log-average"), SPIKES),
    Alternative(&[("spike-threshold", "1")], ("spike-tile-size", "12"), SPIKES),
    Alternative(&[], ("spike-iterations", "20"), SPIKES),
    Alternative(&[("spike-threshold", "1")], ("spike-order", "low-rank-first"), SPIKES),
    Alternative(&[], ("spike-lambda", "0.2"), SPIKES),
    Alternative(&[("spike-iterations", "20")], ("spike-tolerance", "1"), SPIKES),
    Alternative(&[], ("prefilter-filter", "off"), FEATURES),
    Alternative(&[], ("prefilter-filter", "pixel"), FEATURES),
    Alternative(&[], ("prefilter-filter", "nl-means"), FEATURES),
    Alternative(&[], ("prefilter-visibility", "false"), FEATURES),
    Alternative(&[], ("prefilter-radius", "2"), FEATURES),
    Alternative(&[], ("prefilter-patch-radius", "1"), FEATURES),
    Alternative(&[], ("prefilter-epsilon", "0.1"), FEATURES),
    Alternative(&[("prefilter-filter", "nl-means")], ("prefilter-nl-bandwidth", "0.4"), FEATURES),
    Alternative(&[], ("prefilter-variance-from", "buckets"), FEATURES),
    Alternative(&[], ("prefilter-variance-radius", "3"), FEATURES),
    Alternative(&[], ("window-radius", "5"), SPACE),
    Alternative(&[], ("window-normalise", "none"), SPACE),
    Alternative(&[], ("reduce-method", "svd"), SPACE),
    Alternative(&[], ("reduce-iterations", "1"), SPACE),
    Alternative(&[], ("reduce-tolerance", "0.3"), SPACE),
    Alternative(&[], ("reduce-order", "a-first"), SPACE),
    Alternative(&[], ("reduce-lambda", "three-over-root"), SPACE),
    Alternative(&[], ("reduce-lambda", "shortest-side"), SPACE),
    Alternative(&[], ("reduce-stride", "1"), SPACE),
    Alternative(&[], ("reduce-energy", "0.999"), SPACE),
    Alternative(&[("reduce-method", "svd")], ("reduce-energy-of", "squares"), SPACE),
    Alternative(&[("reduce-lambda", "shortest-side")], ("reduce-rank", "perturbation"), SPACE),
    Alternative(
        &[("reduce-energy", "0"), ("reduce-perturbation", "0.1"), ("reduce-lambda", "shortest-side")],
        ("reduce-rank", "energy"),
        SPACE,
    ),
    Alternative(
        &[("reduce-rank", "perturbation"), ("reduce-lambda", "shortest-side")],
        ("reduce-perturbation", "0.1"),
        SPACE,
    ),
    Alternative(&[], ("bandwidth-fixed", "1"), BANDWIDTH),
    Alternative(&[], ("curvature-adaptive", "false"), PICTURE),
    Alternative(&[], ("curvature-ridge", "0.5"), PICTURE),
    Alternative(&[], ("curvature-floor", "2"), PICTURE),
    Alternative(&[], ("regression-ridge", "0.5"), PICTURE),
];

/// A noisy picture with fireflies, its noise and its features known from four buckets.
fn stack() -> FeatureStack {
    let (scene, mut noise) = (Scene::new(SIZE, 0.0), TestNoise(3));
    let samples = SampleCounts::uniform(SIZE.pixels(), vec![4; 4]);
    let mut noisy = |planes: &[Vec<f32>], scale: f32, shift: f32, sigma: f32| {
        let mut bucket = || {
            let plane =
                |plane: &Vec<f32>| plane.iter().map(|v| scale * v + shift + sigma * noise.normal() as f32).collect();
            Image::from_channels(SIZE, planes.iter().map(plane).collect())
        };
        (0..4).map(|_| bucket()).collect::<Vec<Image>>()
    };
    let mut buckets = noisy(scene.clean.channels(), 1.0, 0.0, 0.1);
    for (i, pixel) in (17..SIZE.pixels()).step_by(97).enumerate() {
        buckets[i % 4].channels_mut()[i % 3][pixel] += 5.0 + 3.0 * (i % 5) as f32;
    }
    let roles = [FeatureRole::Position, FeatureRole::Albedo, FeatureRole::Normal, FeatureRole::Visibility];
    let features = roles.into_iter().zip(&scene.features.groups).map(|(role, group)| {
        let ranged = matches!(role, FeatureRole::Albedo | FeatureRole::Visibility);
        let (scale, shift) = if ranged { (0.5, 0.5) } else { (1.0, 0.0) };
        let buckets = noisy(&scene.features.planes[group.clone()], scale, shift, 0.05);
        Feature { role, estimate: Estimate::from_buckets(buckets, &samples) }
    });
    let features = features.collect();
    let radiance = Estimate::from_buckets(buckets, &samples);
    FeatureStack {
        window: Window::whole(SIZE),
        film: SIZE,
        components: vec![Component { role: ComponentRole::Scattered, radiance }],
        indirect: None,
        gathered: None,
        samples,
        features,
        passthrough: Vec::new(),
    }
}

fn settings(flags: impl IntoIterator<Item = (&'static str, &'static str)>) -> Settings {
    let mut settings = Settings::default();
    for (flag, value) in flags {
        settings.set(flag, value).unwrap_or_else(|| panic!("no flag --{flag}")).unwrap();
    }
    settings
}

fn run(stack: &FeatureStack, settings: &Settings) -> Found {
    let radiance = &stack.components[0].radiance;
    let variance = radiance.variance_of_mean(&stack.samples).unwrap();
    let spikes = remove_spikes(&radiance.mean, &variance, &settings.spikes, &Silent).unwrap();
    let features = prefilter(stack, &settings.prefilter, &Silent).unwrap();
    let input =
        RegressionInput { colour: &spikes.colour, variance: &spikes.variance, features: &features, active: None };
    let regression = regress(&input, &settings.regression, &Silent).unwrap();
    Found { spikes, features, regression }
}

impl Found {
    /// Which of [`FINDINGS`] differ.
    fn differences(&self, other: &Self) -> Vec<&'static str> {
        let (a, b) = (&self.regression, &other.regression);
        let differ = [
            self.spikes != other.spikes,
            self.features != other.features,
            a.rank != b.rank,
            a.bandwidth != b.bandwidth,
            a.picture != b.picture,
        ];
        FINDINGS.into_iter().zip(differ).filter_map(|(name, differ)| differ.then_some(name)).collect()
    }
}

#[test]
fn every_alternative_changes_what_it_says_and_nothing_else() {
    let stack = stack();
    for Alternative(base, change, may_change) in ALTERNATIVES {
        let before = run(&stack, &settings(base.iter().copied()));
        let after = run(&stack, &settings(base.iter().copied().chain([*change])));
        let changed = before.differences(&after);
        let name = format!("--{} {}: {changed:?}", change.0, change.1);
        assert!(changed.iter().all(|finding| may_change.contains(finding)), "{name} changes too much");
        assert!(changed.contains(&"picture"), "{name} leaves the picture as it was");
        // The space itself is no finding of its own: only its rank, and the bandwidth that follows from both.
        let first = if may_change[0] == "rank" { "bandwidth" } else { may_change[0] };
        assert!(changed.contains(&first), "{name} does not change {first}");
    }
}

#[test]
fn every_setting_of_the_paper_has_its_alternative() {
    let knobs = [SpikeSettings::describe(), PrefilterSettings::describe(), RegressionSettings::describe()].concat();
    for knob in knobs {
        let tried = ALTERNATIVES.iter().any(|Alternative(_, (flag, _), _)| *flag == knob.flag);
        assert!(tried, "--{} is not among the alternatives", knob.flag);
    }
}
