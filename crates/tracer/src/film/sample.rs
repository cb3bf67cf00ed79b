//! What one path contributes to its pixel.

use std::ops::Range;

use glam::Vec3;

use crate::gather::GatherPoint;

/// Channels of radiance: scattered, emission, indirect, gathered.
pub(super) const RADIANCE_CHANNELS: usize = 12;
/// Those of indirect and of gathered light among them.
pub(super) const INDIRECT: Range<usize> = 6..9;
pub(super) const GATHERED: Range<usize> = 9..12;
/// Channels of features, in the order of [`stack::FeatureRole::ALL`].
pub(super) const FEATURE_CHANNELS: usize = 13;

/// What one path saw at its feature hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeatureRecord {
    /// World-space position, in scene units; on a miss where the ray leaves the scene's bounding sphere.
    pub position: Vec3,
    /// Reflectance, 0 … 1 ([`Bsdf::albedo`](crate::bsdf::Bsdf::albedo)); 1 on a miss.
    pub albedo: Vec3,
    /// World-space shading normal of unit length on the *surface's* outside, whether that faces the viewer or not (as
    /// Mitsuba's `sh_normal`); 0 on a miss.
    pub normal: Vec3,
    /// 1 when the one light sample taken here arrives unoccluded, else 0; 0 when the light lies below the horizon or
    /// turns its back. 1 on a miss.
    pub visibility: f32,
    /// Distance along the camera ray to the first surface, in scene units; on a miss to the bounding sphere.
    pub depth: f32,
    /// R/(R + t), t the distance to the surface that the path meets next and R 3 % of `depth`; 0 when it meets none.
    pub proximity: f32,
    /// 1 when the light sample taken at that surface arrives unoccluded, else 0; 0 when there is no such surface.
    pub lit: f32,
}

/// What one path contributes to its pixel. The radiance it carries is `scattered + emission`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleRecord {
    /// Radiance scattered at least once by a surface that is neither a perfect mirror nor clear glass.
    pub scattered: Vec3,
    /// Emission and sky seen directly, or by way of perfect mirrors and clear glass only.
    pub emission: Vec3,
    /// Part of what is scattered: what arrived at the feature hit from other surfaces.
    pub indirect: Vec3,
    /// Part of that: what the path found before it came to where the rest is gathered.
    pub gathered: Vec3,
    /// Where the rest is gathered, when there is such a place.
    pub to_gather: Option<GatherPoint>,
    /// What the path saw on its way.
    pub features: FeatureRecord,
}

impl SampleRecord {
    /// Replaces a radiance, or the features, by zero where a value is not finite. Whether there was one.
    pub fn make_finite(&mut self) -> bool {
        let mut replaced = false;
        if !self.emission.is_finite() {
            self.emission = Vec3::ZERO;
            replaced = true;
        }
        let gathers = self.to_gather.is_none_or(|point| point.is_finite());
        if !(self.scattered.is_finite() && self.indirect.is_finite() && self.gathered.is_finite() && gathers) {
            (self.scattered, self.indirect, self.gathered) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            self.to_gather = None;
            replaced = true;
        }
        if !self.feature_channels().iter().all(|v| v.is_finite()) {
            self.features = FeatureRecord::default();
            replaced = true;
        }
        replaced
    }

    /// The radiance, channel by channel.
    pub(super) fn radiance_channels(&self) -> [f32; RADIANCE_CHANNELS] {
        let (s, e, i, g) = (self.scattered, self.emission, self.indirect, self.gathered);
        [s.x, s.y, s.z, e.x, e.y, e.z, i.x, i.y, i.z, g.x, g.y, g.z]
    }

    /// The features, channel by channel.
    pub(super) fn feature_channels(&self) -> [f32; FEATURE_CHANNELS] {
        let FeatureRecord { position: p, albedo: a, normal: n, visibility, depth, proximity, lit } = self.features;
        [p.x, p.y, p.z, a.x, a.y, a.z, n.x, n.y, n.z, visibility, depth, proximity, lit]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_becomes_zero_and_is_told() {
        let sound = SampleRecord { scattered: Vec3::ONE, emission: Vec3::X, ..SampleRecord::default() };
        let mut record = sound;
        assert!(!record.make_finite());
        assert_eq!(record, sound);
        (record.scattered.y, record.indirect) = (f32::NAN, Vec3::Y);
        record.features.depth = f32::INFINITY;
        assert!(record.make_finite());
        assert_eq!(record, SampleRecord { emission: Vec3::X, ..SampleRecord::default() });
    }
}
