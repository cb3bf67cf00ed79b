//! A path while it is being followed.

use glam::Vec3;

use crate::Ray;
use crate::bsdf::Bsdf;
use crate::bvh::Bounds;
use crate::film::{FeatureRecord, SampleRecord};
use crate::gather::GatherPoint;
use crate::interaction::Interaction;
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
    /// Share of what it finds from here on that is found for others, too, where light is gathered.
    pub(super) shared: Vec3,
    /// What it loses by unit length where it is: in coloured glass, or else nothing.
    pub(super) absorption: Vec3,
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
            shared: Vec3::ONE,
            absorption: Vec3::ZERO,
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
            self.add_scattered(self.throughput * radiance, self.shared, left);
        }
    }

    /// Adds radiance that reaches the camera from where the path is, the share `left` of it to be gathered; of that, `shared`
    /// is found for others, too.
    #[inline]
    pub(super) fn add_scattered(&mut self, radiance: Vec3, shared: Vec3, left: f32) {
        self.record.scattered += radiance;
        if self.indirect {
            self.record.indirect += radiance;
            self.gather(left * radiance, shared);
        }
    }

    /// Adds to what is gathered.
    #[inline]
    pub(super) fn gather(&mut self, radiance: Vec3, shared: Vec3) {
        match &mut self.record.to_gather {
            Some(point) => {
                point.found += shared * radiance;
                self.record.gathered += (Vec3::ONE - shared) * radiance;
            }
            None => self.record.gathered += radiance,
        }
    }

    /// Gathers what leaves the first diffuse surface, or else the first coated one. Whether that is the surface at `hit`.
    #[inline]
    pub(super) fn gather_at(&mut self, hit: &Interaction, bsdf: &Bsdf, bounds: Bounds) -> bool {
        if !self.indirect {
            return false;
        }
        let is_better = self.record.to_gather.is_none_or(|point| point.is_coated() && bsdf.is_diffuse());
        let point = || GatherPoint::new(hit, bsdf, self.throughput, self.spread, bounds);
        let Some(point) = is_better.then(point).flatten() else { return false };
        if let Some(coated) = self.record.to_gather.replace(point) {
            self.record.gathered += coated.found;
        }
        true
    }

    /// Records features; the depth is that of the first surface.
    #[inline]
    pub(super) fn set_features(&mut self, features: FeatureRecord, settled: bool, is_first: bool) {
        let depth = if is_first { features.depth } else { self.record.features.depth };
        self.record.features = FeatureRecord { depth, ..features };
        self.settled = settled;
    }
}
