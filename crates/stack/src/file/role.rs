//! What a layer of another renderer's file can be.

use std::fmt;
use std::str::FromStr;

use crate::FeatureRole;

/// What a layer shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// The noisy picture.
    Colour,
    /// Directly seen emission, part of the picture.
    Emission,
    /// A feature.
    Feature(FeatureRole),
    /// Coverage.
    Alpha,
    /// Samples per pixel.
    Samples,
}

/// Which number about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Measure {
    /// The mean over samples.
    Mean,
    /// A measure of its noise.
    Variance(Convention),
    /// The mean over one half of the samples.
    HalfA,
    /// The mean over the other half.
    HalfB,
}

/// What a file calls variance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Convention {
    /// Of one sample: that of the mean is this, divided by the number of samples.
    Sample,
    /// Of the mean.
    Mean,
    /// Mean of the squared samples.
    SecondMoment,
    /// Square root of the variance of the mean.
    StandardError,
    /// ((A − B)/2)² of two halves.
    HalfDifference,
    /// The file does not say, and its renderer is not known.
    Unsaid,
}

impl Convention {
    /// Word for the command line, and what is said about it.
    const WORDS: [(Self, &'static str, &'static str); 5] = [
        (Self::Sample, "sample", "variance of a sample"),
        (Self::Mean, "mean", "variance of the mean"),
        (Self::SecondMoment, "second-moment", "second moment"),
        (Self::StandardError, "standard-error", "standard error"),
        (Self::HalfDifference, "half-difference", "squared half difference"),
    ];
}

impl FromStr for Convention {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words = || Self::WORDS.map(|(_, word, _)| word).join(", ");
        let found = Self::WORDS.iter().find(|(_, word, _)| *word == text);
        found.map(|(convention, ..)| *convention).ok_or_else(|| format!("expected one of {}", words()))
    }
}

impl fmt::Display for Convention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = Self::WORDS.iter().find(|(convention, ..)| convention == self);
        f.write_str(said.map_or("variance of unknown kind", |(.., text)| text))
    }
}

impl Role {
    /// All roles, colour first.
    pub const ALL: [Self; 11] = [
        Self::Colour,
        Self::Emission,
        Self::Feature(FeatureRole::Position),
        Self::Feature(FeatureRole::Albedo),
        Self::Feature(FeatureRole::Normal),
        Self::Feature(FeatureRole::Visibility),
        Self::Feature(FeatureRole::Depth),
        Self::Feature(FeatureRole::Proximity),
        Self::Feature(FeatureRole::Lit),
        Self::Alpha,
        Self::Samples,
    ];

    /// Its name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Colour => "colour",
            Self::Emission => "emission",
            Self::Feature(feature) => feature.layer(),
            Self::Alpha => "alpha",
            Self::Samples => "samples",
        }
    }

    /// How many channels it has, 3 or 1.
    pub const fn channels(self) -> usize {
        match self {
            Self::Colour | Self::Emission => 3,
            Self::Feature(feature) => feature.channels().len(),
            Self::Alpha | Self::Samples => 1,
        }
    }
}

/// A role and a measure: what `albedo-variance=` names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Slot {
    /// What is shown.
    pub role: Role,
    /// Which number about it.
    pub measure: Measure,
}

impl Slot {
    /// Whether both name the same thing, whatever kind of variance it is.
    pub fn same_as(self, other: Self) -> bool {
        let kind =
            |measure| if let Measure::Variance(_) = measure { Measure::Variance(Convention::Unsaid) } else { measure };
        self.role == other.role && kind(self.measure) == kind(other.measure)
    }
}

impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.role.name())?;
        f.write_str(match self.measure {
            Measure::Mean => "",
            Measure::Variance(_) => "-variance",
            Measure::HalfA => "-a",
            Measure::HalfB => "-b",
        })
    }
}

impl FromStr for Slot {
    type Err = String;

    /// A role, perhaps with `-variance`, `-a` or `-b`: `albedo`, `colour-variance`, `normal-a`.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.to_lowercase().replace("color", "colour");
        let endings = [
            ("-variance", Measure::Variance(Convention::Unsaid)),
            ("-a", Measure::HalfA),
            ("-b", Measure::HalfB),
            ("", Measure::Mean),
        ];
        let read = |(ending, measure)| {
            let name = text.strip_suffix(ending)?;
            let role = Role::ALL.into_iter().find(|role| role.name() == name)?;
            Some(Self { role, measure })
        };
        let roles = || Role::ALL.map(Role::name).join(", ");
        endings.into_iter().find_map(read).ok_or_else(|| {
            format!("'{text}' is no role; expected one of {}, perhaps with -variance, -a or -b", roles())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_are_written_as_they_are_read() {
        for role in Role::ALL {
            for measure in [Measure::Mean, Measure::Variance(Convention::Unsaid), Measure::HalfA, Measure::HalfB] {
                let slot = Slot { role, measure };
                assert_eq!(slot.to_string().parse(), Ok(slot));
            }
        }
        assert_eq!("Color-A".parse::<Slot>().unwrap().to_string(), "colour-a");
        assert!("shadow".parse::<Slot>().unwrap_err().contains("visibility"));
    }
}
