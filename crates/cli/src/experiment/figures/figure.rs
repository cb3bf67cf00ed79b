//! A figure that compares settings on the same samples.

use anyhow::Result;

use super::layers::Layer;
use super::measures::Measure;
use super::outcome::{Outcome, Outcomes};
use super::subject::Subject;
use crate::args::ExperimentArgs;
use crate::experiment::case::Entry;
use crate::output::write_png;
use crate::progress::Progress;
use crate::table::{Table, maybe};

/// What a figure of the paper compares, and how.
pub struct Figure {
    /// Its number; two when one table serves both.
    pub numbers: &'static [u32],
    /// What it is about.
    pub about: &'static str,
    /// The settings it compares, a row each.
    pub entries: &'static [Entry],
    /// What is measured, a column each.
    pub measures: &'static [&'static Measure],
    /// Pictures beside the results.
    pub layers: &'static [&'static Layer],
}

impl Figure {
    /// Makes the table from every subject, and writes the pictures.
    ///
    /// # Errors
    /// When a reconstruction fails or a picture cannot be written.
    pub fn make(
        &self,
        subjects: &[Subject],
        outcomes: &mut Outcomes,
        args: &ExperimentArgs,
        progress: &Progress,
    ) -> Result<Table> {
        let head: Vec<&str> = ["input", "variant"].into_iter().chain(self.measures.iter().map(|m| m.head)).collect();
        let mut table = Table::new(self.title(), &head);
        for subject in subjects {
            for entry in self.entries {
                progress.say(&format!("{}: {}: {}", self.title(), subject.case.name, entry.0));
                let outcome = outcomes.of(subject, *entry, args)?;
                self.write_pictures(subject, entry.0, &outcome, args)?;
                let cells = self.measures.iter().map(|measure| maybe((measure.of)(&outcome, subject)));
                let names = [subject.case.name.clone(), entry.0.to_string()];
                table.rows.push(names.into_iter().chain(cells).collect());
            }
        }
        Ok(table)
    }

    fn title(&self) -> String {
        let numbers: Vec<String> = self.numbers.iter().map(u32::to_string).collect();
        let word = if numbers.len() == 1 { "Figure" } else { "Figures" };
        format!("{word} {}: {}", numbers.join(" and "), self.about)
    }

    /// The result, and every layer there is.
    fn write_pictures(&self, subject: &Subject, entry: &str, outcome: &Outcome, args: &ExperimentArgs) -> Result<()> {
        let stem = format!("figure{}-{}-{}", self.numbers[0], subject.case.name, entry.replace(' ', "-"));
        write_png(&args.output.join(format!("{stem}.png")), &outcome.found.picture, subject.stops)?;
        for layer in self.layers {
            if let Some(picture) = (layer.of)(outcome, subject) {
                let stops = if layer.is_light { subject.stops } else { 0.0 };
                write_png(&args.output.join(format!("{stem}-{}.png", layer.name)), &picture, stops)?;
            }
        }
        Ok(())
    }
}
