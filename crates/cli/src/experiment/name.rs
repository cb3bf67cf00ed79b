//! Which experiments there are.

use clap::ValueEnum;

/// The experiments there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Experiment {
    /// Error with each stage switched off in turn, and how rank and bandwidth are distributed. Inputs: folders with
    /// b0.exr, b1.exr …, ref1.exr and ref2.exr.
    Stages,
    /// Every method on every stack: errors, time, pictures, and errors over Open Image Denoise's and over the best
    /// rival's. Inputs: folders as for stages, perhaps with oidn.exr, or scenes.
    Methods,
    /// Noisy, uniform and adaptive pictures of scenes and adaptive over uniform errors. Inputs: scenes.
    Scenes,
    /// How many independent sequences the samples of a pixel should be dealt from. Inputs: scenes.
    Sequences,
    /// Estimated against true squared error: calibration by brightness, and how well pixels are ranked. Inputs: scenes, or
    /// folders as for stages.
    Errormap,
    /// The paper's figures, a table and pictures each: what they compare, on the same samples; figures 10 and 11, whole
    /// renders, on scenes only. Inputs: folders as for stages, or scenes; without any, scenes/*.toml of this project.
    Figures,
    /// What is left of quality as a stack knows less, from buckets down to colour alone. Inputs: folders as for stages,
    /// perhaps with oidn.exr and oidn-colour.exr; b0.exr alone, and one reference, will do.
    Degrade,
    /// Errors with other denoisers' and useless pictures as guides (--guide), over those of the better of both. Inputs:
    /// folders as for degrade.
    Guide,
    /// Planted fireflies found, and marks where there are none, on synthetic pictures. No inputs.
    Fireflies,
    /// Trains the learning-based filter (--method lbf) on variations of scenes/*.toml of this project, writes its
    /// weights, and judges them beside the best fixed filter on pictures held out. The seed is --set seed=N. Inputs:
    /// scenes, or folders as for stages, to judge on; without any, scenes/*.toml as they are.
    Lbf,
    /// Trains the network that helps preset best to mix candidates on variations of scenes/*.toml of this project, writes
    /// its weights, and judges them beside the rule without it on pictures held out. The seed is --set seed=N. Inputs: as
    /// for lbf.
    Chooser,
}

impl Experiment {
    /// Whether there is nothing to measure without inputs.
    pub const fn needs_inputs(self) -> bool {
        !matches!(self, Self::Fireflies | Self::Figures | Self::Lbf | Self::Chooser)
    }
}
