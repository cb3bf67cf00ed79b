//! Stacks made poorer, step by step.

use stack::{Component, Estimate, Feature, FeatureRole, FeatureStack, Noise};

/// How much of a stack is left. Each has no more than the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// All buckets.
    Buckets,
    /// Two half-buffers.
    Halves,
    /// Means and their variances.
    Variance,
    /// Means.
    Mean,
    /// Without position.
    NoPosition,
    /// Without visibility and depth, either: albedo and normal.
    AlbedoNormal,
    /// Colour alone.
    Colour,
}

impl Level {
    /// All levels, richest first.
    pub const ALL: [Self; 7] =
        [Self::Buckets, Self::Halves, Self::Variance, Self::Mean, Self::NoPosition, Self::AlbedoNormal, Self::Colour];

    /// What is left, in words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Buckets => "buckets",
            Self::Halves => "halves",
            Self::Variance => "variance",
            Self::Mean => "mean",
            Self::NoPosition => "mean, no position",
            Self::AlbedoNormal => "mean, albedo, normal",
            Self::Colour => "colour alone",
        }
    }

    /// `stack` with no more than this level has; `None` when it has less.
    pub fn of(self, stack: &FeatureStack) -> Option<FeatureStack> {
        let mut poorer = stack.clone();
        for Component { radiance, .. } in &mut poorer.components {
            *radiance = self.left_of(radiance, stack)?;
        }
        // What other renderers do not keep apart.
        (poorer.indirect, poorer.gathered) = (None, None);
        poorer.features.retain(|feature| self.keeps(feature.role));
        for Feature { estimate, .. } in &mut poorer.features {
            *estimate = self.left_of(estimate, stack)?;
        }
        if self == Self::Halves {
            let halves = [0, 1].map(|half| stack.samples.in_group(0, half, 2));
            poorer.samples = stack::SampleCounts::uniform(stack.size().pixels(), halves.to_vec());
        }
        Some(poorer)
    }

    fn keeps(self, role: FeatureRole) -> bool {
        match role {
            FeatureRole::Position => self < Self::NoPosition,
            FeatureRole::Albedo | FeatureRole::Normal => self < Self::Colour,
            _ => self < Self::AlbedoNormal,
        }
    }

    fn left_of(self, estimate: &Estimate, stack: &FeatureStack) -> Option<Estimate> {
        let noise = match self {
            Self::Buckets => matches!(estimate.noise, Noise::Buckets(_)).then(|| estimate.noise.clone())?,
            Self::Halves => Noise::Buckets(estimate.halves(&stack.samples)?.to_vec()),
            Self::Variance => Noise::VarianceOfMean(estimate.variance_of_mean(&stack.samples)?),
            _ => Noise::Unknown,
        };
        Some(Estimate { mean: estimate.mean.clone(), noise })
    }
}
