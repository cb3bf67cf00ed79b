//! Exposure. Much of `best` is relative to brightness, down to constants that keep logarithms and quotients finite in the
//! dark. So light in other units than usual is made brighter or darker before it is rebuilt, and brought back at the end.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use rayon::prelude::*;
use stack::{Component, ComponentRole, Estimate, FeatureStack, Image, Noise, Size};

use crate::reconstruction::Reconstruction;

/// Side of the blocks of pixels whose mean brightness counts: noise averages out, light and shadow do not.
const BLOCK: usize = 8;

/// Blocks below this share of the mean brightness are background.
const BACKGROUND: f64 = 1e-4;

/// Largest exponent of a factor, up or down.
const LARGEST: f64 = 60.0;

/// The power of two that brings the scattered light of `components` closest to what brightness is `usual`, in the geometric
/// mean over blocks of pixels. Multiplying by it rounds nothing. 1 where light lies in that range, or there is none. Of a
/// range that is empty its end counts.
pub fn exposure(components: &[Component], usual: RangeInclusive<f32>) -> f32 {
    let scattered = components.iter().find(|component| component.role == ComponentRole::Scattered);
    let Some(brightness) = scattered.and_then(|component| typical_brightness(&component.radiance.mean)) else {
        return 1.0;
    };
    let wanted = brightness.max((*usual.start()).into()).min((*usual.end()).into());
    (wanted / brightness).log2().round().clamp(-LARGEST, LARGEST).exp2() as f32
}

/// The geometric mean of brightness over blocks of pixels, without background; `None` where all is black.
pub fn typical_brightness(image: &Image) -> Option<f64> {
    let blocks = block_means(image);
    let least = BACKGROUND * blocks.iter().sum::<f64>() / blocks.len().max(1) as f64;
    let lit: Vec<f64> = blocks.into_iter().filter(|mean| *mean > least).map(f64::log2).collect();
    (!lit.is_empty()).then(|| (lit.iter().sum::<f64>() / lit.len() as f64).exp2())
}

/// The median of the pixels' brightness.
pub fn median_brightness(image: &Image) -> f32 {
    let mut values: Vec<f32> = (0..image.pixels()).map(|pixel| image.mean_at(pixel)).collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Mean brightness of every block of an image, as far as it lies inside.
fn block_means(image: &Image) -> Vec<f64> {
    let size = image.size();
    let blocks = Size::new(size.width.div_ceil(BLOCK), size.height.div_ceil(BLOCK));
    let mean = |block: usize| {
        let first = [block % blocks.width, block / blocks.width].map(|at| at * BLOCK);
        let columns = first[0]..(first[0] + BLOCK).min(size.width);
        let rows = first[1]..(first[1] + BLOCK).min(size.height);
        let pixels = columns.len() * rows.len();
        let row = |y: usize| columns.clone().map(move |x| f64::from(image.mean_at(size.index(x, y)))).sum::<f64>();
        rows.map(row).sum::<f64>() / pixels as f64
    };
    (0..blocks.pixels()).into_par_iter().map(mean).collect()
}

/// Light that can be made brighter or darker.
pub trait Exposed: Sized {
    /// The same, `factor` times as bright.
    #[must_use]
    fn exposed(self, factor: f32) -> Self;
}

impl Exposed for Image {
    fn exposed(mut self, factor: f32) -> Self {
        if factor != 1.0 {
            self.channels_mut().par_iter_mut().flatten().for_each(|v| *v *= factor);
        }
        self
    }
}

impl Exposed for Estimate {
    fn exposed(self, factor: f32) -> Self {
        let noise = match self.noise {
            Noise::Buckets(buckets) => {
                Noise::Buckets(buckets.into_iter().map(|bucket| bucket.exposed(factor)).collect())
            }
            Noise::VarianceOfMean(variance) => Noise::VarianceOfMean(variance.exposed(factor * factor)),
            Noise::Unknown => Noise::Unknown,
        };
        Self { mean: self.mean.exposed(factor), noise }
    }
}

impl Exposed for Component {
    fn exposed(self, factor: f32) -> Self {
        Self { radiance: self.radiance.exposed(factor), ..self }
    }
}

/// Borrowed light is copied only if it changes.
impl<T: Exposed + Clone> Exposed for Cow<'_, T> {
    fn exposed(self, factor: f32) -> Self {
        if factor == 1.0 { self } else { Cow::Owned(self.into_owned().exposed(factor)) }
    }
}

impl Exposed for FeatureStack {
    fn exposed(self, factor: f32) -> Self {
        let components = self.components.into_iter().map(|component| component.exposed(factor)).collect();
        let [indirect, gathered] = [self.indirect, self.gathered].map(|light| light.map(|light| light.exposed(factor)));
        Self { components, indirect, gathered, ..self }
    }
}

impl Exposed for Reconstruction {
    fn exposed(self, factor: f32) -> Self {
        let mut mse = self.mse;
        mse.iter_mut().for_each(|v| *v *= factor * factor);
        Self {
            picture: self.picture.exposed(factor),
            mse,
            spikes: self.spikes.map(|spikes| spikes.exposed(factor)),
            passes: self.passes.into_iter().map(|pass| pass.exposed(factor)).collect(),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use stack::Silent;

    use super::*;
    use crate::best::test_scene::{component, flat, stack_of, walls};
    use crate::{Settings, reconstruct};

    const SIZE: Size = Size::new(40, 24);

    fn of(image: &Image) -> f32 {
        let stack = stack_of(image, 9);
        exposure(&[component(vec![image.clone(); 2], &stack.samples)], 0.125..=0.5)
    }

    #[test]
    fn light_comes_into_its_range_by_powers_of_two() {
        assert_eq!(of(&flat(SIZE, 0.125)), 1.0);
        assert_eq!(of(&flat(SIZE, 0.6)), 1.0);
        assert_eq!(of(&flat(SIZE, 40.0)), 2.0_f32.powi(-6));
        assert_eq!(of(&flat(SIZE, 1e-3)), 128.0);
        assert_eq!(of(&flat(SIZE, 0.0)), 1.0);
        assert_eq!(of(&flat(SIZE, f32::MIN_POSITIVE)), 2.0_f32.powi(60));
    }

    #[test]
    fn no_light_stays_above_the_brightest() {
        let image = flat(SIZE, 0.125);
        let (darkest, brightest) = (0.5, 0.125);
        let components = [component(vec![image.clone(); 2], &stack_of(&image, 9).samples)];
        assert_eq!(exposure(&components, darkest..=brightest), 1.0);
    }

    #[test]
    fn black_background_does_not_count() {
        let mut dark = flat(SIZE, 0.06);
        dark.channels_mut().iter_mut().for_each(|plane| plane[..SIZE.width * BLOCK].fill(0.0));
        assert_eq!(of(&dark), 2.0);
    }

    #[test]
    fn units_do_not_matter() {
        let stack = stack_of(&walls(SIZE), 143);
        let rebuilt = |factor: f32| {
            let stack = stack.clone().exposed(factor);
            reconstruct(&stack, &Settings::default(), &Silent).unwrap().exposed(1.0 / factor)
        };
        let [dark, bright] = [2.0_f32.powi(-10), 2.0_f32.powi(10)];
        assert!(rebuilt(dark) == rebuilt(dark / 4096.0));
        assert!(rebuilt(bright) == rebuilt(bright * 4096.0));
    }
}
