//! Damaging files.

/// Random numbers (SplitMix64).
pub struct Random(u64);

impl Random {
    /// A sequence for input `number` of `seed`.
    pub fn new(seed: u64, number: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ number);
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let n = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let n = (n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        n ^ (n >> 31)
    }

    /// A number below `end`, which is above 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

/// Words that readers of text trip over.
const WORDS: [&str; 20] = [
    "0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e38",
    "-1e39",
    "1e-46",
    "4294967296",
    "99999999999999999999",
    ".",
    "-",
    "/",
    "//",
    "[",
    "]",
    "\"",
    "\\\n",
    "\u{fffd}",
];

/// Numbers that readers of binary files trip over, little-endian.
const NUMBERS: [u32; 8] = [0, 1, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff];

/// Makes one input out of a corpus.
pub struct Mutator<'a> {
    seeds: &'a [Vec<u8>],
    random: &'a mut Random,
}

impl<'a> Mutator<'a> {
    /// `seeds` must not be empty.
    pub fn new(seeds: &'a [Vec<u8>], random: &'a mut Random) -> Self {
        Self { seeds, random }
    }

    /// A file of the corpus, damaged in a place or two, sometimes in many.
    pub fn make(mut self) -> Vec<u8> {
        let mut bytes = self.seed().to_vec();
        let most = if self.random.below(4) == 0 { 12 } else { 2 };
        for _ in 0..=self.random.below(most) {
            self.damage(&mut bytes);
        }
        bytes
    }

    fn seed(&mut self) -> &'a [u8] {
        &self.seeds[self.random.below(self.seeds.len())]
    }

    /// Between two bytes, or at an end.
    fn place(&mut self, bytes: &[u8]) -> usize {
        self.random.below(bytes.len() + 1)
    }

    /// A piece of `bytes`, mostly short.
    fn piece(&mut self, bytes: &[u8]) -> std::ops::Range<usize> {
        let start = self.place(bytes);
        let most = if self.random.below(4) == 0 { bytes.len() } else { 16 };
        start..(start + self.random.below(most + 1)).min(bytes.len())
    }

    fn damage(&mut self, bytes: &mut Vec<u8>) {
        match self.random.below(9) {
            0 if !bytes.is_empty() => {
                let at = self.random.below(bytes.len());
                bytes[at] ^= 1 << self.random.below(8);
            }
            1 if !bytes.is_empty() => {
                let at = self.random.below(bytes.len());
                bytes[at] = self.random.next() as u8;
            }
            2 => {
                let piece = self.piece(bytes);
                bytes.drain(piece);
            }
            3 => {
                let copy = bytes[self.piece(bytes)].to_vec();
                let at = self.place(bytes);
                bytes.splice(at..at, copy);
            }
            4 => {
                let other = self.seed();
                let part = other[self.piece(other)].to_vec();
                let gap = self.piece(bytes);
                bytes.splice(gap, part);
            }
            5 => {
                let number = NUMBERS[self.random.below(NUMBERS.len())].to_le_bytes();
                let at = self.place(bytes);
                let end = (at + 4).min(bytes.len());
                bytes.splice(at..end, number);
            }
            6 => {
                let end = self.place(bytes);
                bytes.truncate(end);
            }
            _ => self.replace_word(bytes),
        }
    }

    /// Puts a strange word in the place of one, by preference of a number.
    fn replace_word(&mut self, bytes: &mut Vec<u8>) {
        let is_end = |byte: &u8| byte.is_ascii_whitespace() || b",/=[]".contains(byte);
        let mut start = 0;
        for _ in 0..8 {
            let from = self.place(bytes);
            start = bytes[from..].iter().position(is_end).map_or(bytes.len(), |n| from + n + 1).min(bytes.len());
            if bytes.get(start).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'-') {
                break;
            }
        }
        let end = bytes[start..].iter().position(is_end).map_or(bytes.len(), |n| start + n);
        let word = WORDS[self.random.below(WORDS.len())];
        bytes.splice(start..end, word.bytes());
    }
}
