//! Writes the channels of an EXR file as zipped scan lines.
//!
//! Zipped here and not by the `exr` crate, which takes more than twice as long over a file of the same size.

use std::io::{Seek, Write};

use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::ChunksWriter;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::{ChannelDescription, Compression, ImageAttributes, LayerAttributes, LineOrder, Text};
use flate2::{Compress, FlushCompress, Status};
use rayon::prelude::*;

use super::borrowed::BorrowedSamples;
use super::in_flight::blocks_at_once;

/// Lines that are zipped together, where they are short. Every reader takes it.
const LINES: usize = 16;

/// Longest line, in bytes, that is zipped with others. Deflate looks back over 32 KiB only, and a line holds one channel after
/// another, so nothing is found again in the next line of a longer one; but whoever reads a block holds it whole.
const LONGEST_TOGETHER: usize = 64 << 10;

/// How hard to zip: above, files get smaller by less than a hundredth, below, larger by a fourteenth.
const LEVEL: u32 = 2;

/// Writes `channels` of `size` = (width, height) as a file of one part, with the given attributes. The bytes do not depend
/// on the thread count.
///
/// # Errors
/// When `out` fails, or the names or attributes make no valid file.
pub fn write_exr(
    out: impl Write + Seek + Send,
    size: (usize, usize),
    (image_attributes, attributes): (ImageAttributes, LayerAttributes),
    mut channels: Vec<(Text, BorrowedSamples<'_>)>,
) -> exr::error::UnitResult {
    channels.sort_by(|a, b| a.0.cmp(&b.0));
    let described = channels.iter().map(|(name, samples)| ChannelDescription::named(name.clone(), samples.kind()));
    let top = attributes.layer_position.y();
    let line_bytes = size.0 * channels.iter().map(|(_, samples)| samples.kind().bytes_per_sample()).sum::<usize>();
    let (compression, together) =
        if line_bytes > LONGEST_TOGETHER { (Compression::ZIP1, 1) } else { (Compression::ZIP16, LINES) };
    let header = Header::new(Text::default(), size, described.collect())
        .with_encoding(compression, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_shared_attributes(image_attributes)
        .with_attributes(attributes);
    let (width, height) = size;
    let samples: Vec<BorrowedSamples> = channels.into_iter().map(|(_, samples)| samples).collect();
    let lines = |block: usize| block * together..((block + 1) * together).min(height);
    let zip = |block: usize| zipped(|| bytes_of(lines(block), width, &samples));
    let blocks: Vec<usize> = (0..height.div_ceil(together)).collect();
    exr::block::write(out, [header].into_iter().collect(), true, |_, writer| {
        let mut put = |zipped: Vec<(usize, Vec<u8>)>| {
            zipped.into_iter().try_for_each(|(block, compressed_pixels_le)| {
                let y_coordinate = top + (block * together) as i32;
                let lines = CompressedScanLineBlock { y_coordinate, compressed_pixels_le };
                writer.write_chunk(block, Chunk { layer_index: 0, compressed_block: CompressedBlock::ScanLine(lines) })
            })
        };
        let mut ready = Vec::new();
        for blocks in blocks.chunks(blocks_at_once(line_bytes * together)) {
            let zip_all = || blocks.par_iter().map(|block| (*block, zip(*block))).collect();
            let (written, zipped) = rayon::join(|| put(ready), zip_all);
            written?;
            ready = zipped;
        }
        put(ready)
    })
}

/// Some `lines` as they stand in a file: line by line, within one channel by channel, little-endian.
fn bytes_of(lines: std::ops::Range<usize>, width: usize, channels: &[BorrowedSamples]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for line in lines {
        channels.iter().for_each(|channel| channel.append_to(&mut bytes, line * width..(line + 1) * width));
    }
    bytes
}

/// What `make` returns, zipped; as it is where that is not shorter.
fn zipped(make: impl Fn() -> Vec<u8>) -> Vec<u8> {
    let mut bytes = make();
    take_differences(&mut bytes);
    let mut zipped = Vec::with_capacity(bytes.len());
    match Compress::new(flate2::Compression::new(LEVEL), true).compress_vec(&bytes, &mut zipped, FlushCompress::Finish)
    {
        Ok(Status::StreamEnd) if zipped.len() < bytes.len() => zipped,
        _ => make(),
    }
}

/// What makes numbers short when zipped: first every other byte, then the rest, each as its difference to the one before
/// (OpenEXR's technical introduction, "ZIP").
fn take_differences(bytes: &mut [u8]) {
    // Nothing is taken off the first.
    let mut parted = vec![128; 1 + bytes.len()];
    let (even, odd) = parted[1..].split_at_mut(bytes.len() / 2);
    for ((pair, even), odd) in bytes.chunks_exact(2).zip(even).zip(odd) {
        (*even, *odd) = (pair[0], pair[1]);
    }
    for ((byte, before), this) in bytes.iter_mut().zip(&parted).zip(&parted[1..]) {
        *byte = this.wrapping_sub(*before).wrapping_add(128);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::prelude::{FlatSamples, IntegerBounds, Vec2, f16, read_all_flat_layers_from_file};

    use super::super::test_files::{Files, noise};
    use super::*;

    #[test]
    fn long_lines_are_zipped_one_by_one() {
        let folder = Files::new();
        for (width, compression) in [(16_384, Compression::ZIP16), (16_385, Compression::ZIP1)] {
            let values: Vec<f32> = (0..width * 18).map(|i| noise("Y", i)).collect();
            let mut bytes = Vec::new();
            let image = ImageAttributes::new(IntegerBounds::from_dimensions((width, 18)));
            let channels = vec![(Text::from("Y"), BorrowedSamples::Float(&values))];
            write_exr(Cursor::new(&mut bytes), (width, 18), (image, LayerAttributes::default()), channels).unwrap();
            let path = folder.path("long.exr");
            std::fs::write(&path, bytes).unwrap();
            let read = read_all_flat_layers_from_file(&path).unwrap();
            assert_eq!(read.layer_data[0].encoding.compression, compression);
            assert!(read.layer_data[0].channel_data.list[0].sample_data == FlatSamples::F32(values));
        }
    }

    #[test]
    fn another_reader_finds_every_bit_whether_lines_get_shorter_or_not() {
        // Two whole blocks of lines and the start of a third.
        let (width, height) = (37, 35);
        let pixels = width * height;
        // Bits of which none follows from the others.
        let random =
            |i: usize| (i as u32 + 1).wrapping_mul(0x9E37_79B9).rotate_left(i as u32 % 31).wrapping_mul(0x85EB_CA6B);
        let smooth: Vec<f32> = (0..pixels).map(|i| (i / width) as f32).collect();
        let rough: Vec<f32> = (0..pixels).map(|i| f32::from_bits(random(i))).collect();
        let half = FlatSamples::F16((0..pixels).map(|i| f16::from_f32(noise("half", i))).collect());
        let ids = FlatSamples::U32((0..pixels).map(random).collect());
        let file = |named: &[(&str, BorrowedSamples)]| {
            let mut bytes = Vec::new();
            let display = IntegerBounds::new((-3, 5), (100, 90));
            let own = LayerAttributes { layer_position: Vec2(-2, -9), ..LayerAttributes::default() };
            let channels = named.iter().map(|(name, samples)| (Text::from(*name), *samples)).collect();
            write_exr(Cursor::new(&mut bytes), (width, height), (ImageAttributes::new(display), own), channels)
                .unwrap();
            bytes
        };
        let named = [
            ("smooth", BorrowedSamples::Float(&smooth)),
            ("rough", BorrowedSamples::Float(&rough)),
            ("half", BorrowedSamples::Any(&half)),
            ("ids", BorrowedSamples::Any(&ids)),
        ];
        let folder = Files::new();
        let path = folder.path("a.exr");
        std::fs::write(&path, file(&named)).unwrap();
        let read = read_all_flat_layers_from_file(&path).unwrap();
        let layer = &read.layer_data[0];
        assert_eq!(layer.attributes.layer_position, Vec2(-2, -9));
        let expected = [&half, &ids, &FlatSamples::F32(rough.clone()), &FlatSamples::F32(smooth.clone())];
        for (found, expected) in layer.channel_data.list.iter().zip(expected) {
            let bits = |samples: &FlatSamples| match samples {
                FlatSamples::F16(values) => values.iter().map(|v| u32::from(v.to_bits())).collect::<Vec<u32>>(),
                FlatSamples::F32(values) => values.iter().map(|v| v.to_bits()).collect(),
                FlatSamples::U32(values) => values.clone(),
            };
            assert!(bits(&found.sample_data) == bits(expected), "{}", found.name);
        }
        assert!(file(&named[..1]).len() < 1500, "whole rows are alike");
        assert!((4 * pixels..4 * pixels + 500).contains(&file(&named[1..2]).len()), "as they are");
    }
}
