//! What a file says beside its pixels, kept for the file that is made of it.

use exr::meta::header::ImageAttributes;
use exr::meta::header::standard_names::ALL;
use exr::prelude::{AttributeValue, IntegerBounds, LayerAttributes, Text, Vec2};

use super::exr_text::{decoded, encoded};
use super::header_order::CustomNames;
use crate::{Size, Window};

/// Attributes of an EXR file that have nothing to do with its channels: where its display window begins, pixel aspect
/// ratio, chromaticities, camera and lens, and every custom one (of several parts the first that says it).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Carried {
    image: Option<ImageAttributes>,
    layer: LayerAttributes,
    /// Names of attributes that no file may have.
    refused: Vec<String>,
}

impl Carried {
    /// Keeps the attributes of a file, from those of its parts.
    pub(super) fn new(image: ImageAttributes, parts: impl IntoIterator<Item = LayerAttributes>) -> Self {
        let mut parts = parts.into_iter();
        let mut layer = parts.next().unwrap_or_default();
        // Several parts become one, which is none of them.
        layer.layer_name = None;
        for part in parts {
            for (name, value) in part.other {
                layer.other.entry(name).or_insert(value);
            }
            layer.world_to_camera = layer.world_to_camera.or(part.world_to_camera);
            layer.view_name = layer.view_name.filter(|name| Some(name) == part.view_name.as_ref());
        }
        let mut kept = Self { image: Some(image), layer, refused: Vec::new() };
        kept.refuse_misused_names();
        kept
    }

    /// Lets go of attributes with a name of the format's own that are of another type than it demands (frames per second as
    /// one number): with them no file can be written.
    fn refuse_misused_names(&mut self) {
        let image = self.image.iter_mut().map(|image| &mut image.other);
        for attributes in image.chain([&mut self.layer.other]) {
            for name in ALL.iter().map(|name| encoded(&String::from_utf8_lossy(name))) {
                self.refused.extend(attributes.remove(&name).map(|_| decoded(name.bytes())));
            }
        }
    }

    /// Names of attributes that are not carried along.
    pub(super) fn refused(&self) -> &[String] {
        &self.refused
    }

    /// Takes the text attribute `name` out.
    pub(super) fn take_text(&mut self, name: &str) -> Option<String> {
        match self.layer.other.remove(&encoded(name))? {
            AttributeValue::Text(text) => Some(decoded(text.bytes())),
            _ => None,
        }
    }

    /// The custom attribute called `name`, as text whatever it is.
    pub fn text(&self, name: &str) -> Option<String> {
        let known = match name {
            "software" => self.layer.software_name.as_ref(),
            "comments" => self.layer.comments.as_ref(),
            _ => None,
        };
        known.map(|text| decoded(text.bytes())).or_else(|| as_text(self.custom(name)?))
    }

    /// Whether an attribute's name begins with `start` and its value contains `value`.
    pub fn begins_with(&self, start: &str, value: &str) -> bool {
        let says = |text: Option<String>| value.is_empty() || text.is_some_and(|text| text.contains(value));
        self.all().any(|(name, v)| decoded(name.bytes()).starts_with(start) && says(as_text(v)))
            || (start == "software" && self.text("software").is_some_and(|text| text.contains(value)))
    }

    /// The first custom attribute whose name begins and ends as given, as a number.
    pub fn number(&self, (start, end): (&str, &str)) -> Option<f64> {
        let mut found: Vec<(String, &AttributeValue)> =
            self.all().map(|(name, value)| (decoded(name.bytes()), value)).collect();
        found.retain(|(n, _)| n.len() >= start.len() + end.len() && n.starts_with(start) && n.ends_with(end));
        found.sort_by(|a, b| a.0.cmp(&b.0));
        found.into_iter().find_map(|(_, value)| as_text(value)?.trim().parse().ok())
    }

    /// Matrix from world to camera space, as it stands in the file.
    pub fn world_to_camera(&self) -> Option<[f32; 16]> {
        self.layer.world_to_camera
    }

    fn all(&self) -> impl Iterator<Item = (&Text, &AttributeValue)> {
        self.layer.other.iter().chain(self.image.iter().flat_map(|image| &image.other))
    }

    fn custom(&self, name: &str) -> Option<&AttributeValue> {
        self.all().find_map(|(n, value)| (n.bytes() == name.as_bytes()).then_some(value))
    }

    /// Attributes for a file of one part that covers `window` of `film`, and the names of the custom ones.
    pub(super) fn for_file(&self, window: Window, film: Size) -> (ImageAttributes, LayerAttributes, CustomNames) {
        let origin = self.image.as_ref().map_or(Vec2(0, 0), |image| image.display_window.position);
        let display = IntegerBounds::new(origin, (film.width, film.height));
        let image = match &self.image {
            Some(image) => ImageAttributes { display_window: display, ..image.clone() },
            None => ImageAttributes::new(display),
        };
        let layer = LayerAttributes {
            layer_position: origin + Vec2(window.x, window.y),
            software_name: Some(encoded("tamis")),
            ..self.layer.clone()
        };
        let names = self.all().map(|(name, _)| decoded(name.bytes())).collect();
        (image, layer, names)
    }
}

fn as_text(value: &AttributeValue) -> Option<String> {
    match value {
        AttributeValue::Text(text) => Some(decoded(text.bytes())),
        AttributeValue::I32(number) => Some(number.to_string()),
        AttributeValue::F32(number) => Some(number.to_string()),
        AttributeValue::F64(number) => Some(number.to_string()),
        _ => None,
    }
}
