//! Settings of the project's own method.

use std::ops::RangeInclusive;

use crate::reconstruction::ReconstructError;

stack::knobs! {
    /// How light is split into a low layer and events.
    pub struct SplitSettings("split") {
        /// A bucket is cut where it exceeds this multiple of what its surroundings reach.
        factor: f32 = 1.8, 1.0..=1000.0;
        /// What the surroundings reach: this quantile of all their buckets, 0 to 1.
        quantile: f32 = 0.97, 0.0..=1.0;
        /// Radius of the surroundings, in pixels.
        radius: usize = 2, 1..=8;
        /// Radius of the boxes over which that is evened out, in pixels: where a few more events happen to meet than next
        /// to them, more of their light would stay in the low layer of both halves, as a cloud. 0 leaves it as it is.
        smoothing: usize = 8, 0..=64;
        /// Where a pixel has fewer samples than its surroundings, its buckets vary more: what they are cut at grows with
        /// this power of the ratio. 0 leaves it.
        few: f32 = 1.0, 0.0..=2.0;
        /// Most of the light of a pixel's surroundings that is cut off, 0 to 1, the few brightest buckets aside: where light
        /// is sparse, what most of it is made of is no firefly.
        most: f32 = 0.3, 0.0..=1.0;
        /// How many bright details of one pixel there are for one that only looks like it, before it is known how many of
        /// its buckets are bright. With 0 none is believed; with large numbers all are, and where two fireflies meet a
        /// speck is left.
        detail: f32 = 0.001, 0.0..=1000.0;
    }
}

stack::knobs! {
    /// What light is rebuilt as.
    pub struct LightSettings("light") {
        /// Brightness, in the geometric mean over blocks of pixels, below which light is made brighter before it is rebuilt
        /// and darker again at the end: constants that matter in the dark are made for usual units. 0 leaves it.
        darkest: f32 = 0.03, 0.0..=1000.0;
        /// Brightness above which light is made darker before it is rebuilt.
        brightest: f32 = 0.3, 1e-9..=1e30;
        /// Whether direct and indirect light are rebuilt apart, where a stack keeps them apart: their borders lie
        /// elsewhere. It takes up to twice the time.
        apart: bool = true, ..;
        /// Whether indirect light is taken as it was gathered, where a stack knows it so: with less noise.
        gathered: bool = true, ..;
        /// Weight of a difference in the logarithm of the rebuilt direct light against one in features, where indirect
        /// light is rebuilt apart; 0 leaves it to visibility.
        direct_guide: f32 = 0.3, 0.0..=100.0;
        /// Weight of rebuilt direct light in the brightness by which fireflies of indirect light are spread, where it is
        /// rebuilt apart: there is likely more of both in the same places. 0 leaves it to indirect light.
        direct_spread: f32 = 0.5, 0.0..=100.0;
        /// Share of the noise from which on direct light is not rebuilt apart, as under a wide sky: the light of both has
        /// less noise to tell its borders by.
        direct_noise: f32 = 0.45, 0.0..=1.0;
        /// Share of the noise below which direct light, where it is rebuilt apart, is rebuilt with the few fits and
        /// candidates of `--preset fast`: whatever else is set of those.
        direct_fast: f32 = 0.05, 0.0..=1.0;
        /// Widenings of the kernel by which light is given back that direct light lost, where it is rebuilt fast: with
        /// hardly any noise little is lost, and that nearby.
        direct_restore: usize = 2, 0..=10;
    }
}

stack::knobs! {
    /// What kernels go by where no feature tells surfaces apart.
    pub struct ColourSettings("colour") {
        /// Weight of a difference in the logarithm of the first pass's picture against one in features; 0 leaves it to the
        /// brightness that each step looks at.
        guide: f32 = 1.0, 0.0..=100.0;
    }
}

stack::knobs! {
    /// How features are freed of noise before a collaborative fit explains light by them.
    pub struct FeatureSettings("features") {
        /// Bandwidth k of the non-local means.
        bandwidth: f32 = 1.2, 0.01..=100.0;
        /// Radius of its window, in pixels.
        radius: usize = 5, 0..=32;
        /// Radius of its patches, in pixels.
        patch_radius: usize = 2, 0..=8;
        /// Radius of the box that smooths the variance of features, in pixels.
        variance_radius: usize = 1, 0..=16;
        /// Whether what paths meet next after the feature hit is among them, where a stack tells: in corners and under
        /// tables it is what indirect light goes by.
        next: bool = true, ..;
        /// Bandwidth k of the regression that frees that of noise.
        next_bandwidth: f32 = 1.4, 0.01..=100.0;
        /// The same for visibility, of which the noise would be seen in soft shadows and under a sky; 0 filters it as other
        /// features, which is faster.
        visibility_bandwidth: f32 = 0.85, 0.0..=100.0;
    }
}

