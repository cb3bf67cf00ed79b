//! The choice between lights of one kind and all others.

use std::ops::RangeInclusive;

/// How many different whole numbers a choice can be.
pub(super) const CHOICES: u64 = 1 << 32;

/// Chooses between one kind of lights and the others, always in the same proportion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fork {
    /// Of 2³² choices, those that take the one kind.
    choices: u64,
}

impl Fork {
    /// A choice in proportion to `power` and that of the `others`; where both have any, the kind's share stays `within` a
    /// range.
    pub(super) fn new(power: f64, others: f64, within: RangeInclusive<f64>) -> Self {
        let share = match (power > 0.0, others > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (power / (power + others)).clamp(*within.start(), *within.end()),
        };
        Self { choices: (share * CHOICES as f64) as u64 }
    }

    /// Probability of the kind.
    pub(super) fn share(&self) -> f64 {
        self.choices as f64 / CHOICES as f64
    }

    /// Probability of the others.
    pub(super) fn rest(&self) -> f32 {
        ((CHOICES - self.choices) as f64 / CHOICES as f64) as f32
    }

    /// What the whole number `choice` (uniform over 2³²) says: a number in [0, 1) to choose one of the kind, or else one
    /// uniform over 2³² for the others.
    pub(super) fn take(&self, choice: u32) -> Result<f64, u32> {
        let choice = u64::from(choice);
        if choice < self.choices {
            return Ok(choice as f64 / self.choices as f64);
        }
        Err(((choice - self.choices) * CHOICES / (CHOICES - self.choices)) as u32)
    }
}
