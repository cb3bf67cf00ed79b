//! Numbers in the bytes of a glTF file: what its accessors say is there, checked against what is.

use gltf::Accessor;
use gltf::accessor::DataType;
use gltf::accessor::sparse::IndexType;
use gltf::buffer::View;

use super::buffers::Buffers;

/// Elements that an accessor may claim without bytes for them.
const UNBACKED: usize = 1 << 16;

/// The elements of `accessor`, of `N` numbers each. Integers that are marked as normalised are shares of their largest value.
///
/// # Errors
/// In words, when they have another number of numbers, or are not all there.
pub(super) fn vectors<const N: usize>(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<[f32; N]>, String> {
    numbers(accessor, buffers, accessor.normalized())
}

/// The same of what can only be shares: integers are, whether they are marked or not.
///
/// # Errors
/// As [`vectors`].
pub(super) fn shares<const N: usize>(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<[f32; N]>, String> {
    numbers(accessor, buffers, true)
}

fn numbers<const N: usize>(accessor: &Accessor, buffers: &Buffers, normalised: bool) -> Result<Vec<[f32; N]>, String> {
    let found = accessor.dimensions().multiplicity();
    if found != N {
        return Err(format!("accessors[{}] has {found} numbers for each element, expected {N}", accessor.index()));
    }
    let kind = accessor.data_type();
    let size = kind.size();
    elements(accessor, buffers, [0.0; N], |bytes| std::array::from_fn(|i| number(&bytes[i * size..], kind, normalised)))
}

/// Checks that there is one of `what` for each of the `vertices`.
///
/// # Errors
/// In words, when there is not.
pub(super) fn as_many(what: &str, count: usize, vertices: usize) -> Result<(), String> {
    if count == vertices { Ok(()) } else { Err(format!("{count} {what}s for {vertices} positions")) }
}

/// The elements of `accessor`, of `N` whole numbers each.
///
/// # Errors
/// As [`vectors`].
pub(super) fn whole_vectors<const N: usize>(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<[u32; N]>, String> {
    let (kind, found) = (accessor.data_type(), accessor.dimensions().multiplicity());
    if found != N || !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(format!("accessors[{}] does not hold {N} whole numbers for each element", accessor.index()));
    }
    let size = kind.size();
    elements(accessor, buffers, [0; N], |bytes| std::array::from_fn(|i| whole(&bytes[i * size..], size)))
}

/// The elements of `accessor`, which are single whole numbers.
///
/// # Errors
/// In words, when they are something else, or are not all there.
pub(super) fn indices(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<u32>, String> {
    let kind = accessor.data_type();
    if accessor.dimensions().multiplicity() != 1 || !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(format!("accessors[{}] does not hold whole numbers, as indices are", accessor.index()));
    }
    elements(accessor, buffers, 0, |bytes| whole(bytes, kind.size()))
}

/// All elements, as `read` makes them of their bytes.
fn elements<T: Clone>(
    accessor: &Accessor,
    buffers: &Buffers,
    nothing: T,
    read: impl Fn(&[u8]) -> T,
) -> Result<Vec<T>, String> {
    let (count, size) = (accessor.count(), accessor.size());
    let claims = |what: &str| format!("accessors[{}] claims {count} elements, {what}", accessor.index());
    let mut all: Vec<T> = match accessor.view() {
        Some(view) => {
            let stride = view.stride().unwrap_or(size);
            let some = pieces(&view, buffers, [accessor.offset(), stride, size, count])?;
            some.ok_or_else(|| claims("more than its view has bytes for"))?.map(&read).collect()
        }
        None if count > UNBACKED.max(buffers.bytes()) => return Err(claims("more than the file has bytes")),
        None => vec![nothing; count],
    };
    let Some(sparse) = accessor.sparse() else { return Ok(all) };
    let (places, values) = (sparse.indices(), sparse.values());
    let width = match places.index_type() {
        IndexType::U8 => 1,
        IndexType::U16 => 2,
        IndexType::U32 => 4,
    };
    let [places, values] = [(places.view(), places.offset(), width), (values.view(), values.offset(), size)]
        .map(|(view, offset, size)| pieces(&view, buffers, [offset, size, size, sparse.count()]).transpose());
    let short = || claims("of which those that are set apart are not all there");
    for (place, value) in places.ok_or_else(short)??.zip(values.ok_or_else(short)??) {
        *all.get_mut(whole(place, width) as usize).ok_or_else(short)? = read(value);
    }
    Ok(all)
}

/// The bytes of `count` elements of `size` bytes in a view, the first at `offset`, one every `stride` bytes. `None` when they
/// are not all there.
fn pieces<'a>(
    view: &View,
    buffers: &'a Buffers,
    [offset, stride, size, count]: [usize; 4],
) -> Result<Option<impl Iterator<Item = &'a [u8]> + use<'a>>, String> {
    let bytes = buffers.view(view)?;
    let reach = |count: usize| (count - 1).checked_mul(stride)?.checked_add(offset)?.checked_add(size);
    let sound = count == 0 || (stride >= size && reach(count).is_some_and(|end| end <= bytes.len()));
    Ok(sound.then(|| (0..count).map(move |i| &bytes[offset + i * stride..][..size])))
}

fn whole(bytes: &[u8], size: usize) -> u32 {
    bytes[..size].iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

fn number(bytes: &[u8], kind: DataType, normalised: bool) -> f32 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, largest) = match kind {
        DataType::I8 => (f32::from(bytes[0] as i8), f32::from(i8::MAX)),
        DataType::U8 => (f32::from(bytes[0]), f32::from(u8::MAX)),
        DataType::I16 => (f32::from(i16::from_le_bytes(two())), f32::from(i16::MAX)),
        DataType::U16 => (f32::from(u16::from_le_bytes(two())), f32::from(u16::MAX)),
        DataType::U32 => (u32::from_le_bytes(four()) as f32, u32::MAX as f32),
        DataType::F32 => return f32::from_le_bytes(four()),
    };
    if normalised { (value / largest).max(-1.0) } else { value }
}
