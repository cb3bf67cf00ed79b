//! How much a rough coat reflects in all, and how much it lets through: its directional albedo, tabulated on first use.
//!
//! With Schlick's Fresnel the albedo of single scattering is linear in the reflectance F₀ at normal incidence:
//! F₀ A + (1 − F₀) B, where A is the albedo of a perfect reflector and B weighs it with (1 − cos)⁵ (Karis 2013, the split
//! sum). Times 1 + F₀ (1 − A)/A, which gives back what facets reflect more than once (see `conductor`), it leaves
//!
//! 1 − E = (1 − F₀) (1 − B + F₀ D),  D = (1 − A)(1 − B/A):
//!
//! written so, what a bright coat lets through is not lost to cancellation, and a perfect reflector lets nothing through.
//! A, B and D depend on angle and roughness alone. The table is right to 0.002, of coats smoother than 0.02 to 0.01 near
//! the horizon.

use std::sync::LazyLock;

use glam::{Vec2, Vec3};

use super::albedo_grid;
use super::fresnel::schlick_weight;
use super::ggx::{Ggx, Reflection};

/// Tabulated cosines, at the fourth powers of 0 … 1: albedo bends most near the horizon.
const COSINES: usize = 48;
/// Tabulated roughnesses, at the cubes of 0 … 1.
const ROUGHNESSES: usize = 48;
/// Samples per side of the square that an entry is integrated over.
const SAMPLES: usize = 24;

/// A, B and D at the tabulated cosines, and at the end of the row their mean over the hemisphere.
type Row = [Split; COSINES + 1];

static TABLE: LazyLock<Vec<Row>> =
    LazyLock::new(|| (0..ROUGHNESSES).map(|i| tabulate(albedo_grid::roughness(i, ROUGHNESSES))).collect());

/// The albedo of a coat of one roughness.
#[derive(Clone, Copy, Debug)]
pub(super) struct CoatAlbedo {
    row: usize,
    /// Share of the next row.
    blend: f32,
}

/// The albedo of a coat with GGX roughness `alpha`, 0 … 1.
pub(super) fn at_roughness(alpha: f32) -> CoatAlbedo {
    let (row, blend) = albedo_grid::locate_roughness(alpha, ROUGHNESSES);
    CoatAlbedo { row, blend }
}

impl CoatAlbedo {
    /// What is seen with cosine `cosine`.
    #[inline]
    pub(super) fn directional(&self, cosine: f32) -> Split {
        let (column, blend) = albedo_grid::locate_cosine(cosine, COSINES);
        self.blended(|row| row[column].0.lerp(row[column + 1].0, blend))
    }

    /// The mean over all directions, each weighted with its cosine.
    #[inline]
    pub(super) fn mean(&self) -> Split {
        self.blended(|row| row[COSINES].0)
    }

    #[inline]
    fn blended(&self, entry: impl Fn(&Row) -> Vec3) -> Split {
        let table = &*TABLE;
        Split(entry(&table[self.row]).lerp(entry(&table[self.row + 1]), self.blend))
    }
}

/// A, B and D.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split(Vec3);

impl Split {
    fn new(single: Vec2) -> Self {
        let Vec2 { x: a, y: b } = single;
        Self(Vec3::new(a, b, (1.0 - a) * (1.0 - b / a)))
    }

    /// Share of light that a coat reflects in all directions together which reflects `specular` at normal incidence. Black is no
    /// coat: what it would reflect at grazing angles is not there.
    #[inline]
    pub(super) fn reflected(&self, specular: Vec3) -> Vec3 {
        Vec3::ONE - self.passed(specular)
    }

    /// What it does not reflect.
    #[inline]
    pub(super) fn passed(&self, specular: Vec3) -> Vec3 {
        (Vec3::ONE - specular) * self.passed_shape(specular)
    }

    /// How that depends on the direction: without the factor 1 − F₀, which a white coat makes 0.
    #[inline]
    pub(super) fn passed_shape(&self, specular: Vec3) -> Vec3 {
        Vec3::splat(1.0 - grazing(specular) * self.0.y) + specular * self.0.z
    }

    /// All that is reflected ÷ what is reflected once.
    #[inline]
    pub(super) fn compensation(&self, specular: Vec3) -> Vec3 {
        Vec3::ONE + specular * ((1.0 - self.0.x) / self.0.x)
    }
}

