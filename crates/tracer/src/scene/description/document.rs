//! The tables of `scene.toml` as documentation has them.

use super::camera_table::CameraTable;
use super::environment_table::EnvironmentTable;
use super::geometry_table::{GeometryTable, TransformTable};
use super::image_table::ImageTable;
use super::keys::{Key, TomlTable};
use super::light_table::{LightTable, LightType};
use super::material_table::MaterialTable;
use super::motion_table::MotionTable;

/// What a table of `scene.toml` may hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableDescription {
    /// What the table is called.
    pub name: &'static str,
    /// Its keys, as a Markdown table that ends with a line break.
    pub markdown: String,
}

/// All tables of `scene.toml`, made from what reads them.
pub fn describe_tables() -> Vec<TableDescription> {
    let table = |name, keys: Vec<Key>| TableDescription { name, markdown: table_of(name, &keys) };
    vec![
        table("camera", CameraTable::keys()),
        table("environment", EnvironmentTable::keys()),
        table("geometry", GeometryTable::keys()),
        table("transform", TransformTable::keys()),
        table("motion", MotionTable::keys()),
        TableDescription { name: "types of light", markdown: table_of_lights() },
        table("light", LightTable::keys()),
        table("material", MaterialTable::keys()),
        table("image", ImageTable::keys()),
    ]
}

/// A row for each key. Defaults are left out where they are all the same.
fn table_of(name: &str, keys: &[Key]) -> String {
    let differ = keys.iter().any(|key| key.default != keys[0].default);
    let header = if differ { ["| type | default | |", "|---|---|---|"] } else { ["| type | |", "|---|---|"] };
    let mut lines = format!("| key of `{name}` {}\n|---{}\n", header[0], header[1]);
    for Key { name, values, default, doc } in keys {
        let default = if differ { format!("{default} | ") } else { String::new() };
        lines += &format!("| `{name}` | {values} | {default}{doc} |\n");
    }
    lines
}

/// A row for each type of light.
fn table_of_lights() -> String {
    let list = |keys: &[&str]| keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    let mut lines = String::from("| `type` | needs | may have | one of |\n|---|---|---|---|\n");
    for shape in LightType::ALL.map(LightType::shape) {
        let [needs, may, one] = [shape.required, shape.optional, shape.brightness].map(list);
        lines += &format!("| `\"{}\"` | {needs} | {may} | {one} |\n", shape.name);
    }
    lines
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Set to make the tables of the document again.
    const WRITE: &str = "TAMIS_WRITE_DOCS";

    /// `document` with the table between each pair of marks made again.
    fn updated(document: &str) -> String {
        let mut text = document.to_string();
        for TableDescription { name, markdown } in describe_tables() {
            let (start, end) = (format!("<!-- keys: {name} -->\n"), "<!-- end of keys -->");
            let at = text.find(&start).unwrap_or_else(|| panic!("no place for the keys of {name}")) + start.len();
            let length = text[at..].find(end).unwrap_or_else(|| panic!("the keys of {name} have no end"));
            text.replace_range(at..at + length, &markdown);
        }
        text
    }

    #[test]
    fn the_document_says_what_the_code_reads() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene-format.md");
        let document = std::fs::read_to_string(&path).unwrap();
        let made = updated(&document);
        if std::env::var_os(WRITE).is_some() {
            std::fs::write(&path, &made).unwrap();
        }
        let differ = made.lines().zip(document.lines()).find(|(made, found)| made != found);
        assert!(
            made == document || std::env::var_os(WRITE).is_some(),
            "docs/scene-format.md is not what the code reads; make its tables again with\n\
             {WRITE}=1 cargo test -p tracer the_document_says\nfirst difference: {differ:?}"
        );
    }
}
