//! Values that may be written in more than one way.

use std::fmt::{self, Formatter};
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::image_table::ImageTable;
use super::keys::TomlValue;
use super::triple::Triple;

/// A value, or an image to take it from.
#[derive(Debug)]
pub(super) enum Textured<T> {
    Value(T),
    Image(ImageTable),
}

/// An image, by its name or by a table.
#[derive(Debug)]
pub(super) struct Image(pub(super) ImageTable);

impl<T: TomlValue> TomlValue for Textured<T> {
    fn kind() -> String {
        format!("image, or {}", T::kind())
    }

    fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Value(value) => value.numbers(),
            Self::Image(_) => vec![],
        }
    }
}

impl TomlValue for Image {
    fn kind() -> String {
        "image".into()
    }
}

/// What can stand where plain values do, and the forms in which it can.
trait Plain: Sized {
    const EXPECTED: &'static str;

    fn from_one(_: f64) -> Option<Self> {
        None
    }

    fn from_three(_: [f64; 3]) -> Option<Self> {
        None
    }

    fn from_image(_: ImageTable) -> Option<Self> {
        None
    }
}

impl Plain for f32 {
    const EXPECTED: &'static str = "a number";

    fn from_one(number: f64) -> Option<Self> {
        Some(number as f32)
    }
}

impl Plain for Triple {
    const EXPECTED: &'static str = "a number or three numbers";

    fn from_one(number: f64) -> Option<Self> {
        Some(Self::splat(number))
    }

    fn from_three(numbers: [f64; 3]) -> Option<Self> {
        Some(Self(numbers))
    }
}

impl Plain for Textured<f32> {
    const EXPECTED: &'static str = "a number, or an image's name or table";

    fn from_one(number: f64) -> Option<Self> {
        f32::from_one(number).map(Self::Value)
    }

    fn from_image(image: ImageTable) -> Option<Self> {
        Some(Self::Image(image))
    }
}

impl Plain for Textured<Triple> {
    const EXPECTED: &'static str = "a number, three numbers, or an image's name or table";

    fn from_one(number: f64) -> Option<Self> {
        Triple::from_one(number).map(Self::Value)
    }

    fn from_three(numbers: [f64; 3]) -> Option<Self> {
        Triple::from_three(numbers).map(Self::Value)
    }

    fn from_image(image: ImageTable) -> Option<Self> {
        Some(Self::Image(image))
    }
}

impl Plain for Image {
    const EXPECTED: &'static str = "an image's name or table";

    fn from_image(image: ImageTable) -> Option<Self> {
        Some(Self(image))
    }
}

/// Reads any of them. Unlike an untagged enumeration it keeps the places of keys and names those that do not exist.
struct AnyForm<T>(PhantomData<T>);

impl<'de, T: Plain> Visitor<'de> for AnyForm<T> {
    type Value = T;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(T::EXPECTED)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<T, E> {
        self.visit_f64(number as f64)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<T, E> {
        T::from_one(number).ok_or_else(|| E::invalid_type(serde::de::Unexpected::Float(number), &self))
    }

    fn visit_str<E: Error>(self, file: &str) -> Result<T, E> {
        T::from_image(ImageTable::plain(file)).ok_or_else(|| E::invalid_type(serde::de::Unexpected::Str(file), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<T, A::Error> {
        let mut numbers: Vec<f64> = vec![];
        while let Some(number) = list.next_element()? {
            numbers.push(number);
        }
        let three = <[f64; 3]>::try_from(numbers).map_err(|list| A::Error::invalid_length(list.len(), &self))?;
        T::from_three(three).ok_or_else(|| A::Error::invalid_type(serde::de::Unexpected::Seq, &self))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        let image = ImageTable::deserialize(MapAccessDeserializer::new(map))?;
        T::from_image(image).ok_or_else(|| A::Error::invalid_type(serde::de::Unexpected::Map, &self))
    }
}

macro_rules! any_form {
    ($($type:ty),*) => { $(
        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(AnyForm(PhantomData))
            }
        }
    )* };
}
any_form!(Triple, Textured<f32>, Textured<Triple>, Image);
