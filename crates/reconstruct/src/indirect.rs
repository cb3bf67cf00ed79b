//! Direct and indirect light apart. Shadows end where indirect light goes on, and its noise is of another kind: each
//! part is rebuilt better by itself than both together, where direct light has little noise.

use stack::{Component, Estimate, Image, Noise, SampleCounts};

use crate::best::halves::luminance;
use crate::box_filter::box_mean;

/// Whether `indirect` can be taken off `whole`: both come in as many buckets.
pub fn is_part_of(indirect: &Estimate, whole: &Estimate) -> bool {
    match (&indirect.noise, &whole.noise) {
        (Noise::Buckets(indirect), Noise::Buckets(whole)) => indirect.len() == whole.len(),
        _ => false,
    }
}

/// Direct light, which is the `whole` without its `indirect` light, and that.
pub fn parts(whole: Component, indirect: Estimate) -> [Component; 2] {
    let of = |radiance| Component { role: whole.role, radiance };
    [of(without(whole.radiance, &indirect)), of(indirect)]
}

fn without(mut whole: Estimate, indirect: &Estimate) -> Estimate {
    take_off(&mut whole.mean, &indirect.mean);
    if let (Noise::Buckets(buckets), Noise::Buckets(indirect)) = (&mut whole.noise, &indirect.noise) {
        buckets.iter_mut().zip(indirect).for_each(|(bucket, indirect)| take_off(bucket, indirect));
    }
    whole
}

/// The share of the noise of `whole` that is not that of its `indirect` light: variances of the mean over RGB, each
/// relative to the squared luminance L² + 0.001 of 5×5 pixels, averaged over the picture. Zero where there is no noise.
pub fn direct_share_of_noise(indirect: &Estimate, whole: &Estimate, counts: &SampleCounts) -> f32 {
    let [indirect, whole] = [indirect, whole].map(grey);
    let size = whole.mean.size();
    let around = box_mean(&whole.mean.channels()[0], size, 2);
    let relative_noise = |light: &Estimate| {
        let variance = light.variance_of_mean(counts).unwrap_or_else(|| Image::zeros(size, 1));
        let relative = variance.channels()[0].iter().zip(&around).map(|(v, l)| f64::from(v / (l * l + 1e-3)));
        relative.filter(|v| !v.is_nan()).sum::<f64>()
    };
    let of_indirect = relative_noise(&indirect);
    let of_direct = relative_noise(&without(whole, &indirect));
    if of_direct > 0.0 { (of_direct / (of_direct + of_indirect)) as f32 } else { 0.0 }
}

/// Means over RGB.
fn grey(light: &Estimate) -> Estimate {
    let grey = |image: &Image| Image::from_channels(image.size(), vec![luminance(image)]);
    let noise = match &light.noise {
        Noise::Buckets(buckets) => Noise::Buckets(buckets.iter().map(grey).collect()),
        _ => Noise::Unknown,
    };
    Estimate { mean: grey(&light.mean), noise }
}

/// Takes a part off an image; rounding leaves nothing below zero.
pub fn take_off(whole: &mut Image, part: &Image) {
    for (whole, part) in whole.channels_mut().iter_mut().zip(part.channels()) {
        whole.iter_mut().zip(part).for_each(|(whole, part)| *whole = (*whole - part).max(0.0));
    }
}

#[cfg(test)]
mod tests {
    use stack::{FeatureStack, Silent, Size};

    use super::*;
    use crate::best::LightSettings;
    use crate::best::test_scene::{component, error, image, stack_of, with_noise};
    use crate::test_noise::TestNoise;
    use crate::{Settings, reconstruct};

    const SIZE: Size = Size::new(32, 24);

    /// A stack of a picture in two parts, whose brightness changes in the given columns, and the stacks of both.
    fn stacks([of_direct, of_indirect]: [usize; 2]) -> [FeatureStack; 3] {
        let (mut noise, edge) = (TestNoise(17), |x: usize, at: usize| if x < at { 1.0 } else { 0.5 });
        let mut buckets = |at: usize, deviation: f32| {
            [(); 8].map(|()| with_noise(&image(SIZE, |x, _, _| edge(x, at)), deviation, &mut noise)).to_vec()
        };
        let (direct, indirect) = (buckets(of_direct, 0.1), buckets(of_indirect, 0.4));
        let mut both = direct.clone();
        both.iter_mut().zip(&indirect).for_each(|(both, indirect)| both.add(indirect));
        let whole = stack_of(&image(SIZE, |_, _, _| 1.0), 3);
        let of = |buckets| FeatureStack { components: vec![component(buckets, &whole.samples)], ..whole.clone() };
        let [mut both, direct, indirect] = [of(both), of(direct), of(indirect)];
        both.indirect = Some(indirect.components[0].radiance.clone());
        [both, direct, indirect]
    }

    fn picture(stack: &FeatureStack, light: LightSettings) -> Image {
        let mut settings = Settings::default();
        settings.best.light = light;
        reconstruct(stack, &settings, &Silent).unwrap().picture
    }

    /// Indirect light that knows nothing of direct light, which is rebuilt with all fits; both as bright as they are.
    fn alone() -> LightSettings {
        let unguided = LightSettings { direct_guide: 0.0, direct_spread: 0.0, ..LightSettings::DEFAULT };
        LightSettings { direct_fast: 0.0, darkest: 0.0, brightest: 1e30, ..unguided }
    }

