//! Distances of whole windows against eq. 11, pair by pair.

use stack::Size;

use super::*;
use crate::patch_distance::tests::{distance_twin, random_planes};
use crate::patch_distance::{NoisyPlanes, PatchComparison};

const SIZE: Size = Size::new(17, 12);

fn pixels_of(tile: Rectangle, step: usize) -> Vec<[usize; 2]> {
    (tile.y0..tile.y1).step_by(step).flat_map(|y| (tile.x0..tile.x1).step_by(step).map(move |x| [x, y])).collect()
}

/// Checks all windows of `fits` and all pictures that are compared together: inside the image against the formula, outside
/// that they are far.
fn check<const PICTURES: usize>(guides: &Guides, tile: Rectangle, fits: &[[usize; 2]], pictures: [usize; PICTURES]) {
    let distances = WindowDistances::new(guides, tile);
    for fit in fits {
        let mut out = [(); PICTURES].map(|()| vec![[0.0; LANES]; guides.side() * guides.groups()]);
        distances.compute(pulp::Scalar, *fit, pictures, out.each_mut().map(Vec::as_mut_slice));
        for (picture, out) in pictures.into_iter().zip(&out) {
            let planes = NoisyPlanes { size: SIZE, values: guides.values[picture], variances: guides.variances };
            let c = fit.map(|v| v as isize);
            let rows = out.chunks_exact(guides.groups()).map(|row| &row.as_flattened()[..guides.side()]);
            for (distance, offset) in rows.flatten().zip(offsets(guides.radius)) {
                let q = [c[0] + offset[0], c[1] + offset[1]];
                let inside = (0..SIZE.width as isize).contains(&q[0]) && (0..SIZE.height as isize).contains(&q[1]);
                let expected = if inside { distance_twin(planes, c, q, guides.comparison) } else { f64::from(FAR) };
                let difference = (f64::from(*distance) - expected).abs();
                assert!(difference < 2e-5 * (1.0 + expected), "{c:?} {offset:?}: {distance} {expected}");
            }
        }
    }
}

fn guides<'a>(
    values: &'a [&'a [Vec<f32>]],
    variances: &'a [Vec<f32>],
    radius: usize,
    patch_radius: usize,
    noise_taken_off: f32,
) -> Guides<'a> {
    Guides {
        size: SIZE,
        values,
        variances,
        comparison: PatchComparison { patch_radius, epsilon: 1e-4, noise_taken_off },
        radius,
    }
}

#[test]
fn agree_with_the_formula_up_to_the_borders() {
    let whole = Rectangle { x0: 0, y0: 0, x1: 17, y1: 12 };
    let corner = Rectangle { x0: 12, y0: 8, x1: 17, y1: 12 };
    for (channels, patch_radius, radius, noise_taken_off) in
        [(3, 1, 3, 1.0), (3, 2, 4, 0.0), (1, 3, 2, 1.0), (2, 0, 5, 0.0)]
    {
        let [values, variances] = random_planes(SIZE, channels, 40 + channels as u64);
        let [others, _] = random_planes(SIZE, channels, 50);
        let values = [&values[..], &others[..]];
        let guides = guides(&values, &variances, radius, patch_radius, noise_taken_off);
        for (tile, step) in [(whole, 1), (whole, 3), (corner, 1), (corner, 2)] {
            check(&guides, tile, &pixels_of(tile, step), [0, 1]);
            check(&guides, tile, &pixels_of(tile, step), [1]);
        }
    }
}

#[test]
fn windows_wider_than_the_image_reach_all_of_it() {
    let [values, variances] = random_planes(SIZE, 1, 45);
    let values = [&values[..]];
    let guides = guides(&values, &variances, 19, 1, 1.0);
    check(&guides, Rectangle { x0: 0, y0: 0, x1: 17, y1: 12 }, &[[0, 0], [8, 5], [16, 11]], [0]);
}

#[test]
fn windows_lie_row_by_row_around_their_centre() {
    let all: Vec<[isize; 2]> = offsets(1).collect();
    assert_eq!(all, [[-1, -1], [0, -1], [1, -1], [-1, 0], [0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]]);
}
