//! From MTL to [`Material`]. MTL has no physics; `docs/scene-format.md` says how its statements are read.
//!
//! Roughness α is `Pr`², else √(2/(`Ns`+2)): the width of Phong's lobe (Walter et al. 2007, section 5.1, with equal
//! exponents of the lobe and of the half vector). Diffuse and specular reflectance together are scaled to at most 1, as
//! a surface cannot reflect more than it gets, where no part of it is metal.

use glam::Vec3;

use super::super::look::{COMMON_COAT, capped, coated, metal};
use super::super::notes::Notes;
use super::super::textures::{TextureFiles, TextureUse};
use super::entry::MtlEntry;
use crate::material::{Colour, Material, Surface, Tinted};

impl MtlEntry {
    /// The material; without its textures when there is nobody to read them.
    pub(super) fn material(&self, mut read: Option<(&mut TextureFiles, &mut Notes)>) -> Material {
        let mut texture = |colour: Colour, line: &Option<TextureUse>| match (line, &mut read) {
            (Some(line), Some((files, notes))) => self.textured(colour, line, files, notes),
            _ => colour,
        };
        let diffuse = texture(Colour::constant(self.diffuse_factor()), &self.diffuse_map);
        let specular = texture(Colour::constant(self.specular_factor()), &self.specular_map);
        let emission = texture(Colour::constant(self.emission_factor()), &self.emission_map);
        if let Some((_, notes)) = &mut read {
            self.note_ignored(notes);
        }
        let is_mapped = diffuse.texture.is_some();
        let surface = self.surface(diffuse, specular);
        let mut maps = self.maps(read);
        if matches!(surface, Surface::Diffuse { .. }) {
            // Where nothing says how wide its highlights are, it has none, and no metal.
            maps.metallic = None;
        }
        if is_mapped {
            // Scanners write the same colours twice.
            maps.tinted = Tinted::Nothing;
        }
        Material { name: self.name.clone(), surface, emission, maps }
    }

    fn textured(&self, colour: Colour, line: &TextureUse, files: &mut TextureFiles, notes: &mut Notes) -> Colour {
        match files.colours(line) {
            Ok(texture) => Colour { texture: Some(texture), ..colour },
            Err(why) => {
                notes.add_missing_texture(format!("material '{}': {why}; its colour is used", self.name));
                colour
            }
        }
    }

    fn note_ignored(&self, notes: &mut Notes) {
        for key in &self.ignored {
            notes.add(format!("material '{}': {key} is not supported and ignored", self.name));
        }
        if self.opacity.is_some_and(|d| d <= 0.0) && self.opacity_map.is_none() && !self.is_glass() {
            notes
                .add(format!("material '{}': nothing of it would be seen with d 0; it is taken for opaque", self.name));
        }
    }

    /// `Kd`. Black in front of a texture is a habit of exporters, not a wish.
    fn diffuse_factor(&self) -> Vec3 {
        let unsaid = if self.diffuse_map.is_some() { Vec3::ONE } else { Vec3::splat(0.5) };
        let said = self.diffuse.filter(|&kd| kd != Vec3::ZERO || self.diffuse_map.is_none());
        // A material that only shines or only reflects is black otherwise.
        let other = self.emission.is_some() || self.specular.is_some_and(|ks| ks != Vec3::ZERO);
        said.unwrap_or(if other && self.diffuse_map.is_none() { Vec3::ZERO } else { unsaid })
    }

    fn specular_factor(&self) -> Vec3 {
        self.specular.unwrap_or(if self.specular_map.is_some() { Vec3::ONE } else { Vec3::ZERO })
    }

    fn emission_factor(&self) -> Vec3 {
        self.emission.unwrap_or(if self.emission_map.is_some() { Vec3::ONE } else { Vec3::ZERO })
    }

    pub(super) fn is_glass(&self) -> bool {
        let transparent = self.opacity.is_some_and(|d| d < 1.0) && self.ior.is_some() && self.opacity_map.is_none();
        transparent || matches!(self.model, Some(4 | 6 | 7 | 9))
    }

    /// GGX α, where the material says anything about it.
    fn alpha(&self) -> Option<f32> {
        let alpha = self.roughness_alpha().or(self.shininess.filter(|&ns| ns > 0.0).map(alpha_of_phong));
        alpha.map(|alpha| alpha.clamp(0.0, 1.0))
    }

    /// α by `Pr`. A zero in front of a texture is a habit of exporters.
    fn roughness_alpha(&self) -> Option<f32> {
        let mapped = self.roughness_map.is_some();
        let said = self.roughness.filter(|&pr| pr > 0.0 || !mapped).or(mapped.then_some(1.0));
        said.map(|pr| (pr * pr).clamp(0.0, 1.0))
    }

