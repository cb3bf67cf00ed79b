//! `--guide`: another denoiser's picture, mixed in where it is likely to be nearer to the truth.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use reconstruct::Reconstruction;
use reconstruct::blend::{blend, check_size};
use serde_json::{Value, json};
use stack::{FeatureStack, Image, Size};

use crate::any_picture::read_any_picture;
use crate::progress::Progress;

/// A picture to mix in.
pub struct Guide {
    file: PathBuf,
    picture: Image,
}

/// Which picture was mixed in, and how far it was followed.
pub struct Followed {
    file: PathBuf,
    mean_weight: f64,
}

impl Guide {
    /// Reads the picture of `file`, which the user calls `name`, for a stack of `size`.
    ///
    /// # Errors
    /// When it cannot be read, holds no colour, or has another size.
    pub fn read((file, name): (&Path, &Path), size: Size) -> Result<Self> {
        let (picture, _) = read_any_picture(file).context("--guide")?;
        check_size(&picture, size).with_context(|| format!("--guide {}", file.display()))?;
        Ok(Self { file: name.into(), picture })
    }

    /// Mixes it into what `stack` was `rebuilt` to, and says how much.
    ///
    /// # Errors
    /// When there is nothing to judge it by, or the work is stopped.
    pub fn mix(
        self,
        stack: &FeatureStack,
        rebuilt: &mut Reconstruction,
        settings: &reconstruct::Settings,
        progress: &Progress,
    ) -> Result<Followed> {
        let blend = blend(stack, rebuilt, &self.picture, settings, progress)?;
        let mean_weight = blend.mean_weight();
        rebuilt.picture = blend.picture;
        if !settings.method.is_collaborative() {
            progress.say("guides help --preset best and fast; with this method a better guide may be better alone");
        }
        progress.say(&format!("guide {}: weight {mean_weight:.3} in the mean", self.file.display()));
        Ok(Followed { file: self.file, mean_weight })
    }
}

impl Followed {
    /// For `--json`.
    pub fn json(&self) -> Value {
        json!({"file": self.file, "mean_weight": self.mean_weight})
    }
}
