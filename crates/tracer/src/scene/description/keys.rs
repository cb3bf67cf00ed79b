//! Tables of `scene.toml` that are written once: what reads a key, its range, its default and its documentation come from
//! one [`toml_table!`] definition.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use toml::Spanned;

use super::super::SceneError;
use super::mistakes::Lines;

/// Any number that can be computed with in f32.
pub(super) const FINITE: RangeInclusive<f64> = -1e37..=1e37;
/// 0 or more.
pub(super) const NOT_NEGATIVE: RangeInclusive<f64> = 0.0..=f64::MAX;
/// More than 0.
pub(super) const POSITIVE: RangeInclusive<f64> = f64::MIN_POSITIVE..=f64::MAX;
/// A share.
pub(super) const SHARE: RangeInclusive<f64> = 0.0..=1.0;

/// What documentation says of a key.
#[derive(Clone, Debug)]
pub(super) struct Key {
    pub(super) name: &'static str,
    /// Type and range, in words.
    pub(super) values: String,
    /// Default, as one would type it or in words.
    pub(super) default: String,
    pub(super) doc: &'static str,
}

/// A table made by [`toml_table!`].
pub(super) trait TomlTable {
    /// Its keys, in order.
    fn keys() -> Vec<Key>;

    /// Names and places of the keys that are there.
    fn given(&self) -> Vec<(&'static str, usize)>;

    /// Checks every number that has a range.
    ///
    /// # Errors
    /// The first one outside.
    fn check(&self, lines: &Lines) -> Result<(), SceneError>;

    /// Where the value of `key` begins, when there is one.
    fn place_of(&self, key: &str) -> Option<usize> {
        self.given().into_iter().find(|(name, _)| *name == key).map(|(_, offset)| offset)
    }
}

/// A type that a key's value can have.
pub(super) trait TomlValue {
    /// What values look like, in words.
    fn kind() -> String;

    /// A value as one would type it.
    fn written(&self) -> String {
        String::new()
    }

    /// The numbers in it, for a key with a range.
    fn numbers(&self) -> Vec<f64> {
        vec![]
    }
}

macro_rules! number_values {
    ($($number:ty),*) => { $(
        impl TomlValue for $number {
            fn kind() -> String { "number".into() }
            fn written(&self) -> String { format!("`{self}`") }
            fn numbers(&self) -> Vec<f64> { vec![f64::from(*self)] }
        }
        impl<const N: usize> TomlValue for [$number; N] {
            fn kind() -> String { format!("{N} numbers") }
            fn written(&self) -> String { format!("`{:?}`", self.map(|n| Plain(f64::from(n)))) }
            fn numbers(&self) -> Vec<f64> { self.map(f64::from).to_vec() }
        }
    )* };
}
number_values!(f32, f64);

/// A number without the ".0" that Rust writes behind whole ones.
struct Plain(f64);

impl std::fmt::Debug for Plain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl TomlValue for Vec<f64> {
    fn kind() -> String {
        "numbers".into()
    }
}

impl TomlValue for String {
    fn kind() -> String {
        "string".into()
    }
}

impl TomlValue for PathBuf {
    fn kind() -> String {
        "file name".into()
    }
}

impl TomlValue for bool {
    fn kind() -> String {
        "boolean".into()
    }