    fn surface(&self, diffuse: Colour, specular: Colour) -> Surface {
        let has = |colour: &Colour| colour.factor != Vec3::ZERO;
        if self.metallic.is_some_and(|pm| pm >= 1.0) && self.metallic_map.is_none() {
            return metal(if has(&diffuse) { diffuse } else { specular }, self.alpha());
        }
        if self.model == Some(5) {
            return Surface::Mirror { reflectance: capped(if has(&specular) { specular } else { diffuse }) };
        }
        if self.is_glass() {
            let tint = Colour::constant(self.filter.unwrap_or(Vec3::ONE));
            let ior = self.ior.filter(|&ni| ni > 0.0).unwrap_or(1.5);
            // `Ns` is the width of highlights, which clear glass has, too.
            let (transmittance, alpha) = (capped(tint), self.roughness_alpha().unwrap_or(0.0));
            return match self.model {
                Some(4 | 9) => Surface::ThinGlass { ior, transmittance, alpha },
                _ => Surface::Glass { ior, transmittance, alpha },
            };
        }
        if matches!(self.model, None | Some(3 | 8)) && has(&specular) && !has(&diffuse) {
            return metal(specular, self.alpha());
        }
        self.opaque(diffuse, specular)
    }

    fn opaque(&self, diffuse: Colour, specular: Colour) -> Surface {
        let metal = self.is_partly_metal();
        let has_roughness = self.roughness.is_some() || self.roughness_map.is_some();
        let shows_highlights = !matches!(self.model, Some(0 | 1)) || has_roughness || self.metallic_map.is_some();
        let common = specular.factor == Vec3::ZERO && (has_roughness || metal);
        let specular = if common { Colour::constant(Vec3::splat(COMMON_COAT)) } else { specular };
        match self.alpha().or(self.metallic_map.is_some().then_some(1.0)) {
            // Where there is metal, `Kd` is its reflectance, and no share beside that of the coat.
            Some(alpha) if shows_highlights && metal => {
                Surface::Coated { diffuse: capped(diffuse), specular: capped(specular), alpha }
            }
            Some(alpha) if shows_highlights && specular.factor != Vec3::ZERO => coated(diffuse, specular, alpha),
            _ => Surface::Diffuse { reflectance: capped(diffuse) },
        }
    }

    /// Whether a part of it may be metal.
    fn is_partly_metal(&self) -> bool {
        self.metallic_map.is_some() || self.metallic.is_some_and(|pm| pm > 0.0)
    }
}

