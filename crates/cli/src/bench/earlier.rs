//! What an earlier run measured.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use serde_json::Value;

use super::measures::Measures;
use crate::failure::usage;

/// Rates by step, and of what.
pub struct Earlier {
    rates: BTreeMap<String, f64>,
    /// What it says of the work beside its rates.
    told: Value,
}

/// What says what the work was: rates of one work say nothing of another.
const WORK: [&str; 3] = ["scene", "size", "spp"];

impl Earlier {
    /// Reads what `tamis bench --json` printed into `file`.
    ///
    /// # Errors
    /// When the file cannot be read or holds something else.
    pub fn read(file: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(file)
            .map_err(|error| usage(format!("--against {}: cannot be read: {error}", file.display())))?;
        Self::parse(&text).ok_or_else(|| {
            usage(format!(
                "--against {}: expected what tamis bench --json prints, found something else",
                file.display()
            ))
        })
    }

    fn parse(text: &str) -> Option<Self> {
        let value: Value = serde_json::from_str(text).ok()?;
        let rate = |(name, measure): (&String, &Value)| Some((name.clone(), measure.get("rate")?.as_f64()?));
        let rates = value.get("measures")?.as_object()?.iter().map(rate).collect::<Option<_>>()?;
        Some(Self { rates, told: value })
    }

    /// Demands that it measured the work that `now` is, as far as it says.
    ///
    /// # Errors
    /// The first difference.
    pub fn check_work(&self, now: &Value) -> Result<()> {
        let differs = |key: &&str| self.told.get(key).is_some_and(|then| *then != now[key]);
        let Some(key) = WORK.into_iter().find(differs) else { return Ok(()) };
        let (then, now) = (&self.told[key], &now[key]);
        Err(usage(format!("--against: {key} was {then} then and is {now} now; measure the same work again")))
    }

    /// Rates now over rates then, of the steps that both have.
    pub fn ratios(&self, now: &Measures) -> BTreeMap<String, f64> {
        let ratio = |(name, rate): (&str, f64)| Some((name.to_string(), rate / self.rates.get(name)?));
        now.rates().filter_map(ratio).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_printed_is_read_and_set_beside() {
        let mut measures = Measures::default();
        measures.add("a", "x/s", 8.0, 2.0);
        let printed = serde_json::json!({ "measures": measures.to_json() }).to_string();
        let earlier = Earlier::parse(&printed).unwrap();
        measures.add("a", "x/s", 8.0, 1.0);
        measures.add("b", "x/s", 8.0, 1.0);
        assert_eq!(earlier.ratios(&measures), BTreeMap::from([("a".to_string(), 2.0)]));
        for other in ["", "[]", "{}", r#"{ "measures": { "a": 3 } }"#] {
            assert!(Earlier::parse(other).is_none(), "{other}");
        }
    }
}
