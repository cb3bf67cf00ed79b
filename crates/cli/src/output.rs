//! Writes pictures and stacks in the formats that were asked for.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::Reconstruction;
use stack::file::{
    Action, Carried, FileError, ResultLayer, StackHeader, check_writable, extension, write_atomically, write_pfm,
    write_picture, write_stack,
};
use stack::{FeatureStack, Image};

use crate::args::{DEFAULT_AOV, OutputArgs};
use crate::exposure::{self, Lit};
use crate::failure::usage;
use crate::progress::Progress;

/// What may stand in `--aov`.
const LAYERS: [&str; 6] = ["inputs", "mse", "samples", "spikes", "bandwidth", "rank"];

/// Validated output options.
#[derive(Clone, Debug)]
pub struct Outputs {
    files: Vec<PathBuf>,
    layers: Vec<String>,
    /// Whether these were chosen one by one, so that whoever did will look for each.
    chosen: bool,
    exposure: Option<f32>,
}

impl Outputs {
    /// Checks formats, layer names and that every file can be written, before any work is done. Without `--output`,
    /// the outputs are `stem`.exr and `stem`.png in the working directory.
    ///
    /// # Errors
    /// An unknown format or layer, or a place that cannot be written to.
    pub fn prepare(args: &OutputArgs, stem: &str) -> Result<Self> {
        let files = args.files(stem);
        for file in &files {
            check_format(file)?;
            check_writable(file)?;
        }
        let chosen = args.aov != DEFAULT_AOV && args.aov != "all";
        Ok(Self { files, layers: layers(&args.aov)?, chosen, exposure: args.exposure })
    }

    /// The files, in the order given.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Whether the samples themselves are written, and not only what is made of them.
    pub fn need_inputs(&self) -> bool {
        self.wants("inputs") && self.files.iter().any(|file| extension(file) == "exr")
    }

    fn wants(&self, layer: &str) -> bool {
        self.layers.iter().any(|wanted| wanted == layer)
    }

    /// Writes every output; the exposure of those that need one is chosen where the samples are `lit`.
    ///
    /// # Errors
    /// When one cannot be written; those before it are complete.
    pub fn write(&self, written: &Written<'_>, lit: &Lit, progress: &Progress) -> Result<()> {
        self.say_what_there_is_not(written, progress);
        for file in &self.files {
            match extension(file).as_str() {
                "exr" => self.write_exr(file, written)?,
                "pfm" => write_pfm(file, written.picture)?,
                "hdr" => write_hdr(file, written.picture)?,
                _ => write_png(file, written.picture, self.stops(file, (written.picture, lit), progress))?,
            }
        }
        Ok(())
    }

    /// Layers that were chosen, but that nothing made.
    fn say_what_there_is_not(&self, written: &Written<'_>, progress: &Progress) {
        let made = written.reconstruction.map_or_else(Vec::new, maps_of);
        let is_made =
            |layer: &str| ["inputs", "samples"].contains(&layer) || made.iter().any(|(name, _)| *name == layer);
        let missing: Vec<&str> = self.layers.iter().map(String::as_str).filter(|layer| !is_made(layer)).collect();
        if !self.chosen || missing.is_empty() || !self.files.iter().any(|file| extension(file) == "exr") {
            return;
        }
        let why = if written.reconstruction.is_some() { "this method makes none" } else { "nothing was reconstructed" };
        progress.say(&format!("--aov: there is no layer {}: {why}", missing.join(", ")));
    }

    fn write_exr(&self, file: &Path, written: &Written<'_>) -> Result<()> {
        let samples: Vec<Vec<f32>> = vec![written.stack.samples.total.iter().map(|&n| n as f32).collect()];
        let maps = written.reconstruction.map_or_else(Vec::new, maps_of);
        let mut results =
            vec![ResultLayer { name: "", channels: &["R", "G", "B"], planes: written.picture.channels() }];
        let with_inputs = self.wants("inputs");
        if self.wants("samples") && !with_inputs {
            results.push(ResultLayer { name: "samples", channels: &["Y"], planes: &samples });
        }
        for (name, planes) in maps.iter().filter(|(name, _)| self.wants(name)) {
            results.push(ResultLayer {
                name,
                channels: if planes.len() == 1 { &["Y"] } else { &["R", "G", "B"] },
                planes,
            });
        }
        Ok(write_stack(file, written.stack, with_inputs, written.header, &results, written.carried)?)
    }

