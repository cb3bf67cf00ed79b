//! What every method returns, and why one may fail.

use stack::{Cancelled, Fault, Image};

use crate::lack::Lack;
use crate::network::WeightsError;
use crate::prefilter::PrefilterError;

/// A reconstructed picture and what is known about it, one value per pixel and plane. What a method does not have is
/// `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The picture: three channels of linear radiance.
    pub picture: Image,
    /// Estimated mean squared error of the picture, mean over RGB, summed over components.
    pub mse: Vec<f32>,
    /// What was taken for spikes: noisy minus cleaned, three channels.
    pub spikes: Option<Image>,
    /// How many pixels were marked as spikes.
    pub marked: usize,
    /// Shared bandwidth h of the scattered light (eq. 14).
    pub bandwidth: Option<Vec<f32>>,
    /// Rank k of its reduced feature space (eq. 12).
    pub rank: Option<Vec<f32>>,
    /// Passes that were asked for, rebuilt with the weights of the scattered light.
    pub passes: Vec<Image>,
    /// What the stack lacked, and what was used in its stead.
    pub lacks: Vec<Lack>,
}

impl Reconstruction {
    /// `picture`, of which nothing more is known and no error.
    pub fn plain(picture: Image) -> Self {
        let mse = vec![0.0; picture.pixels()];
        Self {
            picture,
            mse,
            spikes: None,
            marked: 0,
            bandwidth: None,
            rank: None,
            passes: Vec::new(),
            lacks: Vec::new(),
        }
    }

    /// Adds a component; what there is of maps comes from whichever component has it.
    pub fn add(&mut self, other: Self) {
        self.picture.add(&other.picture);
        for (total, mse) in self.mse.iter_mut().zip(&other.mse) {
            *total += mse;
        }
        self.marked += other.marked;
        self.passes.extend(other.passes);
        self.spikes = self.spikes.take().or(other.spikes);
        self.bandwidth = self.bandwidth.take().or(other.bandwidth);
        self.rank = self.rank.take().or(other.rank);
    }
}

/// Why a stack could not be reconstructed.
#[derive(Debug, thiserror::Error)]
pub enum ReconstructError {
    /// The work was stopped by its monitor.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Nothing is known about the noise of the colour.
    #[error(
        "nothing is known about the noise of layer '{layer}': expected buckets, half-buffers or a variance; \
         render with at least two buckets, or give several renders with --buckets"
    )]
    NoiseUnknown {
        /// Layer of the component.
        layer: &'static str,
    },
    /// The method needs independent parts of the picture.
    #[error(
        "the noise of layer '{layer}' does not come in buckets or half-buffers, which this method needs: choose \
         --preset paper, or give several renders with --buckets"
    )]
    NoBuckets {
        /// Layer of the component.
        layer: &'static str,
    },
    /// Passes were asked for.
    #[error("this method rebuilds no passes: choose --preset best or fast")]
    NoPasses,
    /// The network was asked about candidates it does not know.
    #[error(
        "the network of --choice-learned true knows more candidates than --fit-few true makes: set one of them to false"
    )]
    FewCandidates,
    /// The features cannot be used.
    #[error(transparent)]
    Prefilter(#[from] PrefilterError),
    /// The weights of a network cannot be used.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

impl ReconstructError {
    /// Whose fault this is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Cancelled(_) => Fault::Interrupted,
            Self::NoiseUnknown { .. } | Self::NoBuckets { .. } | Self::NoPasses | Self::FewCandidates => Fault::Input,
            Self::Prefilter(error) => error.fault(),
            Self::Weights(error) => error.fault(),
        }
    }
}
