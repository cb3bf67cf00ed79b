//! Brightness as a feature, where features do not tell what light does.

use stack::Image;

use super::features::CleanFeatures;

/// `features`, where none of them tells surfaces apart, and the logarithm of `picture`, `weight` times, as another:
/// kernels then stay on pixels of like colour.
pub fn with_colour(features: &CleanFeatures, picture: &Image, weight: f32) -> Option<CleanFeatures> {
    if weight == 0.0 || !features.flat {
        return None;
    }
    let mut extended = features.clone();
    let first = extended.set.planes.len();
    let planes = picture.channels().iter().map(|plane| plane.iter().map(|v| weight * logarithm(*v)).collect());
    extended.set.planes.extend(planes);
    extended.set.groups.push(first..first + 3);
    extended.separating.extend(first..first + 3);
    Some(extended)
}

/// `features` for indirect light: the logarithm of the `direct` light, `weight` times, in place of visibility. Light that
/// was rebuilt tells shadows without their noise, and kernels stay on one side of them. `None` where it has no weight.
pub fn with_direct_light(features: &CleanFeatures, direct: &Image, weight: f32) -> Option<CleanFeatures> {
    if weight == 0.0 {
        return None;
    }
    let mut extended = features.clone();
    let plane = (0..direct.pixels()).map(|pixel| weight * logarithm(direct.mean_at(pixel))).collect();
    let planes = &mut extended.set.planes;
    let place = (0..planes.len()).find(|plane| !extended.separating.contains(plane)).unwrap_or(planes.len());
    if place < planes.len() {
        planes[place] = plane;
    } else {
        planes.push(plane);
        extended.set.groups.push(place..place + 1);
    }
    extended.separating.push(place);
    Some(extended)
}

/// Finite in the dark, where noise would rule it.
pub(super) fn logarithm(light: f32) -> f32 {
    (light + 0.02).max(0.01).ln()
}

#[cfg(test)]
mod tests {
    use stack::Size;

    use super::super::test_scene::{image, two_halves};
    use super::*;

    const SIZE: Size = Size::new(8, 6);

    #[test]
    fn direct_light_stands_in_for_visibility_and_tells_surfaces_apart() {
        let direct = image(SIZE, |x, _, _| if x < 3 { 0.0 } else { 0.98 });
        let mut features = two_halves(SIZE);
        let before = features.set.planes.len();
        assert_eq!(with_direct_light(&features, &direct, 0.0), None);
        let added = with_direct_light(&features, &direct, 0.5).unwrap();
        assert_eq!((added.set.planes.len(), added.set.groups.len()), (before + 1, features.set.groups.len() + 1));
        let shadow = 0.5 * (1.0_f32 / 0.02).ln();
        let edge = |features: &CleanFeatures| {
            let plane = &features.set.planes[*features.separating.last().unwrap()];
            plane[SIZE.index(3, 2)] - plane[SIZE.index(2, 2)]
        };
        assert!((edge(&added) - shadow).abs() < 1e-5);
        // The last plane now is a visibility: it tells no surfaces apart.
        features.set.planes.push(vec![0.25; SIZE.pixels()]);
        features.set.groups.push(before..before + 1);
        let replaced = with_direct_light(&features, &direct, 0.5).unwrap();
        assert_eq!(replaced.set.planes.len(), before + 1);
        assert_eq!(replaced.set.groups, features.set.groups);
        assert_eq!(edge(&replaced), edge(&added));
    }
}
