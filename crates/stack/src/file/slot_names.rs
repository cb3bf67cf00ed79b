//! What a name alone says about a file or layer, whoever wrote it.

use super::alias::{ANYBODY, OF_LAYERS_ALONE, RENDERERS};
use super::layer_list::normalise;
use super::role::{Measure, Slot};

/// What a layer or file of the name `name` is in the language of any renderer: a slot, or nothing where it is known to
/// be something else.
pub(super) fn slot_of(name: &str) -> Option<Option<Slot>> {
    let key = normalise(name);
    if OF_LAYERS_ALONE.contains(&key.as_str()) {
        return None;
    }
    let tables = || RENDERERS.iter().chain([&ANYBODY]);
    let mean = tables().find_map(|table| {
        let (role, _) = table.means.iter().find(|(_, names)| names.contains(&key.as_str()))?;
        Some(Slot { role: *role, measure: Measure::Mean })
    });
    let noise = || {
        tables().find_map(|table| {
            let (role, measure, _) = table.noise.iter().find(|(.., names)| names.contains(&key.as_str()))?;
            Some(Slot { role: *role, measure: *measure })
        })
    };
    let ended = || {
        tables().flat_map(|table| table.endings).find_map(|(ending, measure)| {
            let of = key.strip_suffix(ending).filter(|of| of.len() > 1)?;
            let named = tables().find_map(|t| t.means.iter().find(|(_, names)| names.contains(&of)))?;
            Some(Slot { role: named.0, measure: *measure })
        })
    };
    let other = || tables().any(|table| table.others.contains(&key.as_str()));
    match mean.or_else(noise).or_else(ended) {
        Some(slot) => Some(Some(slot)),
        None => other().then_some(None),
    }
}
