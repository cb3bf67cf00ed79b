//! How far prefiltered features are from converged ones.

use reconstruct::prefilter::{FeatureFilter, FeatureSet, PrefilterSettings, prefilter};
use stack::{FeatureRole, FeatureStack, Silent};

use super::outcome::Outcome;
use super::subject::Subject;

/// Mean squared error of visibility on its own scale, 0 … 1. `None` without converged features.
pub fn visibility_error(outcome: &Outcome, subject: &Subject) -> Option<f64> {
    error(outcome, subject, &[FeatureRole::Visibility]).map(|error| error / 4.0)
}

/// Mean squared error of normals and albedo, both within [−1, 1]. Positions are left out: their scale depends on the
/// stack's own box. `None` without converged features.
pub fn surfaces_error(outcome: &Outcome, subject: &Subject) -> Option<f64> {
    error(outcome, subject, &[FeatureRole::Normal, FeatureRole::Albedo])
}

fn error(outcome: &Outcome, subject: &Subject, roles: &[FeatureRole]) -> Option<f64> {
    let settings = &outcome.settings.reconstruction.prefilter;
    let plain = PrefilterSettings { filter: FeatureFilter::Off, ..*settings };
    let found = planes(&subject.case.stack, settings, roles)?;
    let right = planes(subject.converged.as_ref()?, &plain, roles)?;
    let squares = found.iter().zip(&right).flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| f64::from(a - b).powi(2));
    let count: usize = right.iter().map(Vec::len).sum();
    Some(squares.sum::<f64>() / count.max(1) as f64)
}

/// The planes of the features of `roles` as the regression sees them, each within [−1, 1].
pub fn planes(stack: &FeatureStack, settings: &PrefilterSettings, roles: &[FeatureRole]) -> Option<Vec<Vec<f32>>> {
    let kept = |role: FeatureRole| roles.contains(&role);
    let features = stack.features.iter().filter(|feature| kept(feature.role)).cloned().collect();
    let stack = FeatureStack { features, components: Vec::new(), ..stack.clone() };
    prefilter(&stack, settings, &Silent).ok().map(|FeatureSet { planes, .. }| planes)
}
