//! A clear coat takes what it reflects from what lies below, and samples the density it claims.

use glam::{Vec2, Vec3};

use super::Bsdf;
use super::chi_square::{Random, p_value};
use crate::interaction::Interaction;
use crate::material::{ClearCoat, Colour, Grey, Material, Surface};

fn constant(value: f32) -> Colour {
    Colour::constant(Vec3::splat(value))
}

/// Surfaces of reflectance `value` that a coat may lie on.
fn surfaces(value: f32) -> Vec<Material> {
    let surfaces = [
        Surface::Diffuse { reflectance: constant(value) },
        Surface::Mirror { reflectance: constant(value) },
        Surface::Conductor { reflectance: constant(value), alpha: 0.3 },
        Surface::Coated { diffuse: constant(value), specular: constant(0.04), alpha: 0.5 },
    ];
    surfaces.map(|surface| Material::new("below", surface, Vec3::ZERO)).into()
}

fn coated(material: &Material, cover: f32, roughness: f32) -> Material {
    let mut coated = material.clone();
    coated.maps.clear_coat = Some(ClearCoat::even(cover, roughness));
    coated
}

/// The surface seen from `outgoing`; its shading normal and that of its coat are `normals`.
fn seen(material: &Material, normals: [Vec3; 2], outgoing: Vec3) -> Bsdf {
    let facing = Interaction::facing(Vec3::ZERO, Vec3::Z, material);
    Bsdf::at(&Interaction { shading_normal: normals[0], coat_normal: normals[1], outgoing, distance: 1.0, ..facing })
}

fn towards(cosine: f32) -> Vec3 {
    Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
}

/// Mean weight of samples over a midpoint grid; every choice takes its turn.
fn albedo(bsdf: &Bsdf) -> f32 {
    const SIDE: usize = 160;
    let weight = |i: usize| {
        let u = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
        let choice = (i * 7919 % 1021) as f32 / 1021.0;
        bsdf.sample_direction(choice, u).map_or(0.0, |sample| f64::from(sample.weight.x))
    };
    ((0..SIDE * SIDE).map(weight).sum::<f64>() / (SIDE * SIDE) as f64) as f32
}

/// The white furnace: whatever is white stays so below a coat.
#[test]
fn white_surfaces_lose_no_light_below_a_clear_coat() {
    for roughness in [0.0, 0.1, 0.3, 0.6, 0.8, 1.0] {
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for (material, cover) in surfaces(1.0).iter().flat_map(|material| [(material, 0.4), (material, 1.0)]) {
            let material = coated(material, cover, roughness);
            for cosine in [0.05, 0.2, 0.4, 0.65, 0.9, 1.0] {
                let found = albedo(&seen(&material, [Vec3::Z; 2], towards(cosine)));
                range = [range[0].min(found), range[1].max(found)];
            }
        }
        eprintln!("white furnace below a clear coat, roughness {roughness}: {range:.4?}");
        assert!(range[0] > 0.995 && range[1] < 1.005, "{roughness}: {range:?}");
    }
}

#[test]
fn a_clear_coat_reflects_as_glass_does_over_what_is_black() {
    for material in surfaces(0.0).iter().take(1) {
        for (cosine, cover) in [(1.0, 1.0), (0.5, 1.0), (0.5, 0.5)] {
            // Schlick's approximation of a smooth interface.
            let expected = cover * (0.04 + 0.96 * (1.0_f32 - cosine).powi(5));
            let found = albedo(&seen(&coated(material, cover, 0.0), [Vec3::Z; 2], towards(cosine)));
            assert!((found - expected).abs() < 2e-3, "{cosine} {cover}: {found} {expected}");
        }
    }
}

/// What the coat passes on is bright by the same share from wherever the light comes.
#[test]
fn what_lies_below_is_darkened_by_what_the_coat_reflects() {
    let [bare, ..] = &surfaces(0.5)[..] else { unreachable!() };
    for cosine in [0.1, 0.5, 1.0] {
        let of_coat = albedo(&seen(&coated(&surfaces(0.0)[0], 1.0, 0.4), [Vec3::Z; 2], towards(cosine)));
        let both = seen(&coated(bare, 1.0, 0.4), [Vec3::Z; 2], towards(cosine));
        assert!((albedo(&both) - (of_coat + 0.5 * (1.0 - of_coat))).abs() < 4e-3, "{cosine}");
        assert!((both.even_albedo().unwrap().x - 0.5 * (1.0 - of_coat)).abs() < 4e-3, "{cosine}");
        let incoming = Vec3::new(-0.3, 0.5, 0.66_f32.sqrt());
        let even = both.even_share(incoming) * both.evaluate(incoming);
        let expected = both.even_albedo().unwrap() * incoming.z / std::f32::consts::PI;
        assert!((even - expected).length() < 1e-4, "{cosine}: {even} {expected}");
    }
}

