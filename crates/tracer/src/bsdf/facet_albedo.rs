//! How much of the light that microfacets meet leaves the surface after a single scattering event: tables that tell what
//! is missing.

use glam::{Vec2, Vec3};

use super::albedo_grid;
use super::fresnel;
use super::ggx::Ggx;

/// Tabulated cosines, at the fourth powers of 0 … 1: albedo bends most near the horizon.
const COSINES: usize = 48;
/// Tabulated roughnesses, at the cubes of 0 … 1.
const ROUGHNESSES: usize = 40;
/// Visible normals that an entry is integrated over, in a table of one roughness and in one of all.
const SAMPLES: [usize; 2] = [4096, 1024];

/// Albedos by angle and roughness.
#[derive(Clone, Debug)]
struct FacetAlbedo {
    /// One for each tabulated roughness, or the only one.
    rows: Vec<Row>,
}

/// Albedos by angle.
type Row = [f32; COSINES];

impl FacetAlbedo {
    /// For GGX roughness `alpha`; for every roughness when that is `None`. `kept` tells what of the light that one facet
    /// sends towards the viewer leaves the surface.
    fn new(alpha: Option<f32>, kept: impl Fn(Ggx, Vec3, Vec3) -> f32) -> Self {
        let row = |i: usize| tabulate(albedo_grid::roughness(i, ROUGHNESSES), SAMPLES[1], &kept);
        let all = || (0..ROUGHNESSES).map(row).collect();
        Self { rows: alpha.map_or_else(all, |alpha| vec![tabulate(alpha, SAMPLES[0], &kept)]) }
    }

    fn directional(&self, alpha: f32, cosine: f32) -> f32 {
        let (column, along) = albedo_grid::locate_cosine(cosine, COSINES);
        let of_row = |row: &Row| blend(row[column], row[column + 1], along);
        match &self.rows[..] {
            [only] => of_row(only),
            rows => {
                let (row, beside) = albedo_grid::locate_roughness(alpha, rows.len());
                blend(of_row(&rows[row]), of_row(&rows[row + 1]), beside)
            }
        }
    }
}

/// The albedo of rough metal of which every facet reflects everything.
#[derive(Clone, Debug)]
pub(crate) struct MetalAlbedo(FacetAlbedo);

impl MetalAlbedo {
    /// For GGX roughness `alpha`; for every roughness when that is `None`.
    pub(crate) fn new(alpha: Option<f32>) -> Self {
        Self(FacetAlbedo::new(alpha, reflected))
    }

    /// Share of the light from all directions that leaves with cosine `cosine` after one reflection.
    #[inline]
    pub(super) fn directional(&self, alpha: f32, cosine: f32) -> f32 {
        self.0.directional(alpha, cosine)
    }
}

/// The albedo of rough glass of one refractive index, reflection and refraction together.
#[derive(Clone, Debug)]
pub(crate) struct GlassAlbedo {
    /// Seen from outside, and from inside.
    sides: [FacetAlbedo; 2],
}

impl GlassAlbedo {
    /// For glass of refractive index `ior` and GGX roughness `alpha`; of every roughness when that is `None`.
    pub(crate) fn new(ior: f32, alpha: Option<f32>) -> Self {
        let side = |eta: f32| FacetAlbedo::new(alpha, |ggx, outgoing, facet| sent_on(ggx, outgoing, facet, eta));
        Self { sides: [side(ior), side(1.0 / ior)] }
    }

    /// Share of the light from all directions of both sides that leaves with cosine `cosine`, radiance not scaled by η².
    pub(super) fn directional(&self, outside: bool, alpha: f32, cosine: f32) -> f32 {
        let side = &self.sides[usize::from(!outside)];
        side.directional(alpha, cosine)
    }
}

fn tabulate(alpha: f32, samples: usize, kept: impl Fn(Ggx, Vec3, Vec3) -> f32) -> Row {
    std::array::from_fn(|i| integrate(alpha, albedo_grid::cosine(i, COSINES), samples, &kept))
}

#[inline]
fn blend(a: f32, b: f32, share: f32) -> f32 {
    a + (b - a) * share
}