    /// The exposure that was given, or one chosen from the picture and said.
    fn stops(&self, file: &Path, (picture, lit): (&Image, &Lit), progress: &Progress) -> f32 {
        self.exposure.unwrap_or_else(|| {
            let stops = exposure::choose_for(picture, lit);
            progress.say(&format!("guessed an exposure of {stops:+.1} stops for {} (--exposure)", file.display()));
            stops
        })
    }

    /// Writes what an interrupted run has to `file`, with all that a reconstruction needs.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_partial(&self, file: &Path, written: &Written<'_>) -> Result<()> {
        let with_inputs = Self { layers: vec!["inputs".into()], ..self.clone() };
        with_inputs.write_exr(file, written)
    }
}

/// Checks that a name ends as a format that can be written.
///
/// # Errors
/// When it does not.
pub fn check_format(file: &Path) -> Result<()> {
    if file == Path::new("-") {
        return Err(usage("-o -: pictures are written to files, and not to standard output; give a name"));
    }
    if ["exr", "png", "hdr", "pfm"].contains(&extension(file).as_str()) {
        return Ok(());
    }
    Err(usage(format!("{}: expected a name that ends in .exr, .png, .hdr or .pfm", file.display())))
}

/// The layers a reconstruction adds to its picture, as far as its method has them.
fn maps_of(reconstruction: &Reconstruction) -> Vec<(&'static str, Vec<Vec<f32>>)> {
    let single = |plane: &Vec<f32>| vec![plane.clone()];
    let maps = [
        ("mse", Some(single(&reconstruction.mse))),
        ("bandwidth", reconstruction.bandwidth.as_ref().map(single)),
        ("rank", reconstruction.rank.as_ref().map(single)),
        ("spikes", reconstruction.spikes.as_ref().map(|spikes| spikes.channels().to_vec())),
    ];
    maps.into_iter().filter_map(|(name, planes)| Some((name, planes?))).collect()
}

/// Writes a picture to `file`, and beside it as .png, lifted by `stops`.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_with_png(file: &Path, picture: &Image, stops: f32) -> Result<()> {
    write_png(&file.with_extension("png"), picture, stops)?;
    Ok(write_picture(file, picture)?)
}

/// Writes an 8-bit sRGB picture, lifted by `stops`.
///
/// # Errors
/// When it cannot be written.
pub fn write_png(file: &Path, picture: &Image, stops: f32) -> Result<()> {
    let size = picture.size();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = exposure::to_srgb8(picture, stops);
    let (width, height) = (size.width as u32, size.height as u32);
    image::write_buffer_with_format(
        &mut bytes,
        &pixels,
        width,
        height,
        image::ColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .with_context(|| format!("{}: cannot encode", file.display()))?;
    write_bytes(file, bytes.get_ref())
}

/// What a run produced.
pub struct Written<'a> {
    pub picture: &'a Image,
    pub stack: &'a FeatureStack,
    pub reconstruction: Option<&'a Reconstruction>,
    pub header: &'a StackHeader,
    /// What the input said beside its pixels.
    pub carried: &'a Carried,
}

fn layers(list: &str) -> Result<Vec<String>> {
    match list {
        "none" => return Ok(Vec::new()),
        "all" => return Ok(LAYERS.map(String::from).to_vec()),
        _ => {}
    }
    let layers: Vec<String> = list.split(',').map(|layer| layer.trim().to_string()).collect();
    match layers.iter().find(|layer| !LAYERS.contains(&layer.as_str())) {
        Some(unknown) => Err(usage(format!("--aov: '{unknown}' is none of all, none, {}", LAYERS.join(", ")))),
        None => Ok(layers),
    }
}

fn write_hdr(file: &Path, picture: &Image) -> Result<()> {
    let size = picture.size();
    let pixels: Vec<image::Rgb<f32>> = (0..picture.pixels()).map(|pixel| image::Rgb(picture.rgb(pixel))).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels, size.width, size.height)
        .with_context(|| format!("{}: cannot encode", file.display()))?;
    write_bytes(file, &bytes)
}

fn write_bytes(file: &Path, bytes: &[u8]) -> Result<()> {
    Ok(write_atomically(file, |out| {
        out.write_all(bytes).map_err(|source| FileError::Io { path: file.into(), action: Action::Write, source })
    })?)
}
