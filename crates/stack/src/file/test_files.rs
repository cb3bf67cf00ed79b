//! Files as other renderers write them, for tests.

use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, ImageAttributes, Layer, LayerAttributes,
    Text, WritableImage, f16,
};

use crate::{Image as Planes, Size};

/// Size of every test picture.
pub const SIZE: Size = Size::new(8, 6);

/// A folder of test files.
pub struct Files(tempfile::TempDir);

/// A value for every pixel of a named channel.
pub type Values<'a> = &'a dyn Fn(&str, usize) -> f32;

impl Files {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes one part of half floats or floats.
    pub fn exr(
        &self,
        name: &str,
        channels: &[&str],
        values: Values<'_>,
        attributes: &[(&str, AttributeValue)],
    ) -> PathBuf {
        self.one_part(name, layer(channels, values, attributes, false))
    }

    /// The same in half precision.
    pub fn half(
        &self,
        name: &str,
        channels: &[&str],
        values: Values<'_>,
        attributes: &[(&str, AttributeValue)],
    ) -> PathBuf {
        self.one_part(name, layer(channels, values, attributes, true))
    }

    fn one_part(&self, name: &str, layer: Layer<AnyChannels<FlatSamples>>) -> PathBuf {
        let path = self.path(name);
        Image::from_layer(layer).write().to_file(&path).unwrap();
        path
    }

    /// Writes a part for each name, with its channels.
    pub fn parts(&self, name: &str, parts: &[(&str, &[&str])], attributes: &[(&str, AttributeValue)]) -> PathBuf {
        let unseen: Vec<_> = parts.iter().map(|(part, channels)| (*part, "", *channels)).collect();
        self.views(name, &unseen, attributes)
    }

    /// The same, with the view that each part is of.
    pub fn views(&self, name: &str, parts: &[(&str, &str, &[&str])], attributes: &[(&str, AttributeValue)]) -> PathBuf {
        let path = self.path(name);
        let layers = parts.iter().map(|(part, view, channels)| {
            let mut layer =
                layer(channels, &|channel, pixel| noise(&format!("{channel}{view}"), pixel), attributes, false);
            layer.attributes.layer_name = Some(Text::from(*part));
            layer.attributes.view_name = Some(Text::from(*view)).filter(|_| !view.is_empty());
            layer
        });
        let size = ImageAttributes::with_size((SIZE.width, SIZE.height));
        let image = Image::from_layers(size, layers.collect::<exr::prelude::SmallVec<[_; 2]>>());
        image.write().to_file(&path).unwrap();
        path
    }
}

fn layer(
    channels: &[&str],
    values: Values<'_>,
    attributes: &[(&str, AttributeValue)],
    half: bool,
) -> Layer<AnyChannels<FlatSamples>> {
    let channel = |name: &&str| {
        let plane = (0..SIZE.pixels()).map(|pixel| values(name, pixel));
        let samples =
            if half { FlatSamples::F16(plane.map(f16::from_f32).collect()) } else { FlatSamples::F32(plane.collect()) };
        AnyChannel::new(*name, samples)
    };
    let other = attributes.iter().map(|(name, value)| (Text::from(*name), value.clone())).collect();
    let own = LayerAttributes { other, ..LayerAttributes::default() };
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    Layer::new((SIZE.width, SIZE.height), own, Encoding::FAST_LOSSLESS, channels)
}

/// Something between 0 and 1 that depends on the channel and the pixel, exact in half precision.
pub fn noise(name: &str, pixel: usize) -> f32 {
    let hash = name.bytes().fold(pixel as u32 + 1, |h, b| h.wrapping_mul(0x0100_0193) ^ u32::from(b));
    (hash.wrapping_mul(0x9E37_79B1) >> 22) as f32 / 1024.0
}

/// [`noise`] of the channels of a layer of three.
pub fn noise_of(names: &[&str]) -> Planes {
    let plane = |name: &&str| (0..SIZE.pixels()).map(|pixel| noise(name, pixel)).collect();
    Planes::from_channels(SIZE, names.iter().map(plane).collect())
}

/// A text attribute.
pub fn text(value: &str) -> AttributeValue {
    AttributeValue::Text(Text::from(value))
}

/// A folder or file that is shared by developers, when it is there.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/stacks").join(name);
    path.exists().then_some(path)
}
