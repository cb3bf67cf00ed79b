//! Where things are, when a stack does not say it in three coordinates.

use stack::{FeatureRole, FeatureStack, Image, Size};

/// Depths from here on mean that nothing was hit: some renderers write 10¹⁰ or more there.
const NOWHERE: f32 = 1e9;

/// Positions before a camera of which nothing but `depth` is known: ((x − w/2) z/f, (y − h/2) z/f, z) with a focal length f
/// of the longer side, an angle of 53°. Linear fits do not care about f, and hardly about whether depth is along the ray
/// or along the axis. What was not hit (depth infinite, huge, zero or less) lies as far as the farthest hit.
pub fn position_from_depth(depth: &Image) -> Image {
    let size = depth.size();
    let hit = |z: &f32| *z > 0.0 && *z < NOWHERE;
    let depths = &depth.channels()[0];
    let farthest = depths.iter().copied().filter(hit).fold(0.0, f32::max);
    let depths: Vec<f32> = depths.iter().map(|z| if hit(z) || z.is_nan() { *z } else { farthest }).collect();
    let screen = position_on_screen(size);
    let along = |c: usize| screen.channels()[c].iter().zip(&depths).map(|(place, z)| (place - 0.5) * z).collect();
    Image::from_channels(size, vec![along(0), along(1), depths.clone()])
}

/// Column and row of every pixel's centre over the longer side, and zero.
pub fn position_on_screen(size: Size) -> Image {
    let longest = size.width.max(size.height) as f32;
    let plane = |along: &dyn Fn(usize) -> usize| {
        (0..size.pixels()).map(|pixel| (along(pixel) as f32 + 0.5) / longest).collect()
    };
    let planes = vec![plane(&|p| p % size.width), plane(&|p| p / size.width), vec![0.0; size.pixels()]];
    Image::from_channels(size, planes)
}

/// Whether the positions of `stack` are more than places on the screen.
pub fn has_depth(stack: &FeatureStack) -> bool {
    let position = stack.feature(FeatureRole::Position).and_then(|position| position.estimate.mean.channels().get(2));
    position.is_some_and(|z| z.iter().any(|v| *v != z[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slanted_plane_stays_a_plane() {
        // z = 2 + x' + 0.5 y' in camera space, x' = (x − ½) z on the screen: z = 2/(1 − (x − ½) − 0.5 (y − ½)).
        let size = Size::new(8, 8);
        let screen = position_on_screen(size);
        let depth = |i: usize| {
            let place = screen.channels()[0][i] - 0.5 + 0.5 * (screen.channels()[1][i] - 0.5);
            2.0 / (1.0 - place)
        };
        let depth = Image::from_channels(size, vec![(0..64).map(depth).collect()]);
        let position = position_from_depth(&depth);
        for i in 0..64 {
            let [x, y, z] = position.rgb(i);
            assert!((2.0 + x + 0.5 * y - z).abs() < 1e-5, "{i}");
        }
    }

    #[test]
    fn misses_are_far_and_unknown_depths_stay_unknown() {
        let depth = Image::from_channels(Size::new(5, 1), vec![vec![3.0, f32::INFINITY, 0.0, 1e10, f32::NAN]]);
        let z = position_from_depth(&depth).channels()[2].clone();
        assert_eq!(z[..4], [3.0; 4]);
        assert!(z[4].is_nan());
    }
}
