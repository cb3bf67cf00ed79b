//! The measures of all pictures, for the terminal and the page.

use std::fmt;
use std::path::Path;

use reconstruct::metrics::Comparison;
use serde::Serialize;
use serde_json::{Value, json};

/// A column for each measure that was taken for any image, a row for each image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasureTable {
    /// Names of the measures.
    pub head: Vec<String>,
    /// Files, and a cell for each measure.
    pub rows: Vec<(String, Vec<String>)>,
}

impl MeasureTable {
    /// The table of what was measured.
    pub fn of(measured: &[(&Path, Comparison)]) -> Self {
        let rows: Vec<(String, Measures)> =
            measured.iter().map(|(file, comparison)| (file.display().to_string(), values(comparison))).collect();
        let first = rows.first().map_or(&[][..], |(_, first)| first);
        let shown: Vec<usize> = (0..first.len()).filter(|i| rows.iter().any(|(_, row)| row[*i].1.is_some())).collect();
        let head = shown.iter().map(|i| first[*i].0.clone()).collect();
        let cells = |row: &Measures| shown.iter().map(|i| number(row[*i].1)).collect();
        Self { head, rows: rows.iter().map(|(file, row)| (file.clone(), cells(row))).collect() }
    }
}

impl fmt::Display for MeasureTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|(file, _)| file.len()).max().unwrap_or(0);
        let line = |cells: &[String]| cells.iter().map(|cell| format!("  {cell:>18}")).collect::<String>();
        write!(f, "{:width$}{}", "", line(&self.head))?;
        self.rows.iter().try_for_each(|(file, cells)| write!(f, "\n{file:width$}{}", line(cells)))
    }
}

/// Named measures; those that were not taken are `None`.
type Measures = Vec<(String, Option<f64>)>;

fn values(comparison: &Comparison) -> Measures {
    match json!(comparison) {
        Value::Object(measures) => measures.into_iter().map(|(name, value)| (name, value.as_f64())).collect(),
        _ => Vec::new(),
    }
}

fn number(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(v) if v == 0.0 || (0.01..1e6).contains(&v.abs()) => format!("{v:.4}"),
        Some(v) => format!("{v:.4e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_that_nobody_took_have_no_column() {
        let some = Comparison { rmse: Some(0.5), mse: Some(1e-9), ..Comparison::default() };
        let none = Comparison { nan_pixels: 3, ..Comparison::default() };
        let table = MeasureTable::of(&[(Path::new("a.exr"), some), (Path::new("long.exr"), none)]);
        assert_eq!(table.head, ["rmse", "mse", "nan_pixels"]);
        assert_eq!(table.rows[0].1, ["0.5000", "1.0000e-9", "0.0000"]);
        let text = table.to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len() == 3 && lines.iter().all(|line| line.len() == 8 + 3 * 20), "{text}");
        assert!(lines[2].starts_with("long.exr") && lines[2].ends_with("3.0000"), "{text}");
    }
}
