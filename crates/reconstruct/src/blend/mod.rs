//! A picture by another denoiser mixed in (the command line's `--guide`): `x + w (g − x)`, x what a method of this crate
//! made of the stack, g the other picture, w a weight for every pixel.
//!
//! The weight of least error is ⟨d, t − x⟩/⟨d, d⟩ with d = g − x and t the truth. In place of the truth there is the noisy
//! picture y = t + n, and ⟨d, y − x⟩ = ⟨d, t − x⟩ + cov(g, n) − cov(x, n): whatever was made from the same samples leans
//! towards their noise. For a denoiser that is as good as it can be the covariance is its squared error itself (its error
//! is orthogonal to y, hence E[(g − t) n] = E[(g − t)²]), so that of two good pictures the *worse* one is nearer to y.
//! No formula in second moments can know that covariance from one picture. What helps is what denoisers have in common:
//! a small network (`judge`) has seen how far pictures of many kinds were from the truth, and is told the moments of d,
//! of y − x and of their neighbours, smoothed on surfaces on three scales and over the whole picture (`moments`, `inputs`).
//! Events, as in [`crate::best`], are spread before y judges anyone (`noisy_picture`). Where the pictures differ by far, the
//! darker one is followed further than it deserves by its chances alone (`stakes`).
//!
//! This works on the result of any method; the network has learned on those of `best`, `fast` and `nfor`.

mod inputs;
mod judge;
mod moments;
mod noisy_picture;
pub(crate) mod settings;
mod stakes;
mod weights;

use std::borrow::Cow;

use stack::{Fault, FeatureStack, Image, Monitor, Silent, Size};

pub use self::inputs::INPUTS;
use self::inputs::Inputs;
use self::moments::Moments;
use self::noisy_picture::NoisyPicture;
pub use self::settings::BlendSettings;
use self::stakes::stakes;
use crate::completion::complete;
use crate::exposure::{Exposed, exposure};
use crate::network::WeightsError;
use crate::prefilter::PrefilterError;
use crate::reconstruction::{ReconstructError, Reconstruction};
use crate::settings::Settings;

/// A picture with another one mixed in.
#[derive(Clone, Debug, PartialEq)]
pub struct Blend {
    /// Three channels of linear radiance, not negative.
    pub picture: Image,
    /// Weight of the other picture at every pixel, 0 to 1.
    pub weights: Vec<f32>,
}

impl Blend {
    /// Mean weight of the other picture.
    pub fn mean_weight(&self) -> f64 {
        self.weights.iter().map(|w| f64::from(*w)).sum::<f64>() / self.weights.len().max(1) as f64
    }
}

/// Why a picture could not be mixed in.
#[derive(Debug, thiserror::Error)]
pub enum BlendError {
    /// It does not cover the picture.
    #[error("the guide is {found}: expected {expected}, the size of the stack; give the picture of the same pixels")]
    WrongSize {
        /// The stack's size.
        expected: Size,
        /// The other picture's.
        found: Size,
    },
    /// What it is judged by could not be had.
    #[error(transparent)]
    Reconstruct(#[from] ReconstructError),
}

impl From<PrefilterError> for BlendError {
    fn from(error: PrefilterError) -> Self {
        Self::Reconstruct(error.into())
    }
}

impl From<WeightsError> for BlendError {
    fn from(error: WeightsError) -> Self {
        Self::Reconstruct(error.into())
    }
}

impl BlendError {
    /// Whose fault this is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::WrongSize { .. } => Fault::Input,
            Self::Reconstruct(error) => error.fault(),
        }
    }
}

/// Checks that `other` covers a picture of `size`.
///
/// # Errors
/// When it does not.
pub fn check_size(other: &Image, size: Size) -> Result<(), BlendError> {
    if other.size() == size { Ok(()) } else { Err(BlendError::WrongSize { expected: size, found: other.size() }) }
}

