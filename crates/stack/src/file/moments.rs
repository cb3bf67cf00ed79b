//! Second moments as Mitsuba's `moment` integrator writes them: `m2_NAME` beside the mean `NAME`, both perhaps within another
//! integrator (`outer.m2_NAME`) or with layers of their own (`m2_NAME.albedo`).

use super::layer_list::LayerNames;

/// What stands in front of the name of a mean.
const MOMENT: &str = "m2_";

/// The name of the mean that goes with the second moment called `name`; `None` when it is called as none.
pub fn mean_of_moment(name: &str) -> Option<String> {
    let mut parts: Vec<&str> = name.split('.').collect();
    let moment = parts.iter_mut().find(|part| part.starts_with(MOMENT))?;
    *moment = &moment[MOMENT.len()..];
    Some(parts.join("."))
}

/// Whether `layer` is the second moment of another layer of `list`.
pub fn is_moment(list: &[LayerNames], layer: &LayerNames) -> bool {
    mean_of_moment(&layer.name).is_some_and(|mean| list.iter().any(|other| other.name == mean))
}

/// Whether there is a second moment of `layer` in `list`.
fn has_moment(list: &[LayerNames], layer: &LayerNames) -> bool {
    list.iter().any(|other| mean_of_moment(&other.name).is_some_and(|mean| mean == layer.name))
}

/// Whether `layer` is the picture again, in CIE XYZ, beside its second moment; what it has of layers of its own is not.
pub fn is_picture_with_moment(list: &[LayerNames], layer: &LayerNames) -> bool {
    let outer = list.iter().find(|other| other.name == layer.parent);
    has_moment(list, layer) && !outer.is_some_and(|outer| has_moment(list, outer))
}
