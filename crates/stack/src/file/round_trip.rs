//! Tests that a stack survives its file.

use super::picture::read_picture_layers;
use super::taken::{Taken, read_taken};
use super::*;
use crate::{
    Component, ComponentRole, Dealing, Estimate, Feature, FeatureRole, FeatureStack, GATHERED, INDIRECT, Image,
    SampleCounts, Size, Window,
};

const SIZE: Size = Size::new(5, 4);

fn image(channels: usize, seed: usize) -> Image {
    let value = |c: usize, i: usize| ((seed * 31 + c * 17 + i * 7) % 23) as f32 * 0.1;
    Image::from_channels(SIZE, (0..channels).map(|c| (0..SIZE.pixels()).map(|i| value(c, i)).collect()).collect())
}

fn stack() -> FeatureStack {
    let samples = SampleCounts {
        first: 0,
        total: (0..SIZE.pixels()).map(|i| 4 + (i % 9) as u32).collect(),
        dealing: Dealing::Numbered { sequences: 8, buckets: 8 },
    };
    let buckets = |seed: usize| {
        let mut buckets: Vec<Image> = (0..8).map(|b| image(3, seed + b)).collect();
        for (b, bucket) in buckets.iter_mut().enumerate() {
            for pixel in 0..SIZE.pixels() {
                if samples.in_group(pixel, b, 8) == 0 {
                    bucket.channels_mut().iter_mut().for_each(|plane| plane[pixel] = 0.0);
                }
            }
        }
        Estimate::from_buckets(buckets, &samples)
    };
    let components = ComponentRole::ALL.iter().map(|&role| Component { role, radiance: buckets(role as usize) });
    let feature = |role: FeatureRole| {
        let n = role.channels().len();
        Estimate::from_buckets(vec![image(n, 40 + role as usize), image(n, 50 + role as usize)], &samples)
    };
    FeatureStack {
        window: Window { x: 2, y: 1, size: SIZE },
        film: Size::new(9, 8),
        components: components.collect(),
        indirect: Some(buckets(70)),
        gathered: Some(buckets(71)),
        features: FeatureRole::ALL.iter().map(|&role| Feature { role, estimate: feature(role) }).collect(),
        passthrough: Vec::new(),
        samples,
    }
}

fn header() -> StackHeader {
    let held = vec![crate::merge::Held { first: 0, end: 12, seed: u64::MAX }];
    let record = Some(crate::merge::Record { view: serde_json::json!({"camera": {"fov": 45.5}}), held });
    let settings = serde_json::json!({"seed": 3});
    StackHeader { first: 0, sequences: 8, buckets: 8, per_bucket: None, settings, record, samples_unknown: false }
}

#[test]
fn a_stack_is_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.exr");
    let stack = stack();
    let picture = image(3, 99);
    let results = [ResultLayer { name: "", channels: &["R", "G", "B"], planes: picture.channels() }];
    write_stack(&path, &stack, true, &header(), &results, &Carried::default()).unwrap();
    let read = read_stack(&path).unwrap();
    assert_eq!(read.header.unwrap(), header());
    assert_eq!(read.stack, stack);
    assert_eq!(read_picture(&path).unwrap(), picture);
}

#[test]
fn counts_of_samples_that_nobody_knows_are_no_number_of_samples() {
    let folder = tempfile::tempdir().unwrap();
    for samples_unknown in [false, true] {
        let path = folder.path().join(format!("{samples_unknown}.exr"));
        let header = StackHeader { samples_unknown, record: None, ..header() };
        write_stack(&path, &stack(), true, &header, &[], &Carried::default()).unwrap();
        let read = read_stack(&path).unwrap();
        assert_eq!(read.stack, stack());
        assert_eq!(read.found.spp.is_none(), samples_unknown, "{:?}", read.notes);
        let (mut other, second) = (stack(), folder.path().join("second.exr"));
        let planes = other.components.iter_mut().flat_map(|part| part.radiance.mean.channels_mut());
        planes.flatten().for_each(|value| *value *= 1.5);
        write_stack(&second, &other, true, &header, &[], &Carried::default()).unwrap();
        assert_eq!(read_buckets(&[path.clone(), second]).unwrap().found.spp.is_none(), samples_unknown);
        let (_, record) = read_picture_with_record(&path).unwrap();
        assert_eq!(record.spp.is_none(), samples_unknown);
    }
}

#[test]
fn a_header_that_cannot_be_is_refused_and_its_picture_still_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.exr");
    let wrong = [
        StackHeader { sequences: 0, ..header() },
        StackHeader { sequences: 9, ..header() },
        StackHeader { buckets: 4, ..header() },
        StackHeader { buckets: 0, ..header() },
        StackHeader { buckets: 1 << 31, ..header() },
        StackHeader { per_bucket: Some(vec![3; 7]), ..header() },
        StackHeader { per_bucket: Some(vec![u32::MAX; 8]), ..header() },
        StackHeader { first: u32::MAX - 8, ..header() },
    ];
    let picture = image(3, 99);
    let results = [ResultLayer { name: "", channels: &["R", "G", "B"], planes: picture.channels() }];
    for header in wrong {
        write_stack(&path, &stack(), true, &header, &results, &Carried::default()).unwrap();
        let refused = read_stack(&path).unwrap_err().to_string();
        assert!(refused.contains("its attribute tamis says"), "{header:?}: {refused}");
        assert_eq!(read_picture_with_record(&path).unwrap().0, picture);
    }
    let last = StackHeader { first: u32::MAX - 12, ..header() };
    write_stack(&path, &stack(), true, &last, &[], &Carried::default()).unwrap();
    assert_eq!(read_stack(&path).unwrap().stack.samples.in_group(8, 0, 1), 12);
}

