//! A latitude-longitude map of radiance.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Vec2, Vec3};

use super::SkyDirection;
use super::distribution::Distribution;
use crate::digest::Digest;

/// A latitude-longitude map: u runs round the horizon, v from the zenith down.
///
/// In the map's own space +y is the zenith, at v = 0. The picture's left edge, u = 0, is −z; u = ¼ is +x, the middle of
/// the picture is +z. So it is in Mitsuba 3 (`envmap`). Looked up bilinearly: it repeats in u and stops at the poles.
#[derive(Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
    mean: Vec3,
    /// `None` when all is black.
    distribution: Option<Distribution>,
}

impl EnvironmentMap {
    /// A map of `width` × `height` texels, row-major, top row first, linear RGB radiance.
    ///
    /// # Panics
    /// When there are not `width` × `height` texels, or none, or one is negative or not finite: that is a mistake in the
    /// calling code.
    pub fn new(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Self {
        assert!(!texels.is_empty() && texels.len() == width * height, "texels must fill the map");
        assert!(
            texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0),
            "radiance must be finite and not negative"
        );
        let mean = mean_radiance(width, height, &texels);
        let distribution = Distribution::new(width, height, &texels);
        Self { width, height, texels, mean, distribution }
    }

    /// Columns and rows.
    pub const fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Adds what tells it from other maps.
    pub(super) fn digest(&self, digest: &mut Digest) {
        digest.length(self.width);
        self.texels.iter().for_each(|texel| digest.numbers(texel));
    }

    /// Mean radiance over all directions.
    pub(super) const fn mean(&self) -> Vec3 {
        self.mean
    }

    /// Radiance from `direction`, in the map's own space.
    #[inline]
    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let uv = to_uv(direction);
        let (x, fx) = before(uv.x * self.width as f32 - 0.5);
        let (y, fy) = before(uv.y * self.height as f32 - 0.5);
        let columns = [0, 1].map(|i| (x + i).rem_euclid(self.width as isize) as usize);
        let rows = [0, 1].map(|i| (y + i).clamp(0, self.height as isize - 1) as usize);
        let texel = |row: usize, column: usize| Vec3::from_array(self.texels[row * self.width + column]);
        let row = |row: usize| texel(row, columns[0]).lerp(texel(row, columns[1]), fx);
        row(rows[0]).lerp(row(rows[1]), fy)
    }

    pub(super) fn sample_direction(&self, u: Vec2) -> Option<SkyDirection> {
        let sample = self.distribution.as_ref()?.sample_cell(u);
        let radius = (1.0 - sample.cosine * sample.cosine).max(0.0).sqrt();
        let (sin, cos) = (TAU * sample.u).sin_cos();
        let direction = Vec3::new(radius * sin, sample.cosine, -radius * cos);
        (sample.pdf > 0.0).then_some(SkyDirection { direction, pdf: sample.pdf })
    }

    pub(super) fn direction_pdf(&self, direction: Vec3) -> f32 {
        self.distribution.as_ref().map_or(0.0, |distribution| distribution.cell_pdf(to_uv(direction)))
    }
}

/// Where `direction` lies in the map, both coordinates in 0 … 1.
#[inline]
fn to_uv(direction: Vec3) -> Vec2 {
    let u = 0.5 * FRAC_1_PI * direction.x.atan2(-direction.z);
    // The arc tangent, unlike the arc cosine, keeps its digits at the poles.
    let v = FRAC_1_PI * direction.x.hypot(direction.z).atan2(direction.y);
    Vec2::new(if u < 0.0 { u + 1.0 } else { u }, v)
}

/// The whole number below `x`, and how far `x` is past it.
#[inline]
fn before(x: f32) -> (isize, f32) {
    let floor = x.floor();
    (floor as isize, x - floor)
}

/// Mean of the texels, each weighted with the solid angle of its row.
fn mean_radiance(width: usize, height: usize, texels: &[[f32; 3]]) -> Vec3 {
    let cosine = |row: usize| f64::from(PI * row as f32 / height as f32).cos();
    let of_row = |row: usize| {
        let texels = &texels[row * width..(row + 1) * width];
        let sum: glam::DVec3 = texels.iter().map(|t| Vec3::from_array(*t).as_dvec3()).sum();
        0.5 * (cosine(row) - cosine(row + 1)) / width as f64 * sum
    };
    (0..height).map(of_row).sum::<glam::DVec3>().as_vec3()
}