/// GGX α of the width of Phong's lobe.
pub(super) fn alpha_of_phong(exponent: f32) -> f32 {
    (2.0 / (exponent + 2.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::entry::parse;
    use super::*;

    fn convert(statements: &str) -> Material {
        parse(&format!("newmtl m\n{statements}"), Path::new("m.mtl")).unwrap()[0].material(None)
    }

    fn constant(colour: &Colour) -> [f32; 3] {
        colour.factor.to_array()
    }

    #[test]
    fn conventions_of_models_are_followed() {
        let surface = |statements| convert(statements).surface;
        let grey = [0.5; 3];
        assert!(matches!(surface("Kd .5 .5 .5"), Surface::Diffuse { reflectance } if constant(&reflectance) == grey));
        assert!(matches!(surface("Kd .5"), Surface::Diffuse { reflectance } if constant(&reflectance) == grey));
        assert!(matches!(surface(""), Surface::Diffuse { reflectance } if constant(&reflectance) == grey));
        assert!(
            matches!(surface("Kd 9 0 0\nKs 0 0 0\nNs 9"), Surface::Diffuse { reflectance } if constant(&reflectance) == [1.0, 0.0, 0.0])
        );
        assert!(matches!(surface("Kd 1 1 1\nKs 1 1 1\nNs 9\nillum 1"), Surface::Diffuse { .. }));
        assert!(
            matches!(surface("Ks .5 .5 .5\nillum 5"), Surface::Mirror { reflectance } if constant(&reflectance) == grey)
        );
        assert!(matches!(surface("Kd 0 0 0\nKs 1 1 1\nNs 198\nillum 3"), Surface::Conductor { alpha: 0.1, .. }));
        assert!(matches!(surface("Kd 0 0 0\nKs 1 1 1\nillum 3"), Surface::Mirror { .. }));
        assert!(
            matches!(surface("Ks .5 .5 .5"), Surface::Mirror { reflectance } if constant(&reflectance) == grey),
            "nothing but a highlight is no black thing"
        );
        assert!(matches!(surface("Kd 0 0 0\nKs 1 1 1\nNs 198"), Surface::Conductor { alpha: 0.1, .. }));
        assert!(matches!(surface("Kd .1 0 0\nKs 1 1 1"), Surface::Diffuse { .. }));
        assert!(matches!(surface("Kd 1 .5 0\nPm 1\nPr .5"), Surface::Conductor { alpha: 0.25, .. }));
    }

    #[test]
    fn glass_is_told_by_model_or_by_dissolve_with_an_index() {
        for statements in ["illum 7\nNi 1.3\nTf .2 .3 .4", "d 0.1\nNi 1.3\nTf .2 .3 .4", "Tr .9\nNi 1.3\nTf .2 .3 .4"] {
            let Surface::Glass { ior: 1.3, transmittance, alpha: 0.0 } = convert(statements).surface else {
                panic!("{statements}")
            };
            assert_eq!(constant(&transmittance), [0.2, 0.3, 0.4]);
        }
        assert!(matches!(convert("illum 6\nPr .5").surface, Surface::Glass { alpha: 0.25, .. }));
        for (pane, rough) in [("illum 4\nNi 1.3\nNs 9", 0.0), ("illum 9\nNi 1.3\nPr .5", 0.25)] {
            assert!(
                matches!(convert(pane).surface, Surface::ThinGlass { ior: 1.3, alpha, .. } if alpha == rough),
                "{pane}"
            );
        }
        for opaque in ["d 0.1", "d 1\nTr 1\nNi 1.5", "Tr 1\nd 1\nNi 1.5", "Ni 1.5"] {
            assert!(matches!(convert(opaque).surface, Surface::Diffuse { .. }), "{opaque}");
        }
        let opacity = |statements| convert(statements).maps.opacity.map(|o| o.factor);
        assert_eq!(
            [opacity("d 0.1"), opacity("Tr .25"), opacity("d 1"), opacity("d .1\nNi 2")],
            [Some(0.1), Some(0.75), None, None]
        );
    }

    #[test]
    fn a_coat_reflects_no_more_than_comes_in() {
        let Surface::Coated { diffuse, specular, alpha } = convert("Kd .6 .2 0\nKs 1 1 1\nNs 48 shiny").surface else {
            panic!("no coat")
        };
        assert_eq!(alpha, 0.2);
        assert!((diffuse.factor + specular.factor).max_element() <= 1.0);
        assert!((specular.factor.x - 0.625).abs() < 1e-6);
    }

    #[test]
    fn what_is_metal_in_part_keeps_its_colour_for_the_metal() {
        let nearly = convert("Kd 1 .5 0\nKs .5 .5 .5\nPm .996\nPr 1");
        assert_eq!(nearly.maps.metallic.map(|metallic| metallic.factor), Some(0.996));
        let Surface::Coated { diffuse, specular, alpha: 1.0 } = nearly.surface else { panic!("no coat") };
        assert_eq!((constant(&diffuse), constant(&specular)), ([1.0, 0.5, 0.0], [0.5; 3]));
        assert!(convert("Pm .5").maps.metallic.is_none() && convert("Pm 0\nPr 1").maps.metallic.is_none());
        assert!(convert("Pm 1\nPr 1").maps.metallic.is_none());
    }

    #[test]
    fn anything_can_emit() {
        let lamp = convert("Kd .78 .78 .78 # white\nKe 10 5 -2\nTr 0\nd 1");
        assert_eq!(lamp.emission.factor, Vec3::new(10.0, 5.0, 0.0));
        assert!(matches!(lamp.surface, Surface::Diffuse { .. }));
        assert_eq!(convert("illum 5\nKs 1 1 1\nKe 1 1 1").emission.factor, Vec3::ONE);
    }

    #[test]
    fn a_clear_coat_lies_over_what_is_no_glass() {
        let coat = |statements| {
            let coat = convert(statements).maps.clear_coat;
            coat.map(|coat| [coat.cover.factor, coat.roughness.factor])
        };
        assert_eq!(coat("Pc .5\nPcr .2"), Some([0.5, 0.2]));
        assert_eq!(coat("Pm 1\nPr .5\nPc 3"), Some([1.0, 0.0]));
        assert_eq!([coat("Pc 0\nPcr .2"), coat("Pcr .2"), coat("illum 7\nPc 1")], [None; 3]);
    }

    #[test]
    fn what_is_not_supported_is_said_unless_it_is_nothing() {
        let notes = |statements: &str| {
            let mut notes = Notes::default();
            let folder = Path::new("");
            let entries = parse(&format!("newmtl m\n{statements}"), Path::new("m.mtl")).unwrap();
            entries[0].material(Some((&mut TextureFiles::new(folder), &mut notes)));
            notes.into_lines()
        };
        assert_eq!(notes("Ps .5\naniso 1\nanisor 2").len(), 2);
        assert!(notes("Ps 0.0\naniso 0\nanisor 2").is_empty());
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        let refused = parse("newmtl a\nKd 1 x 1\n", Path::new("m.mtl")).unwrap_err();
        assert_eq!(refused.to_string(), "m.mtl:2: expected Kd and three numbers, found '1 x 1'");
        let refused = parse("newmtl a\n\nNs shiny\n", Path::new("m.mtl")).unwrap_err();
        assert_eq!(refused.to_string(), "m.mtl:3: expected Ns and a number, found 'shiny'");
    }
}
