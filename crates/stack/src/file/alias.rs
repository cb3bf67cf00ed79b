//! Which layer names mean which feature. Data, not code: one row a role.

use crate::FeatureRole;

/// Layer names of each feature, in lower case without separators, most specific first.
const ALIASES: [(FeatureRole, &[&str]); 5] = [
    (FeatureRole::Position, &["position", "p"]),
    (FeatureRole::Albedo, &["denoisingalbedo", "albedo", "diffusealbedo"]),
    (FeatureRole::Normal, &["denoisingnormal", "shnormal", "ns", "normal", "n"]),
    (FeatureRole::Visibility, &["visibility"]),
    (FeatureRole::Depth, &["denoisingdepth", "depth", "z"]),
];

/// Channel suffixes that a layer of three channels may have.
const TRIPLES: [[&str; 3]; 2] = [["X", "Y", "Z"], ["R", "G", "B"]];

/// Channel suffixes that a layer of one channel may have.
const SINGLES: [&str; 6] = ["Y", "Z", "T", "X", "V", "R"];

/// Full channel names of the feature `role` among `names`, if it is there under any of its aliases.
pub fn find(role: FeatureRole, names: &[&str]) -> Option<Vec<String>> {
    let (_, aliases) = ALIASES.iter().find(|(r, _)| *r == role)?;
    aliases.iter().find_map(|alias| {
        let layers = names.iter().filter_map(|name| name.rsplit_once('.').map(|(layer, _)| layer));
        let mut layers = layers.filter(|layer| normalise(layer) == **alias);
        layers.find_map(|layer| channels_of(layer, role, names))
    })
}

/// The layer's own name in lower case, without what stands before its last dot and without separators.
fn normalise(layer: &str) -> String {
    let own = layer.rsplit('.').next().unwrap_or(layer);
    own.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn channels_of(layer: &str, role: FeatureRole, names: &[&str]) -> Option<Vec<String>> {
    let full = |suffixes: &[&str]| -> Option<Vec<String>> {
        let wanted: Vec<String> = suffixes.iter().map(|suffix| format!("{layer}.{suffix}")).collect();
        wanted.iter().all(|name| names.contains(&name.as_str())).then_some(wanted)
    };
    if role.channels().len() == 3 {
        TRIPLES.iter().find_map(|triple| full(triple))
    } else {
        SINGLES.iter().find_map(|single| full(&[single]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_several_renderers_are_found() {
        let cycles = ["ViewLayer.Denoising Normal.X", "ViewLayer.Denoising Normal.Y", "ViewLayer.Denoising Normal.Z"];
        assert_eq!(find(FeatureRole::Normal, &cycles).unwrap()[0], cycles[0]);
        let pbrt = ["N.X", "N.Y", "N.Z", "Ns.X", "Ns.Y", "Ns.Z", "Albedo.R", "Albedo.G", "Albedo.B"];
        assert_eq!(find(FeatureRole::Normal, &pbrt).unwrap(), ["Ns.X", "Ns.Y", "Ns.Z"]);
        assert_eq!(find(FeatureRole::Albedo, &pbrt).unwrap(), ["Albedo.R", "Albedo.G", "Albedo.B"]);
        assert_eq!(find(FeatureRole::Position, &pbrt), None);
        assert_eq!(find(FeatureRole::Visibility, &["visibility.Y"]).unwrap(), ["visibility.Y"]);
    }
}
