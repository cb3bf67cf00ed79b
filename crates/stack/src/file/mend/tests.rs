//! Tests of the mending.

use super::*;
use crate::Size;

const SIZE: Size = Size::new(3, 3);

fn mended(role: Role, planes: Vec<Vec<f32>>) -> (Image, Vec<Mended>) {
    let mut image = Image::from_channels(SIZE, planes);
    let mut list = Vec::new();
    mend_role(role, &mut [&mut image], &mut list);
    (image, list)
}

#[test]
fn a_nan_becomes_the_median_of_its_neighbours_and_negatives_nothing() {
    let plane = vec![1.0, 2.0, 3.0, 4.0, f32::NAN, 5.0, 6.0, f32::INFINITY, -1.0];
    let (image, list) = mended(Role::Colour, vec![plane; 3]);
    assert_eq!(image.channels()[0][4], 3.0, "of -1 1 2 3 4 5 6");
    assert_eq!(image.channels()[0][7], 4.5, "of -1 4 5 6, without the one that was no number either");
    assert_eq!(image.channels()[0][8], 0.0);
    assert_eq!(list.iter().map(|m| m.count).collect::<Vec<_>>(), [6, 3]);
}

#[test]
fn a_picture_of_nothing_but_nan_is_black() {
    let (image, _) = mended(Role::Colour, vec![vec![f32::NAN; 9]; 3]);
    assert_eq!(image, Image::zeros(SIZE, 3));
}

#[test]
fn albedo_is_held_between_0_and_1() {
    let (image, list) =
        mended(Role::Feature(FeatureRole::Albedo), vec![vec![0.0, 0.5, 86.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]; 3]);
    assert_eq!(image.channels()[0][..3], [0.0, 0.5, 1.0]);
    assert_eq!(list, [Mended { what: "values of albedo above 1 (set to 1)".into(), count: 3 }]);
}

#[test]
fn what_is_infinitely_far_is_as_far_as_the_farthest() {
    let depth = vec![1.0, 2.0, 1e10, 7.5, f32::INFINITY, 3.0, 4.0, 5.0, f32::NAN];
    let (image, list) = mended(Role::Feature(FeatureRole::Depth), vec![depth]);
    assert_eq!([2, 4, 8].map(|i| image.channels()[0][i]), [7.5; 3]);
    assert_eq!(list[0].count, 3);
}

#[test]
fn unknown_variances_are_those_around() {
    let plane = vec![f32::NAN, 2.0, 4.0, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN];
    let mut image = Image::from_channels(SIZE, vec![plane]);
    assert!(mend_variance(Role::Colour, &mut image, &mut Vec::new()));
    let plane = &image.channels()[0];
    assert_eq!((plane[0], plane[4], plane[5], plane[6]), (2.0, 3.0, 3.0, 3.0));
    assert!(!mend_variance(Role::Colour, &mut Image::from_channels(SIZE, vec![vec![f32::NAN; 9]]), &mut Vec::new()));
}

/// A sphere around (0, 0, 5) in world space, seen from (1, 2, −3) by a camera that is turned.
#[test]
fn camera_space_is_known_by_its_normals_and_left() {
    let (s, c) = 0.5_f32.sin_cos();
    let rotation = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]];
    let eye = [1.0, 2.0, -3.0];
    let rotate = |v: [f32; 3]| rotation.map(|row: [f32; 3]| (0..3).map(|i| row[i] * v[i]).sum::<f32>());
    let translation = rotate(eye).map(|x| -x);
    let mut matrix = [0.0; 16];
    for row in 0..3 {
        (0..3).for_each(|column| matrix[4 * column + row] = rotation[row][column]);
        matrix[12 + row] = translation[row];
    }
    matrix[15] = 1.0;
    let size = Size::new(40, 40);
    let (mut position, mut normal) = (Image::zeros(size, 3), Image::zeros(size, 3));
    for pixel in 0..size.pixels() {
        let (a, b) = ((pixel % 40) as f32 * 0.157, (pixel / 40) as f32 * 0.078);
        let n = [a.cos() * b.sin(), b.cos(), a.sin() * b.sin()];
        let p = [n[0], n[1], n[2] + 5.0];
        let towards: f32 = (0..3).map(|c| n[c] * (p[c] - eye[c])).sum();
        if towards < 0.0 {
            for c in 0..3 {
                position.channels_mut()[c][pixel] = p[c];
                normal.channels_mut()[c][pixel] = n[c];
            }
        }
    }
    let (world_position, world_normal) = (position.clone(), normal.clone());
    let mut untouched = position.clone();
    assert!(!to_world_space(&matrix, &world_position, &world_normal, &mut [Oriented::Position(&mut untouched)]));
    for pixel in 0..size.pixels() {
        let (p, n) = (rotate(position.rgb(pixel)), rotate(normal.rgb(pixel)));
        for c in 0..3 {
            position.channels_mut()[c][pixel] = p[c] + translation[c];
            normal.channels_mut()[c][pixel] = n[c];
        }
    }
    let (camera_position, camera_normal) = (position.clone(), normal.clone());
    let mut both = [Oriented::Position(&mut position), Oriented::Normal(&mut normal)];
    assert!(to_world_space(&matrix, &camera_position, &camera_normal, &mut both));
    for pixel in (0..size.pixels()).filter(|pixel| world_normal.rgb(*pixel) != [0.0; 3]) {
        for c in 0..3 {
            assert!((position.channels()[c][pixel] - world_position.channels()[c][pixel]).abs() < 1e-4);
            assert!((normal.channels()[c][pixel] - world_normal.channels()[c][pixel]).abs() < 1e-5);
        }
    }
}

#[test]
fn light_whose_square_is_no_number_is_cut_and_counted() {
    let mut image = Image::from_channels(Size::new(3, 1), vec![vec![1.0, 2e25, 1e18]]);
    let mut list = Vec::new();
    mend_role(Role::Colour, &mut [&mut image], &mut list);
    assert_eq!(image.channels()[0], [1.0, 1e18, 1e18]);
    assert_eq!(list, [Mended { what: "values of colour above 1e18 (set to 1e18)".into(), count: 1 }]);
}
