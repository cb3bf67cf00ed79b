//! Files of weights: text, one line per group of numbers, `#` begins a comment.
//!
//! The first line is a head that says which network it is and how large; every other line is a name and its numbers,
//! written so that reading them gives the same bits.

use std::fmt::Write;

use stack::Fault;

/// A weights file that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("weights of {network}, line {line}: expected {expected}, found {found}; make them again with `{command}`")]
pub struct WeightsError {
    /// Which network.
    pub network: &'static str,
    /// Counted from 1; one past the last when the file ends early.
    pub line: usize,
    /// What should stand there.
    pub expected: String,
    /// What does.
    pub found: String,
    /// What writes such a file.
    pub command: &'static str,
}

impl WeightsError {
    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        Fault::Input
    }
}

/// The lines of a file that say something, one by one.
#[derive(Clone, Debug)]
pub struct WeightsReader<'t> {
    network: &'static str,
    command: &'static str,
    lines: Vec<(usize, &'t str)>,
    next: usize,
}

impl<'t> WeightsReader<'t> {
    /// Begins to read the weights of `network` that `command` writes, and checks their `head`.
    ///
    /// # Errors
    /// When they have another head.
    pub fn new(text: &'t str, network: &'static str, command: &'static str, head: &str) -> Result<Self, WeightsError> {
        let mut reader = Self { network, command, lines: text.lines().enumerate().collect(), next: 0 };
        let (line, found) = reader.take(head)?;
        if found == head { Ok(reader) } else { Err(reader.refuse(line, head, found.into())) }
    }

    fn refuse(&self, line: usize, expected: &str, found: String) -> WeightsError {
        WeightsError { network: self.network, line, expected: expected.into(), found, command: self.command }
    }

    /// The next line with its number.
    fn take(&mut self, expected: &str) -> Result<(usize, &'t str), WeightsError> {
        while let Some((index, line)) = self.lines.get(self.next) {
            self.next += 1;
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                return Ok((index + 1, line));
            }
        }
        Err(self.refuse(self.lines.len() + 1, expected, "the end of the file".into()))
    }

    /// The `count` finite numbers, above 0 if `positive`, of the next line, which must begin with `name`.
    ///
    /// # Errors
    /// When that is not so.
    pub fn numbers(&mut self, name: &str, count: usize, positive: bool) -> Result<Vec<f32>, WeightsError> {
        let least = if positive { " above 0" } else { "" };
        let expected = format!("'{name}' and {count} numbers{least}");
        let (line, text) = self.take(&expected)?;
        let refuse = |found: String| self.refuse(line, &expected, found);
        let mut words = text.split_whitespace();
        if let Some(other) = words.next().filter(|word| *word != name) {
            return Err(refuse(format!("'{other}'")));
        }
        let is_fit = |v: &f32| v.is_finite() && (!positive || *v > 0.0);
        let number = |word: &str| word.parse().ok().filter(is_fit).ok_or_else(|| refuse(format!("'{word}'")));
        let numbers: Vec<f32> = words.map(number).collect::<Result<_, _>>()?;
        if numbers.len() == count { Ok(numbers) } else { Err(refuse(format!("{} numbers", numbers.len()))) }
    }

    /// [`Self::numbers`] as an array.
    ///
    /// # Errors
    /// As there.
    pub fn array<const N: usize>(&mut self, name: &str, positive: bool) -> Result<[f32; N], WeightsError> {
        let numbers = self.numbers(name, N, positive)?;
        Ok(std::array::from_fn(|i| numbers[i]))
    }
}

/// Adds the line of `name` and its `numbers` to `text`.
pub fn write_line(text: &mut String, name: &str, numbers: &[f32]) {
    text.push_str(name);
    for number in numbers {
        let _ = write!(text, " {number}");
    }
    text.push('\n');
}
