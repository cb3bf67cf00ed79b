//! Reads feature stacks: our own, and other renderers'.

use std::path::{Path, PathBuf};

use super::picture::colour_prefix;
use super::write::bucket_layer;
use super::{FileError, Layers, StackHeader, alias};
use crate::{
    Component, ComponentRole, Dealing, Estimate, Feature, FeatureRole, FeatureStack, Image, Noise, SampleCounts,
};

/// Layers that a reconstruction makes; they are results, never inputs.
const RESULTS: [&str; 9] = ["R", "G", "B", "spikes.", "mse.", "bandwidth.", "rank.", "samples.", "beauty."];

/// A stack as it was read.
#[derive(Clone, Debug)]
pub struct ReadStack {
    /// The stack.
    pub stack: FeatureStack,
    /// What our own files say about themselves.
    pub header: Option<StackHeader>,
    /// What was found and how it was understood, a line each.
    pub notes: Vec<String>,
}

/// Reads a stack from one file.
///
/// # Errors
/// When the file cannot be read or holds no colour.
pub fn read_stack(path: &Path) -> Result<ReadStack, FileError> {
    let mut layers = Layers::read(path)?;
    let header = layers.metadata.take().and_then(|json| serde_json::from_value::<StackHeader>(json).ok());
    match header {
        Some(header) if layers.has("noisy.R") => read_own(layers, header),
        _ => read_foreign(layers),
    }
}

fn read_own(mut layers: Layers, header: StackHeader) -> Result<ReadStack, FileError> {
    let missing = |wanted, expected: &str, layers: &Layers| FileError::Missing {
        path: layers.path.clone(),
        wanted,
        expected: expected.into(),
        found: layers.names(),
    };
    let total = layers.take("samples.Y").ok_or_else(|| missing("sample counts", "samples.Y", &layers))?;
    let samples = SampleCounts {
        first: header.first,
        total: total.into_iter().map(|n| n as u32).collect(),
        dealing: Dealing::Numbered { sequences: header.sequences, buckets: header.buckets },
    };
    let mut components = Vec::new();
    for role in ComponentRole::ALL {
        let buckets = header.buckets as usize;
        if let Some(radiance) = take_estimate(&mut layers, role.layer(), &["R", "G", "B"], buckets, &samples) {
            components.push(Component { role, radiance });
        }
    }
    if components.is_empty() {
        return Err(missing("colour", "noisy.R noisy.G noisy.B and their buckets", &layers));
    }
    let mut features = Vec::new();
    for role in FeatureRole::ALL {
        let many = layers.has(&format!("{}.bucket0.{}", role.layer(), role.channels()[0]));
        let buckets = if many { header.buckets } else { header.buckets.min(2) } as usize;
        if let Some(estimate) = take_estimate(&mut layers, role.layer(), role.channels(), buckets, &samples) {
            features.push(Feature { role, estimate });
        }
    }
    Ok(ReadStack { stack: assemble(layers, samples, components, features), header: Some(header), notes: Vec::new() })
}

fn assemble(
    mut layers: Layers,
    samples: SampleCounts,
    components: Vec<Component>,
    features: Vec<Feature>,
) -> FeatureStack {
    let is_result =
        |name: &str| RESULTS.iter().any(|r| if r.ends_with('.') { name.starts_with(r) } else { name == *r });
    layers.channels.retain(|channel| !is_result(&channel.name));
    let (window, film, passthrough) = (layers.window, layers.film, layers.channels);
    FeatureStack { window, film, samples, components, features, passthrough }
}

fn take_image(layers: &mut Layers, names: &[String]) -> Option<Image> {
    if !names.iter().all(|name| layers.has(name)) {
        return None;
    }
    let planes = names.iter().filter_map(|name| layers.take(name)).collect();
    Some(Image::from_channels(layers.window.size, planes))
}

fn full_names(layer: &str, channels: &[&str]) -> Vec<String> {
    channels.iter().map(|channel| format!("{layer}.{channel}")).collect()
}

/// An estimate of ours: from its buckets when all are there, else its mean alone.
fn take_estimate(
    layers: &mut Layers,
    layer: &str,
    channels: &[&str],
    buckets: usize,
    samples: &SampleCounts,
) -> Option<Estimate> {
    let mean = take_image(layers, &full_names(layer, channels))?;
    if buckets < 2 {
        return Some(Estimate { mean, noise: Noise::Unknown });
    }
    let buckets: Option<Vec<Image>> =
        (0..buckets).map(|b| take_image(layers, &full_names(&bucket_layer(layer, b, buckets), channels))).collect();
    Some(match buckets {
        Some(buckets) => Estimate::from_buckets(buckets, samples),
        None => Estimate { mean, noise: Noise::Unknown },
    })
}

fn read_foreign(mut layers: Layers) -> Result<ReadStack, FileError> {
    let (colour, features) = take_foreign(&mut layers)?;
    let samples = SampleCounts::uniform(colour.pixels(), vec![1]);
    let estimate = |mean| Estimate { mean, noise: Noise::Unknown };
    let components = vec![Component { role: ComponentRole::Scattered, radiance: estimate(colour) }];
    let features: Vec<Feature> =
        features.into_iter().map(|(role, mean)| Feature { role, estimate: estimate(mean) }).collect();
    let notes = vec![format!("found colour{}; nothing about its noise", list(&features))];
    Ok(ReadStack { stack: assemble(layers, samples, components, features), header: None, notes })
}

type ForeignFeatures = Vec<(FeatureRole, Image)>;

