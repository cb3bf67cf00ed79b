//! Whether two scenes are the same, told by a few digits.

use std::sync::Arc;

use glam::Vec3;
use rustc_hash::FxHashMap;

use super::mesh::Mesh;
use super::placed::Placed;
use super::{Dropped, Scene};
use crate::digest::Digest;
use crate::material::{ClearCoat, Colour, Grey, Material, Surface, SurfaceMaps, Tinted};
use crate::texture::{GreyTexture, Raster, Texture};

/// Digests of what a scene consists of. Equal scenes have equal ones, wherever their files are and whatever they are
/// called.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Fingerprint {
    /// Meshes, where they stand and how they move.
    pub geometry: String,
    /// Materials and their textures.
    pub materials: String,
    /// Lights that no ray can hit.
    pub lights: String,
    /// The sky; `None` without one.
    pub sky: Option<String>,
}

impl Scene {
    /// What tells it from other scenes.
    pub fn fingerprint(&self) -> Fingerprint {
        // Emitters, bounds and trees follow from the rest.
        let mut lights = Digest::new();
        self.delta_lights.iter().for_each(|light| lights.debug(light));
        let sky = self.environment.as_ref().map(|sky| {
            let mut digest = Digest::new();
            sky.digest(&mut digest);
            digest.text()
        });
        Fingerprint { geometry: self.geometry(), materials: self.surfaces(), lights: lights.text(), sky }
    }

    fn geometry(&self) -> String {
        let mut digest = Digest::new();
        digest.length(self.meshes.len());
        self.meshes.iter().for_each(|indexed| add_mesh(&mut digest, &indexed.mesh));
        for Placed { mesh, placement, moving, bounds: _, emitters: _ } in &self.placed {
            digest.debug(&(mesh, placement, moving));
        }
        let Dropped { degenerate, not_finite } = self.dropped;
        digest.debug(&(degenerate, not_finite));
        digest.text()
    }

    fn surfaces(&self) -> String {
        let mut surfaces = Surfaces { digest: Digest::new(), textures: FxHashMap::default() };
        self.materials.iter().for_each(|material| surfaces.material(material));
        surfaces.digest.text()
    }
}

fn add_mesh(digest: &mut Digest, mesh: &Mesh) {
    let Mesh { positions, normals, uvs, further_uvs, colours, triangles, materials } = mesh;
    [positions.len(), normals.len(), uvs.len(), triangles.len()].into_iter().for_each(|length| digest.length(length));
    // Only where there are any, so that the digests of scenes without stay what they were.
    if !colours.is_empty() {
        digest.length(colours.len());
    }
    if !further_uvs.is_empty() {
        digest.debug(&"further texture coordinates");
        further_uvs.iter().for_each(|uv| digest.numbers(uv.as_ref()));
    }
    positions.iter().chain(normals).for_each(|v| digest.numbers(v.as_ref()));
    uvs.iter().for_each(|uv| digest.numbers(uv.as_ref()));
    colours.iter().for_each(|colour| digest.numbers(colour.as_ref()));
    triangles.iter().flatten().chain(materials).for_each(|index| digest.word(*index));
}

/// Materials under way.
struct Surfaces {
    digest: Digest,
    /// Digests of textures, which many materials may share, by where they lie.
    textures: FxHashMap<usize, u64>,
}

impl Surfaces {
    fn material(&mut self, material: &Material) {
        let Material { name: _, surface, emission, maps } = material;
        self.surface(surface);
        self.colour(emission);
        let SurfaceMaps {
            opacity,
            cutoff,
            normals,
            roughness,
            metallic,
            clear_coat,
            absorption,
            specular,
            see_through,
            tinted,
            ..
        } = maps;
        for grey in [opacity, metallic] {
            self.digest.debug(&grey.is_some());
            grey.iter().for_each(|grey| self.grey(grey));
        }
        // Only where there is something to say, so that the digests of other materials stay what they were.
        if let Some(cutoff) = cutoff {
            self.digest.debug(&("cutoff", cutoff.to_bits()));
        }
        if *tinted != Tinted::default() {
            self.digest.debug(tinted);
        }
        if *absorption != Vec3::ZERO {
            self.digest.debug(&"absorption");
            self.digest.numbers(absorption.as_ref());
        }
        if specular.is_some() {
            self.digest.debug(&"specular");
            self.grey_texture(specular.as_ref());
        }
        if let Some(see_through) = see_through {
            self.digest.debug(&"see-through");
            self.grey(&see_through.share);
            self.material(&see_through.glass);
        }
        if let Some(ClearCoat { cover, roughness, normals }) = clear_coat {
            self.digest.debug(&"clear coat");
            [cover, roughness].into_iter().for_each(|grey| self.grey(grey));
            self.texture(normals.as_ref());
        }
        self.texture(normals.as_ref());
        self.grey_texture(roughness.as_ref());
    }

