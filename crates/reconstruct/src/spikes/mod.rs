//! Spike noise found by robust PCA and taken out (the paper's section 4.1, algorithm 1, equations 8 and 9), or, for the
//! paper's figure 1, by the learning-based filter's rule (`lbf`).
//!
//! Directly seen lamps must not be in the picture: their light is a component of its own, and beside it nothing of the
//! tile would look like a spike.

mod alm;
mod lbf;
pub(crate) mod replace;
mod shrinkage;
mod spectral_norm;
mod tiles;

use stack::{Cancelled, Image, Monitor};

use alm::AlmSettings;
pub use alm::UpdateOrder;

stack::knob_choice! {
    /// What is taken for a spike.
    pub enum SpikeMethod {
        /// A large entry of the sparse part that robust PCA finds, the paper's algorithm 1.
        RobustPca = "robust-pca",
        /// A pixel far from the mean of its 3×3 block (Kalantari et al. 2015).
        Lbf = "lbf",
    }
}

stack::knob_choice! {
    /// What the spike threshold is measured in.
    pub enum ThresholdUnit {
        /// Radiance, as in the paper: what is a spike depends on the exposure.
        Radiance = "radiance",
        /// The image's log-average luminance: the same pixels are marked however bright the scene is.
        LogAverage = "log-average",
    }
}

stack::knobs! {
    /// How spikes are found and taken out.
    pub struct SpikeSettings("spike") {
        /// Whether to look for spikes at all (algorithm 1). Without, their energy stays and so do their splotches.
        removal: bool = true, ..;
        /// Which pixels are spikes: robust-pca is the paper's algorithm 1; lbf is the rule of the learning-based filter
        /// (Kalantari et al. 2015), which the paper's figure 1 puts in front of our regression. The threshold, tiles and
        /// decomposition below belong to robust-pca.
        method: SpikeMethod = SpikeMethod::RobustPca, ..;
        /// With lbf, a pixel is a spike when it is more than this many standard deviations away from the mean of its 3×3
        /// block in any channel. The pixel itself is in the block, so that nothing exceeds √8.
        deviations: f32 = 2.0, 0.0..=3.0;
        /// A pixel is a spike when its sparse part exceeds this in any channel (algorithm 1, line 9).
        threshold: f32 = 2.5, 0.0..;
        /// Unit of the threshold: radiance as in the paper, or log-average, the image's log-average luminance, which
        /// does not depend on exposure.
        threshold_unit: ThresholdUnit = ThresholdUnit::Radiance, ..;
        /// Side of the tiles that are decomposed one by one, in pixels (algorithm 1, line 1).
        tile_size: usize = 64, 4..=1024;
        /// Iterations of the robust PCA (section 4.1). One huge spike hides the others of its tile after one.
        iterations: usize = 1, 1..=1000;
        /// Which part an iteration of the robust PCA updates first.
        order: UpdateOrder = UpdateOrder::SparseFirst, ..;
        /// Weight λ of the sparse part (eq. 9), as a multiple of 1/√(tile side). More of it marks fewer pixels.
        lambda: f32 = 1.0, 0.01..=100.0;
        /// Stop iterating when the parts miss the whole by less than this share.
        tolerance: f32 = 1e-7, 0.0..=1.0;
    }
}

/// A picture and what was taken out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct SpikeFree {
    /// Radiance without spikes.
    pub colour: Image,
    /// Variance of its mean; a replaced pixel has that of the pixel it was taken from.
    pub variance: Image,
    /// Noisy radiance minus `colour`; zero where the noisy value was not finite.
    pub spikes: Image,
    /// Which pixels were replaced.
    pub marked: Vec<bool>,
}

/// Takes the spikes out of `colour`, three channels of linear radiance, with `variance` of its mean beside it.
///
/// When the stage is switched off everything passes unchanged, values that are not finite included.
///
/// # Errors
/// When the monitor cancels.
pub fn remove_spikes(
    colour: &Image,
    variance: &Image,
    settings: &SpikeSettings,
    monitor: &dyn Monitor,
) -> Result<SpikeFree, Cancelled> {
    if !settings.removal {
        return Ok(untouched(colour, variance));
    }
    let (marked, sources) = match settings.method {
        SpikeMethod::RobustPca => by_robust_pca(colour, settings, monitor)?,
        SpikeMethod::Lbf => lbf::find(colour, settings.deviations, monitor)?,
    };
    let clean = replace::replaced(colour, &sources);
    let variance = replace::replaced(variance, &sources);
    Ok(SpikeFree { spikes: difference(colour, &clean), colour: clean, variance, marked })
}

/// Which pixels are marked, and for each pixel the one it is taken from.
type Found = (Vec<bool>, Vec<Option<usize>>);