    #[test]
    fn both_parts_are_rebuilt_as_if_alone() {
        let [both, direct, indirect] = stacks([10, 20]);
        let mut sum = picture(&direct, alone());
        sum.add(&picture(&indirect, alone()));
        let found = picture(&both, alone());
        for (a, b) in found.channels().iter().flatten().zip(sum.channels().iter().flatten()) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        let whole = picture(&both, LightSettings { apart: false, ..alone() });
        assert!(whole != found);
        // Deviations of 0.1 and 0.4, so a share of 1/17.
        assert_eq!(picture(&both, LightSettings { direct_noise: 0.04, ..alone() }), whole);
        assert_eq!(picture(&both, LightSettings { direct_noise: 0.08, ..alone() }), found);
    }

    #[test]
    fn noise_is_shared_as_variances_are() {
        let [both, ..] = stacks([10, 20]);
        let share = |indirect: &Estimate| direct_share_of_noise(indirect, &both.components[0].radiance, &both.samples);
        let found = share(both.indirect.as_ref().unwrap());
        assert!((found * 17.0 - 1.0).abs() < 0.2, "{found}");
        let mut dark = both.indirect.clone().unwrap();
        let Noise::Buckets(buckets) = &mut dark.noise else { unreachable!() };
        buckets.iter_mut().chain([&mut dark.mean]).for_each(|image| *image = Image::zeros(SIZE, 3));
        assert_eq!(share(&dark), 1.0);
        assert_eq!(share(&both.components[0].radiance), 0.0);
    }

    #[test]
    fn direct_light_may_be_rebuilt_fast_by_itself() {
        let [both, direct, indirect] = stacks([10, 20]);
        let fast = LightSettings { direct_fast: 1.0, ..alone() };
        let mut hastened = Settings::default();
        hastened.best = hastened.best.for_direct_light(0.0);
        let mut sum = reconstruct(&direct, &hastened, &Silent).unwrap().picture;
        sum.add(&picture(&indirect, fast));
        let found = picture(&both, fast);
        for (a, b) in found.channels().iter().flatten().zip(sum.channels().iter().flatten()) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
    }

    #[test]
    fn the_network_is_not_asked_about_few_candidates() {
        let [both, ..] = stacks([10, 20]);
        let mut settings = Settings::default();
        settings.best.regression.few = true;
        let refused = reconstruct(&both, &settings, &Silent).unwrap_err();
        assert!(refused.to_string().contains("--fit-few"), "{refused}");
    }

    #[test]
    fn where_direct_light_ends_indirect_light_may_end() {
        let clean = image(SIZE, |x, _, _| if x < 10 { 2.0 } else { 1.0 });
        let [both, ..] = stacks([10, 10]);
        let [guided, unguided] = [LightSettings::DEFAULT.direct_guide, 0.0].map(|direct_guide| {
            error(&picture(&both, LightSettings { direct_guide, ..LightSettings::DEFAULT }), &clean)
        });
        assert!(guided < 0.8 * unguided, "{guided} {unguided}");
    }

    #[test]
    fn fireflies_of_indirect_light_belong_rather_to_pixels_that_direct_light_reaches() {
        let [mut both, direct, mut indirect] = stacks([16, 16]);
        let mut noise = TestNoise(18);
        let lit = |x: usize| x < 16;
        let buckets = [(); 8].map(|()| {
            let mut light = |x: usize| if lit(x) && noise.uniform() < 0.02 { 60.0 } else { 0.2 };
            let plane: Vec<f32> = (0..SIZE.pixels()).map(|pixel| light(pixel % SIZE.width)).collect();
            Image::from_channels(SIZE, vec![plane; 3])
        });
        indirect.components = vec![component(buckets.to_vec(), &indirect.samples)];
        both.indirect = Some(indirect.components[0].radiance.clone());
        let Noise::Buckets(of_direct) = &direct.components[0].radiance.noise else { unreachable!() };
        let mut sums = of_direct.clone();
        sums.iter_mut().zip(&buckets).for_each(|(sum, bucket)| sum.add(bucket));
        both.components = vec![component(sums, &both.samples)];
        let in_the_dark = |direct_spread: f32| {
            let picture = picture(&both, LightSettings { direct_spread, ..alone() });
            let dark = (0..SIZE.pixels()).filter(|pixel| !lit(pixel % SIZE.width));
            dark.map(|pixel| picture.rgb(pixel)[1] - 0.7).sum::<f32>()
        };
        let [with_direct, without] = [1.0, 0.0].map(in_the_dark);
        assert!(with_direct < 0.8 * without, "{with_direct} {without}");
    }

    #[test]
    fn what_is_not_in_as_many_buckets_is_no_part() {
        let [both, ..] = stacks([10, 20]);
        let mut halves = both.indirect.clone().unwrap();
        halves.noise = Noise::Buckets(halves.halves(&both.samples).unwrap().to_vec());
        assert!(is_part_of(&both.indirect.unwrap(), &both.components[0].radiance));
        assert!(!is_part_of(&halves, &both.components[0].radiance));
    }
}
