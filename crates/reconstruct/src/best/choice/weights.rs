//! The file of the chooser's weights ([`crate::network::WeightsReader`] says how lines are written).
//!
//! ```text
//! tamis-chooser 1 6 12 7 24   format, candidates, inputs of a candidate, inputs they share, hidden nodes
//! means m m m …               of each input over the training set: a candidate's own, then the shared ones
//! deviations d d d …          of each input, above 0
//! hidden b … w … w …          a hidden node: its bias for each candidate, weights of shared inputs, of a candidate's
//! output w w w …              weights of the hidden nodes
//! ```
//!
//! The order of inputs is that of `inputs`, that of candidates that of `second_pass`, behind the first pass.

use super::chooser::{Chooser, HIDDEN, INPUTS, NODE, PARAMETERS};
use super::evidence::CANDIDATES;
use super::inputs::{OWN, SHARED};
use crate::best::settings::ChoiceSettings;
use crate::network::{WeightsError, WeightsReader, write_line};

/// The weights that `tamis experiment chooser` trained.
const TRAINED: &str = include_str!("weights.txt");

/// The network that comes along, where the settings ask for it.
///
/// # Errors
/// When the weights that come along are damaged.
pub fn chooser_of(settings: &ChoiceSettings) -> Result<Option<Chooser>, WeightsError> {
    settings.learned.then(trained).transpose()
}

/// The network with the weights that come with this crate.
///
/// # Errors
/// When the file does not fit the code.
pub fn trained() -> Result<Chooser, WeightsError> {
    Chooser::parse(TRAINED)
}

fn head() -> String {
    format!("tamis-chooser 1 {CANDIDATES} {OWN} {SHARED} {HIDDEN}")
}

impl Chooser {
    /// Reads a weights file.
    ///
    /// # Errors
    /// When a line is missing or has other numbers than it should.
    pub fn parse(text: &str) -> Result<Self, WeightsError> {
        let mut lines = WeightsReader::new(text, "the chooser", "tamis experiment chooser", &head())?;
        let means = lines.array("means", false)?;
        let deviations = lines.array("deviations", true)?;
        let mut parameters = Vec::with_capacity(PARAMETERS);
        for _ in 0..HIDDEN {
            parameters.extend(lines.numbers("hidden", NODE, false)?);
        }
        parameters.extend(lines.numbers("output", HIDDEN, false)?);
        Ok(Self { means, deviations, parameters })
    }

    /// The weights file of this network.
    pub fn to_text(&self) -> String {
        let mut text = format!("# Written by `tamis experiment chooser`; see weights.rs for the format.\n{}\n", head());
        let mut line = |name: &str, numbers: &[f32]| write_line(&mut text, name, numbers);
        line("means", &self.means);
        line("deviations", &self.deviations);
        let (nodes, output) = self.parameters.split_at(HIDDEN * NODE);
        nodes.chunks(NODE).for_each(|node| line("hidden", node));
        line("output", output);
        debug_assert_eq!(self.means.len(), INPUTS);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network() -> Chooser {
        let number = |i: usize| (i as f32 * 0.37).sin() * 10_f32.powi(i as i32 % 9 - 6);
        let means = std::array::from_fn(number);
        let deviations = std::array::from_fn(|i| number(i).abs() + 1e-9);
        Chooser { means, deviations, parameters: (0..PARAMETERS).map(number).collect() }
    }

    #[test]
    fn the_weights_that_come_along_fit_the_code_and_are_small() {
        let network = trained().unwrap();
        assert_eq!(network.parameters.len(), PARAMETERS);
        assert!(TRAINED.len() < 20_000);
        assert!(network.parameters.iter().filter(|v| **v != 0.0).count() > PARAMETERS / 2, "they were trained");
    }

    #[test]
    fn what_is_written_is_read_bit_by_bit() {
        assert_eq!(Chooser::parse(&network().to_text()), Ok(network()));
    }

    #[test]
    fn files_of_another_network_are_refused() {
        let mistake = |text: String| Chooser::parse(&text).unwrap_err();
        let text = network().to_text();
        assert_eq!(mistake(text.replace("chooser 1 6", "chooser 1 5")).line, 2);
        assert!(mistake(text.replace("output", "outputs")).to_string().contains("tamis experiment chooser"));
        assert_eq!(mistake(text.replace("deviations ", "deviations -1 ")).found, "'-1'");
    }
}