/// Algorithm 1.
fn by_robust_pca(colour: &Image, settings: &SpikeSettings, monitor: &dyn Monitor) -> Result<Found, Cancelled> {
    let sparse = tiles::sparse_layer(colour, settings.tile_size, &alm_settings(settings), monitor)?;
    let marked = replace::mark(colour, &sparse, absolute_threshold(colour, settings));
    let sources = (0..colour.pixels()).map(|pixel| replace::source_of(pixel, colour, &marked)).collect();
    Ok((marked, sources))
}

fn untouched(colour: &Image, variance: &Image) -> SpikeFree {
    SpikeFree {
        colour: colour.clone(),
        variance: variance.clone(),
        spikes: Image::zeros(colour.size(), colour.channels().len()),
        marked: vec![false; colour.pixels()],
    }
}

fn alm_settings(settings: &SpikeSettings) -> AlmSettings {
    AlmSettings {
        iterations: settings.iterations,
        order: settings.order,
        lambda: settings.lambda.into(),
        tolerance: settings.tolerance.into(),
    }
}

/// The threshold in radiance.
fn absolute_threshold(colour: &Image, settings: &SpikeSettings) -> f32 {
    match settings.threshold_unit {
        ThresholdUnit::Radiance => settings.threshold,
        ThresholdUnit::LogAverage => settings.threshold * log_average(colour),
    }
}

/// Geometric mean of the luminance of all pixels that have any; none counts as less than 10⁻⁴ of the arithmetic mean,
/// so that a few almost black ones do not decide.
fn log_average(colour: &Image) -> f32 {
    let luminances = (0..colour.pixels()).map(|pixel| f64::from(colour.mean_at(pixel)));
    let lit: Vec<f64> = luminances.filter(|luminance| luminance.is_finite() && *luminance > 0.0).collect();
    let count = lit.len().max(1) as f64;
    let floor = 1e-4 * lit.iter().sum::<f64>() / count;
    let logarithms: f64 = lit.iter().map(|luminance| luminance.max(floor).ln()).sum();
    if lit.is_empty() { 0.0 } else { (logarithms / count).exp() as f32 }
}