/// What `stack` was rebuilt to, with the `other` picture, three channels of linear radiance, mixed in where it is likely to
/// be nearer to the truth. Values of it that are not finite are left out. Reports the stage `guide`.
///
/// # Errors
/// When the other picture has another size, the stack's features cannot be used, or `monitor` cancels.
pub fn blend(
    stack: &FeatureStack,
    rebuilt: &Reconstruction,
    other: &Image,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Blend, BlendError> {
    Pair::new(stack, rebuilt, other, settings, monitor)?.blended(settings.guide.strength)
}

/// Two pictures of a stack, and all that tells which is nearer to the truth.
pub struct Pair {
    picture: Image,
    other: Image,
    moments: Moments,
    stakes: Vec<f32>,
}

impl Pair {
    /// Looks at both; arguments and errors are those of [`blend`].
    ///
    /// # Errors
    /// As there.
    pub fn new(
        stack: &FeatureStack,
        rebuilt: &Reconstruction,
        other: &Image,
        settings: &Settings,
        monitor: &dyn Monitor,
    ) -> Result<Self, BlendError> {
        check_size(other, stack.size())?;
        monitor.begin("guide", 1);
        // What was made up has been told when the picture was rebuilt.
        let completed = complete(Cow::Borrowed(stack), &settings.completion_for_method(), &Silent)?;
        // Both are judged in light of usual brightness; units are no merit.
        let exposure = exposure(&completed.stack.components, settings.best.light.usual_brightness());
        let stack = completed.stack.exposed(exposure);
        let bright = Cow::Borrowed(rebuilt).exposed(exposure);
        let bright_other = sound(other, &rebuilt.picture).exposed(exposure);
        let noisy = NoisyPicture::new(&stack, &bright.picture, &settings.best, &Unreported(monitor))?;
        let moments = Moments::new(&noisy, &bright, &bright_other);
        let stakes = stakes(&bright.picture, &bright_other);
        let other = bright_other.exposed(1.0 / exposure);
        Ok(Self { picture: rebuilt.picture.clone(), other, moments, stakes })
    }

    /// What the network is told about `pixel`.
    pub fn told(&self, pixel: usize) -> [f32; INPUTS] {
        Inputs::new(&self.moments).at(pixel)
    }

    /// What is added to the logit of the weight that the network gives `pixel`.
    pub fn stake(&self, pixel: usize) -> f32 {
        self.stakes[pixel]
    }

    /// The mixture, weights times `strength`.
    ///
    /// # Errors
    /// When the weights of the network cannot be used.
    pub fn blended(&self, strength: f32) -> Result<Blend, BlendError> {
        let mut weights = weights::trained()?.weights(&Inputs::new(&self.moments), &self.stakes);
        weights.iter_mut().for_each(|weight| *weight *= strength);
        Ok(Blend { picture: mixed(&self.picture, &self.other, &weights), weights })
    }
}

/// Lets work inside a stage be stopped, and reports nothing of it: its steps are no stages of their own.
struct Unreported<'a>(&'a dyn Monitor);

impl Monitor for Unreported<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// `other` without what is negative, and where it is not finite as `picture` is.
fn sound(other: &Image, picture: &Image) -> Image {
    let planes = other.channels().iter().zip(picture.channels());
    let value = |(g, x): (&f32, &f32)| if g.is_finite() { g.max(0.0) } else { *x };
    Image::from_channels(other.size(), planes.map(|(g, x)| g.iter().zip(x).map(value).collect()).collect())
}

/// `picture` and `other`, the latter by its `weights`.
fn mixed(picture: &Image, other: &Image, weights: &[f32]) -> Image {
    let mut mixed = picture.clone();
    for (plane, other) in mixed.channels_mut().iter_mut().zip(other.channels()) {
        for ((x, g), w) in plane.iter_mut().zip(other).zip(weights) {
            *x = (*x + w * (g - *x)).max(0.0);
        }
    }
    mixed
}

#[cfg(test)]
mod tests;
