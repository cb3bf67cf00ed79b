//! The first pass held back where it stands alone.

use rayon::prelude::*;
use stack::Image;

/// How much brighter than all others, and than its other half, a half of the first candidate may be.
const LIMIT: f32 = 2.0;

/// Below this nothing is left to share.
const LEAST_REST: f32 = 1e-6;

/// Cuts the weight of the first candidate in proportion where one of its halves is more than twice as bright as the other,
/// and as all other candidates, which share what it loses. It alone was guided by noisy halves, and beside lamps, where their
/// variance is large, its fits run away; a small weight of that is still too much. Halves that agree may know of a highlight.
pub fn hold_back(weights: &mut [Vec<f32>], candidates: &[[Image; 2]]) {
    let ([first, others @ ..], [first_halves, other_halves @ ..]) = (weights, candidates) else { return };
    let factors = |pixel: usize| {
        let [a, b] = first_halves.each_ref().map(|half| half.mean_at(pixel));
        let others = other_halves.iter().flatten().map(|half| half.mean_at(pixel));
        let most = LIMIT * others.fold(a.min(b).max(0.0), f32::max);
        let (own, rest) = (a.max(b), 1.0 - first[pixel]);
        if own <= most || rest < LEAST_REST {
            return [1.0; 2];
        }
        let kept = most / own;
        [kept, (1.0 - first[pixel] * kept) / rest]
    };
    let factors: Vec<[f32; 2]> = (0..first.len()).into_par_iter().map(factors).collect();
    first.iter_mut().zip(&factors).for_each(|(weight, [own, _])| *weight *= own);
    others.par_iter_mut().for_each(|plane| {
        plane.iter_mut().zip(&factors).for_each(|(weight, [_, other])| *weight *= other);
    });
}

#[cfg(test)]
mod tests {
    use stack::Size;

    use super::*;
    use crate::best::test_scene::flat;

    const SIZE: Size = Size::new(2, 1);

    fn held(values: [[f32; 2]; 3], weights: [f32; 3]) -> Vec<f32> {
        let candidates = values.map(|halves| halves.map(|v| flat(SIZE, v)));
        let mut planes = weights.map(|weight| vec![weight; SIZE.pixels()]);
        hold_back(&mut planes, &candidates);
        assert!(planes.iter().all(|plane| plane[0] == plane[1]));
        planes.map(|plane| plane[0]).to_vec()
    }

    #[test]
    fn a_first_pass_that_runs_away_counts_no_more_than_twice_the_others() {
        let found = held([[6.0, 0.3], [0.5, 0.4], [0.1, 0.2]], [0.3, 0.6, 0.1]);
        let kept = 0.3 * 2.0 * 0.5 / 6.0;
        let expected = [kept, 0.6 * (1.0 - kept) / 0.7, 0.1 * (1.0 - kept) / 0.7];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        assert!((found.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn one_among_the_others_or_alone_keeps_its_weight() {
        let weights = [0.3, 0.6, 0.1];
        assert_eq!(held([[1.0, 0.2], [0.5, 0.4], [0.1, 0.2]], weights), weights);
        assert_eq!(held([[6.0, 4.0], [0.5, 0.4], [0.1, 0.2]], weights), weights);
        assert_eq!(held([[0.0, -0.2], [-0.5, 0.0], [0.0, 0.0]], weights), weights);
        assert_eq!(held([[9.0, 9.0], [0.5, 0.4], [0.1, 0.2]], [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
    }
}
