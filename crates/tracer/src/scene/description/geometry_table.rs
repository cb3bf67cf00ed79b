//! `[[geometry]]`.

use std::path::PathBuf;

use glam::{DAffine3, DMat3, DMat4, DVec3, EulerRot};
use serde::Deserialize;
use toml::Spanned;

use super::super::{Motion, Placement, SceneError};
use super::mistakes::Lines;
use super::motion_table::MotionTable;

/// A mesh file and where it stands. A file named several times is read once and instanced.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GeometryTable {
    /// An OBJ file, relative to the scene file.
    file: PathBuf,
    transform: Option<Spanned<TransformTable>>,
    motion: Option<Spanned<MotionTable>>,
}

/// Where a mesh stands: scaled, then rotated, then translated; or a matrix instead.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TransformTable {
    translate: Option<[f64; 3]>,
    /// Degrees round x, then y, then z.
    rotate: Option<[f64; 3]>,
    scale: Option<Scale>,
    /// Row by row, 3 × 4 or 4 × 4 numbers.
    matrix: Option<Vec<f64>>,
}

/// How much larger.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number or three numbers")]
enum Scale {
    Uniform(f64),
    ByAxis([f64; 3]),
}

/// A mesh file and where it stands, checked.
#[derive(Debug)]
pub(in super::super) struct Geometry {
    pub(in super::super) file: PathBuf,
    pub(in super::super) placement: Placement,
    pub(in super::super) motion: Option<Motion>,
}

impl GeometryTable {
    /// The mesh, checked; the table begins at `offset`.
    pub(super) fn geometry(&self, lines: &Lines, offset: usize) -> Result<Geometry, SceneError> {
        let offset = self.transform.as_ref().map_or(offset, |t| t.span().start);
        let refuse = |expected: &str, found: &str| lines.malformed(offset, expected, found);
        let map = match self.transform.as_ref().map(Spanned::get_ref) {
            Some(transform) => transform.map().map_err(|(expected, found)| refuse(expected, &found))?,
            None => DAffine3::IDENTITY,
        };
        let placement =
            Placement::new(map).ok_or_else(|| refuse("a transform that can be undone", "a singular one"))?;
        let motion =
            self.motion.as_ref().map(|motion| motion.get_ref().motion(map.translation, motion.span().start, lines));
        Ok(Geometry { file: self.file.clone(), placement, motion: motion.transpose()? })
    }
}

impl TransformTable {
    /// The map, or what was expected and found.
    fn map(&self) -> Result<DAffine3, (&'static str, String)> {
        if let Some(matrix) = &self.matrix {
            let alone = self.translate.is_none() && self.rotate.is_none() && self.scale.is_none();
            return if alone { from_rows(matrix) } else { Err(("either matrix or its parts", "both".into())) };
        }
        let [x, y, z] = self.rotate.unwrap_or_default().map(f64::to_radians);
        let scale = match self.scale {
            Some(Scale::Uniform(s)) => DVec3::splat(s),
            Some(Scale::ByAxis(s)) => s.into(),
            None => DVec3::ONE,
        };
        let rotation = DMat3::from_euler(EulerRot::ZYX, z, y, x);
        let matrix3 = rotation * DMat3::from_diagonal(scale);
        Ok(DAffine3 { matrix3, translation: self.translate.unwrap_or_default().into() })
    }
}

fn from_rows(rows: &[f64]) -> Result<DAffine3, (&'static str, String)> {
    let mut full = [0.0; 16];
    full[15] = 1.0;
    match rows.len() {
        12 | 16 => full[..rows.len()].copy_from_slice(rows),
        count => return Err(("a matrix of 12 or 16 numbers, row by row", format!("{count} numbers"))),
    }
    if full[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(("0, 0, 0, 1 in the last row of the matrix", format!("{:?}", &full[12..])));
    }
    Ok(DAffine3::from_mat4(DMat4::from_cols_array(&full).transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placement(text: &str) -> Placement {
        Placement::new(toml::from_str::<TransformTable>(text).unwrap().map().unwrap()).unwrap()
    }

    #[test]
    fn a_mesh_is_scaled_then_turned_then_moved() {
        let p = placement("translate = [1, 2, 3]\nrotate = [0, 0, 90]\nscale = [2, 1, 1]");
        assert!((p.point(glam::Vec3::X) - glam::Vec3::new(1.0, 4.0, 3.0)).length() < 1e-6);
        let p = placement("rotate = [90, 90, 0]\nscale = 3");
        // Round x first: y becomes z; then round y: z becomes x.
        assert!((p.point(glam::Vec3::Y) - 3.0 * glam::Vec3::X).length() < 1e-6);
    }

    #[test]
    fn matrices_are_written_row_by_row() {
        let p = placement("matrix = [1, 0, 0, 5,  0, 2, 0, 6,  0, 0, 1, 7]");
        assert_eq!(p.point(glam::Vec3::ONE), glam::Vec3::new(6.0, 8.0, 8.0));
    }
}
