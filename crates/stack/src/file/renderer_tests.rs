//! What each renderer writes is understood without a word from the user.

use super::test_files::{Files, SIZE, noise, noise_of, shared, text};
use super::*;
use crate::{Dealing, Estimate, FeatureRole, Image, Noise};
use exr::prelude::AttributeValue;

fn read(path: &std::path::Path) -> ReadStack {
    read_stack(path).unwrap_or_else(|error| panic!("{error}"))
}

fn files(paths: &[std::path::PathBuf]) -> Inputs {
    Inputs::Files(paths.iter().map(|path| Source::from(path.as_path())).collect())
}

fn read_files(paths: &[std::path::PathBuf]) -> ReadStack {
    read_inputs(&files(paths), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn colour(read: &ReadStack) -> &Estimate {
    &read.stack.components[0].radiance
}

fn feature(read: &ReadStack, role: FeatureRole) -> &Image {
    &read.stack.feature(role).unwrap_or_else(|| panic!("no {role:?}")).estimate.mean
}

fn layers_of(read: &ReadStack) -> Vec<String> {
    read.found.roles.iter().map(|found| format!("{}={}", found.role, found::layer_name(&found.channels))).collect()
}

fn scaled(image: &Image, factor: f32) -> Image {
    let planes = image.channels().iter().map(|plane| plane.iter().map(|v| v * factor).collect()).collect();
    Image::from_channels(image.size(), planes)
}

fn triples(names: &[&str], suffixes: &str) -> Vec<String> {
    names.iter().flat_map(|name| suffixes.chars().map(move |c| format!("{name}.{c}"))).collect()
}

#[test]
fn pbrt_says_its_samples_and_the_variance_of_one() {
    let folder = Files::new();
    let mut channels = triples(&["P", "N", "Ns"], "XYZ");
    channels.extend(triples(&["Albedo", "Variance", "RelativeVariance"], "RGB"));
    channels.extend(["R", "G", "B", "dzdx", "dzdy", "u", "v"].map(String::from));
    let channels: Vec<&str> = channels.iter().map(String::as_str).collect();
    let path = folder.half(
        "gbuffer.exr",
        &channels,
        &noise,
        &[("samplesPerPixel", AttributeValue::I32(16)), ("MSE", AttributeValue::F32(0.1))],
    );
    let read = read(&path);
    assert_eq!(read.found.renderer, "pbrt-v4");
    assert_eq!(layers_of(&read), ["colour=R G B", "position=P", "albedo=Albedo", "normal=Ns"]);
    let variance = scaled(&noise_of(&["Variance.R", "Variance.G", "Variance.B"]), 1.0 / 16.0);
    assert_eq!(colour(&read).noise, Noise::VarianceOfMean(variance));
    assert_eq!(read.stack.samples.total, [16; 48]);
    let carried: Vec<&str> = read.stack.passthrough.iter().map(|c| c.name.as_str()).collect();
    assert!(
        carried.contains(&"u") && carried.contains(&"RelativeVariance.R") && carried.contains(&"N.X"),
        "{carried:?}"
    );
    assert!(carried.iter().all(|name| !name.starts_with("Variance")));
    assert!(matches!(read.stack.passthrough[0].samples, exr::prelude::FlatSamples::F16(_)), "half stays half");
    let spp = ReadOptions { spp: vec![4], variance_is: Some(Convention::StandardError), ..ReadOptions::default() };
    let read = read_inputs(&files(&[path]), &spp).unwrap();
    assert_eq!(read.stack.samples.total, [4; 48]);
    let Noise::VarianceOfMean(variance) = &colour(&read).noise else { panic!("a variance") };
    assert_eq!(variance.channels()[0][5], noise("Variance.R", 5).powi(2));
}

/// Unit vectors but for a miss.
fn unit(name: &str, pixel: usize) -> f32 {
    let angle = 0.3 * pixel as f32;
    match (pixel, name.rsplit('.').next()) {
        (0, _) => 0.0,
        (_, Some("X")) => angle.cos(),
        (_, Some("Y")) => 0.6 * angle.sin(),
        _ => 0.8 * angle.sin(),
    }
}

fn mitsuba(folder: &Files, normals: &[&str]) -> std::path::PathBuf {
    let mut channels = triples(normals, "XYZ");
    channels.extend(triples(&["where"], "XYZ"));
    channels.extend(triples(&["reflectance"], "RGB"));
    channels.extend(["far.T", "R", "G", "B", "img.R", "img.G", "img.B", "img.A", "shape.I"].map(String::from));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let values = |name: &str, pixel: usize| match name.split('.').next() {
        Some("where") => 7.0 + noise(name, pixel),
        Some(layer) if normals.contains(&layer) => unit(name, pixel),
        _ => noise(name, pixel),
    };
    folder.exr("mitsuba.exr", &names, &values, &[("generatedBy", text("Mitsuba version 3.9.1"))])
}

#[test]
fn mitsubas_layers_are_told_by_their_values() {
    let folder = Files::new();
    let read = read(&mitsuba(&folder, &["oriented"]));
    let expected = ["colour=R G B", "position=where", "albedo=reflectance", "normal=oriented", "depth=far"];
    assert_eq!(layers_of(&read), expected);
    assert!(read.found.roles.iter().any(|found| found.guessed));
}

#[test]
fn the_shading_normal_is_preferred_and_a_tie_is_a_question() {
    let folder = Files::new();
    let found = read(&mitsuba(&folder, &["my_geo", "my_sh"]));
    assert!(layers_of(&found).contains(&"normal=my_sh".into()), "{:?}", layers_of(&found));
    let path = mitsuba(&folder, &["one", "two"]);
    let error = read_stack(&path).unwrap_err().to_string();
    assert!(error.contains("'one'") && error.contains("'two'") && error.contains("--map normal="), "{error}");
    let map =
        |layer: &str| ReadOptions { map: vec![("normal".parse().unwrap(), layer.into())], ..ReadOptions::default() };
    let mapped = read_inputs(&files(std::slice::from_ref(&path)), &map("two.")).unwrap();
    assert!(layers_of(&mapped).contains(&"normal=two".into()));
    let none = read_inputs(&files(std::slice::from_ref(&path)), &map("none")).unwrap();
    assert!(none.stack.feature(FeatureRole::Normal).is_none());
    assert!(read_inputs(&files(&[path]), &map("three")).unwrap_err().to_string().contains("three"));
}

#[test]
fn mitsubas_second_moments_need_the_number_of_samples() {
    let folder = Files::new();
    let channels = ["R", "G", "B", "img.X", "img.Y", "img.Z", "m2_img.X", "m2_img.Y", "m2_img.Z"];
    let values = |name: &str, pixel: usize| {
        let mean = 1.0 + noise(&name[name.len() - 1..].replace('X', "R").replace('Y', "G").replace('Z', "B"), pixel);
        if name.starts_with("m2") { mean * mean + 0.75 } else { mean }
    };
    let path = folder.exr("moment.exr", &channels, &values, &[("generatedBy", text("Mitsuba"))]);
    let unknown = read(&path);
    assert_eq!(colour(&unknown).noise, Noise::Unknown);
    assert!(unknown.notes.iter().any(|note| note.contains("--spp")), "{:?}", unknown.notes);
    let read = read_inputs(&files(&[path]), &ReadOptions { spp: vec![4], ..ReadOptions::default() }).unwrap();
    let Noise::VarianceOfMean(variance) = &colour(&read).noise else { panic!("a variance") };
    assert!(variance.channels().iter().flatten().all(|v| (v - 0.25).abs() < 1e-5), "0.75 / (4 − 1)");
}

/// `moment` around `aov`, and `aov` around `moment`.
#[test]
fn mitsubas_moments_have_layers_of_their_own() {
    let folder = Files::new();
    let layers = |prefix: &str| {
        let mut channels = triples(&[""], "XYZ").iter().map(|c| format!("{prefix}{c}")).collect::<Vec<_>>();
        channels.extend(triples(&[&format!("{prefix}.where"), &format!("{prefix}.nn")], "XYZ"));
        channels.extend(triples(&[&format!("{prefix}.albedo")], "RGB"));
        channels
    };
    let mut channels = [layers("img"), layers("m2_img"), vec!["R".into(), "G".into(), "B".into()]].concat();
    let values = |name: &str, pixel: usize| match name.split('.').nth(1) {
        Some("nn") => unit(name, pixel),
        Some("where") => 7.0 + noise(name, pixel),
        _ => noise(name, pixel),
    };
    let options = ReadOptions { spp: vec![4], ..ReadOptions::default() };
    let write = |name: &str, channels: &[String]| {
        let names: Vec<&str> = channels.iter().map(String::as_str).collect();
        let path = folder.exr(name, &names, &values, &[("generatedBy", text("Mitsuba version 3.9.1"))]);
        read_inputs(&files(&[path]), &options).unwrap_or_else(|error| panic!("{error}"))
    };
    let around = write("around.exr", &channels);
    let expected = ["colour=R G B", "position=img.where", "albedo=img.albedo", "normal=img.nn"];
    assert_eq!(layers_of(&around), expected);
    for role in [FeatureRole::Position, FeatureRole::Albedo, FeatureRole::Normal] {
        let noise = &around.stack.feature(role).unwrap().estimate.noise;
        assert!(matches!(noise, Noise::VarianceOfMean(_)), "{role:?}");
    }
    channels = triples(&["outer.img", "outer.m2_img", "nn"], "XYZ");
    channels.extend(triples(&["outer"], "RGB"));
    channels.extend(["R", "G", "B"].map(String::from));
    let within = write("within.exr", &channels);
    assert!(matches!(colour(&within).noise, Noise::VarianceOfMean(_)), "{:?}", within.notes);
}

#[test]
fn grey_pictures_and_those_of_cie_xyz_are_pictures() {
    let folder = Files::new();
    let mitsuba = [("generatedBy", text("Mitsuba version 3.9.1"))];
    let grey = read(&folder.exr("grey.exr", &["Y", "A", "albedo.R", "albedo.G", "albedo.B"], &noise, &mitsuba));
    assert_eq!(layers_of(&grey), ["colour=Y", "albedo=albedo", "alpha=A"]);
    assert_eq!(colour(&grey).mean, noise_of(&["Y", "Y", "Y"]));
    let white = |name: &str, _: usize| {
        if name == "X" {
            0.950_456
        } else if name == "Z" {
            1.089_058
        } else {
            1.0
        }
    };
    let path = folder.exr("xyz.exr", &["X", "Y", "Z"], &white, &mitsuba);
    let xyz = read(&path);
    assert_eq!(xyz.found.roles[0].channels, ["X", "Y", "Z"]);
    assert!(colour(&xyz).mean.channels().iter().flatten().all(|v| (v - 1.0).abs() < 1e-3));
    assert!(read_picture(&path).unwrap().channels().iter().flatten().all(|v| (v - 1.0).abs() < 1e-3));
    assert!(xyz.notes.iter().any(|note| note.contains("XYZ")), "{:?}", xyz.notes);
    // Anybody else's may be a position.
    assert!(read_stack(&folder.exr("p.exr", &["X", "Y", "Z"], &white, &[])).is_err());
}

#[test]
fn mitsubas_own_files() {
    let Some(path) = shared("mitsuba/mi_cornell_256_16spp_aov.exr") else { return };
    let read = read(&path);
    assert_eq!(read.found.renderer, "Mitsuba");
    assert_eq!(
        layers_of(&read),
        ["colour=R G B", "position=position", "albedo=albedo", "normal=sh_normal", "depth=depth"]
    );
}

const CYCLES: [(&str, &[&str]); 8] = [
    (
        "ViewLayer.Combined",
        &["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Combined.A"],
    ),
    ("ViewLayer.Noisy Image", &["ViewLayer.Noisy Image.R", "ViewLayer.Noisy Image.G", "ViewLayer.Noisy Image.B"]),
    (
        "ViewLayer.Denoising Normal",
        &["ViewLayer.Denoising Normal.X", "ViewLayer.Denoising Normal.Y", "ViewLayer.Denoising Normal.Z"],
    ),
    ("ViewLayer.Normal", &["ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"]),
    (
        "ViewLayer.Denoising Albedo",
        &["ViewLayer.Denoising Albedo.R", "ViewLayer.Denoising Albedo.G", "ViewLayer.Denoising Albedo.B"],
    ),
    ("ViewLayer.Depth", &["ViewLayer.Depth.Z"]),
    ("ViewLayer.Debug Sample Count", &["ViewLayer.Debug Sample Count.X"]),
    ("ViewLayer.CryptoObject00", &["ViewLayer.CryptoObject00.r", "ViewLayer.CryptoObject00.g"]),
];

#[test]
fn cycles_in_parts_is_not_named_twice_and_its_counts_are_fractions() {
    let folder = Files::new();
    let path = folder.parts(
        "cycles.exr",
        &CYCLES,
        &[("cycles.ViewLayer.samples", text("1024")), ("BlenderMultiChannel", text(""))],
    );
    let read = read(&path);
    assert_eq!(read.found.renderer, "Cycles");
    let expected = [
        "colour=ViewLayer.Noisy Image",
        "albedo=ViewLayer.Denoising Albedo",
        "normal=ViewLayer.Denoising Normal",
        "depth=ViewLayer.Depth",
        "samples=ViewLayer.Debug Sample Count",
    ];
    assert_eq!(layers_of(&read), expected);
    let count = |pixel| (1024.0 * noise("ViewLayer.Debug Sample Count.X", pixel)).round() as u32;
    assert_eq!(read.stack.samples.total, (0..SIZE.pixels()).map(count).collect::<Vec<_>>());
    assert!(read.stack.passthrough.iter().any(|c| c.name == "ViewLayer.CryptoObject00.r"));
    assert_eq!(read.carried.text("cycles.ViewLayer.samples").unwrap(), "1024");
}

#[test]
fn one_sample_everywhere_is_a_count_unless_its_renderer_writes_fractions() {
    let folder = Files::new();
    let spp = |colour: [&str; 3], count: &str| {
        let values = |name: &str, pixel: usize| if name == count { 1.0 } else { noise(name, pixel) };
        read(&folder.exr("a.exr", &[&colour[..], &[count]].concat(), &values, &[])).found.spp.map(|spp| spp.max)
    };
    assert_eq!(spp(["R", "G", "B"], "samples.Y"), Some(1));
    let cycles = ["Noisy Image.R", "Noisy Image.G", "Noisy Image.B"];
    assert_eq!(spp(cycles, "Debug Sample Count.X"), None);
}

#[test]
fn two_view_layers_are_a_question_that_one_answer_settles() {
    let folder = Files::new();
    let layers: Vec<String> = ["One.Combined", "Two.Combined"].iter().flat_map(|l| triples(&[l], "RGB")).collect();
    let normals = triples(&["One.Normal", "Two.Normal"], "XYZ");
    let names: Vec<&str> = layers.iter().chain(&normals).map(String::as_str).collect();
    let path = folder.exr("two.exr", &names, &noise, &[("BlenderMultiChannel", text(""))]);
    let error = read_stack(&path).unwrap_err().to_string();
    assert!(error.contains("'One.Combined'") && error.contains("--map colour="), "{error}");
    let options =
        ReadOptions { map: vec![("colour".parse().unwrap(), "Two.Combined".into())], ..ReadOptions::default() };
    let read = read_inputs(&files(&[path]), &options).unwrap();
    assert_eq!(layers_of(&read), ["colour=Two.Combined", "normal=Two.Normal"]);
}

/// One answer is the name of a view or view layer; what belongs to another is not taken, and each has its own samples.
#[test]
fn views_and_view_layers_keep_their_layers_to_themselves() {
    let folder = Files::new();
    let combined: [&[&str]; 2] = [
        &["One.Combined.R", "One.Combined.G", "One.Combined.B", "One.Combined.A"],
        &["One.Normal.X", "One.Normal.Y", "One.Normal.Z"],
    ];
    let blender = ("BlenderMultiChannel", text(""));
    let parts = ["left", "right"].map(|view| {
        [(format!("One.Combined-{view}"), view, combined[0]), (format!("One.Normal-{view}"), view, combined[1])]
    });
    let parts: Vec<_> = parts.iter().flatten().map(|(part, view, channels)| (&**part, *view, *channels)).collect();
    let path = folder.views("stereo.exr", &parts, std::slice::from_ref(&blender));
    let error = read_stack(&path).unwrap_err().to_string();
    assert!(error.contains("'left.One.Combined', 'right.One.Combined'"), "{error}");
    let choose = |path: &std::path::Path, layer: &str| {
        let map = vec![("colour".parse().unwrap(), layer.to_string())];
        read_inputs(&files(&[path.into()]), &ReadOptions { map, ..ReadOptions::default() }).unwrap()
    };
    let right = choose(&path, "right");
    assert_eq!(layers_of(&right)[..2], ["colour=right.One.Combined", "normal=right.One.Normal"]);
    assert_eq!(colour(&right).mean, noise_of(&["One.Combined.Rright", "One.Combined.Gright", "One.Combined.Bright"]));

    let mut names = triples(&["One.Combined", "One 2.Combined"], "RGB");
    names.extend(triples(&["One.Position", "One 2.Normal"], "XYZ"));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let attributes = [blender, ("cycles.One 2.samples", text("64")), ("cycles.One.samples", text("16"))];
    let path = folder.exr("layers.exr", &names, &noise, &attributes);
    let one = choose(&path, "One");
    assert_eq!(layers_of(&one), ["colour=One.Combined", "position=One.Position"]);
    assert_eq!(one.stack.samples.total[0], 16);
    let two = choose(&path, "One 2");
    assert_eq!(
        (layers_of(&two), two.stack.samples.total[0]),
        (vec!["colour=One 2.Combined".into(), "normal=One 2.Normal".into()], 64)
    );
}

#[test]
fn attributes_that_no_file_may_have_cost_no_picture() {
    let folder = Files::new();
    let attributes = [("framesPerSecond", AttributeValue::F32(24.0)), ("shot", text("12"))];
    let mut layers = Layers::read(&folder.exr("a.exr", &["R", "G", "B"], &noise, &attributes[1..])).unwrap();
    layers.carried = Carried::new(
        exr::prelude::ImageAttributes::with_size((SIZE.width, SIZE.height)),
        [exr::prelude::LayerAttributes {
            other: attributes.iter().map(|(name, value)| (exr::prelude::Text::from(*name), value.clone())).collect(),
            ..exr::prelude::LayerAttributes::default()
        }],
    );
    assert_eq!(layers.carried.refused(), ["framesPerSecond"]);
    let path = folder.path("b.exr");
    layers.write(&path).unwrap();
    assert_eq!(Layers::read(&path).unwrap().carried.text("shot").unwrap(), "12");
}

/// Where one half does not say how many samples it has, the other's number is not the picture's.
#[test]
fn halves_of_which_one_says_its_samples_count_alike() {
    let folder = Files::new();
    let half = |name: &str, attributes: &[(&str, AttributeValue)]| {
        folder.exr(name, &["R", "G", "B"], &|channel, pixel| noise(&format!("{name}{channel}"), pixel), attributes)
    };
    let halves = [half("a.exr", &[("samplesPerPixel", AttributeValue::I32(16))]), half("b.exr", &[])];
    let read = read_inputs(&Inputs::Halves(halves, Vec::new()), &ReadOptions::default()).unwrap();
    assert_eq!((read.found.spp, read.stack.samples.total[0]), (None, 2));
}

#[test]
fn alpha_goes_with_the_picture_whatever_that_was_called() {
    let folder = Files::new();
    let names = ["Combined.R", "Combined.G", "Combined.B", "Combined.A"].map(|name| format!("ViewLayer.{name}"));
    let names = names.each_ref().map(String::as_str);
    let read = read(&folder.half("a.exr", &names, &noise, &[("BlenderMultiChannel", text(""))]));
    let plane = |name: &str| read.stack.passthrough.iter().find(|c| c.name == name).unwrap();
    assert_eq!(plane("A").samples, plane("ViewLayer.Combined.A").samples);
    assert_eq!(plane("A").value(5), noise("ViewLayer.Combined.A", 5));
}

/// Names that lists of passes in compositing scripts, and the manual of another denoiser, give.
#[test]
fn vray_corona_redshift_and_karma_are_known_by_their_layers() {
    let folder = Files::new();
    let roles = |names: &[&str], attributes: &[(&str, AttributeValue)]| {
        let read = read(&folder.exr("a.exr", names, &noise, attributes));
        (read.found.renderer.clone(), layers_of(&read))
    };
    let of = |layers: &[&str], suffixes: &[&str], more: &[&str]| -> Vec<String> {
        let names = layers.iter().flat_map(|layer| suffixes.iter().map(move |suffix| format!("{layer}.{suffix}")));
        names.chain(["R", "G", "B"].iter().chain(more).map(|name| (*name).into())).collect()
    };
    let told = |names: Vec<String>, attributes: &[(&str, AttributeValue)]| {
        roles(&names.iter().map(String::as_str).collect::<Vec<_>>(), attributes)
    };
    let rgb = ["R", "G", "B"];
    let (renderer, found) =
        told(of(&["diffuse", "bumpNormals", "lighting"], &rgb, &["zdepth"]), &[("vrayInfo/renderlayer", text("a"))]);
    assert_eq!(
        (&*renderer, &found[..]),
        ("V-Ray", &["colour=R G B", "albedo=diffuse", "normal=bumpNormals", "depth=zdepth"].map(String::from)[..])
    );
    let corona = ["CShading_SourceColor", "CGeometry_NormalsShading", "CGeometry_WorldPosition"];
    let (renderer, found) = told(of(&corona, &rgb, &[]), &[]);
    assert_eq!(renderer, "Corona");
    assert_eq!(
        found[1..],
        ["position=CGeometry_WorldPosition", "albedo=CShading_SourceColor", "normal=CGeometry_NormalsShading"]
    );
    let (renderer, found) =
        told(of(&["Beauty", "DiffuseFilter", "P", "Shadows"], &["red", "green", "blue"], &["Z"]), &[]);
    assert_eq!(renderer, "Redshift");
    assert_eq!(found, ["colour=R G B", "position=P", "albedo=DiffuseFilter", "depth=Z"]);
    let (_, found) =
        roles(&["C.R", "C.G", "C.B", "C.A", "albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "hitPz"], &[]);
    assert_eq!(found, ["colour=C", "albedo=albedo", "normal=N", "depth=hitPz", "alpha=C"]);
}

#[test]
fn old_blender_wrote_a_variance_of_samples() {
    let folder = Files::new();
    let mut channels =
        triples(&["RenderLayer.Combined", "RenderLayer.Denoising Variance", "RenderLayer.DiffCol"], "RGB");
    channels.extend(triples(&["RenderLayer.Denoising Normal"], "XYZ"));
    channels.push("RenderLayer.Denoising Shadowing.X".into());
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let path = folder.exr("old.exr", &names, &noise, &[("cycles.RenderLayer.samples", text("8"))]);
    let read = read(&path);
    let Noise::VarianceOfMean(variance) = &colour(&read).noise else { panic!("a variance") };
    assert_eq!(variance.channels()[1][9], noise("RenderLayer.Denoising Variance.G", 9) / 8.0);
    assert_eq!(feature(&read, FeatureRole::Albedo).channels()[2][3], noise("RenderLayer.DiffCol.B", 3));
    assert!(read.stack.feature(FeatureRole::Visibility).is_some());
}

/// The channels of a file of Blender 2.79, as a script that takes such files apart lists them.
#[test]
fn blender_2_79_wrote_a_variance_of_samples_for_every_feature() {
    let folder = Files::new();
    let rgb = ["Combined", "Denoising Albedo", "Denoising Albedo Variance", "Denoising Image Variance", "Noisy Image"];
    let layer = |names: &[&str], suffixes: &str| -> Vec<String> {
        triples(names, suffixes).into_iter().map(|name| format!("interior.{name}")).collect()
    };
    let mut channels = layer(&rgb, "RGB");
    channels.extend(layer(&["Denoising Normal", "Denoising Normal Variance", "Vector"], "XYZ"));
    channels.extend(layer(&["Denoising Shadow A", "Denoising Shadow B"], "XYV"));
    channels.extend(layer(&["Denoising Depth", "Denoising Depth Variance", "Depth"], "Z"));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let attributes =
        [("BlenderMultiChannel", text("Blender V2.55.1 and newer")), ("cycles.interior.samples", text("8"))];
    let read = read(&folder.exr("old.exr", &names, &noise, &attributes));
    let expected = [
        "colour=interior.Noisy Image",
        "albedo=interior.Denoising Albedo",
        "normal=interior.Denoising Normal",
        "depth=interior.Denoising Depth",
    ];
    assert_eq!(layers_of(&read), expected);
    let of = |name: &str, suffixes: &str| {
        let names: Vec<String> = suffixes.chars().map(|c| format!("interior.{name} Variance.{c}")).collect();
        Noise::VarianceOfMean(scaled_down(&names.iter().map(String::as_str).collect::<Vec<_>>(), 8.0))
    };
    let noise_is = |role| read.stack.feature(role).unwrap().estimate.noise.clone();
    assert_eq!(colour(&read).noise, of("Denoising Image", "RGB"));
    assert_eq!(noise_is(FeatureRole::Albedo), of("Denoising Albedo", "RGB"));
    assert_eq!(noise_is(FeatureRole::Normal), of("Denoising Normal", "XYZ"));
    assert_eq!(noise_is(FeatureRole::Depth), of("Denoising Depth", "Z"));
}

#[test]
fn cycles_own_files() {
    for (name, spp) in [("cy50_naming_64", 4), ("cy50_interleave_64", 4), ("cy50_glossy_512_64spp_a0_d1", 64)] {
        let Some(path) = shared(&format!("cycles/{name}.exr")) else { return };
        let read = read(&path);
        assert_eq!(layers_of(&read)[0], "colour=ViewLayer.Noisy Image");
        assert_eq!(read.stack.features.len(), 4, "{name}");
        assert!(read.stack.samples.total.iter().all(|n| *n == spp), "{name}");
    }
}

#[test]
fn luxcore_files_are_known_by_their_names() {
    let folder = Files::new();
    let rgb = ["R", "G", "B"];
    let depth = |_: &str, pixel: usize| if pixel == 3 { f32::INFINITY } else { pixel as f32 };
    let count = |_: &str, pixel: usize| 10.0 + pixel as f32;
    let paths = [
        folder.exr("RGB_IMAGEPIPELINE_0.exr", &rgb, &noise, &[]),
        folder.exr("ALBEDO.exr", &rgb, &noise, &[]),
        folder.exr("AVG_SHADING_NORMAL.exr", &rgb, &noise, &[]),
        folder.exr("DEPTH.exr", &rgb, &depth, &[]),
        folder.exr("SAMPLECOUNT.exr", &rgb, &count, &[]),
        folder.exr("NOISE.exr", &rgb, &noise, &[]),
    ];
    let read = read_files(&paths);
    assert_eq!(read.found.renderer, "LuxCore");
    assert_eq!(read.stack.features.len(), 3);
    assert_eq!(read.stack.samples.total[5], 15);
    assert_eq!(feature(&read, FeatureRole::Depth).channels()[0][3], 47.0);
    assert_eq!(read.found.mended.iter().map(|m| m.count).sum::<usize>(), 1);
    let carried: Vec<&str> = read.stack.passthrough.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(carried, ["NOISE.B", "NOISE.G", "NOISE.R"]);
    let Some(real) = shared("luxcore/glossy_256_64spp") else { return };
    let paths: Vec<_> = std::fs::read_dir(real).unwrap().map(|entry| entry.unwrap().path()).collect();
    let read = read_files(&paths);
    assert_eq!(read.stack.features.len(), 4);
    assert!((read.stack.samples.mean_min_max().0 - 64.0).abs() < 0.1);
}

fn tungsten(folder: &Files, n: usize) -> Vec<std::path::PathBuf> {
    let (a, b) = (n.div_ceil(2) as f32, (n / 2) as f32);
    let rgb = ["R", "G", "B"];
    let half_a = |name: &str, pixel: usize| noise(&format!("a{name}"), pixel);
    let half_b = |name: &str, pixel: usize| noise(&format!("b{name}"), pixel);
    let mean = |name: &str, pixel: usize| (a * half_a(name, pixel) + b * half_b(name, pixel)) / (a + b);
    vec![
        folder.half("color.exr", &rgb, &mean, &[]),
        folder.half("colorA.exr", &rgb, &half_a, &[]),
        folder.half("colorB.exr", &rgb, &half_b, &[]),
        folder.half("colorVariance.exr", &rgb, &noise, &[]),
        folder.half("albedo.exr", &rgb, &noise, &[]),
        folder.half(
            "albedoVariance.exr",
            &rgb,
            &|name, pixel| if pixel == 9 { f32::NAN } else { noise(name, pixel) },
            &[],
        ),
        folder.half("depth.exr", &["Y"], &noise, &[]),
    ]
}

#[test]
fn tungstens_halves_are_weighted_as_its_mean_says() {
    for (n, expected) in [(4, [1, 1]), (3, [2, 1]), (5, [3, 2]), (16, [1, 1])] {
        let folder = Files::new();
        let read = read_files(&tungsten(&folder, n));
        assert_eq!(read.found.renderer, "Tungsten");
        assert_eq!(read.stack.samples.dealing, Dealing::PerBucket(expected.to_vec()), "{n} samples");
        assert!(matches!(&colour(&read).noise, Noise::Buckets(halves) if halves.len() == 2));
        let Noise::VarianceOfMean(albedo) = &read.stack.feature(FeatureRole::Albedo).unwrap().estimate.noise else {
            panic!("a variance")
        };
        assert_eq!(albedo.channels()[0][8], noise("R", 8), "it is that of the mean");
        let around: f32 = [0, 1, 2, 8, 10, 16, 17, 18].iter().map(|i| noise("R", *i)).sum::<f32>() / 8.0;
        assert!((albedo.channels()[0][9] - around).abs() < 1e-6, "what is unknown is that around");
    }
    let folder = Files::new();
    let options = ReadOptions { spp: vec![5], ..ReadOptions::default() };
    let read = read_inputs(&files(&tungsten(&folder, 5)), &options).unwrap();
    assert_eq!(read.stack.samples.dealing, Dealing::PerBucket(vec![3, 2]));
}

#[test]
fn tungstens_own_files() {
    let Some(real) = shared("tungsten/s256_spiky_16") else { return };
    let paths: Vec<_> = std::fs::read_dir(real).unwrap().map(|entry| entry.unwrap().path()).collect();
    let read = read_files(&paths);
    assert_eq!(read.stack.features.len(), 4);
    let named = Layers::read(&paths.iter().find(|p| p.ends_with("color.exr")).unwrap().clone()).unwrap();
    let red = named.channels.iter().find(|channel| channel.name == "R").unwrap();
    let worst =
        (0..256 * 256).map(|i| (red.value(i) - colour(&read).mean.channels()[0][i]).abs() / (1.0 + red.value(i)));
    assert!(worst.fold(0.0, f32::max) < 2e-3, "the halves add up to the mean, within the precision of a half");
}

#[test]
fn noice_features_and_variance() {
    let folder = Files::new();
    let mut channels = triples(&["variance", "diffuse_albedo_noice", "diffuse_albedo"], "RGB");
    channels.extend(triples(&["N_noice"], "XYZ"));
    channels.extend(["R", "G", "B", "A", "Z"].map(String::from));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let path = folder.exr("arnold.exr", &names, &noise, &[]);
    let read = read_inputs(&files(&[path]), &ReadOptions { spp: vec![9], ..ReadOptions::default() }).unwrap();
    assert_eq!(read.found.renderer, "Arnold");
    let expected = ["colour=R G B", "albedo=diffuse_albedo_noice", "normal=N_noice", "depth=Z", "alpha=A"];
    assert_eq!(layers_of(&read), expected);
    assert_eq!(
        colour(&read).noise,
        Noise::VarianceOfMean(scaled_down(&["variance.R", "variance.G", "variance.B"], 9.0))
    );
    assert!(read.stack.passthrough.iter().any(|c| c.name == "A"), "alpha passes through");
}

/// The channels of a script that makes files for noice.
#[test]
fn noice_takes_channels_without_a_layer_and_attributes_say_arnold() {
    let folder = Files::new();
    let mut channels = triples(&["denoise_albedo_noice", "variance"], "RGB");
    channels.extend(triples(&["N_noice"], "XYZ"));
    channels.extend(["R", "G", "B", "A", "Z_noice"].map(String::from));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let attributes = [("arnold/aovs/variance/filter", text("variance_filter"))];
    let read = read(&folder.half("noice.exr", &names, &noise, &attributes));
    let expected = ["colour=R G B", "albedo=denoise_albedo_noice", "normal=N_noice", "depth=Z_noice", "alpha=A"];
    assert_eq!((read.found.renderer.as_str(), layers_of(&read)), ("Arnold", expected.map(String::from).to_vec()));
}

fn scaled_down(names: &[&str], n: f32) -> Image {
    let planes = noise_of(names).channels().iter().map(|plane| plane.iter().map(|v| v / n).collect()).collect();
    Image::from_channels(SIZE, planes)
}

#[test]
fn renderman_prefers_the_variance_of_the_mean() {
    let folder = Files::new();
    let mut channels = triples(&["Ci", "mse", "albedo", "albedo_var", "albedo_mse", "diffuse"], "rgb");
    channels.extend(triples(&["normal", "normal_var"], "xyz"));
    channels.extend(["a", "sampleCount", "zfiltered", "zfiltered_var"].map(String::from));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let values = |name: &str, pixel: usize| if name == "sampleCount" { 32.0 } else { noise(name, pixel) };
    let read = read(&folder.exr("renderman.exr", &names, &values, &[]));
    assert_eq!(read.found.renderer, "RenderMan");
    assert_eq!(read.stack.samples.total, [32; 48]);
    let noise_is = |role: FeatureRole, names: &[&str], n: f32| {
        assert_eq!(read.stack.feature(role).unwrap().estimate.noise, Noise::VarianceOfMean(scaled_down(names, n)));
    };
    assert_eq!(colour(&read).noise, Noise::VarianceOfMean(noise_of(&["mse.r", "mse.g", "mse.b"])));
    noise_is(FeatureRole::Albedo, &["albedo_mse.r", "albedo_mse.g", "albedo_mse.b"], 1.0);
    noise_is(FeatureRole::Normal, &["normal_var.x", "normal_var.y", "normal_var.z"], 32.0);
    noise_is(FeatureRole::Depth, &["zfiltered_var"], 32.0);
}

/// What RenderMan's denoiser asked for before it had sample counts, with colour and alpha as `asrgba` names them.
#[test]
fn renderman_without_sample_counts_knows_the_noise_of_its_colour() {
    let folder = Files::new();
    let rgb = ["mse", "albedo", "albedo_var", "diffuse", "diffuse_mse", "specular", "specular_mse"];
    let mut channels = triples(&rgb, "rgb");
    channels.extend(triples(&["normal", "normal_var", "forward", "backward", "__Pworld"], "xyz"));
    channels.extend(["R", "G", "B", "A", "zfiltered", "zfiltered_var"].map(String::from));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let read = read(&folder.half("renderman.exr", &names, &noise, &[]));
    let expected =
        ["colour=R G B", "position=__Pworld", "albedo=albedo", "normal=normal", "depth=zfiltered", "alpha=A"];
    assert_eq!((read.found.renderer.as_str(), layers_of(&read)), ("RenderMan", expected.map(String::from).to_vec()));
    assert_eq!(colour(&read).noise, Noise::VarianceOfMean(noise_of(&["mse.r", "mse.g", "mse.b"])));
    assert!(read.notes.iter().any(|note| note.contains("albedo_var") && note.contains("--spp")), "{:?}", read.notes);
}

#[test]
fn bcd_covariance_and_histogram() {
    let folder = Files::new();
    let bins: Vec<String> = (0..61).map(|bin| format!("Bin_{bin:04}")).collect();
    let bins: Vec<&str> = bins.iter().map(String::as_str).collect();
    let paths = [
        folder.exr("box.exr", &["R", "G", "B"], &noise, &[]),
        folder.exr("box_cov.exr", &bins[..6], &noise, &[]),
        folder.exr(
            "box_hist.exr",
            &bins,
            &|name, pixel| if name == "Bin_0060" { 20.0 } else { noise(name, pixel) },
            &[],
        ),
    ];
    let read = read_files(&paths);
    assert_eq!(read.found.renderer, "BCD");
    assert_eq!(read.stack.samples.total, [20; 48]);
    assert_eq!(colour(&read).noise, Noise::VarianceOfMean(scaled_down(&["Bin_0000", "Bin_0001", "Bin_0002"], 20.0)));
    let read = read_inputs(&files(&paths[..2]), &ReadOptions { spp: vec![10], ..ReadOptions::default() }).unwrap();
    assert_eq!(read.stack.samples.total, [10; 48], "without the histogram");
}

#[test]
fn oidns_pictures() {
    let folder = Files::new();
    let normal = noise_of(&["x", "y", "z"]);
    let paths = ["scene.hdr.pfm", "scene.alb.pfm", "scene.nrm.pfm"].map(|name| folder.path(name));
    paths.iter().for_each(|path| write_pfm(path, &normal).unwrap());
    let read = read_files(&paths);
    assert_eq!((read.found.renderer.as_str(), read.stack.features.len()), ("OIDN", 2));
    assert_eq!(feature(&read, FeatureRole::Normal), &normal);
}

#[test]
fn a_variance_of_unknown_kind_is_not_used_and_said() {
    let folder = Files::new();
    let mut channels = triples(&["beauty", "beauty_variance"], "RGB");
    channels.extend(triples(&["myNormals"], "XYZ"));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let path = folder.exr("some.exr", &names, &noise, &[]);
    let unsaid = read(&path);
    assert_eq!(colour(&unsaid).noise, Noise::Unknown);
    assert!(unsaid.notes.iter().any(|note| note.contains("--variance-is")), "{:?}", unsaid.notes);
    assert!(layers_of(&unsaid).contains(&"normal=myNormals".into()));
    let options = ReadOptions { variance_is: Some(Convention::Mean), ..ReadOptions::default() };
    let read = read_inputs(&files(&[path]), &options).unwrap();
    assert!(matches!(colour(&read).noise, Noise::VarianceOfMean(_)));
    assert!(read.notes.iter().all(|note| !note.contains("--variance-is")), "{:?}", read.notes);
    let without = folder.exr("without.exr", &["R", "G", "B"], &noise, &[]);
    let read = read_inputs(&files(&[without]), &options).unwrap();
    assert!(read.notes.iter().any(|note| note.contains("--variance-is")), "{:?}", read.notes);
}

#[test]
fn what_stands_behind_the_last_dot_of_a_layer_is_enough_for_map() {
    let folder = Files::new();
    let channels = triples(&["First.Combined", "First.Other", "Second.Other"], "RGB");
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let path = folder.exr("a.exr", &names, &noise, &[]);
    let mapped = |layer: &str| {
        let colour = Slot { role: Role::Colour, measure: Measure::Mean };
        let options = ReadOptions { map: vec![(colour, layer.into())], ..ReadOptions::default() };
        read_inputs(&files(std::slice::from_ref(&path)), &options)
    };
    assert_eq!(colour(&mapped("combined").unwrap()).mean.channels()[0][4], noise("First.Combined.R", 4));
    let error = mapped("Other").unwrap_err().to_string();
    assert!(error.contains("'First.Other', 'Second.Other'"), "{error}");
    assert!(matches!(mapped("Othe"), Err(FileError::NoSuchLayer { .. })));
}

#[test]
fn features_of_one_half_alone_are_not_used_and_said() {
    let folder = Files::new();
    let names = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"];
    let [a, b] = [(6, "a.exr"), (3, "b.exr")].map(|(count, name)| {
        folder.exr(name, &names[..count], &|channel, pixel| noise(&format!("{name}{channel}"), pixel), &[])
    });
    for halves in [[a.clone(), b.clone()], [b.clone(), a.clone()]] {
        let read = read_inputs(&Inputs::Halves(halves, Vec::new()), &ReadOptions::default()).unwrap();
        assert!(read.stack.features.is_empty());
        assert!(
            read.notes.iter().any(|note| note == "albedo is in one half alone, and is not used"),
            "{:?}",
            read.notes
        );
        assert!(read.found.roles.iter().all(|found| found.role != "albedo"));
    }
    for buckets in [[a.clone(), b.clone()], [b, a]] {
        let error = read_buckets(&buckets).unwrap_err().to_string();
        assert!(error.contains("b.exr: no albedo"), "{error}");
    }
}

#[test]
fn renders_of_different_pictures_are_noticed() {
    let folder = Files::new();
    let render = |name: &str, of: &str| {
        let value = |channel: &str, pixel: usize| {
            let picture = if of == "steps" { (pixel / 24) as f32 } else { (pixel % 8 / 4) as f32 };
            0.3 + 0.5 * picture + 0.01 * noise(&format!("{name}{channel}"), pixel)
        };
        folder.exr(name, &["R", "G", "B"], &value, &[])
    };
    let [a, b, c] = [("a.exr", "steps"), ("b.exr", "steps"), ("c.exr", "sides")].map(|(name, of)| render(name, of));
    let said = |buckets: &[std::path::PathBuf]| {
        read_buckets(buckets).unwrap().notes.into_iter().find(|note| note.contains("resembles"))
    };
    assert_eq!(said(&[a.clone(), b.clone()]), None);
    let expected = "render 3 hardly resembles render 1 in colour: halves and buckets are renders of one picture";
    assert_eq!(said(&[a, b, c]).as_deref(), Some(expected));
}

#[test]
fn a_result_beside_its_noisy_picture_is_a_question() {
    let folder = Files::new();
    let mut channels = triples(&["noisy"], "RGB");
    channels.extend(["R", "G", "B"].map(String::from));
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let error = read_stack(&folder.exr("both.exr", &names, &noise, &[])).unwrap_err().to_string();
    assert!(error.contains("'noisy'") && error.contains("--map colour="), "{error}");
}

#[test]
fn halves_of_different_lengths_and_features_from_elsewhere() {
    let folder = Files::new();
    let names = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"];
    let spp = |n: i32| [("samplesPerPixel", AttributeValue::I32(n))];
    let a = folder.exr("a.exr", &names, &noise, &spp(24));
    let b = folder.exr("b.exr", &names, &|name, pixel| noise(&format!("other {name}"), pixel), &spp(8));
    let more = folder.exr("more.exr", &["R", "G", "B", "normal.X", "normal.Y", "normal.Z"], &noise, &[]);
    let inputs = Inputs::Halves([a.clone(), b.clone()], vec![Source::from(more.as_path())]);
    let read = read_inputs(&inputs, &ReadOptions::default()).unwrap();
    assert_eq!(read.stack.samples.dealing, Dealing::PerBucket(vec![24, 8]));
    assert_eq!(read.stack.samples.total, [32; 48]);
    let mean = 0.75 * noise("R", 4) + 0.25 * noise("other R", 4);
    assert!((colour(&read).mean.channels()[0][4] - mean).abs() < 1e-6);
    assert_eq!(read.stack.feature(FeatureRole::Normal).unwrap().estimate.noise, Noise::Unknown);
    assert_eq!(read.stack.features.len(), 2);
    let options = ReadOptions { spp: vec![1, 3], ..ReadOptions::default() };
    let read = read_inputs(&inputs, &options).unwrap();
    assert_eq!(read.stack.samples.dealing, Dealing::PerBucket(vec![1, 3]));
    let options = ReadOptions { spp: vec![1, 3, 5], ..ReadOptions::default() };
    assert!(matches!(read_inputs(&inputs, &options), Err(FileError::SampleCounts { given: 3, .. })));
    let same = Inputs::Halves([a.clone(), a], Vec::new());
    assert!(matches!(read_inputs(&same, &ReadOptions::default()), Err(FileError::SameNoise { .. })));
}

#[test]
fn adaptive_halves_count_pixel_by_pixel_and_are_read_again_as_they_were() {
    let folder = Files::new();
    let half = |name: &'static str, n: fn(usize) -> f32| {
        let values = move |channel: &str, pixel: usize| match channel {
            "samples.Y" => n(pixel),
            colour => noise(&format!("{name}{colour}"), pixel),
        };
        folder.exr(name, &["R", "G", "B", "samples.Y"], &values, &[])
    };
    let a = half("a.exr", |pixel| [4.0, 16.0, 0.0][pixel % 3]);
    let b = half("b.exr", |pixel| [12.0, 1.0, 0.0][pixel % 3]);
    let read = read_inputs(&Inputs::Halves([a, b], Vec::new()), &ReadOptions::default()).unwrap();
    let means = &colour(&read).mean.channels()[0];
    for (pixel, [n_a, n_b]) in [[4.0, 12.0], [16.0, 1.0], [1.0, 1.0]].into_iter().enumerate() {
        let expected = (n_a * noise("a.exrR", pixel) + n_b * noise("b.exrR", pixel)) / (n_a + n_b);
        assert!((means[pixel] - expected).abs() < 1e-6, "{n_a} and {n_b} samples");
    }
    assert_eq!(read.found.spp.as_ref().map(|spp| (spp.min, spp.max)), Some((2, 17)));
    let again = folder.path("again.exr");
    let header = StackHeader::of(&read.stack, serde_json::json!({}));
    write_stack(&again, &read.stack, true, &header, &[], &read.carried).unwrap();
    assert_eq!(read_stack(&again).unwrap().stack, read.stack);
}

#[test]
fn halves_of_an_adaptive_file_are_the_even_and_the_odd_samples_of_each_pixel() {
    let folder = Files::new();
    let channels = ["color.R", "color.G", "color.B", "colorA.R", "colorA.G", "colorA.B", "colorB.R", "colorB.G"];
    let channels = [&channels[..], &["colorB.B", "samples.Y"]].concat();
    let values = |name: &str, pixel: usize| if name == "samples.Y" { 2.0 + pixel as f32 } else { noise(name, pixel) };
    let read = read(&folder.exr("adaptive.exr", &channels, &values, &[]));
    let halves = |pixel| [0, 1].map(|half| read.stack.samples.in_group(pixel, half, 2));
    assert_eq!([halves(0), halves(3), halves(4)], [[1, 1], [3, 2], [3, 3]]);
}

#[test]
fn emission_apart_in_every_bucket_is_a_component() {
    let folder = Files::new();
    let names = ["R", "G", "B", "emission.R", "emission.G", "emission.B"];
    let bucket = |b: usize| {
        let values = move |name: &str, pixel: usize| match name.starts_with("emission") {
            true => 0.5,
            false => 0.5 + noise(&format!("{b}{name}"), pixel),
        };
        folder.exr(&format!("b{b}.exr"), &names, &values, &[])
    };
    let read = read_buckets(&[bucket(0), bucket(1), bucket(2)]).unwrap();
    assert_eq!(read.stack.components.len(), 2);
    assert_eq!(read.stack.components[1].radiance.mean.channels()[0][7], 0.5);
    let whole = (0..3).map(|b| 0.5 + noise(&format!("{b}R"), 7)).sum::<f32>() / 3.0;
    assert!((read.stack.beauty().channels()[0][7] - whole).abs() < 1e-6);
}
