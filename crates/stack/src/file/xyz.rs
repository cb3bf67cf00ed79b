//! Pictures of CIE XYZ.

use crate::Image;

/// From XYZ to linear Rec. 709 with its white of D65, a row for each colour (IEC 61966-2-1).
const TO_RGB: [[f32; 3]; 3] =
    [[3.240_479, -1.537_15, -0.498_535], [-0.969_256, 1.875_991, 0.041_556], [0.055_648, -0.204_043, 1.057_311]];

/// A picture of X, Y and Z as one of red, green and blue.
pub fn rgb_of_xyz(picture: &Image) -> Image {
    let [x, y, z] = [0, 1, 2].map(|c| &picture.channels()[c]);
    let plane = |row: [f32; 3]| (0..x.len()).map(|i| row[0] * x[i] + row[1] * y[i] + row[2] * z[i]).collect();
    Image::from_channels(picture.size(), TO_RGB.map(plane).into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Size;

    #[test]
    fn white_is_white_and_red_is_red() {
        // The white of D65, and Rec. 709's red.
        let planes = [[0.950_456, 0.412_453], [1.0, 0.212_671], [1.089_058, 0.019_334]];
        let picture = Image::from_channels(Size::new(2, 1), planes.map(Vec::from).into());
        let rgb = rgb_of_xyz(&picture);
        for (plane, expected) in rgb.channels().iter().zip([[1.0, 1.0], [1.0, 0.0], [1.0, 0.0]]) {
            assert!(plane.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-3), "{plane:?}");
        }
    }
}
