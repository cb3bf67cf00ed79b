//! Direct and indirect light apart. Shadows end where indirect light goes on, and its noise is of another kind: each
//! part is rebuilt better by itself than both together, where direct light has little noise.

use std::borrow::Cow;

use rayon::prelude::*;
use stack::{Component, Estimate, FeatureStack, Image, Noise, SampleCounts};

use super::halves::luminance;
use super::settings::LightSettings;
use crate::box_filter::box_mean;
use crate::exposure::Exposed;

/// Whether `indirect` can be taken off `whole`: both come in as many buckets.
pub fn is_part_of(indirect: &Estimate, whole: &Estimate) -> bool {
    match (&indirect.noise, &whole.noise) {
        (Noise::Buckets(indirect), Noise::Buckets(whole)) => indirect.len() == whole.len(),
        _ => false,
    }
}

/// A component as it is rebuilt.
pub enum Light<'a> {
    /// All at once.
    Whole(Cow<'a, Component>),
    /// Direct and indirect light by themselves.
    Apart {
        /// Both, direct light first.
        parts: [Component; 2],
        /// The share of the noise that is direct light's.
        share: f32,
    },
}

impl<'a> Light<'a> {
    /// How a `whole` component is rebuilt that has this `indirect` light; noise is compared in light made `exposure` times
    /// as bright.
    pub fn of(
        whole: Cow<'a, Component>,
        indirect: Option<IndirectLight>,
        counts: &SampleCounts,
        settings: &LightSettings,
        exposure: f32,
    ) -> Self {
        match indirect {
            Some(indirect) => indirect.of_whole(whole, counts, settings, exposure),
            None => Self::Whole(whole),
        }
    }
}

/// Indirect light of a component.
pub struct IndirectLight<'a> {
    /// As paths found it.
    found: Cow<'a, Estimate>,
    /// With less noise, where a stack knows it so.
    gathered: Option<Cow<'a, Estimate>>,
}

impl<'a> IndirectLight<'a> {
    /// That of `stack`; as gathered if that is `wanted`.
    pub fn of(stack: &'a FeatureStack, wanted: bool) -> Option<Self> {
        let gathered = stack.gathered.as_ref().filter(|_| wanted).map(Cow::Borrowed);
        Some(Self { found: Cow::Borrowed(stack.indirect.as_ref()?), gathered })
    }

    /// The same, taken out of `stack`.
    pub fn taken_from(stack: &mut FeatureStack, wanted: bool) -> Option<Self> {
        let gathered = stack.gathered.take().filter(|_| wanted).map(Cow::Owned);
        Some(Self { found: Cow::Owned(stack.indirect.take()?), gathered })
    }