stack::knobs! {
    /// The collaborative regressions.
    pub struct FitSettings("fit") {
        /// Distance between the pixels that carry a fit; the pixels between them are predicted by their neighbours'.
        stride: usize = 3, 1..=8;
        /// A pixel on which the fits around it weigh less than this gets one of its own; 1 is what a fit at the pixel
        /// itself weighs, 0 leaves to the lattice all that it reaches.
        covered: f32 = 1.0, 0.0..=100.0;
        /// Bandwidth k of the first pass's weights exp(−D/k²), D the distance of patches in units of their noise.
        first_bandwidth: f32 = 0.5, 0.01..=100.0;
        /// Radius of the first pass's window, in pixels.
        first_radius: usize = 9, 1..=32;
        /// Radius of the second pass's window, in pixels.
        second_radius: usize = 11, 1..=32;
        /// Ridge without noise, relative to features of unit scale.
        ridge: f32 = 1e-5, 1e-9..=1.0;
        /// Ridge per relative variance: the noisier the pixels, the flatter the fit.
        ridge_noise: f32 = 0.2, 0.0..=1000.0;
        /// Differences in the pilot picture below the root of this share of its squared luminance count little.
        tolerance: f32 = 0.005, 1e-6..=1.0;
        /// Deviation of the candidate with a small window, in pixels.
        small_sigma: f32 = 3.0, 0.3..=100.0;
        /// Deviation of the candidate with a tiny window, in pixels.
        tiny_sigma: f32 = 1.5, 0.3..=100.0;
        /// Whether the second pass makes two bandwidths and a tiny window only, among which the rule chooses without the
        /// network.
        few: bool = false, ..;
        /// Passes: with one, the first picture is the last; faster and coarser.
        passes: usize = 2, 1..=2;
        /// Whether a residual counts in proportion to its pixel's samples, where they differ.
        weigh_samples: bool = true, ..;
        /// Whether residuals count relative to the pilot's brightness, so that bright pixels do not smear into dark
        /// ones.
        relative: bool = true, ..;
    }
}

stack::knobs! {
    /// How events are spread.
    pub struct SpreadSettings("spread") {
        /// Events that an event's surroundings must hold before it is spread no wider.
        events: f32 = 8.0, 1.0..=1000.0;
        /// Weight of a difference in the logarithm of brightness against one in features.
        brightness: f32 = 1.5, 0.0..=100.0;
        /// Power of a pixel's brightness that its share of an event rises with.
        share: f32 = 2.0, 0.0..=10.0;
        /// Scale of the differences between features that separate surfaces.
        feature_scale: f32 = 0.8, 0.01..=10.0;
        /// Scales, each twice as coarse as the one before, on which blotches of spread events are kept only where both
        /// halves show them.
        levels: usize = 6, 0..=10;
        /// Multiple of a blotch's variance that its square must exceed.
        significance: f32 = 2.0, 0.0..=1000.0;
        /// Weight of the light of events along a line in the brightness by which all are spread: a thin highlight that few
        /// samples met with. 0 looks for none.
        lines: f32 = 2.0, 0.0..=100.0;
        /// By how many deviations events along a line must exceed those that the surface around leads to expect.
        lines_significance: f32 = 3.4, 0.0..=1000.0;
    }
}

stack::knobs! {
    /// What is added to the pilot picture from the residual.
    pub struct CascadeSettings("cascade") {
        /// Multiple of the residual's variance that its square must exceed, whichever bucket is left out. Of two fireflies
        /// that meet in a pixel, one is left then, whose square is its variance: above 1, no detail.
        significance: f32 = 1.2, 0.0..=1000.0;
        /// The same where there are but two halves, of which none can be left out.
        significance_of_two: f32 = 2.0, 0.0..=1000.0;
        /// Scales, each twice as coarse as the one before.
        levels: usize = 6, 0..=10;
        /// Groups of buckets that details are judged by.
        parts: usize = 8, 2..=8;
        /// Scale of the differences between features that separate surfaces.
        feature_scale: f32 = 0.3, 0.01..=10.0;
    }
}

stack::knobs! {
    /// How clouds of noise, wider than any window, are told from light.
    pub struct CloudSettings("clouds") {
        /// Scales, each twice as coarse as the one before, on which differences are kept only where both halves of the
        /// picture show them; 0 keeps all.
        levels: usize = 4, 0..=10;
        /// How many of them, the finest, are kept all the same.
        trusted: usize = 2, 0..=10;
        /// Multiple of a difference's variance that its square must exceed.
        significance: f32 = 3.0, 0.0..=1000.0;
        /// Multiple of the share of signal in it that a difference counts by, at most in full: where most of it is
        /// signal, nothing is lost.
        gain: f32 = 2.0, 0.0..=1000.0;
    }
}

