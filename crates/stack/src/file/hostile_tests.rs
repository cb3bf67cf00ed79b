//! Damaged and malicious files end in an error: no panic, no hang, no memory that is not there.

use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::time::{Duration, Instant};

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes,
    LineOrder, Vec2, WritableImage, f16,
};

use super::loaded::{ReadOptions, load};
use super::test_files::{Files, noise};
use super::together::alone;
use super::*;
use crate::{Fault, Noise};

/// A whole file, as it is read.
fn read_exr_from(path: &Path, source: impl Read + Seek + Send) -> Result<Layers, FileError> {
    exr_read::read_exr_from(path, source, &|_| true)
}

/// Longest that a small file may take, on a busy machine.
const LONGEST: Duration = Duration::from_secs(20);

/// A small picture in every common form.
fn seeds() -> Vec<Vec<u8>> {
    let scan = |compression| Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let tiles = |compression| Encoding { blocks: Blocks::Tiles(Vec2(4, 4)), ..scan(compression) };
    let encodings = [
        scan(Compression::Uncompressed),
        scan(Compression::RLE),
        scan(Compression::ZIP1),
        scan(Compression::ZIP16),
        scan(Compression::PIZ),
        scan(Compression::PXR24),
        scan(Compression::B44),
        tiles(Compression::Uncompressed),
        tiles(Compression::ZIP16),
        tiles(Compression::PIZ),
    ];
    encodings.into_iter().map(picture).collect()
}

fn picture(encoding: Encoding) -> Vec<u8> {
    let plane = |name: &str| (0..70).map(|i| noise(name, i)).collect::<Vec<f32>>();
    let half = |name: &str| FlatSamples::F16(plane(name).into_iter().map(f16::from_f32).collect());
    let names = [
        "R",
        "G",
        "B",
        "Albedo.R",
        "Albedo.G",
        "Albedo.B",
        "Ns.X",
        "Ns.Y",
        "Ns.Z",
        "Variance.R",
        "Variance.G",
        "Variance.B",
    ];
    let mut channels: exr::prelude::SmallVec<[AnyChannel<FlatSamples>; 4]> = names
        .map(|name| AnyChannel::new(name, if name.len() > 4 { half(name) } else { FlatSamples::F32(plane(name)) }))
        .into_iter()
        .collect();
    channels.push(AnyChannel::new("id", FlatSamples::U32((0..70).collect())));
    let layer = Layer::new((10, 7), LayerAttributes::default(), encoding, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    ExrImage::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % n
    }
}

