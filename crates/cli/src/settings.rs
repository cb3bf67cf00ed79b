//! All settings of a picture, from preset, file and flags.

use anyhow::Result;
use clap::{ArgMatches, ValueEnum};
use reconstruct::Fit;
use reconstruct::adaptive::AdaptiveSettings;
use reconstruct::best::BestSettings;
use stack::Knobs;
use tracer::integrator::TraceSettings;

/// Settings to start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Two passes of collaborative regression.
    #[default]
    Best,
    /// `best` with fewer fits in smaller windows.
    Fast,
    /// The paper to the letter.
    Paper,
}

stack::knobs! {
    /// How the loop is divided.
    pub struct LoopSettings("") {
        /// Samples every pixel gets before the first round, at most the whole budget (section 5).
        initial_spp: u32 = 4, 1..=65536;
        /// Rounds that share what remains (section 6).
        iterations: u32 = 3, 0..=64;
        /// Radius of the regression's window in those rounds, in pixels: 5 is 11×11 (section 6). The last
        /// reconstruction has the larger window of the regression's own setting.
        iteration_radius: usize = 5, 1..=64;
        /// Distance between the pixels that carry a collaborative fit in those rounds, unless the last has fewer.
        iteration_stride: usize = 4, 1..=8;
        /// Passes of collaborative fits in those rounds.
        iteration_passes: usize = 2, 1..=2;
        /// Radius of the second pass's window in those rounds, in pixels, unless the last has a smaller one.
        iteration_second_radius: usize = 8, 1..=32;
        /// Whether direct and indirect light are rebuilt apart in those rounds.
        iteration_apart: bool = false, ..;
    }
}

stack::knob_groups! {
    /// Every setting there is.
    pub struct Settings {
        /// How samples are taken.
        trace: TraceSettings,
        /// How the loop is divided.
        rounds: LoopSettings,
        /// Where samples are taken.
        sampling: AdaptiveSettings,
        /// How the picture is rebuilt from them.
        reconstruction: reconstruct::Settings,
    }
}

impl Settings {
    /// The settings of a preset.
    pub fn of(preset: Preset) -> Self {
        match preset {
            Preset::Best => Self::default(),
            Preset::Fast => {
                let mut settings = Self::default();
                settings.reconstruction.best = fast();
                settings
            }
            Preset::Paper => {
                let mut settings = Self::default();
                settings.reconstruction.method.fit = Fit::Local;
                settings.sampling = AdaptiveSettings::PAPER;
                settings
            }
        }
    }

    /// What pictures between two rounds are rebuilt with: no more than tells where samples go.
    pub fn between_rounds(&self) -> reconstruct::Settings {
        let (rounds, mut settings) = (&self.rounds, self.reconstruction);
        settings.regression.window.radius = rounds.iteration_radius;
        settings.best.light.apart &= rounds.iteration_apart;
        // Samples go by the error, which knows nothing of clouds.
        settings.best.clouds.levels = 0;
        let fit = &mut settings.best.regression;
        fit.stride = fit.stride.max(rounds.iteration_stride);
        fit.passes = rounds.iteration_passes;
        fit.second_radius = fit.second_radius.min(rounds.iteration_second_radius);
        settings
    }

    /// The settings that say how samples are taken, and nothing of what is made of them.
    pub fn describe_sampling() -> Vec<stack::Knob> {
        [TraceSettings::describe(), LoopSettings::describe(), AdaptiveSettings::describe()].concat()
    }

    /// The settings that a file records as [`Self::to_json`] has them.
    ///
    /// # Errors
    /// What is wrong with them: a key that is not known, or a value that its flag would not take.
    pub fn recorded(settings: &serde_json::Value) -> Result<Self, String> {
        let settings: Self = serde_json::from_value(settings.clone()).map_err(|error| error.to_string())?;
        settings.validate().map_err(|error| error.to_string())?;
        Ok(settings)
    }

    /// All settings as JSON, numbers as short as they can be written.
    pub fn to_json(self) -> serde_json::Value {
        // By way of text: a value made directly would hold each f32 with the digits of an f64.
        serde_json::to_string(&self).and_then(|text| serde_json::from_str(&text)).unwrap_or_default()
    }

    /// Overrides single settings by the flags that were given.
    ///
    /// # Errors
    /// The first value that cannot be read or is out of range.
    pub fn override_by(&mut self, matches: &ArgMatches) -> Result<()> {
        for knob in Self::describe() {
            if let Some(value) = matches.try_get_one::<String>(&knob.flag).ok().flatten()
                && let Some(outcome) = self.set(&knob.flag, value)
            {
                outcome?;
            }
        }
        Ok(())
    }
}

/// The method of `best` for all light at once, hastened, with a smaller prefilter that leaves out what lies next, and details
/// and lost light looked for on a scale less each.
fn fast() -> BestSettings {
    let mut best = BestSettings::default().hastened();
    best.light.apart = false;
    best.features.radius = 2;
    best.features.next = false;
    best.features.visibility_bandwidth = 0.0;
    best.cascade.levels = 3;
    best.restore.levels = 4;
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_between_rounds_take_no_more_than_the_last() {
        for (preset, stride, radius) in [(Preset::Best, 4, 8), (Preset::Fast, 5, 7)] {
            let found = Settings::of(preset).between_rounds().best;
            assert_eq!((found.regression.stride, found.regression.second_radius), (stride, radius), "{preset:?}");
            assert!(!found.light.apart && found.clouds.levels == 0);
        }
        assert_eq!(Settings::of(Preset::Paper).between_rounds().regression.window.radius, 5);
    }

    #[test]
    fn recorded_settings_are_checked_as_flags_are() {
        let mut fast = Settings::of(Preset::Fast);
        assert_eq!(Settings::recorded(&fast.to_json()), Ok(fast));
        fast.reconstruction.best.regression.stride = 0;
        assert!(Settings::recorded(&fast.to_json()).is_err_and(|why| why.contains("stride: 0 is outside 1..=")));
        let other = serde_json::json!({ "trace": { "of-another-version": 1 } });
        assert!(Settings::recorded(&other).is_err_and(|why| why.contains("of-another-version")));
    }
}
