//! What can go wrong when tracing.

use stack::{Fault, KnobError};

use super::TraceReport;
use crate::sampler::SequenceTooShort;

/// Tracing was refused or interrupted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] KnobError),
    /// Buckets cannot be dealt evenly to sequences.
    #[error("{buckets} buckets cannot be shared by {sequences} sequences: buckets must be a multiple of sequences")]
    UnevenBuckets {
        /// Buckets asked for.
        buckets: u32,
        /// Sequences asked for.
        sequences: u32,
    },
    /// The film was made with other settings.
    #[error(
        "the film deals its samples to {} sequences and {} buckets, the settings ask for {} and {}: \
         continue a film with the settings it was begun with",
        film[0], film[1], settings[0], settings[1]
    )]
    OtherDealing {
        /// The film's sequences and buckets.
        film: [u32; 2],
        /// The settings'.
        settings: [u32; 2],
    },
    /// The sample map is for another film.
    #[error("the sample map names {found} pixels, but the film window has {expected}")]
    MapSize {
        /// Pixels of the film window.
        expected: usize,
        /// Pixels of the map.
        found: usize,
    },
    /// A pixel's new samples do not follow those it has.
    #[error("pixel ({x}, {y}) has the samples before {expected}, so {found} cannot be its next: a film has no gaps")]
    NotNext {
        /// Column in the film window.
        x: usize,
        /// Row in the film window.
        y: usize,
        /// The sample that comes next.
        expected: u32,
        /// The sample asked for.
        found: u32,
    },
    /// More samples were asked for than there are random numbers.
    #[error(transparent)]
    TooManySamples(#[from] SequenceTooShort),
    /// The monitor stopped the work; the film holds all passes that were finished.
    #[error("interrupted after {} samples", .0.samples)]
    Cancelled(TraceReport),
}

impl TraceError {
    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        match self {
            Self::Cancelled(_) => Fault::Interrupted,
            Self::Setting(_)
            | Self::UnevenBuckets { .. }
            | Self::OtherDealing { .. }
            | Self::MapSize { .. }
            | Self::NotNext { .. } => Fault::Usage,
            Self::TooManySamples(cause) => cause.fault(),
        }
    }
}
