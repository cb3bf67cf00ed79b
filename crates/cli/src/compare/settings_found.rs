//! What the page says about how a picture was made.

use serde_json::{Map, Value, json};
use stack::file::Record;

use crate::settings::{Preset, Settings};

/// The setting that differs between equal pictures.
const SEED: &str = "trace.seed";

/// Where the settings say which method rebuilt the picture.
const METHOD: &str = "reconstruction.method.method";

/// The record of a file, its settings as a flat list, and which preset they are nearest to. What is not known is
/// `null`.
pub fn settings_found(record: &Record) -> Value {
    let settings = record.settings.as_ref().map(flat);
    let get = |key: &str| settings.as_ref().and_then(|settings| settings.get(key));
    json!({
        "software": record.software,
        "spp": record.spp,
        "seed": get(SEED),
        "method": get(METHOD),
        "preset": settings.as_ref().filter(|_| get(METHOD) == Some(&json!("ours"))).map(nearest_preset),
        "settings": settings,
    })
}

/// What recorded `settings` change of the defaults: key, value, default.
pub fn changed_settings(settings: &Value) -> Vec<[Value; 3]> {
    changes(&flat(settings), &flat(&Settings::default().to_json()))
}

/// Every setting by the path to it.
fn flat(settings: &Value) -> Map<String, Value> {
    fn collect(path: &str, value: &Value, found: &mut Map<String, Value>) {
        let Value::Object(members) = value else {
            found.insert(path.into(), value.clone());
            return;
        };
        for (key, value) in members {
            collect(&if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, value, found);
        }
    }
    let mut found = Map::new();
    collect("", settings, &mut found);
    found
}

/// The preset of which fewest settings were changed, and those: key, value, the preset's value. A file names no preset,
/// for what a preset holds may change.
fn nearest_preset(settings: &Map<String, Value>) -> Value {
    let presets = [("best", Preset::Best), ("fast", Preset::Fast), ("paper", Preset::Paper)];
    let changes = presets.map(|(name, preset)| (name, changes(settings, &flat(&Settings::of(preset).to_json()))));
    let nearest = changes.iter().min_by_key(|(_, changes)| changes.len());
    nearest.map_or(Value::Null, |(name, changes)| json!({ "name": name, "changes": changes }))
}

fn changes(settings: &Map<String, Value>, preset: &Map<String, Value>) -> Vec<[Value; 3]> {
    let pairs = settings.iter().filter_map(|(key, value)| Some((key, value, preset.get(key)?)));
    let changed = pairs.filter(|(key, value, usual)| key.as_str() != SEED && value != usual);
    changed.map(|(key, value, usual)| [json!(key), value.clone(), usual.clone()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_is_recognised_and_what_was_changed_is_told() {
        for (preset, name) in [(Preset::Best, "best"), (Preset::Fast, "fast"), (Preset::Paper, "paper")] {
            let mut settings = Settings::of(preset);
            settings.trace.seed = 7;
            let record = |settings: Settings| Record { settings: Some(settings.to_json()), ..Record::default() };
            let found = settings_found(&record(settings));
            assert_eq!(found["seed"], 7);
            assert_eq!(found["preset"], json!({"name": name, "changes": []}));
            settings.trace.max_depth = 3;
            let found = settings_found(&record(settings));
            assert_eq!(found["preset"]["changes"], json!([["trace.max-depth", 3, 32]]), "{name}");
            assert_eq!(found["settings"]["trace.max-depth"], 3);
        }
    }

    #[test]
    fn what_is_unknown_is_null() {
        let found = settings_found(&Record::default());
        assert!(found.as_object().unwrap().values().all(Value::is_null), "{found}");
        let rival = json!({"reconstruction": {"method": {"method": "nfor"}}});
        let found = settings_found(&Record { settings: Some(rival), ..Record::default() });
        assert_eq!((&found["method"], &found["preset"], &found["seed"]), (&json!("nfor"), &Value::Null, &Value::Null));
    }
}
