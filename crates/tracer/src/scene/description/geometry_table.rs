//! `[[geometry]]`.

use std::path::PathBuf;

use glam::{DAffine3, DMat3, DMat4, DVec3, EulerRot};
use toml::Spanned;

use super::super::{Motion, Placement, SceneError};
use super::keys::{FINITE, TomlTable, TomlValue, toml_table};
use super::mistakes::Lines;
use super::motion_table::MotionTable;
use super::triple::Triple;

toml_table! {
    /// A mesh file and where it stands.
    pub(super) struct GeometryTable {
        /// an OBJ or glTF file, relative to the scene file; one that is named several times is read and stored once
        required file: PathBuf;
        /// where it stands: either `matrix`, or any of the other three
        optional transform: TransformTable = "identity";
        /// it stands at each of these places, which are applied after `transform`; its triangles are stored once
        optional instances: Vec<Spanned<TransformTable>> = "one, where `transform` puts it";
        /// how it moves over the frame, on top of `transform` and `instances`, which hold at time 0
        optional motion: MotionTable = "none";
    }
}

toml_table! {
    /// Where a mesh stands.
    pub(super) struct TransformTable {
        /// applied first
        default scale: Triple = Triple::splat(1.0), FINITE;
        /// then these turns, in degrees: round *x*, then *y*, then *z*
        default rotate: [f64; 3] = [0.0; 3], FINITE;
        /// then this
        default translate: [f64; 3] = [0.0; 3], FINITE;
        /// in their place: 12 or 16 numbers, row by row; the last row of 16 must be 0 0 0 1
        optional matrix: Vec<f64> = "none";
    }
}

impl TomlValue for TransformTable {
    fn kind() -> String {
        "table".into()
    }
}

impl TomlValue for Vec<Spanned<TransformTable>> {
    fn kind() -> String {
        "list of tables, as `transform`".into()
    }
}

/// A mesh file and where it stands, checked.
#[derive(Debug)]
pub(in super::super) struct Geometry {
    pub(in super::super) file: PathBuf,
    pub(in super::super) stands: Vec<Stand>,
}

/// Where a mesh stands at time 0, and how it moves.
#[derive(Debug)]
pub(in super::super) struct Stand {
    pub(in super::super) placement: Placement,
    pub(in super::super) motion: Option<Motion>,
}

impl GeometryTable {
    /// The mesh, checked.
    pub(super) fn geometry(&self, lines: &Lines) -> Result<Geometry, SceneError> {
        let own = self.transform.as_ref().map_or(Ok(DAffine3::IDENTITY), |transform| map_of(transform, lines))?;
        let stands = match &self.instances {
            None => vec![self.stand(own, self.place_of("transform").unwrap_or_default(), lines)?],
            Some(instances) => {
                let stand = |instance: &Spanned<TransformTable>| {
                    self.stand(map_of(instance, lines)? * own, instance.span().start, lines)
                };
                instances.get_ref().iter().map(stand).collect::<Result<_, _>>()?
            }
        };
        Ok(Geometry { file: self.file().clone(), stands })
    }

    /// Where `map`, which is written at `offset`, puts it.
    fn stand(&self, map: DAffine3, offset: usize, lines: &Lines) -> Result<Stand, SceneError> {
        let singular = || lines.malformed(offset, "a transform that can be undone", "a singular or too large one");
        let placement = Placement::new(map).ok_or_else(singular)?;
        let motion = self.motion().map(|motion| motion.motion(map.translation, lines)).transpose()?;
        Ok(Stand { placement, motion })
    }
}

/// The map that a table describes, checked but for being singular.
fn map_of(table: &Spanned<TransformTable>, lines: &Lines) -> Result<DAffine3, SceneError> {
    table.get_ref().check(lines)?;
    table.get_ref().map().map_err(|(expected, found)| lines.malformed(table.span().start, expected, &found))
}

impl TransformTable {
    /// The map, or what was expected and found.
    fn map(&self) -> Result<DAffine3, (&'static str, String)> {
        if let Some(matrix) = self.matrix() {
            return if self.given().len() == 1 {
                from_rows(matrix)
            } else {
                Err(("either matrix or its parts", "both".into()))
            };
        }
        let [x, y, z] = self.rotate().map(f64::to_radians);
        let rotation = DMat3::from_euler(EulerRot::ZYX, z, y, x);
        let matrix3 = rotation * DMat3::from_diagonal(DVec3::from_array(self.scale().0));
        Ok(DAffine3 { matrix3, translation: self.translate().into() })
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
