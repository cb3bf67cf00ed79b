//! What scattered light is rebuilt with.

use stack::{Image, SampleCounts};

use super::choice::Chooser;
use super::features::CleanFeatures;
use super::settings::BestSettings;

/// What a component of scattered light is rebuilt with.
#[derive(Clone, Copy)]
pub struct Recipe<'a> {
    /// Samples of the stack that it comes from.
    pub counts: &'a SampleCounts,
    /// What explains it.
    pub features: &'a CleanFeatures,
    /// Light of the same picture that was rebuilt before, where it says where there is likely more of the rest.
    pub beside: Option<&'a Image>,
    /// How.
    pub settings: &'a BestSettings,
    /// What helps to mix candidates, where the settings ask for it.
    pub chooser: Option<&'a Chooser>,
    /// What is asked beside the picture.
    pub extras: Extras<'a>,
}

/// What is asked beside the picture, and how it is worked on.
#[derive(Clone, Copy, Debug)]
pub struct Extras<'a> {
    /// Rows of the second pass that are made at once: fewer need less memory and more time, the picture is the same.
    pub rows: usize,
    /// Parts of the scattered light that are rebuilt with its weights; of as many pixels, with three channels.
    pub passes: &'a [Image],
}

impl Default for Extras<'_> {
    fn default() -> Self {
        Self { rows: usize::MAX, passes: &[] }
    }
}
