//! A path while it is being followed.

use glam::Vec3;

use crate::Ray;
use crate::film::{FeatureRecord, SampleRecord};
use crate::gather::GatherPoint;
use crate::light::Receiver;

/// How a path left its last surface, when other directions were possible too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departure {
    /// Density per solid angle of the direction taken.
    pub(super) pdf: f32,
    /// How that surface looks for light.
    pub(super) receiver: Receiver,
}

/// A surface where light is looked for among photons, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    /// Squared radius of the disc that photons are looked for in × how many count.
    pub(super) sent: f32,
    /// The surface's unit normal.
    pub(super) normal: Vec3,
    /// Cosine of the direction that the path took from there.
    pub(super) cosine: f32,
    /// By what mirrors and glass since have thinned photons out.
    pub(super) thinned: f32,
}

/// A path while it is being followed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Its next segment.
    pub(super) ray: Ray,
    /// Radiance at the camera ÷ radiance along `ray`.
    pub(super) throughput: Vec3,
    /// Product of η² of the interfaces crossed: what `throughput` lost to them comes back when the path leaves again.
    pub(super) eta_scale: f32,
    /// `None` when light along `ray` can be found in no other way: straight from the camera, a mirror or glass.
    pub(super) departure: Option<Departure>,
    /// Length of its way so far.
    pub(super) length: f32,
    /// Where photons show it caustics, as long as it has met only mirrors and clear glass since.
    pub(super) landing: Option<Landing>,
    /// Square root of the solid angle that it stands for: 1/√pdf of where it went when it last had a choice.
    pub(super) spread: f32,
    /// Whether all surfaces so far were perfect mirrors or clear glass.
    pub(super) specular: bool,
    /// Whether the features are final.
    pub(super) settled: bool,
    /// Whether it went on from the hit of the features to another surface.
    pub(super) indirect: bool,
    /// What has been found so far.
    pub(super) record: SampleRecord,
    /// Rays cast.
    pub(super) rays: u64,
}

impl Path {
    /// A path that begins with `ray`, at the camera.
    pub(super) fn new(ray: Ray) -> Self {
        Self {
            ray,
            throughput: Vec3::ONE,
            eta_scale: 1.0,
            departure: None,
            length: 0.0,
            landing: None,
            spread: 0.0,
            specular: true,
            settled: false,
            indirect: false,
            record: SampleRecord::default(),
            rays: 0,
        }
    }

    /// Adds radiance that `ray` meets at its end, of which photons leave the share `left` to be gathered.
    #[inline]
    pub(super) fn add_emission(&mut self, radiance: Vec3, left: f32) {
        if self.specular {
            self.record.emission += self.throughput * radiance;
        } else {
            self.add_scattered(self.throughput * radiance, left);
        }
    }

    /// Adds radiance that reaches the camera from where the path is, the share `left` of it to be gathered.
    #[inline]
    pub(super) fn add_scattered(&mut self, radiance: Vec3, left: f32) {
        self.record.scattered += radiance;
        if self.indirect {
            self.record.indirect += radiance;
            match &mut self.record.to_gather {
                Some(point) => point.found += left * radiance,
                None => self.record.gathered += left * radiance,
            }
        }
    }

    /// From here on, what leaves the surface at `point` is gathered, once, unless it was already.
    #[inline]
    pub(super) fn gather_at(&mut self, point: impl FnOnce() -> GatherPoint) {
        if self.indirect {
            self.record.to_gather.get_or_insert_with(point);
        }
    }

    /// Records features; the depth is that of the first surface.
    #[inline]
    pub(super) fn set_features(&mut self, features: FeatureRecord, settled: bool, is_first: bool) {
        let depth = if is_first { features.depth } else { self.record.features.depth };
        self.record.features = FeatureRecord { depth, ..features };
        self.settled = settled;
    }
}
