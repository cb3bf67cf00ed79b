//! Adds up stacks that hold different samples of the same picture.
//!
//! Means are weighted with the samples behind them, bucket by bucket, and counts are added. Every step rounds, so
//! whoever wants the same bytes whatever the order of files adds them in the order of their [`Record`]s.

mod error;
mod record;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

pub use error::MergeError;
use rayon::prelude::*;
use record::Claims;
pub(crate) use record::check_apart;
pub use record::{Difference, Held, Record, check_records, first_difference};

use crate::file::StackHeader;
use crate::{Dealing, Estimate, FeatureStack, Image, Noise, SampleCounts};

/// A stack, where it came from, and what its file says about it.
#[derive(Clone, Debug)]
pub struct Slice {
    /// What messages call it.
    pub path: PathBuf,
    /// The stack.
    pub stack: FeatureStack,
    /// What its file says.
    pub header: StackHeader,
}

/// Slices under addition.
#[derive(Clone, Debug)]
pub struct Sum {
    first: PathBuf,
    stack: FeatureStack,
    header: StackHeader,
    claims: Claims,
}

impl Sum {
    /// Begins with one slice, whose settings and layers that nobody interprets will be those of the sum.
    ///
    /// # Errors
    /// When it does not say which samples it holds.
    pub fn new(slice: Slice) -> Result<Self, MergeError> {
        let Slice { path, stack, header } = slice;
        let mut claims = Claims::default();
        claims.add(&path, record_of(&path, &header)?)?;
        Ok(Self { first: path, stack, header, claims })
    }

    /// Adds another one.
    ///
    /// # Errors
    /// When it shows something else, has other layers, or holds samples that are there already; the sum is then of no
    /// use.
    pub fn add(&mut self, slice: Slice) -> Result<(), MergeError> {
        self.claims.add(&slice.path, record_of(&slice.path, &slice.header)?)?;
        let pair = Pair { like: &self.first, path: &slice.path };
        let theirs = slice.stack;
        pair.same("size of the whole picture", self.stack.film, theirs.film)?;
        let corner = |stack: &FeatureStack| format!("{},{}", stack.window.x, stack.window.y);
        pair.same("size", self.stack.size(), theirs.size())?;
        pair.same("corner of the crop", corner(&self.stack), corner(&theirs))?;
        let buckets = self.stack.samples.dealing.buckets();
        pair.same("buckets", buckets, theirs.samples.dealing.buckets())?;
        pair.same("layers", layers(&self.stack), layers(&theirs))?;
        let counts = [self.stack.samples.clone(), theirs.samples.clone()];
        for (mine, theirs) in estimates_mut(&mut self.stack).into_iter().zip(estimates(&theirs)) {
            add_estimate(mine, theirs, &counts);
        }
        self.stack.samples = sum_of(&counts, buckets);
        Ok(())
    }

    /// What they are together.
    pub fn finish(mut self) -> (FeatureStack, StackHeader) {
        let record = self.claims.record();
        if let (Some(mut record), true) = (record, self.claims.slices() > 1) {
            let (sequences, counts) = (self.header.sequences, &mut self.stack.samples);
            if let Some(held) = record.seamless(counts) {
                counts.first = held.first;
                counts.dealing = Dealing::Numbered { sequences, buckets: counts.dealing.buckets() as u32 };
                record.held = vec![held];
            } else {
                counts.first = record.held.first().map_or(0, |held| held.first);
                simplify(counts, sequences);
            }
            let per_bucket = match &counts.dealing {
                Dealing::PerBucket(counts) => Some(counts.clone()),
                Dealing::Numbered { .. } | Dealing::PerPixel(_) => None,
            };
            self.header = StackHeader { first: counts.first, per_bucket, record: Some(record), ..self.header };
        }
        let counts = self.stack.samples.clone();
        for estimate in estimates_mut(&mut self.stack) {
            // What is read again adds them up in this way, too.
            if let Noise::Buckets(buckets) = std::mem::replace(&mut estimate.noise, Noise::Unknown) {
                *estimate = Estimate::from_buckets(buckets, &counts);
            }
        }
        (self.stack, self.header)
    }
}

fn record_of<'a>(path: &Path, header: &'a StackHeader) -> Result<&'a Record, MergeError> {
    header.record.as_ref().ok_or_else(|| MergeError::NoRecord { path: path.into() })
}

/// Two slices that are compared.
struct Pair<'a> {
    like: &'a Path,
    path: &'a Path,
}

