//! Short numbers that tell large data apart.

use std::fmt::{Debug, Write};

/// Takes words one by one and ends in a number that depends on all of them and their order, the same on every machine.
/// It finds out accidents, not forgeries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digest(u64);

impl Digest {
    /// One that has taken nothing.
    pub(crate) const fn new() -> Self {
        Self(0x243f_6a88_85a3_08d3)
    }

    /// Takes a word.
    #[inline]
    pub(crate) fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }

    /// Takes numbers, bit by bit.
    pub(crate) fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f32>) {
        numbers.into_iter().for_each(|number| self.word(number.to_bits()));
    }

    /// Takes how many things follow, so that lists do not run into one another.
    pub(crate) fn length(&mut self, length: usize) {
        self.word(length as u32);
        self.word((length as u64 >> 32) as u32);
    }

    /// Takes what something is written as.
    pub(crate) fn debug(&mut self, value: &impl Debug) {
        // Writing here does not fail.
        let _ = write!(self, "{value:?};");
    }

    /// The number.
    pub(crate) fn number(self) -> u64 {
        // The finaliser of SplitMix64: the last words reach all bits, too.
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// The number in hexadecimal digits.
    pub(crate) fn text(self) -> String {
        format!("{:016x}", self.number())
    }
}

impl Write for Digest {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        text.bytes().for_each(|byte| self.word(u32::from(byte)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_and_the_order_count() {
        let of = |words: &[u32]| {
            let mut digest = Digest::new();
            words.iter().for_each(|word| digest.word(*word));
            digest.number()
        };
        let plain = of(&[1, 2, 3]);
        let others = [of(&[2, 1, 3]), of(&[1, 2]), of(&[1, 2, 3, 0]), of(&[]), of(&[0]), of(&[1, 2, 0x8000_0003])];
        assert!(others.iter().all(|other| *other != plain));
        assert_eq!(of(&[1, 2, 3]), plain);
        let bits = (0..32).map(|bit| of(&[7, 1 << bit, 9])).collect::<std::collections::HashSet<_>>();
        assert_eq!(bits.len(), 32);
    }
}
