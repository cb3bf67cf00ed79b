//! What surrounds a scene, infinitely far away: the same radiance everywhere, or a latitude-longitude map of it.

mod distribution;
mod map;

use std::sync::Arc;

use glam::{Vec2, Vec3};

pub use map::EnvironmentMap;

use crate::digest::Digest;

/// Light from infinitely far away.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Radiance of a constant sky; factor on the map where there is one.
    radiance: Vec3,
    map: Option<Arc<EnvironmentMap>>,
    /// Cosine and sine of the map's turn round +y.
    turn: Vec2,
}

/// A direction chosen by [`Environment::sample_direction`].
#[derive(Clone, Copy, Debug)]
pub struct SkyDirection {
    /// Where the light comes from; unit length.
    pub direction: Vec3,
    /// Density per solid angle; above 0.
    pub pdf: f32,
}

impl Environment {
    /// A sky of the same `radiance` everywhere.
    pub const fn constant(radiance: Vec3) -> Self {
        Self { radiance, map: None, turn: Vec2::X }
    }

    /// The sky that `map` shows.
    pub fn mapped(map: EnvironmentMap) -> Self {
        Self { radiance: Vec3::ONE, map: Some(Arc::new(map)), turn: Vec2::X }
    }

    /// The same sky, `factor` times as bright.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self { radiance: factor * self.radiance, ..self }
    }

    /// The same sky, turned by `degrees` from how its map was made: counter-clockwise seen from above (from +y).
    #[must_use]
    pub fn turned_to(self, degrees: f32) -> Self {
        Self { turn: Vec2::from_angle(degrees.to_radians()), ..self }
    }

    /// Its radiance, where it is the same everywhere.
    pub fn constant_radiance(&self) -> Option<Vec3> {
        self.map.is_none().then_some(self.radiance)
    }

    /// Its map, where it has one.
    pub fn map(&self) -> Option<&EnvironmentMap> {
        self.map.as_deref()
    }

    /// Mean radiance over all directions.
    pub fn mean(&self) -> Vec3 {
        self.map.as_ref().map_or(self.radiance, |map| self.radiance * map.mean())
    }

    /// Radiance that comes from the unit vector `direction`.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match &self.map {
            None => self.radiance,
            Some(map) => self.radiance * map.radiance(self.map_direction(direction)),
        }
    }

    /// Chooses a direction of the whole sphere by a point `u` in [0, 1)², nearly in proportion to the map's radiance.
    /// `None` for a constant or a black sky.
    pub fn sample_direction(&self, u: Vec2) -> Option<SkyDirection> {
        let sample = self.map.as_ref()?.sample_direction(u)?;
        Some(SkyDirection { direction: self.world_direction(sample.direction), ..sample })
    }

    /// Density per solid angle of [`sample_direction`](Self::sample_direction); 0 for a constant or a black sky.
    pub fn direction_pdf(&self, direction: Vec3) -> f32 {
        self.map.as_ref().map_or(0.0, |map| map.direction_pdf(self.map_direction(direction)))
    }

    /// Adds what tells it from other skies.
    pub(crate) fn digest(&self, digest: &mut Digest) {
        let Self { radiance, map, turn } = self;
        digest.numbers(radiance.as_ref());
        digest.numbers(turn.as_ref());
        map.iter().for_each(|map| map.digest(digest));
    }

    #[inline]
    fn map_direction(&self, d: Vec3) -> Vec3 {
        let Vec2 { x: cos, y: sin } = self.turn;
        Vec3::new(cos * d.x - sin * d.z, d.y, sin * d.x + cos * d.z)
    }

    #[inline]
    fn world_direction(&self, d: Vec3) -> Vec3 {
        let Vec2 { x: cos, y: sin } = self.turn;
        Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
    }
}

#[cfg(test)]
mod tests;