    fn surface(&mut self, surface: &Surface) {
        let (kind, numbers, colours) = match surface {
            Surface::Diffuse { reflectance } => ("diffuse", [0.0; 2], vec![reflectance]),
            Surface::Mirror { reflectance } => ("mirror", [0.0; 2], vec![reflectance]),
            Surface::Glass { ior, transmittance, alpha } => ("glass", [*ior, *alpha], vec![transmittance]),
            Surface::ThinGlass { ior, transmittance, alpha } => ("thin glass", [*ior, *alpha], vec![transmittance]),
            Surface::Conductor { reflectance, alpha } => ("conductor", [*alpha, 0.0], vec![reflectance]),
            Surface::Coated { diffuse, specular, alpha } => ("coated", [*alpha, 0.0], vec![diffuse, specular]),
        };
        self.digest.debug(&kind);
        self.digest.numbers(&numbers);
        colours.into_iter().for_each(|colour| self.colour(colour));
    }

    fn colour(&mut self, Colour { factor, texture }: &Colour) {
        self.digest.numbers(factor.as_ref());
        self.texture(texture.as_ref());
    }

    fn grey(&mut self, Grey { factor, texture }: &Grey) {
        self.digest.numbers([factor]);
        self.grey_texture(texture.as_ref());
    }

    fn texture(&mut self, texture: Option<&Arc<Texture>>) {
        self.raster(texture, |texel, digest| digest.numbers(texel));
    }

    fn grey_texture(&mut self, texture: Option<&Arc<GreyTexture>>) {
        self.raster(texture, |texel, digest| digest.numbers([texel]));
    }

    fn raster<T>(&mut self, raster: Option<&Arc<Raster<T>>>, add: impl Fn(&T, &mut Digest)) {
        let Some(raster) = raster else { return self.digest.debug(&"none") };
        let number = *self.textures.entry(Arc::as_ptr(raster) as usize).or_insert_with(|| {
            let Raster { width, height, texels, map, offset, wrap, set, range: _ } = &**raster;
            let mut digest = Digest::new();
            digest.debug(&(width, height, map, offset, wrap));
            if *set != 0 {
                digest.debug(&("set", set));
            }
            texels.iter().for_each(|texel| add(texel, &mut digest));
            digest.number()
        });
        self.digest.debug(&number);
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec2, Vec3, Vec4};

    use super::super::{Instance, Motion, Placement};
    use super::*;
    use crate::environment::{Environment, EnvironmentMap};
    use crate::light::DeltaLight;

    /// Two triangles of a textured material, one of them moving, under a sky.
    struct Plan {
        mesh: Mesh,
        material: Material,
        motion: Option<Motion>,
        sky: Option<Environment>,
        lamp: f32,
    }

    fn plan() -> Plan {
        let texture = Arc::new(Texture::new(2, 1, vec![[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]));
        let reflectance = Colour { factor: Vec3::ONE, texture: Some(texture) };
        let motion = Motion { translate: DVec3::X, turn: DVec3::ZERO, centre: DVec3::ZERO };
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            triangles: vec![[0, 1, 2]],
            materials: vec![0],
            ..Mesh::default()
        };
        Plan {
            mesh,
            material: Material::new("wall", Surface::Diffuse { reflectance }, Vec3::ZERO),
            motion: Some(motion),
            sky: Some(Environment::mapped(EnvironmentMap::new(1, 1, vec![[1.0; 3]]))),
            lamp: 1.0,
        }
    }

