//! The file of the judge's weights ([`crate::network::WeightsReader`] says how lines are written).
//!
//! ```text
//! tamis-guide 1 61 96        format, inputs, hidden nodes
//! means m m m …              of each input over the training set
//! deviations d d d …         of each input, above 0
//! hidden b w w w …           a hidden node: its bias, weights of the inputs
//! output b w w w …           bias, weights of the hidden nodes
//! ```
//!
//! The order of inputs is that of `inputs`.

use super::inputs::INPUTS;
use super::judge::{HIDDEN, Judge, NODE};
use crate::network::{WeightsError, WeightsReader};

/// The trained weights; `docs/denoise.md` says on what.
const TRAINED: &str = include_str!("weights.txt");

/// The network with the weights that come with this crate.
///
/// # Errors
/// When the file does not fit the code.
pub fn trained() -> Result<Judge, WeightsError> {
    Judge::parse(TRAINED)
}

impl Judge {
    /// Reads a weights file.
    ///
    /// # Errors
    /// When a line is missing or has other numbers than it should.
    pub fn parse(text: &str) -> Result<Self, WeightsError> {
        let head = format!("tamis-guide 1 {INPUTS} {HIDDEN}");
        let mut lines = WeightsReader::new(text, "the guide's judge", "scripts/train_guide.py", &head)?;
        let means = lines.array("means", false)?;
        let deviations = lines.array("deviations", true)?;
        let mut hidden = Vec::with_capacity(HIDDEN * NODE);
        for _ in 0..HIDDEN {
            hidden.extend(lines.numbers("hidden", NODE, false)?);
        }
        Ok(Self { means, deviations, hidden, output: lines.array("output", false)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_that_come_along_fit_the_code_and_are_small() {
        let judge = trained().unwrap();
        assert!(TRAINED.len() < 100_000);
        assert!(judge.hidden.iter().filter(|v| **v != 0.0).count() > judge.hidden.len() / 2, "they were trained");
    }

    #[test]
    fn files_of_another_network_are_refused() {
        let mistake = |text: String| Judge::parse(&text).unwrap_err();
        assert_eq!(mistake(TRAINED.replace("tamis-guide 1", "tamis-guide 2")).line, 2);
        assert!(mistake(TRAINED.replace("output", "outputs")).to_string().contains("train_guide.py"));
    }
}
