//! What a picture's file says about how the picture was made.

use serde::Serialize;
use serde_json::Value;

use super::counts::{Spp, rounded};
use super::found::FoundSpp;
use super::layers::Layers;
use super::own::header_of;
use super::write::SAMPLES;

/// How a picture was made, as far as its file says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Record {
    /// The program that wrote the file.
    pub software: Option<String>,
    /// Samples per pixel, in files of ours that hold the counts.
    pub spp: Option<FoundSpp>,
    /// Every setting, in files of ours.
    pub settings: Option<Value>,
}

impl Record {
    /// Takes it out of the channels and attributes of a file.
    pub(super) fn take(layers: &mut Layers) -> Self {
        // A picture is one whatever stands beside it.
        let header = header_of(layers).ok().flatten();
        let channel = format!("{SAMPLES}.Y");
        // Elsewhere a layer of this name may hold fractions, or counts of something else.
        let counts = header.as_ref().and_then(|header| layers.take(&channel).filter(|_| !header.samples_unknown));
        Self {
            software: layers.carried.text("software"),
            spp: counts.map(|plane| Spp { total: rounded(&plane, 1.0), from: channel }.found()),
            settings: header.map(|header| header.settings),
        }
    }
}
