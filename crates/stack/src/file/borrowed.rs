//! Channels that are written from where they lie: a stack is most of the memory there is, and must not be copied.

use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;
use exr::prelude::FlatSamples;

/// Borrowed values of one channel, row-major.
#[derive(Clone, Copy, Debug)]
pub enum BorrowedSamples<'a> {
    /// Ours.
    Float(&'a [f32]),
    /// Somebody else's, of any number type.
    Any(&'a FlatSamples),
}

/// Hands lines of a channel to the encoder.
#[derive(Clone, Copy, Debug)]
pub struct LineSource<'a> {
    width: usize,
    samples: BorrowedSamples<'a>,
}

impl<'s, 'a: 's> WritableSamples<'s> for BorrowedSamples<'a> {
    type Writer = LineSource<'s>;

    fn sample_type(&self) -> SampleType {
        match self {
            Self::Float(_) | Self::Any(FlatSamples::F32(_)) => SampleType::F32,
            Self::Any(FlatSamples::F16(_)) => SampleType::F16,
            Self::Any(FlatSamples::U32(_)) => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'s self, header: &Header) -> LineSource<'s> {
        LineSource { width: header.layer_size.width(), samples: *self }
    }
}

impl SamplesWriter for LineSource<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let start = line.location.position.y() * self.width + line.location.position.x();
        let range = start..start + line.location.sample_count;
        let written = match self.samples {
            BorrowedSamples::Float(values) => line.write_samples_from_slice(&values[range]),
            BorrowedSamples::Any(FlatSamples::F32(values)) => line.write_samples_from_slice(&values[range]),
            BorrowedSamples::Any(FlatSamples::F16(values)) => line.write_samples_from_slice(&values[range]),
            BorrowedSamples::Any(FlatSamples::U32(values)) => line.write_samples_from_slice(&values[range]),
        };
        // The encoder made the line's buffer from the header these samples describe.
        written.expect("a line fits its buffer");
    }
}
