//! What was found in a stack's files, how it was understood, and what had to be done without.

use serde::Serialize;

use super::mend::Mended;
use crate::{Estimate, FeatureRole, FeatureStack, Noise};

/// A layer that was found and its use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FoundRole {
    /// What it is.
    pub role: String,
    /// Full names of its channels.
    pub channels: Vec<String>,
    /// What is known about its noise: `N buckets`, `variance of the mean` or `unknown`.
    pub noise: String,
    /// How that was told, when it was not simply there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// Whether its values or a word of its name were all there was to go by.
    pub guessed: bool,
}

/// How many samples there are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundSpp {
    /// Mean over the picture.
    pub mean: f64,
    /// Least of a pixel.
    pub min: u32,
    /// Most of a pixel.
    pub max: u32,
    /// Where the number stood.
    pub from: String,
}

/// What was found in a stack's files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Found {
    /// Who wrote them.
    pub renderer: String,
    /// What was used.
    pub roles: Vec<FoundRole>,
    /// Samples per pixel, where the files say.
    pub spp: Option<FoundSpp>,
    /// What was mended.
    pub mended: Vec<Mended>,
    /// What else there is to say, a line each.
    pub remarks: Vec<String>,
    /// Roles and knowledge that were not there.
    pub without: Vec<String>,
}

impl Found {
    /// The noise of every role and what is missing, from the finished stack.
    pub(super) fn conclude(&mut self, stack: &FeatureStack) {
        let components = stack.components.iter().map(|c| (component_name(c.role.layer()), &c.radiance));
        let features = stack.features.iter().map(|f| (f.role.layer(), &f.estimate));
        for (name, estimate) in components.chain(features) {
            self.roles.iter_mut().filter(|found| found.role == name).for_each(|found| found.noise = noise_of(estimate));
        }
        let unknown = |name: &str| {
            stack
                .components
                .iter()
                .any(|c| component_name(c.role.layer()) == name && c.radiance.noise == Noise::Unknown)
        };
        if unknown("colour") {
            self.without.push("what the colour's noise is".into());
        }
        let common = FeatureRole::ALL.into_iter().filter(|role| !role.is_of_next_surface());
        let missing = common.filter(|role| stack.feature(*role).is_none());
        self.without.extend(missing.map(|role| role.layer().to_string()));
        if self.spp.is_none() {
            self.without.push("the number of samples".into());
        }
    }

    /// The report as lines of text.
    pub fn lines(&self) -> Vec<String> {
        let roles: Vec<String> = self.roles.iter().map(role_text).collect();
        let spp = self.spp.as_ref().map_or_else(String::new, |spp| {
            let range = if spp.min == spp.max { String::new() } else { format!(" ({} to {})", spp.min, spp.max) };
            format!("; {}{range} samples per pixel, from {}", short(spp.mean), spp.from)
        });
        let mut lines = vec![format!("found {} stack: {}{spp}", with_article(&self.renderer), roles.join(", "))];
        lines.extend(self.remarks.iter().cloned());
        lines.extend(self.mended.iter().map(|mended| format!("mended {} {}", mended.count, mended.what)));
        if !self.without.is_empty() {
            lines.push(format!("without {}", self.without.join(", ")));
        }
        lines
    }
}

fn component_name(layer: &'static str) -> &'static str {
    if layer == "noisy" { "colour" } else { layer }
}

fn noise_of(estimate: &Estimate) -> String {
    match &estimate.noise {
        Noise::Buckets(buckets) => format!("{} buckets", buckets.len()),
        Noise::VarianceOfMean(_) => "variance of the mean".into(),
        Noise::Unknown => "unknown".into(),
    }
}

fn role_text(found: &FoundRole) -> String {
    let layer = match &found.channels[..] {
        [only] => only.clone(),
        several => layer_name(several),
    };
    let guess = if found.guessed { ", guessed" } else { "" };
    let noise = match (found.noise.as_str(), &found.from) {
        ("", _) => String::new(),
        ("unknown", _) => ", noise unknown".into(),
        (noise, Some(from)) => format!(", {noise} from {from}"),
        (noise, None) => format!(", {noise}"),
    };
    format!("{} ({layer}{noise}{guess})", found.role)
}

/// The layer that `channels` are of, or the channels when they are of none.
pub(super) fn layer_name(channels: &[String]) -> String {
    match channels.first().and_then(|first| first.rsplit_once('.')) {
        Some((layer, _)) => layer.into(),
        None => channels.join(" "),
    }
}

fn with_article(renderer: &str) -> String {
    match renderer {
        "unknown" => "an unknown renderer's".into(),
        name if name.starts_with(['A', 'E', 'I', 'O', 'U']) => format!("an {name}"),
        name => format!("a {name}"),
    }
}

fn short(number: f64) -> String {
    if number.fract() == 0.0 { format!("{number:.0}") } else { format!("{number:.2}") }
}
