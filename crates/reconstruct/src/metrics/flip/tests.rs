//! Against the authors' own program: `evaluate` of the Python package flip-evaluator 1.7 (its C++ code, in single
//! precision), on the arrays made here from whole numbers; with `inputsRGB=False`, clipped to 0 … 1 for "LDR", as they
//! are for "HDR", everything else by default. Means are those of its error maps.

use super::*;

const SIZE: Size = Size::new(64, 48);

/// Ramps with a disc and a chequer, darker or lighter; with a pattern of errors.
fn shapes(scale: f32, wrong: bool) -> Image {
    let value = |i: usize, c: usize| {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        let ramp = (x * (c + 1) + y * (3 - c)) as f32 / 448.0;
        let squared = (x as i32 - 32).pow(2) + (y as i32 - 16).pow(2);
        let disc = if squared < 144 { 6.0 } else { 0.25 };
        let chequer = if (x / 5 + y / 7).is_multiple_of(2) { 1.0 } else { 0.5 };
        let error = if wrong && (x * 3 + y * 5 + c * 11) % 32 < 16 { 1.25 } else { 1.0 };
        ramp * disc * chequer * error * scale
    };
    let channels = (0..3).map(|c| (0..SIZE.pixels()).map(|i| value(i, c)).collect()).collect();
    Image::from_channels(SIZE, channels)
}

fn everywhere() -> Vec<usize> {
    (0..SIZE.pixels()).collect()
}

/// As near as single precision lets them be.
fn assert_near(found: Option<f64>, expected: f64) {
    assert!((found.unwrap() / expected - 1.0).abs() < 1e-4, "{found:?} {expected}");
}

#[test]
fn agrees_with_the_authors_program() {
    let (right, wrong, all) = (shapes(1.0, false), shapes(1.0, true), everywhere());
    assert_near(flip(&wrong, &right, &all), 0.115_945_132_4);
    assert_near(flip_hdr(&wrong, &right, &all), 0.183_684_472_8);
    assert_near(flip(&right, &wrong, &all), 0.115_945_132_4);
    assert_near(flip_hdr(&right, &wrong, &all), 0.185_314_372_7);
    let (right, wrong) = (shapes(0.01, false), shapes(0.01, true));
    assert_near(flip(&wrong, &right, &all), 0.015_579_828_0);
    assert_near(flip_hdr(&wrong, &right, &all), 0.183_684_463_8);
}

#[test]
fn single_pixels_agree_with_the_authors_program() {
    let errors = error_map(&shapes(1.0, true), &shapes(1.0, false), &everywhere(), |v| v.clamp(0.0, 1.0) as f32);
    let expected = [(0, 0, 0.010_245_85), (30, 20, 0.147_806_23), (63, 47, 0.136_374_38), (5, 10, 0.081_408_47)];
    for (x, y, expected) in expected {
        assert_near(Some(f64::from(errors[SIZE.index(x, y)])), expected);
    }
}

#[test]
fn green_and_blue_are_as_different_as_can_be() {
    let of = |rgb: [f32; 3]| Image::from_channels(Size::new(16, 16), rgb.map(|v| vec![v; 256]).to_vec());
    let (green, blue) = (of([0.0, 1.0, 0.0]), of([0.0, 0.0, 1.0]));
    let all: Vec<usize> = (0..256).collect();
    assert_near(flip(&blue, &green, &all), 1.0);
    assert_near(flip_hdr(&blue, &green, &all), 0.996_167_421);
    assert_eq!((flip(&green, &green, &all), flip_hdr(&green, &green, &all)), (Some(0.0), Some(0.0)));
    assert_eq!(flip_hdr(&green, &of([0.0; 3]), &all), None, "nothing to expose");
    assert_eq!((flip(&blue, &green, &[]), flip_hdr(&blue, &green, &[])), (None, None));
}

#[test]
fn pixels_that_are_not_judged_do_not_spoil_their_neighbours() {
    let reference = shapes(1.0, false);
    let mut image = reference.clone();
    let spoilt = SIZE.index(5, 10);
    image.channels_mut()[1][spoilt] = 1e6;
    let all = everywhere();
    let others: Vec<usize> = all.iter().copied().filter(|pixel| *pixel != spoilt).collect();
    assert_eq!((flip(&image, &reference, &others), flip_hdr(&image, &reference, &others)), (Some(0.0), Some(0.0)));
    assert!(flip(&image, &reference, &all) > Some(0.0) && flip_hdr(&image, &reference, &all) > Some(0.0));
}

#[test]
fn what_is_no_number_counts_as_black() {
    let reference = shapes(1.0, false);
    let (mut broken, mut black) = (reference.clone(), reference.clone());
    for (c, bad) in [f32::NAN, f32::INFINITY, -1.0].into_iter().enumerate() {
        (broken.channels_mut()[c][777], black.channels_mut()[c][777]) = (bad, 0.0);
    }
    let all = everywhere();
    assert_eq!(flip(&broken, &reference, &all), flip(&black, &reference, &all));
    assert_eq!(flip_hdr(&broken, &reference, &all), flip_hdr(&black, &reference, &all));
}
