//! `[render]`, handed on as written: what it means is known to whoever renders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::{Spanned, Value};

use super::mistakes::Lines;

/// The `[render]` table, as written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawRender {
    /// The file it stands in.
    pub file: PathBuf,
    /// Its settings, in the file's order.
    pub entries: Vec<RenderEntry>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenderEntry {
    /// The key; of a key in a table, the table's name, a dash and the key.
    pub key: String,
    /// The value as one would type it on the command line: strings without quotes, lists with commas.
    pub text: String,
    /// The line, from 1.
    pub line: usize,
}

impl RawRender {
    pub(super) fn new(file: &Path, lines: &Lines, table: &BTreeMap<Spanned<String>, Spanned<Value>>) -> Self {
        let mut entries = vec![];
        for (key, value) in table {
            flatten(key.get_ref().clone(), value.get_ref(), lines.line(key.span().start), &mut entries);
        }
        entries.sort_by_key(|entry| entry.line);
        Self { file: file.into(), entries }
    }
}

fn flatten(key: String, value: &Value, line: usize, entries: &mut Vec<RenderEntry>) {
    match value {
        Value::Table(table) => table.iter().for_each(|(k, v)| flatten(format!("{key}-{k}"), v, line, entries)),
        other => entries.push(RenderEntry { key, text: typed(other), line }),
    }
}

fn typed(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) => values.iter().map(typed).collect::<Vec<_>>().join(","),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        Value::Boolean(truth) => truth.to_string(),
        Value::Datetime(moment) => moment.to_string(),
        // Tables inside lists mean nothing to any setting; their reader will say so.
        Value::Table(_) => "{}".into(),
    }
}
