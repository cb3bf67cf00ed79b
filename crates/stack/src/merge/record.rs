//! What a render's file says of the samples in it, so that more can be added.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::MergeError;
use crate::SampleCounts;

/// Consecutive samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Held {
    /// Number of the first.
    pub first: u32,
    /// The number after the last; where pixels have different numbers of them, of the pixel that has most.
    pub end: u32,
    /// Seed of their random numbers.
    pub seed: u64,
}

impl Held {
    fn overlaps(&self, other: &Self) -> bool {
        self.seed == other.seed && self.first < other.end && other.first < self.end
    }
}

/// What a stack's samples are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// What they show and how they were taken, all but seed and number: only samples of equal views may be added up.
    pub view: Value,
    /// Which they are, in order.
    pub held: Vec<Held>,
}

impl Record {
    /// What is held, as one range, when every pixel has all samples of all ranges and these follow one another.
    pub(super) fn seamless(&self, counts: &SampleCounts) -> Option<Held> {
        let (first, last) = (self.held.first()?, self.held.last()?);
        let whole = Held { end: last.end, ..*first };
        let follows = |pair: &[Held]| pair[0].end == pair[1].first && pair[0].seed == pair[1].seed;
        let all = counts.total.iter().all(|n| Some(*n) == whole.end.checked_sub(whole.first));
        (all && self.held.windows(2).all(follows)).then_some(whole)
    }
}

/// Checks that two files hold different samples.
///
/// # Errors
/// When some are in both.
pub(crate) fn check_apart((path, own): (&Path, &Record), (like, other): (&Path, &Record)) -> Result<(), MergeError> {
    for theirs in &other.held {
        if let Some(held) = own.held.iter().find(|held| held.overlaps(theirs)) {
            let Held { first, end, seed } = *held;
            let (path, like) = (path.into(), like.into());
            let (like_first, like_end) = (theirs.first, theirs.end);
            return Err(MergeError::Overlap { path, like, seed, first, end, like_first, like_end });
        }
    }
    Ok(())
}

/// Slices that may be added up.
#[derive(Clone, Debug, Default)]
pub(super) struct Claims {
    slices: Vec<(PathBuf, Record)>,
}

impl Claims {
    /// Adds one, unless it shows something else than the first, or holds what another does.
    pub(super) fn add(&mut self, path: &Path, record: &Record) -> Result<(), MergeError> {
        if let Some((like, first)) = self.slices.first()
            && let Some(difference) = first_difference(&first.view, &record.view)
        {
            return Err(MergeError::differs(path, like, difference));
        }
        self.slices.iter().try_for_each(|(like, other)| check_apart((path, record), (like, other)))?;
        self.slices.push((path.into(), record.clone()));
        Ok(())
    }

    /// How many there are.
    pub(super) fn slices(&self) -> usize {
        self.slices.len()
    }

    /// All of them together.
    pub(super) fn record(&self) -> Option<Record> {
        let mut held: Vec<Held> = self.slices.iter().flat_map(|(_, record)| record.held.iter().copied()).collect();
        held.sort_unstable();
        Some(Record { view: self.slices.first()?.1.view.clone(), held })
    }
}

/// Checks that slices show the same and hold different samples.
///
/// # Errors
/// The first that does not fit those before it.
pub fn check_records(slices: &[(PathBuf, Record)]) -> Result<(), MergeError> {
    let mut claims = Claims::default();
    slices.iter().try_for_each(|(path, record)| claims.add(path, record))
}

/// Where two values differ first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Keys that lead there, with dots between.
    pub field: String,
    /// What the first has.
    pub expected: String,
    /// What the second has.
    pub found: String,
}

/// The first difference between two values, by the order of keys in the first.
pub fn first_difference(expected: &Value, found: &Value) -> Option<Difference> {
    differing("", expected, found)
}

fn differing(field: &str, expected: &Value, found: &Value) -> Option<Difference> {
    let (Value::Object(mine), Value::Object(theirs)) = (expected, found) else {
        let [expected_text, found_text] = [expected, found].map(in_words);
        let difference = Difference { field: field.into(), expected: expected_text, found: found_text };
        return (expected != found).then_some(difference);
    };
    let more = theirs.keys().filter(|key| !mine.contains_key(*key));
    mine.keys().chain(more).find_map(|key| {
        let path = if field.is_empty() { key.clone() } else { format!("{field}.{key}") };
        let [mine, theirs] = [mine, theirs].map(|object| object.get(key).unwrap_or(&Value::Null));
        differing(&path, mine, theirs)
    })
}

fn in_words(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