    fn fingerprint(change: impl FnOnce(&mut Plan)) -> Fingerprint {
        let mut plan = plan();
        change(&mut plan);
        let Plan { mesh, material, motion, sky, lamp } = plan;
        let stands = [motion, None].map(|motion| Instance { mesh: 0, placement: Placement::IDENTITY, motion });
        let mut scene = Scene::new(vec![mesh], stands.to_vec(), vec![material], sky).unwrap();
        scene.delta_lights.push(DeltaLight::Point { position: Vec3::Y, intensity: Vec3::splat(lamp) });
        scene.fingerprint()
    }

    #[test]
    fn what_changes_the_picture_changes_the_part_that_it_is_in() {
        let plain = fingerprint(|_| ());
        assert_eq!(plain, fingerprint(|plan| plan.material.name = "floor".into()), "a name is not seen");
        let geometry = [
            fingerprint(|plan| plan.mesh.positions[2].y = 1.0f32.next_up()),
            fingerprint(|plan| plan.mesh.uvs[1].x = 0.5),
            fingerprint(|plan| plan.mesh.further_uvs = plan.mesh.uvs.clone()),
            fingerprint(|plan| plan.mesh.triangles[0] = [0, 2, 1]),
            fingerprint(|plan| plan.mesh.colours = vec![Vec4::splat(0.5); 3]),
            fingerprint(|plan| plan.motion = None),
        ];
        for changed in geometry {
            assert_ne!(changed.geometry, plain.geometry);
            assert_eq!(Fingerprint { geometry: plain.geometry.clone(), ..changed }, plain);
        }
        let dull = |texels| {
            let texture = Some(Arc::new(Texture::new(2, 1, texels)));
            Surface::Diffuse { reflectance: Colour { factor: Vec3::ONE, texture } }
        };
        let materials = [
            fingerprint(|plan| plan.material.surface = dull(vec![[0.1, 0.2, 0.3], [0.4, 0.5, 0.7]])),
            fingerprint(|plan| plan.material.emission.factor = Vec3::Z),
            fingerprint(|plan| plan.material.maps.opacity = Some(Grey::constant(0.5))),
            fingerprint(|plan| plan.material.maps.cutoff = Some(0.5)),
            fingerprint(|plan| plan.material.maps.metallic = Some(Grey::constant(0.5))),
            fingerprint(|plan| plan.material.maps.tinted = Tinted::Nothing),
            fingerprint(|plan| plan.material.maps.clear_coat = Some(ClearCoat::even(0.5, 0.0))),
            fingerprint(|plan| plan.material.maps.clear_coat = Some(ClearCoat::even(0.5, 0.1))),
            fingerprint(|plan| plan.material.maps.roughness = Some(Arc::new(GreyTexture::new(1, 1, vec![0.5])))),
        ];
        for (i, changed) in materials.iter().enumerate() {
            assert!(changed.materials != plain.materials && materials[..i].iter().all(|other| other != changed), "{i}");
            assert_eq!(Fingerprint { materials: plain.materials.clone(), ..changed.clone() }, plain);
        }
        assert_ne!(fingerprint(|plan| plan.lamp = 2.0).lights, plain.lights);
        let skies = [
            fingerprint(|plan| plan.sky = None),
            fingerprint(|plan| plan.sky = plan.sky.take().map(|sky| sky.scaled(2.0))),
            fingerprint(|plan| plan.sky = plan.sky.take().map(|sky| sky.turned_to(90.0))),
            fingerprint(|plan| plan.sky = Some(Environment::constant(Vec3::ONE))),
            fingerprint(|plan| {
                plan.sky = Some(Environment::mapped(EnvironmentMap::new(1, 1, vec![[1.0, 1.0, 2.0]])));
            }),
        ];
        for (i, changed) in skies.iter().enumerate() {
            assert!(changed.sky != plain.sky && skies[..i].iter().all(|other| other.sky != changed.sky), "{i}");
        }
    }
}
