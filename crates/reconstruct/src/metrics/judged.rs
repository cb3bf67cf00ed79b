//! Which pixels of a picture are judged, and what their values count as.

use stack::Image;

/// Indices of the pixels that `mask` does not leave out (`true` keeps) and where all `references` are finite.
pub fn judged_pixels(references: &[&Image], mask: Option<&[bool]>) -> Vec<usize> {
    let pixels = references.first().map_or(0, |reference| reference.pixels());
    let finite = |pixel: usize| references.iter().all(|r| r.channels().iter().all(|c| c[pixel].is_finite()));
    (0..pixels).filter(|pixel| mask.is_none_or(|mask| mask[*pixel]) && finite(*pixel)).collect()
}

/// The value of a channel at a pixel. One that is not finite counts as black, which is how it is displayed; how many
/// there are is a measure of its own.
pub fn value(channel: &[f32], pixel: usize) -> f64 {
    if channel[pixel].is_finite() { f64::from(channel[pixel]) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn masked_pixels_and_broken_references_are_not_judged() {
        let mut first = Image::zeros(Size::new(4, 1), 3);
        let mut second = first.clone();
        first.channels_mut()[1][0] = f32::NAN;
        second.channels_mut()[2][3] = f32::INFINITY;
        assert_eq!(judged_pixels(&[&first], None), [1, 2, 3]);
        assert_eq!(judged_pixels(&[&first, &second], None), [1, 2]);
        assert_eq!(judged_pixels(&[&first, &second], Some(&[true, true, false, true])), [1]);
        assert_eq!(value(&[f32::NAN, 2.0], 0), 0.0);
    }
}
