//! Colour spaces of FLIP, all from linear sRGB by way of CIE XYZ relative to the white of D65.

/// From linear sRGB to XYZ; each row is divided by its sum below, so that white is (1, 1, 1).
const TO_XYZ: [[f32; 3]; 3] = [
    [0.412_386_57, 0.357_591_5, 0.180_450_48],
    [0.212_636_82, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_17, 0.950_372_6],
];

/// Its inverse.
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_9],
    [-0.969_224_3, 1.875_93, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

/// XYZ of white, the sums of the rows of [`TO_XYZ`].
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

fn transform(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ over white's, of linear sRGB.
fn relative_xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = transform(&TO_XYZ, rgb);
    [xyz[0] / WHITE[0], xyz[1] / WHITE[1], xyz[2] / WHITE[2]]
}

/// Luminance and the red-green and blue-yellow opponents of linear sRGB: Lab's without the cube root, in which the eye's
/// blur acts linearly. The luminance of white is 100.
pub fn to_ycxcz(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear sRGB of what [`to_ycxcz`] gives.
pub fn from_ycxcz([luminance, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = grey(luminance);
    transform(&FROM_XYZ, [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]])
}

/// The luminance of [`to_ycxcz`] on a scale from 0 to 1.
pub fn grey(luminance: f32) -> f32 {
    (luminance + 16.0) / 116.0
}

/// CIE L\*a\*b\* of linear sRGB, with a\* and b\* scaled by the lightness: differences in hue are harder to see in the dark
/// (the Hunt effect).
pub fn to_hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(rgb)
        .map(|t| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Distance of two such colours for large differences: the lightness's plus the Euclidean one of the hues (HyAB).
pub fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let (da, db) = (a[1] - b[1], a[2] - b[2]);
    (a[0] - b[0]).abs() + (da * da + db * db).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_and_both_ways_are_inverse() {
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(near(to_ycxcz([1.0; 3]), [100.0, 0.0, 0.0]) && near(to_hunt_lab([1.0; 3]), [100.0, 0.0, 0.0]));
        assert!(near(to_hunt_lab([0.0; 3]), [0.0; 3]));
        let colour = [0.2, 0.7, 0.04];
        assert!(near(from_ycxcz(to_ycxcz(colour)), colour));
    }

    #[test]
    fn lab_of_the_primaries_is_the_well_known_one() {
        // L*a*b* of sRGB's green and blue under D65: 87.73, −86.18, 83.18 and 32.30, 79.19, −107.86.
        let known = [([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]), ([0.0, 0.0, 1.0], [32.3, 79.19, -107.86])];
        for (rgb, [l, a, b]) in known {
            let found = to_hunt_lab(rgb);
            let expected: [f32; 3] = [l, 0.01 * l * a, 0.01 * l * b];
            assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.1), "{found:?} {expected:?}");
        }
    }
}
