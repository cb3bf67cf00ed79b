//! The first two Sobol dimensions, scrambled and shuffled by one hash.

use sobol_burley::parts::owen_scramble_rev;

/// Odd, and far from any simple fraction of 2⁶⁴: multiples of it spread evenly (golden ratio).
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes all bits of `n`: the finaliser of SplitMix64 (Stafford's variant 13).
#[inline]
pub(super) const fn mix(n: u64) -> u64 {
    let n = (n ^ (n >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let n = (n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    n ^ (n >> 31)
}

/// The `number`-th of the random words that belong to `key` (a step of SplitMix64, taken at once).
#[inline]
pub(super) const fn combine(key: u64, number: u32) -> u64 {
    mix(key.wrapping_add((number as u64 + 1).wrapping_mul(GOLDEN)))
}

/// One random scrambling of the two-dimensional Sobol sequence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scramble {
    index: u32,
    x: u32,
    y: u32,
}

impl Scramble {
    /// The scrambling that the random word `hash` stands for.
    #[inline]
    pub(super) const fn new(hash: u64) -> Self {
        // Both halves of the word, and of a multiple that depends on all its bits.
        Self { index: hash as u32, x: (hash >> 32) as u32, y: (hash.wrapping_mul(GOLDEN) >> 32) as u32 }
    }

    /// Point number `point` (bits in reverse) of the one-dimensional sequence, in units of 2⁻³².
    #[inline]
    pub(super) fn point_1d(self, point: u32) -> u32 {
        let shuffled = owen_scramble_rev(point, self.index);
        owen_scramble_rev(sobol_x_rev(shuffled), self.x).reverse_bits()
    }

    /// Point number `point` (bits in reverse) of the two-dimensional sequence, in units of 2⁻³².
    #[inline]
    pub(super) fn point_2d(self, point: u32) -> [u32; 2] {
        let shuffled = owen_scramble_rev(point, self.index);
        let x = owen_scramble_rev(sobol_x_rev(shuffled), self.x).reverse_bits();
        let y = owen_scramble_rev(sobol_y_rev(shuffled), self.y).reverse_bits();
        [x, y]
    }
}

/// First Sobol coordinate, bits in reverse like its argument: van der Corput's sequence is the reversed index.
#[inline]
const fn sobol_x_rev(index_rev: u32) -> u32 {
    index_rev.reverse_bits()
}

/// Second Sobol coordinate, bits in reverse like its argument. Its generator matrix is Pascal's triangle modulo 2,
/// which is the five-fold tensor power of (1 1; 0 1): five butterfly steps instead of a table.
#[inline]
const fn sobol_y_rev(index_rev: u32) -> u32 {
    let n = index_rev.reverse_bits();
    let n = n ^ ((n & 0xaaaa_aaaa) >> 1);
    let n = n ^ ((n & 0xcccc_cccc) >> 2);
    let n = n ^ ((n & 0xf0f0_f0f0) >> 4);
    let n = n ^ ((n & 0xff00_ff00) >> 8);
    n ^ (n >> 16)
}

#[cfg(test)]
mod tests {
    use sobol_burley::parts::sobol_rev;

    use super::*;

    #[test]
    fn both_coordinates_agree_with_the_published_direction_numbers() {
        for index in 0..1_u32 << 16 {
            let reversed = index.reverse_bits();
            assert_eq!(sobol_x_rev(reversed), sobol_rev(reversed, 0));
            assert_eq!(sobol_y_rev(reversed), sobol_rev(reversed, 1), "{index}");
        }
    }

    /// Every elementary interval of area 2⁻ᵐ holds exactly one of 2ᵐ consecutive points: the net is a (0, m, 2)-net,
    /// aligned blocks further on included.
    #[test]
    fn scrambled_points_form_a_net() {
        const M: u32 = 8;
        for block in [0, 5, 1 << 12] {
            for key in 0..20 {
                let scramble = Scramble::new(mix(key));
                let points: Vec<[u32; 2]> =
                    (block << M..(block + 1) << M).map(|i: u32| scramble.point_2d(i.reverse_bits())).collect();
                for columns in 0..=M {
                    let cell = |[x, y]: [u32; 2]| {
                        let column = (u64::from(x) << columns) >> 32;
                        let row = (u64::from(y) << (M - columns)) >> 32;
                        (row << columns | column) as usize
                    };
                    let mut hits = vec![0; 1 << M];
                    points.iter().for_each(|p| hits[cell(*p)] += 1);
                    assert!(hits.iter().all(|n| *n == 1), "block {block} key {key} columns {columns}");
                }
            }
        }
    }
}