/// The colour of a foreign file and every feature that goes by a known name.
fn take_foreign(layers: &mut Layers) -> Result<(Image, ForeignFeatures), FileError> {
    let colour = take_colour(layers)?;
    let mut features = Vec::new();
    for role in FeatureRole::ALL {
        let names: Vec<&str> = layers.channels.iter().map(|channel| channel.name.as_str()).collect();
        if let Some(image) = alias::find(role, &names).and_then(|names| take_image(layers, &names)) {
            features.push((role, image));
        }
    }
    Ok((colour, features))
}

/// The noisy picture: in a file of ours the sum of its components, since `R G B` is a result there.
fn take_colour(layers: &mut Layers) -> Result<Image, FileError> {
    if layers.metadata.is_some() && layers.has("noisy.R") {
        let mut sum = Image::zeros(layers.window.size, 3);
        for role in ComponentRole::ALL {
            take_image(layers, &full_names(role.layer(), &["R", "G", "B"])).iter().for_each(|part| sum.add(part));
        }
        return Ok(sum);
    }
    let prefix = colour_prefix(layers)?;
    let names = ["R", "G", "B"].map(|c| format!("{prefix}{c}"));
    let planes = names.iter().filter_map(|name| layers.take(name)).collect();
    Ok(Image::from_channels(layers.window.size, planes))
}

fn list(features: &[Feature]) -> String {
    features.iter().map(|feature| format!(", {}", feature.role.layer())).collect()
}

/// Reads independent renders of one picture, each with its own colour and features, as the buckets of one stack.
///
/// # Errors
/// When there are fewer than two, one cannot be read, sizes or features differ, or two hold the same noise.
pub fn read_buckets(paths: &[PathBuf]) -> Result<ReadStack, FileError> {
    if paths.len() < 2 {
        return Err(FileError::TooFewBuckets { found: paths.len() });
    }
    let mut colours = Vec::new();
    let mut features: Vec<(FeatureRole, Vec<Image>)> = Vec::new();
    let mut first: Option<Layers> = None;
    for path in paths {
        let mut layers = Layers::read(path)?;
        let (colour, found) = take_foreign(&mut layers)?;
        let like = first.get_or_insert(layers);
        check_size(path, &colour, like)?;
        if colours.is_empty() {
            features = found.into_iter().map(|(role, image)| (role, vec![image])).collect();
        } else {
            add_features(path, &mut features, found)?;
        }
        colours.push(colour);
    }
    check_independent(paths, &colours)?;
    let Some(layers) = first else { return Err(FileError::TooFewBuckets { found: 0 }) };
    Ok(bucket_stack(layers, colours, features))
}

fn check_size(path: &Path, colour: &Image, like: &Layers) -> Result<(), FileError> {
    let (expected, found) = (like.window.size, colour.size());
    if expected == found {
        return Ok(());
    }
    Err(FileError::SizeDiffers { path: path.into(), like: like.path.clone(), expected, found })
}

fn add_features(
    path: &Path,
    features: &mut [(FeatureRole, Vec<Image>)],
    found: ForeignFeatures,
) -> Result<(), FileError> {
    let mut found: Vec<(FeatureRole, Option<Image>)> = found.into_iter().map(|(role, i)| (role, Some(i))).collect();
    for (role, images) in features {
        let image = found.iter_mut().find(|(r, _)| r == role).and_then(|(_, image)| image.take());
        images.push(image.ok_or_else(|| FileError::Missing {
            path: path.into(),
            wanted: role.layer(),
            expected: "the same features as in the other buckets".into(),
            found: "none of that role".into(),
        })?);
    }
    Ok(())
}

/// Refuses two buckets with the very same pixels, unless the picture has no noise at all.
fn check_independent(paths: &[PathBuf], colours: &[Image]) -> Result<(), FileError> {
    for i in 0..colours.len() {
        for j in 0..i {
            let flat = colours[i].channels().iter().all(|plane| plane.iter().all(|v| *v == plane[0]));
            if colours[i] == colours[j] && !flat {
                return Err(FileError::SameNoise { first: paths[j].clone(), second: paths[i].clone() });
            }
        }
    }
    Ok(())
}

/// Whether a file of ours has the channel `name` for a component or feature.
fn is_own_input(name: &str) -> bool {
    let components = ComponentRole::ALL.map(ComponentRole::layer);
    let mut layers = components.into_iter().chain(FeatureRole::ALL.map(FeatureRole::layer));
    let own = |rest: &str| [".", "A.", "B.", "Variance."].iter().any(|form| rest.starts_with(form));
    layers.any(|layer| name.strip_prefix(layer).is_some_and(own))
}

fn bucket_stack(mut layers: Layers, colours: Vec<Image>, features: Vec<(FeatureRole, Vec<Image>)>) -> ReadStack {
    if layers.metadata.is_some() {
        layers.channels.retain(|channel| !is_own_input(&channel.name));
    }
    let samples = SampleCounts::uniform(layers.window.size.pixels(), vec![1; colours.len()]);
    let features: Vec<Feature> = features
        .into_iter()
        .map(|(role, buckets)| Feature { role, estimate: Estimate::from_buckets(buckets, &samples) })
        .collect();
    let notes = vec![format!("found {} buckets with colour{}", colours.len(), list(&features))];
    let radiance = Estimate::from_buckets(colours, &samples);
    let component = Component { role: ComponentRole::Scattered, radiance };
    ReadStack { stack: assemble(layers, samples, vec![component], features), header: None, notes }
}
