//! The few numbers most renderers describe a surface with, and the surface they make.

use glam::Vec3;

use crate::material::{Colour, Grey, Surface};

/// A surface described by base colour, coat, roughness, metalness and transmission (as in Burley 2012, reduced). What is metal
/// in part is not: a coated surface, whose maps say how much of it is (see [`metalness`]).
#[derive(Clone, Debug)]
pub(super) struct Look {
    /// Colour of the diffuse base, of the metal, or tint of the glass.
    pub(super) base: Colour,
    /// Reflectance of the coat at normal incidence; black takes it off. `None` where nothing was said.
    pub(super) coat: Option<Colour>,
    /// GGX α; `None` where nothing was said.
    pub(super) alpha: Option<f32>,
    /// Whether all of it is metal.
    pub(super) metal: bool,
    /// 0 … 1; from one half on it is glass.
    pub(super) transmission: f32,
    /// Whether glass is a pane too thin to refract.
    pub(super) thin: bool,
    /// Refractive index.
    pub(super) ior: f32,
}

/// Reflectance at normal incidence of the common coat: glass of index 1.5.
pub(super) const COMMON_COAT: f32 = 0.04;

/// Below this α a metal is taken for a mirror.
const SMOOTH: f32 = 0.01;

impl Look {
    /// A look that makes `surface` again.
    pub(super) fn of(surface: &Surface) -> Self {
        let plain = |base: &Colour| Self {
            base: base.clone(),
            coat: None,
            alpha: None,
            metal: false,
            transmission: 0.0,
            thin: false,
            ior: 1.5,
        };
        match surface {
            Surface::Diffuse { reflectance } => plain(reflectance),
            Surface::Mirror { reflectance } => Self { metal: true, alpha: Some(0.0), ..plain(reflectance) },
            Surface::Conductor { reflectance, alpha } => {
                Self { metal: true, alpha: Some(*alpha), ..plain(reflectance) }
            }
            Surface::Glass { ior, transmittance, alpha } => {
                Self { transmission: 1.0, ior: *ior, alpha: Some(*alpha), ..plain(transmittance) }
            }
            Surface::ThinGlass { ior, transmittance, alpha } => {
                Self { transmission: 1.0, thin: true, ior: *ior, alpha: Some(*alpha), ..plain(transmittance) }
            }
            Surface::Coated { diffuse, specular, alpha } => {
                Self { coat: Some(specular.clone()), alpha: Some(*alpha), ..plain(diffuse) }
            }
        }
    }

    /// Sets the refractive index, and the coat to what Fresnel's equations give for it at normal incidence.
    pub(super) fn set_ior(&mut self, ior: f32) {
        self.ior = ior;
        let r = (ior - 1.0) / (ior + 1.0);
        self.coat = Some(Colour::constant(Vec3::splat(r * r)));
    }

    /// The surface, which may be metal in part. Roughness or metal bring the common coat, where nothing is said of one.
    pub(super) fn surface(self, partly_metal: bool) -> Surface {
        if self.transmission >= 0.5 {
            let (ior, transmittance, alpha) = (self.ior, capped(self.base), self.alpha.unwrap_or(0.0));
            return match self.thin {
                true => Surface::ThinGlass { ior, transmittance, alpha },
                false => Surface::Glass { ior, transmittance, alpha },
            };
        }
        if self.metal {
            return metal(self.base, self.alpha);
        }
        let coat = match self.coat {
            Some(coat) if coat.factor == Vec3::ZERO && !partly_metal => None,
            None if self.alpha.is_none() && !partly_metal => None,
            coat => Some(coat.unwrap_or(Colour::constant(Vec3::splat(COMMON_COAT)))),
        };
        let Some(coat) = coat else { return Surface::Diffuse { reflectance: capped(self.base) } };
        // The base is what light finds that the coat lets in: both may be bright.
        Surface::Coated { diffuse: capped(self.base), specular: capped(coat), alpha: self.alpha.unwrap_or(1.0) }
    }
}

/// Whether a surface of that metalness is all metal; else what its maps say of it, where a part of it is. Such a surface is a
/// coated one, for that is what may be metal in places.
pub(super) fn metalness(metallic: Grey) -> (bool, Option<Grey>) {
    let partly = metallic.texture.is_some() || (metallic.factor > 0.0 && metallic.factor < 1.0);
    (!partly && metallic.factor >= 1.0, partly.then_some(metallic))
}

/// A metal of reflectance `reflectance`; a mirror when it is hardly rough.
pub(super) fn metal(reflectance: Colour, alpha: Option<f32>) -> Surface {
    let reflectance = capped(reflectance);
    match alpha {
        Some(alpha) if alpha >= SMOOTH => Surface::Conductor { reflectance, alpha },
        _ => Surface::Mirror { reflectance },
    }
}

/// A diffuse base under a coat, whose reflectances are both shares of all light, as MTL has them: scaled so that together they
/// are no more than 1.
pub(super) fn coated(base: Colour, coat: Colour, alpha: f32) -> Surface {
    let scale = 1.0 / (base.factor + coat.factor).max_element().max(1.0);
    let scaled = |colour: Colour| Colour { factor: colour.factor * scale, ..colour };
    Surface::Coated { diffuse: scaled(base), specular: scaled(coat), alpha }
}

/// At most 1.
pub(super) fn capped(colour: Colour) -> Colour {
    Colour { factor: colour.factor.clamp(Vec3::ZERO, Vec3::ONE), ..colour }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_makes_the_surface_it_was_taken_from() {
        let c = |v: f32| Colour::constant(Vec3::splat(v));
        let surfaces = [
            Surface::Diffuse { reflectance: c(0.3) },
            Surface::Mirror { reflectance: c(0.9) },
            Surface::Conductor { reflectance: c(0.8), alpha: 0.2 },
            Surface::Glass { ior: 1.3, transmittance: c(0.7), alpha: 0.09 },
            Surface::ThinGlass { ior: 1.3, transmittance: c(0.7), alpha: 0.09 },
            Surface::Coated { diffuse: c(0.5), specular: c(0.04), alpha: 0.1 },
        ];
        for surface in surfaces {
            assert_eq!(format!("{:?}", Look::of(&surface).surface(false)), format!("{surface:?}"));
        }
    }

    #[test]
    fn a_base_keeps_its_colour_below_a_coat() {
        let mut look = Look::of(&Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) });
        look.alpha = Some(0.25);
        let Surface::Coated { diffuse, specular, .. } = look.surface(false) else { panic!("no coat") };
        assert_eq!((diffuse.factor, specular.factor), (Vec3::ONE, Vec3::splat(COMMON_COAT)));
    }

    #[test]
    fn a_coat_that_reflects_nothing_is_none() {
        let white = || Look::of(&Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) });
        let mut without = Look { alpha: Some(0.25), ..white() };
        without.set_ior(1.0);
        assert!(matches!(without.clone().surface(false), Surface::Diffuse { .. }));
        let Surface::Coated { specular, .. } = without.surface(true) else { panic!("metal in part is coated") };
        assert_eq!(specular.factor, Vec3::ZERO);
        assert!(
            matches!(white().surface(true), Surface::Coated { alpha: 1.0, specular, .. } if specular.factor.x == COMMON_COAT)
        );
    }

    #[test]
    fn glass_of_common_index_has_the_common_coat() {
        let mut look = Look::of(&Surface::Diffuse { reflectance: Colour::constant(Vec3::ONE) });
        look.set_ior(1.5);
        assert!((look.coat.unwrap().factor.x - COMMON_COAT).abs() < 1e-6);
    }
}
