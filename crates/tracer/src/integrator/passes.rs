//! How work is cut into passes.
//!
//! Partial means are rounded once per pass, so the same samples must always be cut in the same places: at multiples of
//! [`PASS`] of the sample *number*, whatever was asked for and whatever interrupted.

use std::ops::Range;

use stack::SampleMap;

/// Most samples a pixel gets in one pass.
const PASS: u32 = 8;

/// The passes that [`trace`](super::trace()) cuts `map` into, each as a map of its own: traced one after another they end in the
/// same bytes as `map` at once.
pub fn passes_of(map: &SampleMap) -> impl Iterator<Item = SampleMap> {
    (0..count(map)).map(|pass| {
        let ranges = (0..map.count.len()).map(|pixel| samples(map, pixel, pass));
        let (first, count) = ranges.map(|range| (range.start, range.end - range.start)).unzip();
        SampleMap { first, count }
    })
}

/// How many passes `map` takes.
pub(super) fn count(map: &SampleMap) -> u32 {
    let passes = |(first, count): (&u32, &u32)| if *count == 0 { 0 } else { (first % PASS + count).div_ceil(PASS) };
    map.first.iter().zip(&map.count).map(passes).max().unwrap_or(0)
}

/// Numbers of the samples that `pixel` gets in pass `pass` (from 0) of `map`.
pub(super) fn samples(map: &SampleMap, pixel: usize, pass: u32) -> Range<u32> {
    let (first, count) = (map.first[pixel], map.count[pixel]);
    let start = u64::from(first / PASS + pass) * u64::from(PASS);
    let clamp = |n: u64| n.clamp(u64::from(first), u64::from(first) + u64::from(count)) as u32;
    clamp(start)..clamp(start + u64::from(PASS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_cut_at_multiples_of_eight() {
        let map = SampleMap { first: vec![0, 5, 8, 30], count: vec![20, 2, 9, 0] };
        assert_eq!(count(&map), 3);
        let of = |pixel| (0..3).map(|pass| samples(&map, pixel, pass)).collect::<Vec<_>>();
        assert_eq!(of(0), [0..8, 8..16, 16..20]);
        assert_eq!(of(1), [5..7, 7..7, 7..7]);
        assert_eq!(of(2), [8..16, 16..17, 17..17]);
        assert!(of(3).iter().all(Range::is_empty));
    }

    #[test]
    fn passes_are_maps_of_their_own() {
        let map = SampleMap { first: vec![0, 5, 8], count: vec![10, 2, 0] };
        let passes: Vec<SampleMap> = passes_of(&map).collect();
        assert_eq!(passes.iter().map(|pass| pass.count.clone()).collect::<Vec<_>>(), [[8, 2, 0], [2, 0, 0]]);
        assert_eq!(passes[1].first[0], 8);
    }

    #[test]
    fn a_map_without_samples_takes_no_pass() {
        assert_eq!(count(&SampleMap::uniform(4, 3, 0)), 0);
        assert_eq!(count(&SampleMap::uniform(0, 0, 8)), 0);
    }
}