#[test]
fn no_more_is_read_than_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.exr");
    let picture = image(3, 99);
    let planes = picture.channels();
    let results = [
        ResultLayer { name: "", channels: &["R", "G", "B"], planes },
        ResultLayer { name: "mse", channels: &["Y"], planes: &planes[..1] },
    ];
    write_stack(&path, &stack(), true, &header(), &results, &Carried::default()).unwrap();
    let names = |layers: Layers| layers.channels.into_iter().map(|channel| channel.name).collect::<Vec<_>>();
    let taken = |taken| names(read_taken(&path, taken).unwrap());
    // Both components and parts of light in eight buckets, features of thirteen channels in two, and counts.
    let inputs = 4 * 27 + 3 * 13 + 1;
    assert_eq!(taken(Taken::Everything).len(), inputs + 4);
    assert_eq!(taken(Taken::InputsBut(&[])).len(), inputs);
    assert_eq!(taken(Taken::InputsBut(&[INDIRECT, GATHERED])).len(), inputs - 2 * 27);
    assert_eq!(taken(Taken::Means).len(), 2 * 3 + 13 + 1);
    assert_eq!(names(read_picture_layers(&path).unwrap()), ["B", "G", "R", "samples.Y"]);
    let options = ReadOptions { leave_out: vec![INDIRECT, GATHERED], ..ReadOptions::default() };
    let inputs = Inputs::Files(vec![Source::from(path.as_path())]);
    let read = read_inputs(&inputs, &options).unwrap().stack;
    assert_eq!(survey(&inputs, &options).unwrap().bytes, read.bytes());
    assert_eq!(read, FeatureStack { indirect: None, gathered: None, ..stack() });
}

#[test]
fn adding_slices_up_takes_the_memory_of_two() {
    let folder = tempfile::tempdir().unwrap();
    let slices = [1, 2].map(|seed| {
        let path = folder.path().join(format!("{seed}.exr"));
        let held = vec![crate::merge::Held { first: 0, end: 12, seed }];
        let record = Some(crate::merge::Record { view: serde_json::json!({}), held });
        write_stack(&path, &stack(), true, &StackHeader { record, ..header() }, &[], &Carried::default()).unwrap();
        path
    });
    let told =
        |slices: &[std::path::PathBuf]| survey(&Inputs::Slices(slices.to_vec()), &ReadOptions::default()).unwrap();
    let (one, both) = (told(&slices[..1]), told(&slices));
    assert_eq!(one.reading_bytes, one.bytes);
    assert!(both.reading_bytes > 2 * one.bytes);
}

#[test]
fn equal_stacks_write_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let written = ["a.exr", "b.exr"].map(|name| {
        let path = folder.path().join(name);
        write_stack(&path, &stack(), true, &header(), &[], &Carried::default()).unwrap();
        std::fs::read(path).unwrap()
    });
    assert_eq!(written[0], written[1]);
}

#[test]
fn renders_of_ours_that_share_samples_are_no_buckets() {
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, seed: u64, brightness: f32| {
        let (mut stack, path) = (stack(), folder.path().join(name));
        let planes = stack.components.iter_mut().flat_map(|part| part.radiance.mean.channels_mut());
        planes.flatten().for_each(|value| *value *= brightness);
        let held = vec![crate::merge::Held { first: 4, end: 12, seed }];
        let record = Some(crate::merge::Record { view: serde_json::json!({}), held });
        write_stack(&path, &stack, true, &StackHeader { record, ..header() }, &[], &Carried::default()).unwrap();
        path
    };
    let [a, b, c] = [("a.exr", 1, 1.0), ("b.exr", 2, 1.5), ("c.exr", 1, 2.0)].map(|(n, seed, by)| render(n, seed, by));
    read_buckets(&[a.clone(), b.clone()]).unwrap();
    let error = read_buckets(&[a, b, c]).unwrap_err().to_string();
    assert!(error.contains("c.exr: holds the samples 4..12 of seed 1, but"), "{error}");
}

#[test]
fn buckets_from_several_files_make_one_stack() {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<_> = (0..4)
        .map(|b| {
            let path = folder.path().join(format!("b{b}.exr"));
            write_picture(&path, &image(3, b)).unwrap();
            path
        })
        .collect();
    let read = read_buckets(&paths).unwrap();
    assert!(matches!(&read.stack.components[..], [Component { role: ComponentRole::Scattered, .. }]));
    assert!((read.stack.beauty().mean_at(3) - (0..4).map(|b| image(3, b).mean_at(3)).sum::<f32>() / 4.0).abs() < 1e-5);

    std::fs::copy(&paths[0], &paths[2]).unwrap();
    assert!(matches!(read_buckets(&paths), Err(FileError::SameNoise { .. })));
    assert!(matches!(read_buckets(&paths[..1]), Err(FileError::TooFewBuckets { found: 1 })));
    write_picture(&paths[1], &Image::zeros(Size::new(2, 2), 3)).unwrap();
    assert!(matches!(read_buckets(&paths), Err(FileError::SizeDiffers { .. })));
}
