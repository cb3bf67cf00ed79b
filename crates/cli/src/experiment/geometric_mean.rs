//! Means of measures that may be unknown.

/// `None` when a value is unknown or not above 0, as a cross error may be by chance, and when there are none.
pub fn geometric_mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let logs: Option<Vec<f64>> = values.map(|value| value.filter(|v| *v > 0.0).map(f64::ln)).collect();
    mean(logs?.into_iter().map(Some)).map(f64::exp)
}

/// `None` when a value is unknown, and when there are none.
pub fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.collect::<Option<_>>()?;
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