/// One to four wounds: a byte, a number that is too large, a piece cut out or doubled, an early end.
fn wound(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        // Half of the wounds hit the header, where they do most harm.
        let reach = if random.below(2) == 0 { bytes.len().min(1200) } else { bytes.len() };
        if reach < 16 {
            return;
        }
        let at = random.below(reach - 8);
        match random.below(6) {
            0 => bytes[at] = random.below(256) as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => {
                let extremes = [0_u32, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 65536, 1 << 24];
                bytes[at..at + 4].copy_from_slice(&extremes[random.below(extremes.len())].to_le_bytes());
            }
            3 => bytes.truncate(at),
            4 => drop(bytes.drain(at..at + 1 + random.below(7))),
            _ => {
                let piece = bytes[at..at + 8].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
}

fn survive(cases: usize, seed: u64) {
    let seeds = seeds();
    let mut random = Random(seed);
    let mut read = 0;
    for case in 0..cases {
        let mut bytes = seeds[case % seeds.len()].clone();
        wound(&mut bytes, &mut random);
        let start = Instant::now();
        // What is still readable goes all the way to a stack.
        let layers = read_exr_from(Path::new("wounded.exr"), Cursor::new(bytes));
        if let Ok(stack) = layers.and_then(|layers| load(layers, &ReadOptions::default(), 0, false)).map(alone) {
            read += 1;
            let radiance = &stack.stack.components[0].radiance;
            assert!(radiance.mean.channels().iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
            if let Noise::VarianceOfMean(variance) = &radiance.noise {
                assert!(variance.channels().iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
            }
        }
        assert!(start.elapsed() < LONGEST, "case {case} took {:?}", start.elapsed());
    }
    assert!(read > cases / 100, "some wounds are harmless: {read} of {cases}");
}

#[test]
fn wounded_files_are_refused_or_read() {
    let cases = std::env::var("TAMIS_WOUNDED_FILES").ok().and_then(|n| n.parse().ok()).unwrap_or(4000);
    survive(cases, 0x9E37_79B9_7F4A_7C15);
}

#[test]
#[ignore = "takes minutes"]
fn a_million_wounded_files_are_refused_or_read() {
    survive(1_000_000, 0xD1B5_4A32_D192_ED03);
}

#[test]
fn wounded_pfm_files_are_refused_or_read() {
    let folder = Files::new();
    let (path, mut random) = (folder.path("a.pfm"), Random(77));
    for case in 0..500 {
        let mut bytes = b"PF\n4 3\n-1.0\n".to_vec();
        bytes.extend([0x3f; 144]);
        wound(&mut bytes, &mut random);
        std::fs::write(&path, bytes).unwrap();
        let _ = Layers::read(&path).map(|layers| assert!(!layers.channels.is_empty(), "{case}"));
    }
}

/// A file whose header says that its picture is `width` × `height`, and that has nothing else.
fn claims(width: i32, height: i32) -> Vec<u8> {
    let mut bytes = picture(Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    });
    for name in ["dataWindow\0box2i\0", "displayWindow\0box2i\0"] {
        let at = value_of(&bytes, name);
        bytes[at + 8..at + 12].copy_from_slice(&(width - 1).to_le_bytes());
        bytes[at + 12..at + 16].copy_from_slice(&(height - 1).to_le_bytes());
    }
    let at = value_of(&bytes, "chunkCount\0int\0");
    bytes[at..at + 4].copy_from_slice(&((height + 15) / 16).to_le_bytes());
    bytes
}

/// Where the value of an attribute begins, after its name, type and length.
fn value_of(bytes: &[u8], name: &str) -> usize {
    bytes.windows(name.len()).position(|window| window == name.as_bytes()).unwrap() + name.len() + 4
}

#[test]
fn deep_and_subsampled_files_are_refused_by_name() {
    let refusal = |bytes: Vec<u8>| read_exr_from(Path::new("a.exr"), Cursor::new(bytes)).unwrap_err().to_string();
    let whole = claims(10, 7);
    let mut deep = whole.clone();
    deep[5] |= 0x08;
    let kind = value_of(&deep, "type\0string\0");
    deep.splice(kind - 4..kind + 13, [&12_u32.to_le_bytes()[..], b"deepscanline"].concat());
    deep.splice(kind - 16..kind - 16, [&b"version\0int\0"[..], &4_u32.to_le_bytes(), &1_u32.to_le_bytes()].concat());
    assert!(refusal(deep).contains("deep"));
    let mut subsampled = whole;
    let channel = value_of(&subsampled, "channels\0chlist\0");
    // Behind the first channel's name come type, flags and its sampling in x and y.
    let sampling = channel + b"Albedo.B\0".len() + 8;
    subsampled[sampling..sampling + 4].copy_from_slice(&2_u32.to_le_bytes());
    let said = refusal(subsampled);
    assert!(said.contains("subsampl") || said.contains("sampling"), "{said}");
}

#[test]
fn a_picture_of_another_format_is_told_what_stacks_are() {
    let png = Cursor::new(b"\x89PNG\r\n\x1a\n, and so on");
    let said = read_exr_from(Path::new("a.png"), png).unwrap_err().to_string();
    assert!(said.contains("PFM"), "{said}");
}

#[test]
fn more_than_there_is_memory_is_refused_before_it_is_asked_for() {
    let start = Instant::now();
    let read = |width, height| read_exr_from(Path::new("huge.exr"), Cursor::new(claims(width, height))).unwrap_err();
    assert!(matches!(read(1_000_000_000, 1_000_000), FileError::TooLarge { .. }), "{}", read(1_000_000_000, 1_000_000));
    assert!(matches!(read(2000, 2000), FileError::Damaged { .. }), "what would fit is simply cut short");
    assert!(start.elapsed() < LONGEST);
}

/// A file that claims `width` × 10,000 pixels under compression `number`, whose blocks have `lines` rows.
fn compressed_by(number: u8, lines: i32, width: i32) -> Vec<u8> {
    let mut file = claims(width, 10_000);
    let at = value_of(&file, "compression\0compression\0");
    file[at] = number;
    let at = value_of(&file, "chunkCount\0int\0");
    file[at..at + 4].copy_from_slice(&((10_000 + lines - 1) / lines).to_le_bytes());
    file
}

#[test]
fn compressions_that_are_not_supported_are_told_from_damage() {
    let unsupported = "files of this compression are not supported; write it with ZIP";
    for (number, lines, said) in [(200, 16, unsupported), (8, 32, "it is too short")] {
        let bytes = compressed_by(number, lines, 10_000);
        let refused = read_exr_from(Path::new("a.exr"), Cursor::new(bytes)).unwrap_err().to_string();
        assert!(refused.contains(said) && refused.contains("a.exr"), "{refused}");
    }
}

#[test]
fn a_little_more_than_dwa_can_hold_is_too_much() {
    // Deflate's 1032 : 1, rounded up, for every block of 8 × 8 floats that DWA makes two bytes of; 40 bytes a pixel.
    let most = 1100 * 128 * compressed_by(8, 32, 1).len() / (40 * 10_000);
    let said = |width: usize| {
        let bytes = compressed_by(8, 32, width as i32);
        read_exr_from(Path::new("a.exr"), Cursor::new(bytes)).unwrap_err().to_string()
    };
    assert!(said(most + 8).contains("it is too short for the size"), "{}", said(most + 8));
    assert!(!said(most - 8).contains("it is too short for the size"));
}

/// A file on a disk that fails at a byte.
struct Failing(Cursor<Vec<u8>>, u64);

impl Read for Failing {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let left = self.1.saturating_sub(self.0.position());
        let wanted = buffer.len().min(left as usize);
        if wanted == 0 { Err(std::io::Error::other("bad sector")) } else { self.0.read(&mut buffer[..wanted]) }
    }
}

impl Seek for Failing {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.0.seek(to)
    }
}

#[test]
fn a_disk_that_cannot_be_read_is_told_as_such() {
    let file = seeds().remove(0);
    for good in [100, file.len() as u64 - 100] {
        let source = Failing(Cursor::new(file.clone()), good);
        let error = read_exr_from(Path::new("a.exr"), source).unwrap_err();
        assert_eq!((error.to_string(), error.fault()), ("a.exr: cannot read".into(), Fault::Input));
    }
}

#[test]
fn pictures_of_unusual_shape_are_read() {
    for (width, height) in [(1, 1), (1, 9), (9, 1), (65536, 1), (1, 4000)] {
        let plane = || FlatSamples::F32(vec![0.0; width * height]);
        let channels = ["R", "G", "B"].map(|name| AnyChannel::new(name, plane())).into_iter().collect();
        let layer = Layer::new(
            (width, height),
            LayerAttributes::default(),
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(channels),
        );
        let mut bytes = Cursor::new(Vec::new());
        ExrImage::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        let layers = read_exr_from(Path::new("odd.exr"), Cursor::new(bytes.into_inner())).unwrap();
        let read = alone(load(layers, &ReadOptions::default(), 0, false).unwrap());
        assert_eq!((read.stack.size().width, read.stack.size().height), (width, height));
    }
}