impl Pair<'_> {
    fn same<T: PartialEq + ToString>(&self, field: &str, expected: T, found: T) -> Result<(), MergeError> {
        if expected == found {
            return Ok(());
        }
        let (field, expected, found) = (field.into(), expected.to_string(), found.to_string());
        Err(MergeError::differs(self.path, self.like, Difference { field, expected, found }))
    }
}

/// All layers, and how many parts each comes in.
fn layers(stack: &FeatureStack) -> String {
    let components = stack.components.iter().map(|c| (c.role.layer(), &c.radiance));
    let features = stack.features.iter().map(|f| (f.role.layer(), &f.estimate));
    let all = components.chain(stack.parts_of_light()).chain(features);
    let names = all.map(|(layer, estimate)| match &estimate.noise {
        Noise::Buckets(buckets) => format!("{layer} in {}", buckets.len()),
        Noise::VarianceOfMean(_) => format!("{layer} with its variance"),
        Noise::Unknown => layer.into(),
    });
    names.collect::<Vec<String>>().join(", ")
}

fn estimates(stack: &FeatureStack) -> Vec<&Estimate> {
    let light = stack.parts_of_light().map(|(_, light)| light);
    let features = stack.features.iter().map(|feature| &feature.estimate);
    stack.components.iter().map(|component| &component.radiance).chain(light).chain(features).collect()
}

/// In the same order.
fn estimates_mut(stack: &mut FeatureStack) -> Vec<&mut Estimate> {
    let light = stack.indirect.iter_mut().chain(&mut stack.gathered);
    let features = stack.features.iter_mut().map(|feature| &mut feature.estimate);
    stack.components.iter_mut().map(|component| &mut component.radiance).chain(light).chain(features).collect()
}

/// Adds what comes in as many parts.
fn add_estimate(mine: &mut Estimate, theirs: &Estimate, counts: &[SampleCounts; 2]) {
    match (&mut mine.noise, &theirs.noise) {
        (Noise::Buckets(mine), Noise::Buckets(theirs)) => {
            let groups = mine.len();
            let parts = mine.par_iter_mut().zip(theirs).enumerate();
            parts.for_each(|(group, (mine, theirs))| add_means(mine, theirs, counts, group, groups));
        }
        _ => add_means(&mut mine.mean, &theirs.mean, counts, 0, 1),
    }
}

fn add_means(mine: &mut Image, theirs: &Image, counts: &[SampleCounts; 2], group: usize, groups: usize) {
    let counts = counts.each_ref().map(|counts| counts.grouped(groups));
    let weights: Vec<[u32; 2]> =
        (0..mine.pixels()).map(|pixel| counts.each_ref().map(|counts| counts.of(pixel, group))).collect();
    for (mine, theirs) in mine.channels_mut().iter_mut().zip(theirs.channels()) {
        for ((mine, theirs), weights) in mine.iter_mut().zip(theirs).zip(&weights) {
            *mine = mean([*mine, *theirs], *weights);
        }
    }
}

/// The mean of two means. What stands where there are no samples may be anything.
fn mean(values: [f32; 2], samples: [u32; 2]) -> f32 {
    match samples {
        [0, 0] => 0.0,
        [_, 0] => values[0],
        [0, _] => values[1],
        _ => {
            let ([a, b], [n, m]) = (values.map(f64::from), samples.map(f64::from));
            ((n * a + m * b) / (n + m)) as f32
        }
    }
}

/// Samples of both in every bucket of every pixel.
fn sum_of(counts: &[SampleCounts; 2], buckets: usize) -> SampleCounts {
    let grouped = counts.each_ref().map(|counts| counts.grouped(buckets));
    let of = |pixel, bucket| grouped.iter().fold(0, |sum: u32, counts| sum.saturating_add(counts.of(pixel, bucket)));
    let pixels = counts[0].total.len();
    SampleCounts::per_pixel((0..buckets).map(|bucket| (0..pixels).map(|pixel| of(pixel, bucket)).collect()).collect())
}

/// Counts of every pixel's buckets in as few words as will do.
fn simplify(counts: &mut SampleCounts, sequences: u32) {
    let Dealing::PerPixel(planes) = &counts.dealing else { return };
    let alike = |plane: &Vec<u32>| plane.iter().all(|n| *n == plane[0]);
    if planes.len() == 1 {
        counts.dealing = Dealing::Numbered { sequences, buckets: 1 };
    } else if planes.iter().all(|plane| !plane.is_empty() && alike(plane)) {
        counts.dealing = Dealing::PerBucket(planes.iter().map(|plane| plane[0]).collect());
    }
}
