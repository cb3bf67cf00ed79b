//! What a file says is in the file that is made of it.

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image as ExrImage, IntegerBounds, Layer,
    LayerAttributes, Text, Vec2, WritableImage, f16,
};

use super::exr_text::encoded;
use super::test_files::{Files, noise, text};
use super::*;
use crate::{FeatureStack, Image, Size, Window};

const SIZE: Size = Size::new(5, 3);

fn foreign(folder: &Files) -> std::path::PathBuf {
    let plane = |name: &str| (0..SIZE.pixels()).map(|i| noise(name, i)).collect::<Vec<f32>>();
    let mut channels: exr::prelude::SmallVec<[AnyChannel<FlatSamples>; 4]> =
        ["R", "G", "B", "A"].map(|n| AnyChannel::new(n, FlatSamples::F32(plane(n)))).into_iter().collect();
    channels.push(AnyChannel::new("crypto00.r", FlatSamples::F32(vec![f32::from_bits(0x7fa0_1234); SIZE.pixels()])));
    channels.push(AnyChannel::new("id", FlatSamples::U32(vec![u32::MAX; SIZE.pixels()])));
    channels.push(AnyChannel::new("mask.Y", FlatSamples::F16(vec![f16::from_bits(0x7e01); SIZE.pixels()])));
    let mut own = LayerAttributes { layer_position: Vec2(-7, 12), focus: Some(3.5), ..LayerAttributes::default() };
    for i in 0..12 {
        own.other.insert(Text::from(format!("cryptomatte/{i}/manifest").as_str()), text(&format!("{{\"thing\":{i}}}")));
    }
    own.other.insert(Text::from("weight"), AttributeValue::F64(0.25));
    own.other.insert(encoded("人/manifest"), AttributeValue::Text(encoded("山")));
    let layer = Layer::new((SIZE.width, SIZE.height), own, Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    let mut image = ExrImage::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((-10, 10), (40, 30));
    image.attributes.pixel_aspect = 2.0;
    let white = |x| Vec2(x, 0.3);
    image.attributes.chromaticities =
        Some(Chromaticities { red: white(0.6), green: white(0.3), blue: white(0.1), white: white(0.31) });
    let path = folder.path("in.exr");
    image.write().to_file(&path).unwrap();
    path
}

fn write(read: &ReadStack, path: &std::path::Path) {
    let header = StackHeader::of(&read.stack, serde_json::json!({}));
    let picture = Image::zeros(SIZE, 3);
    let result = ResultLayer { name: "", channels: &["R", "G", "B"], planes: picture.channels() };
    write_stack(path, &read.stack, true, &header, &[result], &read.carried).unwrap();
}

#[test]
fn windows_attributes_and_unknown_channels_survive_and_equal_runs_write_equal_bytes() {
    let folder = Files::new();
    let input = foreign(&folder);
    let before = std::fs::read(&input).unwrap();
    let outputs = ["a.exr", "b.exr", "c.exr"].map(|name| folder.path(name));
    for output in &outputs {
        write(&read_stack(&input).unwrap(), output);
    }
    let bytes = outputs.each_ref().map(|output| std::fs::read(output).unwrap());
    assert!(bytes[0] == bytes[1] && bytes[1] == bytes[2]);
    assert_eq!(std::fs::read(&input).unwrap(), before, "the input is not touched");
    let [was, is] = [&input, &outputs[0]].map(|path| exr::prelude::read_all_flat_layers_from_file(path).unwrap());
    assert_eq!(is.attributes, was.attributes);
    let (is, was) = (&is.layer_data[0], &was.layer_data[0]);
    assert_eq!((is.attributes.layer_position, is.attributes.focus), (Vec2(-7, 12), Some(3.5)));
    for (name, value) in &was.attributes.other {
        assert_eq!(is.attributes.other.get(name), Some(value), "{name}");
    }
    for name in ["A", "crypto00.r", "id", "mask.Y"] {
        let find = |layer: &Layer<AnyChannels<FlatSamples>>| {
            let channel = layer.channel_data.list.iter().find(|channel| channel.name == *name);
            bits(&channel.unwrap().sample_data)
        };
        assert_eq!(find(is), find(was), "{name}: bit for bit, in its own type");
    }
}

fn bits(samples: &FlatSamples) -> (u8, Vec<u32>) {
    match samples {
        FlatSamples::F16(values) => (16, values.iter().map(|v| u32::from(v.to_bits())).collect()),
        FlatSamples::F32(values) => (32, values.iter().map(|v| v.to_bits()).collect()),
        FlatSamples::U32(values) => (0, values.clone()),
    }
}

#[test]
fn names_and_settings_in_any_script_survive_and_equal_runs_write_equal_bytes() {
    let folder = Files::new();
    let mut read = read_stack(&foreign(&folder)).unwrap();
    read.stack.passthrough.iter_mut().for_each(|channel| channel.name = format!("カラー.{}", channel.name));
    let settings = serde_json::json!({"ファイル": "Übung"});
    let header = StackHeader::of(&read.stack, settings.clone());
    let written = [0; 4].map(|_| {
        let path = folder.path("out.exr");
        write_stack(&path, &read.stack, true, &header, &[], &read.carried).unwrap();
        std::fs::read(path).unwrap()
    });
    assert!(written.iter().all(|bytes| *bytes == written[0]));
    let again = read_stack(&folder.path("out.exr")).unwrap();
    assert_eq!(again.header.unwrap().settings, settings);
    let names = |stack: &FeatureStack| stack.passthrough.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&again.stack), names(&read.stack));
    assert_eq!(again.carried.text("人/manifest"), read.carried.text("人/manifest"));
    assert!(again.carried.text("人/manifest").is_some_and(|text| text == "山"));
}

#[test]
fn a_foreign_stack_that_was_written_is_read_again_as_it_was() {
    let folder = Files::new();
    let names = ["R", "G", "B", "Variance.R", "Variance.G", "Variance.B", "Ns.X", "Ns.Y", "Ns.Z"];
    let spp = [("samplesPerPixel", AttributeValue::I32(16))];
    let variance = folder.exr("variance.exr", &names, &noise, &spp);
    let halves = Inputs::Halves(
        [3, 5].map(|n| {
            let values = move |name: &str, pixel: usize| noise(&format!("{n}{name}"), pixel);
            folder.exr(&format!("{n}.exr"), &names, &values, &[("samplesPerPixel", AttributeValue::I32(n))])
        }),
        Vec::new(),
    );
    let options = ReadOptions::default();
    for inputs in [Inputs::Files(vec![Source::from(variance.as_path())]), halves] {
        let first = read_inputs(&inputs, &options).unwrap();
        let path = folder.path("again.exr");
        let header = StackHeader::of(&first.stack, serde_json::json!({}));
        write_stack(&path, &first.stack, true, &header, &[], &first.carried).unwrap();
        let again = read_stack(&path).unwrap();
        assert_eq!(again.stack.components, first.stack.components);
        assert_eq!(again.stack.features, first.stack.features);
        assert_eq!(again.stack.samples.total, first.stack.samples.total);
        assert_eq!(again.carried.number(("samplesPerPixel", "")), first.carried.number(("samplesPerPixel", "")));
    }
}

#[test]
fn an_output_may_replace_its_input() {
    let folder = Files::new();
    let path = foreign(&folder);
    let read = read_stack(&path).unwrap();
    write(&read, &path);
    assert_eq!(read_stack(&path).unwrap().stack.window, Window { x: 3, y: 2, size: SIZE });
}
