//! Settings that are written once: the field, its default, its range, its name in files, its flag and its help come
//! from one [`knobs!`](crate::knobs) definition.

use std::fmt::Display;
use std::str::FromStr;

/// Describes one setting to whoever builds flags or documentation from it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Knob {
    /// Name on the command line, without dashes in front.
    pub flag: String,
    /// What it means, from the field's doc comment.
    pub help: &'static str,
    /// Default value, as one would type it.
    pub default: String,
    /// Accepted range, as Rust writes ranges.
    pub range: &'static str,
}

/// A value was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KnobError {
    /// The text is not a value of the knob's type.
    #[error("--{flag}: '{text}' is not {expected}")]
    Unreadable {
        /// The knob.
        flag: String,
        /// What was given.
        text: String,
        /// What is expected.
        expected: String,
    },
    /// The value lies outside the knob's range.
    #[error("--{flag}: {text} is outside {range}")]
    OutOfRange {
        /// The knob.
        flag: String,
        /// What was given.
        text: String,
        /// What is accepted.
        range: &'static str,
    },
}

/// A type that a knob can hold.
pub trait KnobValue: FromStr + Display {
    /// What values look like, for messages.
    fn expected() -> String;
}

macro_rules! plain_values {
    ($($type:ty: $text:literal),*) => { $(
        impl KnobValue for $type {
            fn expected() -> String { $text.into() }
        }
    )* };
}
plain_values!(f32: "a number", u32: "a whole number", usize: "a whole number", u64: "a whole number", bool: "true or false");

/// A group of settings made by [`knobs!`](crate::knobs), or several such groups together.
pub trait Knobs {
    /// Describes every setting.
    fn describe() -> Vec<Knob>;

    /// Sets the knob called `flag` from text. `None` when there is no such knob.
    fn set(&mut self, flag: &str, text: &str) -> Option<Result<(), KnobError>>;

    /// Checks every value against its range, for settings that came from a file.
    ///
    /// # Errors
    /// The first value out of range.
    fn validate(&self) -> Result<(), KnobError>;
}

/// Reads a value and checks its range; [`knobs!`](crate::knobs) calls it.
///
/// # Errors
/// When `text` cannot be read or `accepts` refuses the value.
pub fn read_knob<T: KnobValue>(
    flag: &str,
    text: &str,
    range: &'static str,
    accepts: impl Fn(&T) -> bool,
) -> Result<T, KnobError> {
    let value: T = text.parse().map_err(|_| KnobError::Unreadable {
        flag: flag.into(),
        text: text.into(),
        expected: T::expected(),
    })?;
    if accepts(&value) { Ok(value) } else { Err(KnobError::OutOfRange { flag: flag.into(), text: text.into(), range }) }
}

/// The flag of field `field` in a group with `prefix`: `("spike", "tile_size")` is `spike-tile-size`.
pub fn flag_name(prefix: &str, field: &str) -> String {
    let field = field.replace('_', "-");
    if prefix.is_empty() { field } else { format!("{prefix}-{field}") }
}

