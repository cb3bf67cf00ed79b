//! How much of a file is unzipped or zipped at a time.
//!
//! Blocks differ in size by a factor of a thousand: 16 lines of 150 channels are 12 MB, a line of one channel is a few
//! kilobytes. So their bytes are bounded and not their number, that memory does not depend on how many threads there are.

/// Bytes of pixels in the blocks that are unzipped together, or zipped while as many are written. What is zipped, and what
/// a thread needs for a block, comes on top; for each thread keeps what it has freed for itself, as many threads work as
/// there are blocks.
const BYTES: usize = 64 << 20;

/// Blocks of no more than `each` bytes that are worked on together: at least one.
pub fn blocks_at_once(each: usize) -> usize {
    (BYTES / each.max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_blocks_are_few_and_small_ones_many() {
        assert_eq!([0, 1 << 20, 12 << 20, usize::MAX].map(blocks_at_once), [BYTES, 64, 5, 1]);
    }
}