/// Reflectance of a coat at grazing angles.
#[inline]
pub(super) fn grazing(specular: Vec3) -> f32 {
    if specular == Vec3::ZERO { 0.0 } else { 1.0 }
}

fn tabulate(alpha: f32) -> Row {
    let mut row = [Split(Vec3::ZERO); COSINES + 1];
    for (i, entry) in row[..COSINES].iter_mut().enumerate() {
        *entry = Split::new(integrate(alpha, albedo_grid::cosine(i, COSINES), SAMPLES));
    }
    row[COSINES] = mean_of(&row);
    row
}

/// A and B at one angle, over a midpoint grid of visible normals.
fn integrate(alpha: f32, cosine: f32, samples: usize) -> Vec2 {
    let outgoing = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let ggx = Ggx::new(alpha);
    let at = |i: usize| (i as f32 + 0.5) / samples as f32;
    let entry = |s: f32, v: f32| {
        // Substituted so that the grid reaches into the long tail of steep normals, at u.x → 1.
        let rest = 1.0 - s;
        let sample = ggx.sample_reflection(outgoing, Vec2::new(1.0 - rest.powi(4), v));
        let weight = |s: Reflection| s.weight * Vec2::new(1.0, schlick_weight(s.facet_cosine));
        4.0 * rest.powi(3) * sample.map_or(Vec2::ZERO, weight)
    };
    // Row by row: a long sum of small numbers would lose its last digits.
    let row = |j: usize| (0..samples).map(|i| entry(at(i), at(j))).sum::<Vec2>() / samples as f32;
    (0..samples).map(row).sum::<Vec2>() / samples as f32
}

/// 2 ∫ E(μ) μ dμ of the row as it is interpolated, in closed form: with μ = t⁴ it is ∫ E 8t⁷ dt, E linear in t.
fn mean_of(row: &Row) -> Split {
    let step = 1.0 / (COSINES - 1) as f64;
    let mean = (0..COSINES - 1)
        .map(|i| {
            let (before, after) = (i as f64 * step, (i + 1) as f64 * step);
            let both = after.powi(8) - before.powi(8);
            let second = (8.0 / 9.0 * (after.powi(9) - before.powi(9)) - before * both) / step;
            (both - second) as f32 * row[i].0 + second as f32 * row[i + 1].0
        })
        .sum();
    Split(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of the table against a finer integral.
    fn worst_error(alphas: &[f32]) -> f32 {
        let mut worst = 0.0_f32;
        for &alpha in alphas {
            for cosine in [0.004, 0.03, 0.1, 0.21, 0.47, 0.7, 0.93, 1.0] {
                let Vec2 { x: a, y: b } = integrate(alpha, cosine, 400);
                let found = at_roughness(alpha).directional(cosine);
                for specular in [0.01, 0.04, 0.5, 1.0] {
                    let single = specular * a + (1.0 - specular) * b;
                    let exact = single * (1.0 + specular * (1.0 - a) / a);
                    worst = worst.max((found.reflected(Vec3::splat(specular)).x - exact).abs());
                }
                worst = worst.max((1.0 / found.compensation(Vec3::ONE).x - a).abs());
            }
        }
        worst
    }

    #[test]
    fn the_table_agrees_with_a_finer_integral() {
        let [rough, smooth] = [&[0.02, 0.07, 0.15, 0.33, 0.5, 0.72, 0.97][..], &[0.001, 0.003, 0.007]].map(worst_error);
        eprintln!("albedo table: worst error {rough:.5}, of nearly smooth coats {smooth:.5}");
        assert!(rough < 2e-3, "{rough}");
        assert!(smooth < 1e-2, "{smooth}");
    }

    #[test]
    fn a_smooth_coat_has_schlick_s_closed_forms() {
        // Directional: F₀ + (1 − F₀)(1 − μ)⁵. Mean: F₀ + (1 − F₀)/21.
        let albedo = at_roughness(1e-4);
        let specular = Vec3::splat(0.04);
        assert!((albedo.mean().reflected(specular).x - (0.04 + 0.96 / 21.0)).abs() < 1e-3);
        assert!((albedo.directional(0.5).reflected(specular).x - (0.04 + 0.96 / 32.0)).abs() < 1e-3);
    }
}
