//! One material of an MTL file, as written.

use std::path::Path;

use glam::Vec3;

use super::super::error::Place;
use super::super::source::logical_lines;
use super::super::textures::TextureUse;
use super::SceneError;
use super::texture_line;

/// One material of an MTL file, as written; what was not written is `None`.
#[derive(Debug, Default)]
pub(super) struct MtlEntry {
    pub(super) name: String,
    /// `Kd`
    pub(super) diffuse: Option<Vec3>,
    /// `Ks`
    pub(super) specular: Option<Vec3>,
    /// `Ke`
    pub(super) emission: Option<Vec3>,
    /// `Tf`
    pub(super) filter: Option<Vec3>,
    /// `Ns`
    pub(super) shininess: Option<f32>,
    /// `Ni`
    pub(super) ior: Option<f32>,
    /// `d`, or 1 − `Tr` where there is no `d`.
    pub(super) opacity: Option<f32>,
    /// `illum`
    pub(super) model: Option<u32>,
    /// `Pr`
    pub(super) roughness: Option<f32>,
    /// `Pm`
    pub(super) metallic: Option<f32>,
    /// `Pc`
    pub(super) clear_coat: Option<f32>,
    /// `Pcr`
    pub(super) clear_coat_roughness: Option<f32>,
    /// `map_Kd`
    pub(super) diffuse_map: Option<TextureUse>,
    /// `map_Ks`
    pub(super) specular_map: Option<TextureUse>,
    /// `map_Ke`
    pub(super) emission_map: Option<TextureUse>,
    /// `map_d`
    pub(super) opacity_map: Option<TextureUse>,
    /// `map_Pr`
    pub(super) roughness_map: Option<TextureUse>,
    /// `map_Ns`
    pub(super) shininess_map: Option<TextureUse>,
    /// `map_Pm`
    pub(super) metallic_map: Option<TextureUse>,
    /// `norm`
    pub(super) normal_map: Option<TextureUse>,
    /// `bump`, `map_Bump`
    pub(super) bump_map: Option<TextureUse>,
    /// Keys that would change the look but are not supported.
    pub(super) ignored: Vec<&'static str>,
}

/// Keys that would change the look but are not supported.
const IGNORED: [&str; 5] = ["disp", "map_tr", "refl", "map_ps", "map_pc"];

/// The same of keys that exporters write with a zero for materials without.
const UNLESS_ZERO: [&str; 2] = ["ps", "aniso"];

impl MtlEntry {
    /// A material that says nothing but its name.
    pub(super) fn new(name: String) -> Self {
        Self { name, ..Self::default() }
    }

    /// Takes in one statement. Keys are told apart ignoring case; unknown ones say nothing about light.
    fn set(&mut self, key: &str, value: &Value) -> Result<(), SceneError> {
        match key.to_ascii_lowercase().as_str() {
            "kd" => self.diffuse = Some(value.colour()?),
            "ks" => self.specular = Some(value.colour()?),
            "ke" => self.emission = Some(value.colour()?),
            "tf" => self.filter = Some(value.colour()?),
            "ns" => self.shininess = Some(value.number()?),
            "ni" => self.ior = Some(value.number()?),
            "d" => self.opacity = Some(value.dissolve()?),
            "tr" => self.opacity = self.opacity.or(Some(1.0 - value.number()?)),
            "illum" => self.model = Some(value.number()?.max(0.0) as u32),
            "pr" => self.roughness = Some(value.number()?),
            "pm" => self.metallic = Some(value.number()?),
            "pc" => self.clear_coat = Some(value.number()?),
            "pcr" => self.clear_coat_roughness = Some(value.number()?),
            "map_kd" => self.diffuse_map = texture_line::parse(value.text),
            "map_ks" => self.specular_map = texture_line::parse(value.text),
            "map_ke" => self.emission_map = texture_line::parse(value.text),
            "map_d" => self.opacity_map = texture_line::parse(value.text),
            "map_pr" => self.roughness_map = texture_line::parse(value.text),
            "map_ns" => self.shininess_map = texture_line::parse(value.text),
            "map_pm" => self.metallic_map = texture_line::parse(value.text),
            "norm" | "map_norm" | "map_kn" => self.normal_map = texture_line::parse(value.text),
            "bump" | "map_bump" => self.bump_map = texture_line::parse(value.text),
            other => {
                let ignored = IGNORED.iter().find(|&&key| key == other);
                let ignored = ignored.or(UNLESS_ZERO.iter().find(|&&key| key == other && !value.is_zero()));
                self.ignored.extend(ignored);
            }
        }
        Ok(())
    }
}

/// What follows a key.
struct Value<'a> {
    key: &'a str,
    text: &'a str,
    file: &'a Path,
    line: usize,
}

impl Value<'_> {
    /// Whether nothing but zeros is said.
    fn is_zero(&self) -> bool {
        self.text.split_whitespace().all(|word| word.parse() == Ok(0.0))
    }

    /// The first number; exporters put all kinds of text behind it.
    fn number(&self) -> Result<f32, SceneError> {
        let number = self.text.split_whitespace().next().and_then(|word| word.parse().ok());
        number.filter(|n: &f32| n.is_finite()).ok_or_else(|| self.malformed("a number"))
    }

    /// `d 0.5` or `d -halo 0.5`.
    fn dissolve(&self) -> Result<f32, SceneError> {
        let text = self.text.strip_prefix("-halo").unwrap_or(self.text);
        Value { text, ..*self }.number()
    }

    /// Three numbers, or one for grey. Negative ones count as zero.
    fn colour(&self) -> Result<Vec3, SceneError> {
        let words = self.text.split_whitespace().take_while(|word| !word.starts_with('#')).take(3);
        let numbers: Vec<f32> = words.map(str::parse).collect::<Result<_, _>>().unwrap_or_default();
        let colour = match numbers[..] {
            [grey] => Vec3::splat(grey),
            [r, g, b] => Vec3::new(r, g, b),
            _ => return Err(self.malformed("three numbers")),
        };
        if colour.is_finite() { Ok(colour.max(Vec3::ZERO)) } else { Err(self.malformed("finite numbers")) }
    }

    fn malformed(&self, expected: &str) -> SceneError {
        SceneError::Malformed {
            place: Place { file: self.file.into(), line: self.line },
            expected: format!("{} and {expected}", self.key),
            found: format!("'{}'", self.text.chars().take(60).collect::<String>()),
        }
    }
}

/// Reads the materials in `text`, the content of `file`.
pub(super) fn parse(text: &str, file: &Path) -> Result<Vec<MtlEntry>, SceneError> {
    let mut entries: Vec<MtlEntry> = vec![];
    for (line, content) in logical_lines(text) {
        let content = content.trim();
        let (key, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        if key.eq_ignore_ascii_case("newmtl") {
            entries.push(MtlEntry::new(rest.trim().into()));
        } else if let Some(entry) = entries.last_mut() {
            entry.set(key, &Value { key, text: rest.trim(), file, line })?;
        }
    }
    Ok(entries)
}