    fn written(&self) -> String {
        format!("`{self}`")
    }
}

/// A field's name as a key: some are words of Rust, too.
pub(super) fn key_name(field: &'static str) -> &'static str {
    field.strip_prefix("r#").unwrap_or(field)
}

/// A range in words; nothing for [`FINITE`].
pub(super) fn in_words(range: &RangeInclusive<f64>) -> String {
    match (*range.start(), *range.end()) {
        _ if *range == FINITE => String::new(),
        (f64::MIN_POSITIVE, f64::MAX) => "> 0".into(),
        (least, f64::MAX) => format!("≥ {least}"),
        (least, most) => format!("{least} … {most}"),
    }
}

/// Checks the numbers of the value of `key`, if it was given.
pub(super) fn check_range<T: TomlValue>(
    key: &str,
    value: Option<&Spanned<T>>,
    range: &RangeInclusive<f64>,
    lines: &Lines,
) -> Result<(), SceneError> {
    let Some(value) = value else { return Ok(()) };
    let numbers = value.get_ref().numbers();
    let Some(wrong) = numbers.iter().find(|n| !range.contains(n)) else { return Ok(()) };
    let words = match in_words(range) {
        any if any.is_empty() => format!("numbers of at most 1e37 for {key}"),
        words => format!("{key} {words}"),
    };
    Err(lines.malformed(value.span().start, &words, &wrong.to_string()))
}

/// A value that may have been given.
pub(super) trait Given<T> {
    fn given(&self) -> Option<&Spanned<T>>;
}

impl<T> Given<T> for Spanned<T> {
    fn given(&self) -> Option<&Spanned<T>> {
        Some(self)
    }
}

impl<T> Given<T> for Option<Spanned<T>> {
    fn given(&self) -> Option<&Spanned<T>> {
        self.as_ref()
    }
}

/// Defines a table of `scene.toml`. A key is `required`; or has a `default` value; or is `optional`, and then the text in
/// its place says what is assumed. Each key becomes a method that returns the value, or an `Option` of it. A range behind
/// the default is checked by [`TomlTable::check`].
macro_rules! toml_table {
    ($(#[$meta:meta])* $vis:vis struct $Name:ident {
        $($(#[doc = $doc:literal])+ $need:ident $key:ident: $type:ty $(= $default:expr)? $(, $range:expr)?;)+
    }) => {
        $(#[$meta])*
        #[derive(Debug, ::serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        $vis struct $Name { $($(#[doc = $doc])+ $key: toml_table!(@field $need $type),)+ }

        #[allow(dead_code, reason = "not every value is asked for by its key")]
        impl $Name { $(toml_table! { @value $need $(#[doc = $doc])+ $key: $type $(= $default)? })+ }

        impl $crate::scene::description::keys::TomlTable for $Name {
            fn keys() -> Vec<$crate::scene::description::keys::Key> {
                use $crate::scene::description::keys;
                vec![$(keys::Key {
                    name: keys::key_name(stringify!($key)),
                    values: [<$type as keys::TomlValue>::kind() $(, keys::in_words(&$range))?].join(" ").trim_end().into(),
                    default: toml_table!(@default $need $type $(= $default)?),
                    doc: concat!($($doc),+).trim_ascii_start(),
                },)+]
            }

            fn given(&self) -> Vec<(&'static str, usize)> {
                use $crate::scene::description::keys;
                let keys = [$((
                    keys::key_name(stringify!($key)),
                    keys::Given::<$type>::given(&self.$key).map(|value| value.span().start),
                ),)+];
                keys.into_iter().filter_map(|(key, offset)| Some((key, offset?))).collect()
            }

            fn check(
                &self,
                lines: &$crate::scene::description::mistakes::Lines,
            ) -> Result<(), $crate::scene::SceneError> {
                [$(toml_table!(@check self lines $key $type $(, $range)?),)+].into_iter().collect()
            }
        }
    };
    (@field required $type:ty) => { ::toml::Spanned<$type> };
    (@field $need:ident $type:ty) => { Option<::toml::Spanned<$type>> };
    (@value required $(#[doc = $doc:literal])+ $key:ident: $type:ty) => {
        $(#[doc = $doc])+
        pub(super) fn $key(&self) -> &$type { self.$key.get_ref() }
    };
    (@value optional $(#[doc = $doc:literal])+ $key:ident: $type:ty = $else:expr) => {
        $(#[doc = $doc])+
        pub(super) fn $key(&self) -> Option<&$type> { self.$key.as_ref().map(::toml::Spanned::get_ref) }
    };
    (@value default $(#[doc = $doc:literal])+ $key:ident: $type:ty = $default:expr) => {
        $(#[doc = $doc])+
        pub(super) fn $key(&self) -> $type { self.$key.as_ref().map_or($default, |value| value.get_ref().clone()) }
    };
    (@check $self:ident $lines:ident $key:ident $type:ty) => { { let _ = $lines; Ok(()) } };
    (@check $self:ident $lines:ident $key:ident $type:ty, $range:expr) => {
        $crate::scene::description::keys::check_range(
            stringify!($key),
            $crate::scene::description::keys::Given::<$type>::given(&$self.$key),
            &$range,
            $lines,
        )
    };
    (@default required $type:ty) => { "required".into() };
    (@default optional $type:ty = $else:expr) => { $else.into() };
    (@default default $type:ty = $default:expr) => {{
        let default: $type = $default;
        $crate::scene::description::keys::TomlValue::written(&default)
    }};
}
pub(super) use toml_table;