    /// `whole` taken apart where that is better, or with this light as it is best known. Noise is compared in light made
    /// `exposure` times as bright.
    fn of_whole<'b>(
        self,
        whole: Cow<'b, Component>,
        counts: &SampleCounts,
        settings: &LightSettings,
        exposure: f32,
    ) -> Light<'b> {
        if !self.is_part_of(&whole.radiance) {
            return Light::Whole(whole);
        }
        let share = || self.direct_share_of_noise(&whole.radiance, counts, exposure);
        match settings.apart.then(share).filter(|share| *share < settings.direct_noise) {
            Some(share) => Light::Apart { parts: self.parts(whole.into_owned()), share },
            None => Light::Whole(self.within(whole)),
        }
    }

    /// Whether it can be taken off `whole`.
    pub fn is_part_of(&self, whole: &Estimate) -> bool {
        [Some(&self.found), self.gathered.as_ref()].into_iter().flatten().all(|light| is_part_of(light, whole))
    }

    /// The share of the noise of `whole` that is direct light's, this being as paths found it: variances of the mean over
    /// RGB, each relative to the squared luminance L² + 0.001 of 5×5 pixels, all made `exposure` times as bright, averaged
    /// over the picture. Zero where there is no noise.
    pub fn direct_share_of_noise(&self, whole: &Estimate, counts: &SampleCounts, exposure: f32) -> f32 {
        let [indirect, whole] = [&self.found, whole].map(|light| grey(light).exposed(exposure));
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

    /// Direct light, which is the `whole` without indirect light, and that as it is best known.
    pub fn parts(self, whole: Component) -> [Component; 2] {
        let of = |radiance| Component { role: whole.role, radiance };
        let direct = without(whole.radiance, &self.found);
        [of(direct), of(self.gathered.unwrap_or(self.found).into_owned())]
    }

    /// The `whole` with this light as it is best known.
    pub fn within(self, whole: Cow<'_, Component>) -> Cow<'_, Component> {
        if self.gathered.is_none() {
            return whole;
        }
        let [Component { role, mut radiance }, indirect] = self.parts(whole.into_owned());
        radiance.mean.add(&indirect.radiance.mean);
        if let (Noise::Buckets(buckets), Noise::Buckets(indirect)) = (&mut radiance.noise, &indirect.radiance.noise) {
            buckets.par_iter_mut().zip(indirect).for_each(|(bucket, indirect)| bucket.add(indirect));
        }
        Cow::Owned(Component { role, radiance })
    }
}

fn without(mut whole: Estimate, indirect: &Estimate) -> Estimate {
    take_off(&mut whole.mean, &indirect.mean);
    if let (Noise::Buckets(buckets), Noise::Buckets(indirect)) = (&mut whole.noise, &indirect.noise) {
        buckets.par_iter_mut().zip(indirect).for_each(|(bucket, indirect)| take_off(bucket, indirect));
    }
    whole
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
    use crate::best::test_scene::{component, error, image, stack_of, with_noise};
    use crate::best::{BestSettings, LightSettings};
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
        rebuilt(stack, BestSettings { light, ..BestSettings::default() })
    }

    fn rebuilt(stack: &FeatureStack, best: BestSettings) -> Image {
        reconstruct(stack, &Settings { best, ..Settings::default() }, &Silent).unwrap().picture
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
        let share = |indirect: &Estimate| {
            let indirect = IndirectLight { found: Cow::Borrowed(indirect), gathered: None };
            indirect.direct_share_of_noise(&both.components[0].radiance, &both.samples, 1.0)
        };
        let found = share(both.indirect.as_ref().unwrap());
        assert!((found * 17.0 - 1.0).abs() < 0.2, "{found}");
        let mut dark = both.indirect.clone().unwrap();
        let Noise::Buckets(buckets) = &mut dark.noise else { unreachable!() };
        buckets.iter_mut().chain([&mut dark.mean]).for_each(|image| *image = Image::zeros(SIZE, 3));
        assert_eq!(share(&dark), 1.0);
        assert_eq!(share(&both.components[0].radiance), 0.0);
    }

    #[test]
    fn gathered_light_takes_the_place_of_what_paths_found() {
        let [mut both, _, indirect] = stacks([10, 20]);
        let without = picture(&both, alone());
        let mut noise = TestNoise(19);
        let clean = image(SIZE, |x, _, _| if x < 20 { 1.0 } else { 0.5 });
        let buckets = [(); 8].map(|()| with_noise(&clean, 0.1, &mut noise)).to_vec();
        both.gathered = Some(component(buckets, &indirect.samples).radiance);
        assert_eq!(picture(&both, LightSettings { gathered: false, ..alone() }), without);
        let whole = image(SIZE, |x, _, _| clean.channels()[0][x] + if x < 10 { 1.0 } else { 0.5 });
        let noisy = error(&without, &whole);
        for apart in [true, false] {
            let gathered = error(&picture(&both, LightSettings { apart, ..alone() }), &whole);
            assert!(gathered < 0.5 * noisy, "{apart}: {gathered} {noisy}");
        }
    }

    #[test]
    fn direct_light_may_be_rebuilt_fast_by_itself() {
        let [both, direct, indirect] = stacks([10, 20]);
        let fast = LightSettings { direct_fast: 1.0, ..alone() };
        let mut sum = rebuilt(&direct, BestSettings::default().for_direct_light(0.0));
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
            let mut best =
                BestSettings { light: LightSettings { direct_spread, ..alone() }, ..BestSettings::default() };
            // All of them are fireflies, many as they are.
            best.split.most = 1.0;
            let picture = rebuilt(&both, best);
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
