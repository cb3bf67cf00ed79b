//! The page that shows what was compared: one file, with all that it needs inside.

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use reconstruct::metrics::{Reference, judged_pixels};
use serde_json::{Value, json};
use stack::Image;
use stack::file::{Action, FileError, Record, check_writable, extension, write_atomically};

use super::encoded_picture::{EncodedPicture, STEPS_PER_OCTAVE, encode, encode_judged};
use super::reduced::Scale;
use super::settings_found::settings_found;
use super::table::MeasureTable;
use crate::args::CompareArgs;
use crate::failure::usage;

/// The page, with a `{{name}}` for each part that is put in.
const FRAME: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 3] = [include_str!("pixels.js"), include_str!("plots.js"), include_str!("page.js")];

/// Refuses a name that a page cannot have, before any work is done. An ending is asked for so that nobody's picture is
/// replaced by a page.
///
/// # Errors
/// When it does not end in `.html`, or cannot be written to.
pub fn check_page(file: &Path) -> Result<()> {
    if !["html", "htm"].contains(&extension(file).as_str()) {
        return Err(usage(format!("--html {}: expected a name that ends in .html", file.display())));
    }
    Ok(check_writable(file)?)
}

/// A picture as the page has it.
#[derive(Clone, Debug)]
pub struct Shown {
    name: String,
    found: Value,
    encoded: EncodedPicture,
}

impl Shown {
    /// The picture in `file`.
    ///
    /// # Errors
    /// When it cannot be encoded.
    pub fn new(file: &Path, picture: &Image, record: &Record, scale: Scale) -> Result<Self> {
        Ok(Self {
            name: file.display().to_string(),
            found: settings_found(record),
            encoded: encode(&scale.reduce(picture), scale.coding)?,
        })
    }
}

/// All that is on a page.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    /// What was asked for.
    pub args: &'a CompareArgs,
    /// What the pictures were compared with.
    pub reference: Reference<'a>,
    /// How they are shown.
    pub scale: Scale,
    /// The reference as it is shown.
    pub first: Shown,
    /// The pictures that were measured.
    pub shown: Vec<Shown>,
    /// The second reference.
    pub second: Option<Shown>,
    /// Their measures.
    pub table: MeasureTable,
}

impl Page<'_> {
    /// Writes the page to `file`.
    ///
    /// # Errors
    /// When it cannot be encoded or written.
    pub fn write(&self, file: &Path) -> Result<()> {
        let judged = self.judged();
        let shown = self.scale.reduce_judged(&judged);
        let judged_png = encode_judged(self.scale.shown(), &shown)?;
        let data = self.data(judged.iter().filter(|judged| !**judged).count()).to_string();
        let failed = |source| FileError::Io { path: file.into(), action: Action::Write, source };
        Ok(write_atomically(file, |out| {
            fill(out, |out, part| match part {
                "style" => out.write_all(STYLE.as_bytes()),
                "data" => out.write_all(inside_script(&data).as_bytes()),
                "pictures" => self.write_pictures(out, &judged_png),
                _ => SCRIPTS.iter().try_for_each(|script| out.write_all(script.as_bytes())),
            })
            .map_err(failed)
        })?)
    }

    fn judged(&self) -> Vec<bool> {
        let references: Vec<&Image> = std::iter::once(self.reference.image).chain(self.reference.second).collect();
        let mut judged = vec![false; self.scale.size.pixels()];
        judged_pixels(&references, self.reference.mask).into_iter().for_each(|pixel| judged[pixel] = true);
        judged
    }

    /// The pictures in the order of the page, and what each is.
    fn pictures(&self) -> impl Iterator<Item = (&'static str, &Shown)> {
        let images = self.shown.iter().map(|shown| ("image", shown));
        let second = self.second.iter().map(|shown| ("second reference", shown));
        std::iter::once(("reference", &self.first)).chain(images).chain(second)
    }

    /// What the scripts know.
    fn data(&self, left_out: usize) -> Value {
        let (size, shown) = (self.scale.size, self.scale.shown());
        let pictures = self.pictures().map(|(role, picture)| {
            json!({ "role": role, "name": picture.name, "sum": picture.encoded.sum, "found": picture.found })
        });
        json!({
            "size": [size.width, size.height],
            "shown": [shown.width, shown.height],
            "factor": self.scale.factor,
            "stops": short(self.scale.stops),
            "lowest": self.scale.coding.lowest,
            "stepsPerOctave": STEPS_PER_OCTAVE,
            "epsilon": short(self.args.epsilon),
            "mask": self.args.mask.as_ref().map(|file| file.display().to_string()),
            "leftOut": left_out,
            "pictures": pictures.collect::<Vec<_>>(),
            "table": self.table,
        })
    }

    fn write_pictures(&self, out: &mut impl Write, judged: &[u8]) -> std::io::Result<()> {
        write_picture(out, "judged", judged)?;
        self.pictures().try_for_each(|(_, picture)| {
            write_picture(out, "high", &picture.encoded.high)?;
            write_picture(out, "low", &picture.encoded.low)
        })
    }
}

/// A number with no more digits than it has: as an f64, 0.001 would have sixteen.
fn short(number: f32) -> Value {
    number.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

/// Writes [`FRAME`] with its parts as `write_part` writes them.
fn fill<W: Write>(out: &mut W, mut write_part: impl FnMut(&mut W, &str) -> std::io::Result<()>) -> std::io::Result<()> {
    let mut rest = FRAME;
    while let Some((before, (part, after))) =
        rest.split_once("{{").and_then(|(before, after)| Some((before, after.split_once("}}")?)))
    {
        out.write_all(before.as_bytes())?;
        write_part(out, part)?;
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

/// JSON that neither ends the script element it stands in nor begins a comment there, whatever files are called: in
/// JSON, `<` stands in texts only, and may be escaped in them.
fn inside_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

fn write_picture(out: &mut impl Write, class: &str, png: &[u8]) -> std::io::Result<()> {
    write!(out, "<img class=\"{class}\" alt=\"\" src=\"data:image/png;base64,")?;
    let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
    encoder.write_all(png)?;
    encoder.finish()?;
    drop(encoder);
    out.write_all(b"\">\n")
}

#[cfg(test)]
mod tests;