/// Defines a settings struct. Every field has a doc comment, a default and a range (`..` for any value).
///
/// ```
/// stack::knobs! {
///     /// How spikes are found.
///     pub struct Spikes("spike") {
///         /// Side of a tile, in pixels.
///         tile_size: usize = 64, 8..=1024;
///     }
/// }
/// use stack::Knobs;
/// let mut spikes = Spikes::DEFAULT;
/// spikes.set("spike-tile-size", "32").unwrap().unwrap();
/// assert_eq!(spikes.tile_size, 32);
/// ```
#[macro_export]
macro_rules! knobs {
    ($(#[$meta:meta])* $vis:vis struct $Name:ident($prefix:literal) {
        $($(#[doc = $doc:literal])+ $field:ident: $type:ty = $default:expr, $range:expr;)+
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
        $vis struct $Name { $($(#[doc = $doc])+ pub $field: $type,)+ }

        impl $Name {
            /// The default of every setting.
            pub const DEFAULT: Self = Self { $($field: $default,)+ };
        }

        impl Default for $Name {
            fn default() -> Self { Self::DEFAULT }
        }

        impl $crate::Knobs for $Name {
            fn describe() -> Vec<$crate::Knob> {
                vec![$($crate::Knob {
                    flag: $crate::flag_name($prefix, stringify!($field)),
                    help: concat!($($doc, "\n"),+),
                    default: Self::DEFAULT.$field.to_string(),
                    range: stringify!($range),
                },)+]
            }

            fn set(&mut self, flag: &str, text: &str) -> Option<Result<(), $crate::KnobError>> {
                $(if flag == $crate::flag_name($prefix, stringify!($field)) {
                    let accepts = |value: &$type| ::std::ops::RangeBounds::<$type>::contains(&($range), value);
                    let read = $crate::read_knob::<$type>(flag, text, stringify!($range), accepts);
                    return Some(read.map(|value| self.$field = value));
                })+
                None
            }

            fn validate(&self) -> Result<(), $crate::KnobError> {
                $(if !::std::ops::RangeBounds::<$type>::contains(&($range), &self.$field) {
                    return Err($crate::KnobError::OutOfRange {
                        flag: $crate::flag_name($prefix, stringify!($field)),
                        text: self.$field.to_string(),
                        range: stringify!($range),
                    });
                })+
                Ok(())
            }
        }
    };
}

/// Defines an enumeration a knob can hold, with the words it is written as.
///
/// ```
/// stack::knob_choice! {
///     /// Which of two.
///     pub enum Order {
///         /// The first.
///         First = "first",
///         /// The second.
///         Second = "second",
///     }
/// }
/// assert_eq!("second".parse(), Ok(Order::Second));
/// ```
#[macro_export]
macro_rules! knob_choice {
    ($(#[$meta:meta])* $vis:vis enum $Name:ident { $($(#[$variant_meta:meta])* $Variant:ident = $word:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ::serde::Serialize, ::serde::Deserialize)]
        $vis enum $Name { $($(#[$variant_meta])* #[serde(rename = $word)] $Variant,)+ }

        impl ::std::fmt::Display for $Name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(match self { $(Self::$Variant => $word,)+ })
            }
        }

        impl ::std::str::FromStr for $Name {
            type Err = ();
            fn from_str(text: &str) -> Result<Self, ()> {
                match text { $($word => Ok(Self::$Variant),)+ _ => Err(()) }
            }
        }

        impl $crate::KnobValue for $Name {
            fn expected() -> String { [$($word),+].join(" or ") }
        }
    };
}

/// Defines a struct whose fields are groups of knobs, and makes it one group itself.
#[macro_export]
macro_rules! knob_groups {
    ($(#[$meta:meta])* $vis:vis struct $Name:ident { $($(#[doc = $doc:literal])+ $field:ident: $type:ty,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
        $vis struct $Name { $($(#[doc = $doc])+ pub $field: $type,)+ }

        impl $crate::Knobs for $Name {
            fn describe() -> Vec<$crate::Knob> {
                [$(<$type as $crate::Knobs>::describe()),+].concat()
            }

            fn set(&mut self, flag: &str, text: &str) -> Option<Result<(), $crate::KnobError>> {
                $(if let Some(outcome) = $crate::Knobs::set(&mut self.$field, flag, text) {
                    return Some(outcome);
                })+
                None
            }

            fn validate(&self) -> Result<(), $crate::KnobError> {
                $($crate::Knobs::validate(&self.$field)?;)+
                Ok(())
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::knob_choice! {
        /// Two orders.
        pub enum Order {
            /// First.
            First = "first",
            /// Second.
            Second = "second",
        }
    }

    crate::knobs! {
        /// A group.
        pub struct Group("some") {
            /// How many.
            /// In pixels.
            how_many: u32 = 3, 1..=9;
            /// Which.
            order: Order = Order::First, ..;
        }
    }

    #[test]
    fn a_knob_reads_checks_and_describes_itself() {
        let mut group = Group::DEFAULT;
        group.set("some-how-many", "9").unwrap().unwrap();
        assert_eq!(group.how_many, 9);
        let refused = group.set("some-how-many", "10").unwrap().unwrap_err();
        assert_eq!(refused.to_string(), "--some-how-many: 10 is outside 1..=9");
        let refused = group.set("some-order", "third").unwrap().unwrap_err();
        assert_eq!(refused.to_string(), "--some-order: 'third' is not first or second");
        assert!(group.set("how-many", "1").is_none());
        assert_eq!(Group::describe()[0].help.trim(), "How many.\n In pixels.");
        group.how_many = 10;
        assert!(group.validate().is_err());
    }
}