/// `noisy` − `clean`, zero where the noisy value is not finite.
fn difference(noisy: &Image, clean: &Image) -> Image {
    let channels =
        noisy.channels().iter().zip(clean.channels()).map(|(noisy, clean)| {
            noisy.iter().zip(clean).map(|(a, b)| if a.is_finite() { a - b } else { 0.0 }).collect()
        });
    Image::from_channels(noisy.size(), channels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use stack::{Silent, Size};

    const SIDE: usize = 128;

    /// `scene(x, y)` with normal noise of deviation `sigma`, grey.
    fn noisy(scene: impl Fn(usize, usize) -> f32, sigma: f32, seed: u64) -> Image {
        let size = Size::new(SIDE, SIDE);
        let mut noise = TestNoise(seed);
        let plane: Vec<f32> =
            (0..size.pixels()).map(|i| (scene(i % SIDE, i / SIDE) + sigma * noise.normal() as f32).max(0.0)).collect();
        Image::from_channels(size, vec![plane; 3])
    }

    /// A lit wall whose brightness changes slowly.
    fn wall(x: usize, y: usize) -> f32 {
        0.5 + 0.3 * (x as f32 / 40.0).sin() * (y as f32 / 30.0).cos()
    }

    fn checker(x: usize, y: usize) -> f32 {
        if (x / 5 + y / 5).is_multiple_of(2) { 1.0 } else { 0.05 }
    }

    /// Adds `strength` to every `every`-th pixel in an irregular pattern and returns which ones.
    fn plant(image: &mut Image, every: u64, strength: f32) -> Vec<usize> {
        let mut noise = TestNoise(77);
        let planted: Vec<usize> = (0..image.pixels()).filter(|_| noise.uniform() < 1.0 / every as f64).collect();
        for channel in image.channels_mut() {
            planted.iter().for_each(|p| channel[*p] += strength);
        }
        planted
    }

    fn marks(image: &Image, settings: &SpikeSettings) -> Vec<bool> {
        remove_spikes(image, &Image::zeros(image.size(), 3), settings, &Silent).unwrap().marked
    }

    fn share_of_marks(image: &Image, settings: &SpikeSettings) -> f64 {
        marks(image, settings).iter().filter(|m| **m).count() as f64 / image.pixels() as f64
    }

    #[test]
    fn isolated_fireflies_are_found_and_replaced_and_nothing_else() {
        let mut image = noisy(wall, 0.05, 1);
        let clean = image.clone();
        let planted = plant(&mut image, 500, 6.0);
        let variance = Image::from_channels(image.size(), vec![(0..SIDE * SIDE).map(|i| i as f32).collect(); 3]);
        let free = remove_spikes(&image, &variance, &SpikeSettings::DEFAULT, &Silent).unwrap();
        let found: Vec<usize> = (0..image.pixels()).filter(|p| free.marked[*p]).collect();
        println!("fireflies of 120 σ: {} planted, {} marked", planted.len(), found.len());
        assert_eq!(found, planted);
        for p in planted {
            assert!((free.colour.mean_at(p) - clean.mean_at(p)).abs() < 0.3);
            let source = free.variance.channels()[0][p] as usize;
            assert_eq!(free.colour.rgb(p), image.rgb(source), "variance comes from the pixel the colour came from");
        }
        let mut whole = free.colour.clone();
        whole.add(&free.spikes);
        assert!((0..whole.pixels()).all(|p| (whole.mean_at(p) - image.mean_at(p)).abs() < 1e-5));
    }

    /// Prints what METHOD asks to be known; asserts what must hold in any case.
    #[test]
    fn marks_by_strength_scene_and_iterations() {
        let relative = SpikeSettings { threshold_unit: ThresholdUnit::LogAverage, ..SpikeSettings::DEFAULT };
        let converged = SpikeSettings { iterations: 30, ..relative };
        for (name, settings) in
            [("paper", SpikeSettings::DEFAULT), ("relative", relative), ("30 iterations", converged)]
        {
            for strength in [0.5, 1.0, 2.0, 4.0, 8.0] {
                let mut image = noisy(wall, 0.05, 2);
                let planted = plant(&mut image, 300, strength);
                let marked = marks(&image, &settings);
                let found = planted.iter().filter(|p| marked[**p]).count();
                let wrong = marked.iter().filter(|m| **m).count() - found;
                println!("{name}: {:.0} σ: {found} of {} found, {wrong} wrongly", strength / 0.05, planted.len());
                assert_eq!(wrong, 0, "{name}: a smooth wall holds no other spikes");
            }
            let lamp = |x: usize, y: usize| if x.abs_diff(70) < 9 && y.abs_diff(50) < 6 { 20.0 } else { wall(x, y) };
            println!("{name}: checker {:.4}", share_of_marks(&noisy(checker, 0.02, 3), &settings));
            println!("{name}: lamp {:.4}", share_of_marks(&noisy(lamp, 0.02, 4), &settings));
        }
    }

    #[test]
    fn the_literal_threshold_is_blind_in_a_dark_image_and_the_relative_one_is_not() {
        let mut bright = noisy(wall, 0.05, 5);
        let planted = plant(&mut bright, 500, 6.0);
        let mut dark = bright.clone();
        dark.channels_mut().iter_mut().flatten().for_each(|v| *v *= 0.01);
        let relative = SpikeSettings { threshold_unit: ThresholdUnit::LogAverage, ..SpikeSettings::DEFAULT };
        assert_eq!(share_of_marks(&dark, &SpikeSettings::DEFAULT), 0.0);
        assert_eq!(marks(&dark, &relative), marks(&bright, &relative));
        assert!(planted.iter().all(|p| marks(&dark, &relative)[*p]));
    }

    #[test]
    fn switched_off_nothing_changes() {
        let mut image = noisy(wall, 0.05, 1);
        plant(&mut image, 500, 6.0);
        let off = SpikeSettings { removal: false, ..SpikeSettings::DEFAULT };
        let free = remove_spikes(&image, &image, &off, &Silent).unwrap();
        assert_eq!(free.colour, image);
        assert_eq!(free.spikes, Image::zeros(image.size(), 3));
        assert!(!free.marked.contains(&true));
    }

    #[test]
    fn black_tiny_and_broken_images_pass() {
        for (width, height) in [(1, 1), (5, 3), (0, 0)] {
            let black = Image::zeros(Size::new(width, height), 3);
            for threshold_unit in [ThresholdUnit::Radiance, ThresholdUnit::LogAverage] {
                let settings = SpikeSettings { threshold_unit, ..SpikeSettings::DEFAULT };
                assert_eq!(remove_spikes(&black, &black, &settings, &Silent).unwrap().colour, black);
            }
        }
        let mut broken = noisy(wall, 0.0, 1);
        broken.channels_mut()[1][200] = f32::NAN;
        broken.channels_mut()[0][300] = f32::INFINITY;
        let free = remove_spikes(&broken, &broken, &SpikeSettings::DEFAULT, &Silent).unwrap();
        assert!(free.colour.channels().iter().flatten().all(|v| v.is_finite()));
        assert!(free.spikes.channels().iter().flatten().all(|v| v.is_finite()));
        assert_eq!(free.marked.iter().filter(|m| **m).count(), 2);
    }
}