stack::knobs! {
    /// How far light that the regressions lost is given back. Clouds are told by the same kernel.
    pub struct RestoreSettings("restore") {
        /// Widenings of the kernel, each by a factor of two; 0 gives nothing back.
        levels: usize = 5, 0..=10;
        /// Largest factor by which a pixel may change, up or down.
        limit: f32 = 1.5, 1.0..=100.0;
        /// Scale of the differences between features that separate surfaces.
        feature_scale: f32 = 0.3, 0.01..=10.0;
        /// Weight of a squared difference in the logarithm of the picture against one in features.
        brightness: f32 = 0.3, 0.0..=100.0;
    }
}

stack::knobs! {
    /// How candidates are mixed.
    pub struct ChoiceSettings("choice") {
        /// A candidate's weight falls by e for each this much more error, relative to the least.
        softness: f32 = 0.3, 0.001..=100.0;
        /// And this much of the noise in the errors is added to that: candidates that differ by less are mixed evenly.
        noise: f32 = 0.03, 0.0..=100.0;
        /// Whether the network that comes along has a say, or errors alone. It was trained with the defaults of all
        /// settings here.
        learned: bool = true, ..;
        /// Weight of noise against error: noisy pixels say less about which candidate is right.
        precision: f32 = 3.0, 0.0..=1000.0;
        /// Weight of a squared difference in the logarithm of the pilot against one in features.
        brightness: f32 = 0.2, 0.0..=100.0;
        /// Scale of the differences between features that separate surfaces.
        feature_scale: f32 = 0.3, 0.01..=10.0;
    }
}

stack::knobs! {
    /// How the picture's error is estimated. The factors are fitted to renders whose errors are known; see
    /// `docs/experiments.md`.
    pub struct ErrorSettings("error") {
        /// Squared error of the low layer for each (A − B)²/4 between its halves: their shared weights hide part of the
        /// variance, and bias comes with it.
        halves: f32 = 3.5, 0.0..=1000.0;
        /// Squared error of the spread events for each unit of their own variance.
        events: f32 = 1.5, 0.0..=1000.0;
    }
}

stack::knob_groups! {
    /// Settings of all its steps.
    pub struct BestSettings {
        /// Exposure and parts of the light.
        light: LightSettings,
        /// Low layer and events.
        split: SplitSettings,
        /// Kernels without features.
        colour: ColourSettings,
        /// Features.
        features: FeatureSettings,
        /// Regressions.
        regression: FitSettings,
        /// Events.
        spread: SpreadSettings,
        /// Residual.
        cascade: CascadeSettings,
        /// Clouds.
        clouds: CloudSettings,
        /// Energy.
        restore: RestoreSettings,
        /// Candidates.
        choice: ChoiceSettings,
        /// Error.
        error: ErrorSettings,
    }
}

impl LightSettings {
    /// Brightness in which light is rebuilt as it is.
    pub fn usual_brightness(&self) -> RangeInclusive<f32> {
        self.darkest..=self.brightest
    }
}

impl BestSettings {
    /// Whether the network is asked about candidates that it knows.
    ///
    /// # Errors
    /// When only a few are made.
    pub fn check_candidates(&self) -> Result<(), ReconstructError> {
        if self.choice.learned && self.regression.few { Err(ReconstructError::FewCandidates) } else { Ok(()) }
    }

    /// What direct light is rebuilt with, where it is rebuilt apart and has this `share` of the noise.
    pub fn for_direct_light(self, share: f32) -> Self {
        if share >= self.light.direct_fast {
            return self;
        }
        let levels = self.light.direct_restore.min(self.restore.levels);
        Self { restore: RestoreSettings { levels, ..self.restore }, ..self.hastened() }
    }

    /// The same in a fraction of the time: few fits in small windows and few candidates, mixed by the rule alone; fewer
    /// scales of details that both halves agree on; spread events as they fall.
    pub fn hastened(self) -> Self {
        let regression = FitSettings {
            stride: 5,
            covered: 0.1,
            first_radius: 5,
            second_radius: 7,
            // No window is so tiny that the lattice leaves most pixels to fits of their own.
            tiny_sigma: 3.0,
            few: true,
            ..self.regression
        };
        Self {
            regression,
            spread: SpreadSettings { levels: 0, lines: 0.0, ..self.spread },
            cascade: CascadeSettings {
                levels: self.cascade.levels.min(4),
                parts: self.cascade.parts.min(2),
                ..self.cascade
            },
            clouds: CloudSettings { levels: 0, ..self.clouds },
            choice: ChoiceSettings { learned: false, ..self.choice },
            ..self
        }
    }
}