#[test]
fn a_coat_that_covers_nothing_is_none() {
    for material in surfaces(0.7).iter().filter(|material| !matches!(material.surface, Surface::Mirror { .. })) {
        let [bare, covered] = [material, &coated(material, 0.0, 0.2)].map(|m| seen(m, [Vec3::Z; 2], towards(0.4)));
        let incoming = Vec3::new(-0.3, 0.5, 0.66_f32.sqrt());
        assert_eq!(bare.evaluate(incoming), covered.evaluate(incoming));
        assert_eq!((bare.direction_pdf(incoming), bare.albedo()), (covered.direction_pdf(incoming), covered.albedo()));
        assert_eq!(bare.is_diffuse(), covered.is_diffuse());
    }
    let half = coated(&surfaces(0.5)[0], 1.0, 0.2);
    assert!(!seen(&half, [Vec3::Z; 2], Vec3::Z).is_diffuse());
}

#[test]
fn glass_takes_no_clear_coat() {
    let glass = Surface::Glass { ior: 1.5, transmittance: constant(1.0), alpha: 0.0 };
    let glass = coated(&Material::new("glass", glass, Vec3::ZERO), 1.0, 0.0);
    let pane = seen(&glass, [Vec3::Z; 2], Vec3::Z);
    assert!(pane.is_specular() && super::may_be_specular(&glass));
    assert!(pane.sample_direction(0.01, Vec2::ZERO).unwrap().pdf.is_none() && pane.albedo() == Vec3::ONE);
    assert_eq!(pane.evaluate(Vec3::Z), Vec3::ZERO);
    let mirror = coated(&surfaces(1.0)[1], 1.0, 0.0);
    assert!(!seen(&mirror, [Vec3::Z; 2], Vec3::Z).is_specular() && !super::may_be_specular(&mirror));
}

/// Both where the normals are one and where they are not.
#[test]
fn directions_are_chosen_by_the_density_that_is_claimed() {
    let tilted = Vec3::new(0.6, 0.0, 0.8);
    for (material, roughness) in surfaces(0.6).iter().zip([0.4, 0.7, 0.6, 0.5]) {
        if matches!(material.surface, Surface::Mirror { .. }) {
            continue;
        }
        let material = coated(material, 0.9, roughness);
        for normals in [[Vec3::Z, Vec3::Z], [tilted, Vec3::Z], [Vec3::Z, tilted]] {
            for outgoing in [towards(0.3), Vec3::new(-0.48, 0.36, 0.8)] {
                let bsdf = seen(&material, normals, outgoing);
                let sample = |random: &mut Random| {
                    let choice = random.next();
                    bsdf.sample_direction(choice, random.point()).map(|sample| sample.direction)
                };
                let p = p_value(|incoming| bsdf.direction_pdf(incoming), sample);
                // 18 tests, as in `sampling_tests`.
                assert!(p > 1e-4, "{material:?} {normals:?} {outgoing}: p = {p}");
            }
        }
    }
}

#[test]
fn a_coat_mirrors_about_its_own_normal() {
    let tilted = Vec3::new(0.6, 0.0, 0.8);
    let smooth = coated(&surfaces(0.0)[0], 1.0, 0.0);
    // The relief of what lies below does not show, and the horizon of that hides nothing.
    let bsdf = seen(&smooth, [tilted, Vec3::Z], Vec3::new(0.8, 0.0, 0.6));
    let mirrored = Vec3::new(-0.8, 0.0, 0.6);
    assert!(tilted.dot(mirrored) < 0.2 && bsdf.is_reached_from(mirrored) && bsdf.evaluate(mirrored).x > 1.0);
    assert!(bsdf.is_reached_from(Vec3::new(-0.96, 0.0, 0.28)) && bsdf.receiver().two_sided);
    assert!(!bsdf.is_reached_from(Vec3::new(0.9, 0.0, -0.1).normalize()));
    // Its own does.
    let bsdf = seen(&smooth, [Vec3::Z, tilted], Vec3::Z);
    let about = 2.0 * tilted.z * tilted - Vec3::Z;
    assert!(bsdf.evaluate(about).x > 1.0 && bsdf.evaluate(Vec3::Z).x < 1e-3);
}

/// Mirrored light that would come from below the surface is not lost.
#[test]
fn a_coat_turned_away_from_the_surface_is_not_black() {
    let smooth = coated(&surfaces(1.0)[0], 1.0, 0.0);
    for angle in 0..40 {
        let (sin, cos) = (0.04 * angle as f32 - 0.8).sin_cos();
        for outgoing in [towards(0.1), towards(0.5), Vec3::Z] {
            let found = albedo(&seen(&smooth, [Vec3::Z, Vec3::new(sin, 0.0, cos)], outgoing));
            assert!((found - 1.0).abs() < 0.02, "{angle} {outgoing}: {found}");
        }
    }
}

#[test]
fn maps_say_where_a_coat_is() {
    let texture = std::sync::Arc::new(crate::texture::GreyTexture::new(1, 1, vec![0.5]));
    let mut material = surfaces(0.0).remove(0);
    let roughness = Grey { factor: 0.8, texture: Some(texture.clone()) };
    material.maps.clear_coat =
        Some(ClearCoat { cover: Grey { factor: 1.0, texture: Some(texture) }, roughness, normals: None });
    let [mapped, same] = [&material, &coated(&surfaces(0.0)[0], 0.5, 0.4)].map(|m| seen(m, [Vec3::Z; 2], towards(0.7)));
    let incoming = Vec3::new(-0.6, 0.0, 0.8);
    assert_eq!((mapped.evaluate(incoming), mapped.albedo()), (same.evaluate(incoming), same.albedo()));
}
