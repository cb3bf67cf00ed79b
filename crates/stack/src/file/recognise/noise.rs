//! Halves, variances and second moments of the layers that have a role.

use super::super::alias::ANYBODY;
use super::super::layer_list::LayerNames;
use super::super::moments::mean_of_moment;
use super::super::role::{Convention, Measure, Role, Slot};
use super::Search;
use crate::file::FileError;

impl Search<'_> {
    /// Finds what there is of every mean that was found.
    pub(super) fn noise(&mut self) -> Result<(), FileError> {
        for found in self.found.clone().iter().filter(|m| m.slot.measure == Measure::Mean) {
            let Some(layer) =
                self.list.iter().find(|l| l.channels(found.channels.len()).as_ref() == Some(&found.channels))
            else {
                continue;
            };
            self.by_ending(found.slot.role, layer);
            self.by_own_name(found.slot.role)?;
            self.second_moment(found.slot.role, layer)?;
        }
        let whole = |role| [Measure::HalfA, Measure::HalfB].map(|measure| Slot { role, measure });
        for role in Role::ALL {
            if !whole(role).iter().all(|slot| self.found.iter().any(|m| m.slot == *slot)) {
                self.found.retain(|m| !whole(role).contains(&m.slot));
            }
        }
        Ok(())
    }

    /// Halves and variances whose names are that of their mean with something behind it.
    fn by_ending(&mut self, role: Role, mean: &LayerNames) {
        for (ending, measure) in self.renderer.endings.iter().chain(ANYBODY.endings) {
            let slot = Slot { role, measure: *measure };
            let bare_half = mean.key.is_empty() && matches!(measure, Measure::HalfA | Measure::HalfB);
            if bare_half || !self.is_open(slot) {
                continue;
            }
            let key = format!("{}{ending}", mean.key);
            let beside = |layer: &LayerNames| layer.parent == mean.parent && layer.key == key;
            let below = |layer: &LayerNames| !mean.name.is_empty() && layer.parent == mean.name && layer.key == *ending;
            let fits = |layer: &&LayerNames| (beside(layer) || below(layer)) && self.is_free(layer);
            if let Some(layer) = self.list.iter().find(fits) {
                self.take(slot, layer, false);
            }
        }
    }

    /// Measures of noise that have a name of their own.
    fn by_own_name(&mut self, role: Role) -> Result<(), FileError> {
        for (of, measure, names) in self.renderer.noise.iter().filter(|(of, ..)| *of == role) {
            let slot = Slot { role: *of, measure: *measure };
            if !self.is_open(slot) {
                continue;
            }
            let fits = |l: &&LayerNames| names.contains(&l.key.as_str()) && l.channels(role.channels()).is_some();
            if let Some(layer) = self.one_of(slot, self.list.iter().filter(fits).collect())? {
                self.take(slot, layer, false);
            }
        }
        Ok(())
    }

    /// Mitsuba's second moments `m2_NAME` beside the mean `NAME`. The picture's own are those of no feature.
    fn second_moment(&mut self, role: Role, mean: &LayerNames) -> Result<(), FileError> {
        let slot = Slot { role, measure: Measure::Variance(Convention::SecondMoment) };
        if !self.is_open(slot) {
            return Ok(());
        }
        let count = role.channels();
        let mean_of = |moment: &LayerNames| {
            let name = mean_of_moment(&moment.name)?;
            self.list.iter().find(|layer| layer.name == name && layer.channels(count).is_some())
        };
        let fits = |layer: &&LayerNames| {
            let own = layer.channels(count).and_then(|_| mean_of(layer));
            own.is_some_and(|of| of.name == mean.name || (role == Role::Colour && self.is_free(of)))
        };
        if let Some(moment) = self.one_of(slot, self.list.iter().filter(fits).collect())? {
            let own = mean_of(moment).filter(|of| of.name != mean.name).and_then(|of| of.channels(count));
            self.take(slot, moment, false);
            self.found.last_mut().into_iter().for_each(|m| m.mean.clone_from(&own));
        }
        Ok(())
    }
}
