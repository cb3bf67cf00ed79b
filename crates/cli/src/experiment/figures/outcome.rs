//! Pictures rebuilt from the same samples by different settings, each made once.

use std::collections::BTreeMap;
use std::rc::Rc;

use anyhow::Result;
use reconstruct::metrics::Comparison;
use reconstruct::{Reconstruction, reconstruct};

use super::subject::Subject;
use crate::args::ExperimentArgs;
use crate::experiment::case::{Entry, settings};
use crate::progress::Progress;
use crate::settings::Settings;

/// What came of one reconstruction.
pub struct Outcome {
    /// How it was made.
    pub settings: Settings,
    /// The picture and its maps.
    pub found: Reconstruction,
    /// Against both references.
    pub comparison: Comparison,
    /// Seconds of every stage.
    stages: Vec<(&'static str, f64)>,
}

impl Outcome {
    /// Seconds of one stage; `None` when there was none of that name.
    pub fn seconds_of(&self, stage: &str) -> Option<f64> {
        self.stages.iter().find(|(name, _)| *name == stage).map(|(_, seconds)| *seconds)
    }

    /// Seconds of all stages.
    pub fn seconds(&self) -> f64 {
        self.stages.iter().map(|(_, seconds)| seconds).sum()
    }
}

/// All outcomes so far, by subject and settings: several figures show the same ones.
#[derive(Default)]
pub struct Outcomes(BTreeMap<(String, String), Rc<Outcome>>);

impl Outcomes {
    /// What comes of `subject` with the settings of an entry.
    ///
    /// # Errors
    /// When a flag is wrong or the reconstruction fails.
    pub fn of(&mut self, subject: &Subject, (_, preset, flags): Entry, args: &ExperimentArgs) -> Result<Rc<Outcome>> {
        let settings = settings(preset, flags)?;
        let key = (subject.case.name.clone(), settings.to_json().to_string());
        if let Some(outcome) = self.0.get(&key) {
            return Ok(Rc::clone(outcome));
        }
        let clock = Progress::new(&args.report);
        let found = reconstruct(&subject.case.stack, &settings.reconstruction, &clock)?;
        clock.finish();
        let comparison = subject.case.judge(&found.picture)?;
        let outcome = Rc::new(Outcome { settings, found, comparison, stages: clock.stage_seconds() });
        self.0.insert(key, Rc::clone(&outcome));
        Ok(outcome)
    }
}
