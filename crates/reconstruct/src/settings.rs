//! Every setting of the reconstruction.

use crate::best::BestSettings;
use crate::blend::settings::BlendSettings;
use crate::completion::CompletionSettings;
use crate::method::MethodSettings;
use crate::prefilter::PrefilterSettings;
use crate::regression::RegressionSettings;
use crate::rivals::apr::AprSettings;
use crate::rivals::lbf::LbfSettings;
use crate::rivals::nfor::NforSettings;
use crate::rivals::wlr::WlrSettings;
use crate::spikes::SpikeSettings;

stack::knob_groups! {
    /// Settings of all stages.
    pub struct Settings {
        /// Which method is used.
        method: MethodSettings,
        /// How what a stack lacks is made up.
        completion: CompletionSettings,
        /// How spikes are found and replaced.
        spikes: SpikeSettings,
        /// How features are freed of noise.
        prefilter: PrefilterSettings,
        /// How pixels are rebuilt.
        regression: RegressionSettings,
        /// How the collaborative fit rebuilds.
        best: BestSettings,
        /// Weighted local regression.
        wlr: WlrSettings,
        /// Nonlinearly weighted first-order regression.
        nfor: NforSettings,
        /// Adaptive polynomial rendering.
        apr: AprSettings,
        /// The learning-based filter.
        lbf: LbfSettings,
        /// Another denoiser's picture.
        guide: BlendSettings,
    }
}

impl Settings {
    /// How a stack is completed for the method: others than ours are as published, with the features that there are.
    pub fn completion_for_method(&self) -> CompletionSettings {
        CompletionSettings { mirrors: self.completion.mirrors && self.method.is_collaborative(), ..self.completion }
    }
}
