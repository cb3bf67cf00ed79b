//! An EXR file as a flat list of named channels.

use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, IntegerBounds, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage,
};

use super::borrowed::BorrowedSamples;
use super::{FileError, write_atomically};
use crate::{Size, Window};

/// Name of the one text attribute that holds all our metadata. One only: the `exr` crate writes several custom
/// attributes in random order, and equal runs must write equal bytes.
const METADATA: &str = "tamis";

/// Zipped scan lines in rising order: every reader takes them, and the bytes do not depend on the thread count.
const ENCODING: Encoding =
    Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// A channel nobody here interprets, carried along with its name and its own number type.
#[derive(Clone, Debug, PartialEq)]
pub struct Passthrough {
    /// Full channel name, layers separated by dots.
    pub name: String,
    /// Values, row-major.
    pub samples: FlatSamples,
}

/// All channels of an EXR file (of all its parts, when they cover the same window).
#[derive(Clone, Debug)]
pub struct Layers {
    /// Where it came from, for messages.
    pub path: PathBuf,
    /// The pixels the channels cover.
    pub window: Window,
    /// Size of the display window.
    pub film: Size,
    /// The channels.
    pub channels: Vec<Passthrough>,
    /// Our own metadata, when the file has any.
    pub metadata: Option<serde_json::Value>,
}

impl Layers {
    /// Reads a file.
    ///
    /// # Errors
    /// When the file is absent, a folder, damaged, or of a kind that is not supported (deep data, subsampled channels,
    /// parts of different size).
    pub fn read(path: &Path) -> Result<Self, FileError> {
        if path.is_dir() {
            return Err(FileError::Folder { path: path.into() });
        }
        let file = std::fs::File::open(path).map_err(|source| FileError::io(path, "read", source))?;
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(std::io::BufReader::new(file))
            .map_err(|error| understand(path, error))?;
        gather(path, image)
    }

    /// Takes the channel called `name` out, as `f32`.
    pub fn take(&mut self, name: &str) -> Option<Vec<f32>> {
        let at = self.channels.iter().position(|channel| channel.name == name)?;
        Some(to_f32(self.channels.remove(at).samples))
    }

    /// Whether there is a channel called `name`.
    pub fn has(&self, name: &str) -> bool {
        self.channels.iter().any(|channel| channel.name == name)
    }

    /// Names of all channels, for messages.
    pub fn names(&self) -> String {
        self.channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>().join(" ")
    }

    /// Writes the channels as a one-part file, atomically, values as they are.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let channels = self.channels.iter().map(|c| (c.name.clone(), BorrowedSamples::Any(&c.samples))).collect();
        write_channels(path, self.window, self.film, self.metadata.as_ref(), channels)
    }
}

/// Writes named channels that cover `window` of `film` as a one-part file, atomically.
///
/// # Errors
/// When the file cannot be written.
pub(super) fn write_channels(
    path: &Path,
    window: Window,
    film: Size,
    metadata: Option<&serde_json::Value>,
    channels: Vec<(String, BorrowedSamples<'_>)>,
) -> Result<(), FileError> {
    let mut attributes = LayerAttributes {
        layer_position: Vec2(window.x, window.y),
        software_name: Some(Text::from("tamis")),
        ..LayerAttributes::default()
    };
    if let Some(metadata) = metadata {
        let text = Text::from(metadata.to_string().as_str());
        attributes.other.insert(Text::from(METADATA), AttributeValue::Text(text));
    }
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name.as_str(), samples)).collect();
    let size = (window.size.width, window.size.height);
    let mut image =
        exr::prelude::Image::from_layer(Layer::new(size, attributes, ENCODING, AnyChannels::sort(channels)));
    image.attributes.display_window = IntegerBounds::from_dimensions((film.width, film.height));
    write_atomically(path, |out| image.write().to_buffered(out).map_err(|error| understand(path, error)))
}

/// Converts samples of any type to `f32` (without a copy when they are).
fn to_f32(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

fn gather(
    path: &Path,
    image: exr::prelude::Image<exr::prelude::Layers<AnyChannels<FlatSamples>>>,
) -> Result<Layers, FileError> {
    let display = image.attributes.display_window;
    let mut layers = Layers {
        path: path.into(),
        window: Window::whole(Size::new(0, 0)),
        film: Size::new(display.size.width(), display.size.height()),
        channels: Vec::new(),
        metadata: None,
    };
    let parts = image.layer_data.len();
    for (index, part) in image.layer_data.into_iter().enumerate() {
        let position = part.attributes.layer_position - display.position;
        let window =
            Window { x: position.x(), y: position.y(), size: Size::new(part.size.width(), part.size.height()) };
        if index == 0 {
            layers.window = window;
        } else if window != layers.window {
            return Err(unsupported(path, "parts of different size", "give each part as a file of its own"));
        }
        let prefix = part.attributes.layer_name.filter(|_| parts > 1).map(|name| format!("{name}."));
        for channel in part.channel_data.list {
            if channel.sampling != Vec2(1, 1) {
                return Err(unsupported(path, "subsampled channels", "write all channels at full resolution"));
            }
            let name = format!("{}{}", prefix.as_deref().unwrap_or(""), channel.name);
            layers.channels.push(Passthrough { name, samples: channel.sample_data });
        }
        if let Some(AttributeValue::Text(text)) = part.attributes.other.get(&Text::from(METADATA)) {
            layers.metadata = serde_json::from_str(&text.to_string()).ok();
        }
    }
    Ok(layers)
}

fn unsupported(path: &Path, what: &str, remedy: &'static str) -> FileError {
    FileError::Unsupported { path: path.into(), what: what.into(), remedy }
}

fn understand(path: &Path, error: exr::error::Error) -> FileError {
    use exr::error::Error;
    match error {
        Error::Io(source) => FileError::io(path, "write", source),
        Error::NotSupported(what) if what.contains("deep") => {
            unsupported(path, "deep pixels", "flatten the picture first")
        }
        Error::NotSupported(what) => {
            FileError::Unsupported { path: path.into(), what: what.into_owned(), remedy: "convert the file first" }
        }
        Error::Invalid(reason) => {
            FileError::Damaged { path: path.into(), format: "OpenEXR", reason: reason.into_owned() }
        }
        Error::Aborted => FileError::Damaged { path: path.into(), format: "OpenEXR", reason: "reading stopped".into() },
    }
}
