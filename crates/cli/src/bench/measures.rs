//! How fast each step was in its best round.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::table::{Table, short};

/// A step and its rate.
#[derive(Clone, Debug, PartialEq)]
struct Measure {
    name: &'static str,
    /// Of what so many a second.
    unit: &'static str,
    rate: f64,
}

/// All steps, in the order they were first measured in.
#[derive(Clone, Debug, Default)]
pub struct Measures(Vec<Measure>);

impl Measures {
    /// Notes that step `name` did `amount` of `unit` in so many `seconds`; the fastest of several counts.
    pub fn add(&mut self, name: &'static str, unit: &'static str, amount: f64, seconds: f64) {
        let rate = amount / seconds.max(1e-9);
        match self.0.iter_mut().find(|measure| measure.name == name) {
            Some(before) => before.rate = before.rate.max(rate),
            None => self.0.push(Measure { name, unit, rate }),
        }
    }

    /// Rates by step.
    pub fn rates(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.0.iter().map(|measure| (measure.name, measure.rate))
    }

    /// All of it, by step.
    pub fn to_json(&self) -> Value {
        let entry = |m: &Measure| (m.name.to_string(), json!({ "rate": m.rate, "unit": m.unit }));
        Value::Object(self.0.iter().map(entry).collect())
    }

    /// A table, with `ratios` to an earlier run where there was one.
    pub fn table(&self, ratios: Option<&BTreeMap<String, f64>>) -> Table {
        let head: &[&str] = if ratios.is_some() { &["step", "rate", "", "÷ earlier"] } else { &["step", "rate", ""] };
        let mut table = Table::new("Best of all rounds", head);
        for Measure { name, unit, rate } in &self.0 {
            let ratio = ratios.map(|ratios| ratios.get(*name).map_or_else(|| "-".into(), |r| format!("{r:.2}")));
            let cells = [(*name).to_string(), short(*rate), (*unit).to_string()];
            table.rows.push(cells.into_iter().chain(ratio).collect());
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_round_counts() {
        let mut measures = Measures::default();
        measures.add("a", "x/s", 10.0, 5.0);
        measures.add("b", "y/s", 1.0, 1.0);
        measures.add("a", "x/s", 10.0, 2.0);
        measures.add("a", "x/s", 10.0, 4.0);
        assert_eq!(measures.rates().collect::<Vec<_>>(), [("a", 5.0), ("b", 1.0)]);
        assert_eq!(measures.to_json()["a"], json!({ "rate": 5.0, "unit": "x/s" }));
        let ratios = BTreeMap::from([("a".to_string(), 0.5)]);
        assert_eq!(measures.table(Some(&ratios)).rows, [["a", "5.00", "x/s", "0.50"], ["b", "1.00", "y/s", "-"]]);
        assert_eq!(measures.table(None).rows[1], ["b", "1.00", "y/s"]);
    }
}