/// The albedo at one angle, over `samples` visible normals on a lattice.
///
/// Total reflection begins at some angle: along rows of a grid that would be one step for all, on a lattice every point has
/// a place of its own on either axis (the additive recurrence of Roberts 2018).
fn integrate(alpha: f32, cosine: f32, samples: usize, kept: impl Fn(Ggx, Vec3, Vec3) -> f32) -> f32 {
    let outgoing = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let ggx = Ggx::new(alpha);
    let (mut sum, mut all) = (0.0_f64, 0.0_f64);
    for i in 0..samples {
        let at = |step: f64| (0.5 + i as f64 * step).fract() as f32;
        // Substituted so that the lattice reaches into the long tail of steep normals, at u.x → 1.
        let rest = 1.0 - at(0.754_877_666_246_692_8);
        let weight = f64::from(rest.powi(3));
        let u = Vec2::new(1.0 - rest.powi(4), at(0.569_840_290_998_053_2));
        sum += weight * f64::from(kept(ggx, outgoing, ggx.sample_visible_normal(outgoing, u)));
        all += weight;
    }
    (sum / all) as f32
}

/// Share of what a mirroring facet reflects towards the viewer that came from above the surface and past its neighbours.
fn reflected(ggx: Ggx, outgoing: Vec3, facet: Vec3) -> f32 {
    let incoming = 2.0 * outgoing.dot(facet).clamp(0.0, 1.0) * facet - outgoing;
    if incoming.z > 0.0 { ggx.reflection_weight(outgoing, incoming) } else { 0.0 }
}

/// The same of a facet that reflects and refracts.
fn sent_on(ggx: Ggx, outgoing: Vec3, facet: Vec3, eta: f32) -> f32 {
    let cosine = outgoing.dot(facet).clamp(0.0, 1.0);
    let (share, refracted_cosine) = fresnel::dielectric(cosine, eta);
    let down = (cosine / eta - refracted_cosine) * facet - outgoing / eta;
    let refracted = if down.z < 0.0 { ggx.masking(-down.normalize()) } else { 0.0 };
    share * reflected(ggx, outgoing, facet) + if share < 1.0 { (1.0 - share) * refracted } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALPHAS: [f32; 5] = [0.003, 0.07, 0.33, 0.83, 1.0];
    const COSINES: [f32; 8] = [0.004, 0.03, 0.1, 0.21, 0.47, 0.7, 0.93, 1.0];

    /// Worst error of tables for one roughness and for all, by an integral with many more samples.
    fn worst_errors(tables: impl Fn(f32) -> [FacetAlbedo; 2], exact: impl Fn(f32, f32) -> f32) -> [f32; 2] {
        let mut worst = [0.0_f32; 2];
        for alpha in ALPHAS {
            let tables = tables(alpha);
            for cosine in COSINES {
                let exact = exact(alpha, cosine);
                for (worst, table) in worst.iter_mut().zip(&tables) {
                    *worst = worst.max((table.directional(alpha, cosine) / exact - 1.0).abs());
                }
            }
        }
        worst
    }

    #[test]
    fn the_tables_of_metal_agree_with_a_finer_integral() {
        let all = FacetAlbedo::new(None, reflected);
        let tables = |alpha| [FacetAlbedo::new(Some(alpha), reflected), all.clone()];
        let worst = worst_errors(tables, |alpha, cosine| integrate(alpha, cosine, 20_000, reflected));
        eprintln!("albedo of metal: worst relative errors, one roughness and all: {worst:.5?}");
        assert!(worst[0] < 4e-3 && worst[1] < 1e-2, "{worst:?}");
    }

    #[test]
    fn the_tables_of_glass_agree_with_a_finer_integral() {
        for eta in [1.5, 1.0 / 1.5] {
            let kept = |ggx, outgoing, facet| sent_on(ggx, outgoing, facet, eta);
            let all = FacetAlbedo::new(None, kept);
            let tables = |alpha| [FacetAlbedo::new(Some(alpha), kept), all.clone()];
            let worst = worst_errors(tables, |alpha, cosine| integrate(alpha, cosine, 10_000, kept));
            eprintln!("albedo of glass {eta}: worst relative errors, one roughness and all: {worst:.5?}");
            assert!(worst[0] < 6e-3 && worst[1] < 1.5e-2, "{eta}: {worst:?}");
        }
    }
}
