//! Channels that are written from where they lie: a stack is most of the memory there is, and must not be copied.

use std::ops::Range;

use exr::meta::attribute::SampleType;
use exr::prelude::FlatSamples;

/// Borrowed values of one channel, row-major.
#[derive(Clone, Copy, Debug)]
pub enum BorrowedSamples<'a> {
    /// Ours.
    Float(&'a [f32]),
    /// Somebody else's, of any number type.
    Any(&'a FlatSamples),
}

impl BorrowedSamples<'_> {
    /// What kind of numbers they are.
    pub fn kind(&self) -> SampleType {
        match self {
            Self::Float(_) | Self::Any(FlatSamples::F32(_)) => SampleType::F32,
            Self::Any(FlatSamples::F16(_)) => SampleType::F16,
            Self::Any(FlatSamples::U32(_)) => SampleType::U32,
        }
    }

    /// Appends those in `range` to `bytes`, little-endian.
    pub fn append_to(&self, bytes: &mut Vec<u8>, range: Range<usize>) {
        match self {
            Self::Float(values) => append(bytes, &values[range], |v| v.to_le_bytes()),
            Self::Any(FlatSamples::F32(values)) => append(bytes, &values[range], |v| v.to_le_bytes()),
            Self::Any(FlatSamples::F16(values)) => append(bytes, &values[range], |v| v.to_le_bytes()),
            Self::Any(FlatSamples::U32(values)) => append(bytes, &values[range], |v| v.to_le_bytes()),
        }
    }
}

fn append<T: Copy, const N: usize>(bytes: &mut Vec<u8>, values: &[T], to_bytes: impl Fn(T) -> [u8; N]) {
    let start = bytes.len();
    bytes.resize(start + N * values.len(), 0);
    let (places, _) = bytes[start..].as_chunks_mut::<N>();
    places.iter_mut().zip(values).for_each(|(place, value)| *place = to_bytes(*value));
}
