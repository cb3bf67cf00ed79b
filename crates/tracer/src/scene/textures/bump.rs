//! Bump maps, turned into normal maps.
//!
//! MTL does not say how high a bump is. Here a height of 1 is as high as a texel is wide, times `-bm`: the convention of the
//! tools that turn height maps into normal maps, which needs to know nothing of the scene's units.

use glam::Vec3;

/// Normal map of `heights` (0 … 1, row-major, top row first), `strength` times as high as texels are wide. The image
/// repeats.
pub(super) fn normals_of_heights([width, height]: [usize; 2], heights: &[f32], strength: f32) -> Vec<[f32; 3]> {
    let at = |x: usize, y: usize| heights[y % height * width + x % width];
    let normal = |i: usize| {
        let (x, y) = (i % width, i / width);
        let along_u = 0.5 * (at(x + 1, y) - at(x + width - 1, y));
        // Rows run against v.
        let along_v = 0.5 * (at(x, y + height - 1) - at(x, y + 1));
        let normal = Vec3::new(-strength * along_u, -strength * along_v, 1.0).normalize();
        (0.5 * (normal + Vec3::ONE)).to_array()
    };
    (0..width * height).map(normal).collect()
}

/// Makes the slopes of a normal map `strength` times as steep.
pub(super) fn steeper(normals: &mut [[f32; 3]], strength: f32) {
    if strength == 1.0 {
        return;
    }
    for texel in normals {
        let normal = 2.0 * Vec3::from_array(*texel) - Vec3::ONE;
        let steeper = (normal * Vec3::new(strength, strength, 1.0)).normalize_or(Vec3::Z);
        *texel = (0.5 * (steeper + Vec3::ONE)).to_array();
    }
}

/// Whether an image given as a bump map is a normal map, as some exporters have it: bluish, and level on the whole.
pub(super) fn is_normal_map(pixels: &[[f32; 3]]) -> bool {
    let sum: glam::DVec3 = pixels.iter().map(|p| Vec3::from_array(*p).as_dvec3()).sum();
    let mean = sum / pixels.len() as f64;
    (mean.x - 0.5).abs() < 0.1 && (mean.y - 0.5).abs() < 0.1 && mean.z > 0.7
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_become_normals_that_lean_away_from_the_rise() {
        // Rises by 0.1 a texel along u in the middle row, and towards the top between rows.
        let heights = [0.5, 0.5, 0.5, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0];
        let normals = normals_of_heights([3, 3], &heights, 2.0);
        let middle = 2.0 * Vec3::from_array(normals[4]) - Vec3::ONE;
        // dh/du = 0.1, dh/dv = (0.5 − 0)/2 = 0.25 texels, twice as high.
        let expected = Vec3::new(-0.2, -0.5, 1.0).normalize();
        assert!((middle - expected).length() < 1e-6, "{middle}");
    }

    #[test]
    fn slopes_are_scaled() {
        let mut normals = normals_of_heights([3, 3], &[0.5, 0.5, 0.5, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0], 1.0);
        let twice = normals_of_heights([3, 3], &[0.5, 0.5, 0.5, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0], 2.0);
        steeper(&mut normals, 2.0);
        for (a, b) in normals.iter().flatten().zip(twice.iter().flatten()) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn normal_maps_are_told_from_heights() {
        assert!(is_normal_map(&[[0.5, 0.5, 1.0], [0.6, 0.4, 0.9]]));
        assert!(!is_normal_map(&[[0.5, 0.5, 0.5], [1.0, 1.0, 1.0]]));
        assert!(is_normal_map(&normals_of_heights([2, 2], &[0.0, 1.0, 0.5, 0.25], 0.5)));
    }
}
