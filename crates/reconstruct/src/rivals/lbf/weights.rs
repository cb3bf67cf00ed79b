//! The weights file: text, one line per group of numbers, `#` begins a comment.
//!
//! ```text
//! tamis-lbf 1 36 16 6        format, secondary features, hidden nodes, bandwidths
//! means m m m …              of each secondary feature over the training set
//! deviations d d d …         of each secondary feature, above 0
//! units u u u …              what each bandwidth is measured in, above 0
//! hidden b w w w …           bias and weights of a hidden node; as many lines as nodes
//! output b w w w …           bias and weights of an output; as many lines as bandwidths
//! ```
//!
//! Numbers are written so that reading them gives the same bits. The order of the secondary features is that of
//! `secondary`, that of the bandwidths that of `kernel`.

use std::fmt::Write;

use stack::Fault;

use super::kernel::TERMS;
use super::network::{HIDDEN, Network, PARAMETERS};
use super::secondary::INPUTS;

/// The weights that `tamis experiment lbf` trained.
const TRAINED: &str = include_str!("weights.txt");

/// A weights file that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("lbf weights, line {line}: expected {expected}, found {found}; make them again with `tamis experiment lbf`")]
pub struct WeightsError {
    /// Counted from 1; one past the last when the file ends early.
    pub line: usize,
    /// What should stand there.
    pub expected: String,
    /// What does.
    pub found: String,
}

impl WeightsError {
    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        Fault::Input
    }
}

/// The network with the weights that come with this crate.
///
/// # Errors
/// When the file does not fit the code.
pub fn trained() -> Result<Network, WeightsError> {
    Network::parse(TRAINED)
}

fn head() -> String {
    format!("tamis-lbf 1 {INPUTS} {HIDDEN} {TERMS}")
}

impl Network {
    /// Reads a weights file.
    ///
    /// # Errors
    /// When a line is missing or has other numbers than it should.
    pub fn parse(text: &str) -> Result<Self, WeightsError> {
        let mut lines = Lines { lines: text.lines().enumerate().collect(), next: 0 };
        let (line, found) = lines.take(&head())?;
        if found != head() {
            return Err(WeightsError { line, expected: head(), found: found.into() });
        }
        let means = array(&lines.numbers("means", INPUTS, false)?);
        let deviations = array(&lines.numbers("deviations", INPUTS, true)?);
        let units = array(&lines.numbers("units", TERMS, true)?);
        let mut parameters = Vec::with_capacity(PARAMETERS);
        for _ in 0..HIDDEN {
            parameters.extend(lines.numbers("hidden", INPUTS + 1, false)?);
        }
        for _ in 0..TERMS {
            parameters.extend(lines.numbers("output", HIDDEN + 1, false)?);
        }
        Ok(Self { means, deviations, units, parameters })
    }

    /// The weights file of this network.
    pub fn to_text(&self) -> String {
        let mut text = format!("# Written by `tamis experiment lbf`; see weights.rs for the format.\n{}\n", head());
        let mut line = |name: &str, numbers: &[f32]| {
            text.push_str(name);
            numbers.iter().for_each(|v| {
                let _ = write!(text, " {v}");
            });
            text.push('\n');
        };
        line("means", &self.means);
        line("deviations", &self.deviations);
        line("units", &self.units);
        let (first, second) = self.parameters.split_at(HIDDEN * (INPUTS + 1));
        first.chunks(INPUTS + 1).for_each(|node| line("hidden", node));
        second.chunks(HIDDEN + 1).for_each(|node| line("output", node));
        text
    }
}

/// Numbers that were counted before.
fn array<const N: usize>(numbers: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| numbers[i])
}

/// The lines of a file that say something, one by one.
struct Lines<'t> {
    lines: Vec<(usize, &'t str)>,
    next: usize,
}

impl<'t> Lines<'t> {
    /// The next line with its number.
    fn take(&mut self, expected: &str) -> Result<(usize, &'t str), WeightsError> {
        while let Some((index, line)) = self.lines.get(self.next) {
            self.next += 1;
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                return Ok((index + 1, line));
            }
        }
        let end = self.lines.len() + 1;
        Err(WeightsError { line: end, expected: expected.into(), found: "the end of the file".into() })
    }

    /// The `count` finite numbers, above 0 if `positive`, of the next line, which must begin with `name`.
    fn numbers(&mut self, name: &str, count: usize, positive: bool) -> Result<Vec<f32>, WeightsError> {
        let least = if positive { " above 0" } else { "" };
        let expected = format!("'{name}' and {count} numbers{least}");
        let (line, text) = self.take(&expected)?;
        let refuse = |found: String| WeightsError { line, expected: expected.clone(), found };
        let mut words = text.split_whitespace();
        if let Some(other) = words.next().filter(|word| *word != name) {
            return Err(refuse(format!("'{other}'")));
        }
        let is_fit = |v: &f32| v.is_finite() && (!positive || *v > 0.0);
        let number = |word: &str| word.parse().ok().filter(is_fit).ok_or_else(|| refuse(format!("'{word}'")));
        let numbers: Vec<f32> = words.map(number).collect::<Result<_, _>>()?;
        if numbers.len() == count { Ok(numbers) } else { Err(refuse(format!("{} numbers", numbers.len()))) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::training::start;
    use super::*;

    fn network() -> Network {
        let examples = [[0.25; INPUTS], [1.0; INPUTS]];
        start(examples.iter(), [0.1, 3.0, 1e-7, 5.5, 1e9, 1.0], 7)
    }

    #[test]
    fn the_weights_that_come_along_fit_the_code() {
        let network = trained().unwrap();
        assert_eq!(network.parameters.len(), PARAMETERS);
        assert!(TRAINED.len() < 200_000);
        let distinct = network.parameters.iter().filter(|v| **v != 0.0).count();
        assert!(distinct > PARAMETERS / 2, "they were trained");
    }

    #[test]
    fn what_is_written_is_read_bit_by_bit() {
        let network = network();
        assert_eq!(Network::parse(&network.to_text()), Ok(network));
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        let text = network().to_text();
        let mistake = |text: String| Network::parse(&text).unwrap_err();
        let other = mistake(text.replace("tamis-lbf 1", "tamis-lbf 2"));
        assert_eq!((other.line, other.found.contains("tamis-lbf 2")), (2, true));
        assert_eq!(mistake(text.replace("deviations ", "deviations 0 ")).found, "'0'");
        assert_eq!(mistake(text.replace("means ", "means x")).line, 3);
        assert_eq!(mistake(text.replace("units ", "units 1 ")).found, "7 numbers");
        let end = mistake(text.rsplit_once("output").unwrap().0.to_string());
        assert_eq!((end.found.as_str(), end.line), ("the end of the file", text.lines().count()));
    }
}
