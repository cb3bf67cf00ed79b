//! Which layers of a file have which role.

mod noise;

use super::alias::{ANYBODY, GEOMETRIC_WORDS, OTHER_WORDS, RENDERERS, Renderer, SHADING_WORDS, Sign, WORDS};
use super::by_value::by_value;
use super::layer_list::{LayerNames, layer_list, words};
use super::moments::{is_moment, is_picture_with_moment};
use super::role::{Measure, Role, Slot};
use super::slot_names::slot_of;
use super::{FileError, Layers};
use crate::FeatureRole;

/// A slot, and the channels that fill it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Match {
    /// What they are.
    pub slot: Slot,
    /// Their full names, as many as the role has.
    pub channels: Vec<String>,
    /// Of a second moment, the channels that hold its mean, where these are not the role's own.
    pub mean: Option<Vec<String>>,
    /// Whether a value or a word of the name was all there was to go by.
    pub guessed: bool,
}

/// What was recognised in a file.
#[derive(Clone, Debug)]
pub struct Recognised {
    /// Who wrote it.
    pub renderer: &'static Renderer,
    /// Everything that has a role.
    pub matches: Vec<Match>,
}

impl Recognised {
    /// The match for the mean of `role`.
    pub fn mean(&self, role: Role) -> Option<&Match> {
        self.get(Slot { role, measure: Measure::Mean })
    }

    /// The match for `slot`, whatever kind of variance.
    pub fn get(&self, slot: Slot) -> Option<&Match> {
        self.matches.iter().find(|found| found.slot.same_as(slot))
    }
}

/// What the user says a layer is: a slot and the layer's name; `none` where there shall be nothing.
pub type Mapping = (Slot, String);

/// Finds out what the layers of a file are: what `map` says, then the renderer's own names, then everybody's, then, for a
/// renderer whose names are the user's, by their values.
///
/// # Errors
/// When there is no colour, a mapped layer is not there, or two layers have an equal claim to a role.
pub fn recognise(layers: &Layers, map: &[Mapping]) -> Result<Recognised, FileError> {
    let list = layer_list(layers);
    let mut search = Search { layers, list: &list, renderer: renderer_of(layers, &list), map, found: Vec::new() };
    search.mapped()?;
    search.colour()?;
    for role in Role::ALL {
        search.mean(role)?;
    }
    search.noise()?;
    Ok(Recognised { renderer: search.renderer, matches: search.found })
}

fn renderer_of(layers: &Layers, list: &[LayerNames]) -> &'static Renderer {
    let shows = |sign: &Sign| match sign {
        Sign::Attribute(start, value) => layers.carried.begins_with(start, value),
        Sign::Layers(keys) => keys.iter().all(|key| list.iter().any(|layer| layer.key == *key)),
    };
    RENDERERS.iter().find(|renderer| renderer.signs.iter().any(shows)).unwrap_or(&ANYBODY)
}

/// The renderer whose layers have the user's names.
const NAMES_ARE_THE_USERS: &str = "Mitsuba";

/// Channels of a picture of CIE XYZ.
pub(super) const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// A search under way.
struct Search<'a> {
    layers: &'a Layers,
    list: &'a [LayerNames],
    renderer: &'static Renderer,
    map: &'a [Mapping],
    found: Vec<Match>,
}

impl<'a> Search<'a> {
    /// Whether nobody has decided about `slot` yet.
    fn is_open(&self, slot: Slot) -> bool {
        !self.found.iter().any(|m| m.slot.same_as(slot)) && !self.map.iter().any(|(s, _)| s.same_as(slot))
    }

    /// Whether a layer has no role yet, and may have one.
    fn is_free(&self, layer: &LayerNames) -> bool {
        let taken = |name: &String| self.found.iter().any(|m| m.channels.contains(name));
        !is_moment(self.list, layer)
            && !self.is_of_another_picture(layer)
            && !layer.triple().or_else(|| layer.single()).is_some_and(|names| names.iter().any(taken))
    }

    /// Whether a layer stands beside another picture than the colour: that of another view, or view layer.
    fn is_of_another_picture(&self, layer: &LayerNames) -> bool {
        let Some(own) = self.colour_parent() else { return false };
        let is_picture = |other: &LayerNames| {
            let mut names = self.renderer.means.iter().filter(|(role, _)| *role == Role::Colour);
            names.any(|(_, names)| names.contains(&other.key.as_str())) && other.triple().is_some()
        };
        let beside = |other: &LayerNames| other.parent == layer.parent && is_picture(other);
        !layer.parent.is_empty() && layer.parent != own && self.list.iter().any(beside)
    }

    fn take(&mut self, slot: Slot, layer: &LayerNames, guessed: bool) {
        if let Some(channels) = layer.channels(slot.role.channels()) {
            self.found.push(Match { slot, channels, mean: None, guessed });
        }
    }

    fn mapped(&mut self) -> Result<(), FileError> {
        for (slot, prefix) in self.map {
            let prefix = prefix.trim_end_matches('.');
            if prefix == "none" {
                continue;
            }
            let fits = |layer: &&LayerNames| layer.channels(slot.role.channels()).is_some();
            let exact = self.list.iter().filter(fits).find(|layer| layer.name.eq_ignore_ascii_case(prefix));
            let all = |named: &dyn Fn(&LayerNames) -> bool| -> Vec<&'a LayerNames> {
                self.list.iter().filter(fits).filter(|layer| named(layer)).collect()
            };
            let mut named = all(&|layer| layer.name.starts_with(prefix));
            if named.is_empty() {
                named = all(&|layer| is_last_part(layer, prefix));
            }
            match (exact, &named[..]) {
                (Some(layer), _) => self.take(*slot, layer, false),
                (None, [layer]) => self.take(*slot, layer, false),
                (None, []) => return Err(self.no_such_layer(*slot, prefix)),
                (None, several) => match self.named_in(*slot, prefix) {
                    Some(layer) => self.take(*slot, layer, false),
                    None => return Err(self.ambiguous(*slot, several)),
                },
            }
        }
        Ok(())
    }

    /// Of a view or view layer called `prefix`, the one layer that has the most specific of the names for `slot`.
    fn named_in(&self, slot: Slot, prefix: &str) -> Option<&'a LayerNames> {
        let inside = |layer: &&LayerNames| {
            layer.parent.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let of_role = |table: &'static Renderer| table.means.iter().filter(move |(role, _)| *role == slot.role);
        let mut names = [self.renderer, &ANYBODY].into_iter().flat_map(of_role).flat_map(|(_, names)| *names);
        names.find_map(|name| {
            let fits = |layer: &&LayerNames| layer.key == **name && layer.channels(slot.role.channels()).is_some();
            let mut all = self.list.iter().filter(inside).filter(fits);
            all.next().filter(|_| all.next().is_none())
        })
    }

    /// The colour: the renderer's own name for it, bare `R G B`, a name anybody may use, or the only `R G B` there is.
    fn colour(&mut self) -> Result<(), FileError> {
        let slot = Slot { role: Role::Colour, measure: Measure::Mean };
        if !self.is_open(slot) {
            return if self.found.iter().any(|m| m.slot == slot) { Ok(()) } else { Err(self.no_colour()) };
        }
        if self.renderer.name != ANYBODY.name
            && let Some(layer) = self.by_name(self.renderer, slot)?
        {
            self.take(slot, layer, false);
            return Ok(());
        }
        let rgb = ["R", "G", "B"];
        let bare = self.list.iter().find(|layer| layer.name.is_empty() && layer.has(&rgb));
        let noisy =
            self.list.iter().find(|layer| ["noisy", "noisyimage"].contains(&layer.key.as_str()) && layer.has(&rgb));
        if let (Some(bare), Some(noisy)) = (bare, noisy) {
            return Err(self.ambiguous(slot, &[bare, noisy]));
        }
        let named = match bare {
            Some(bare) => Some(bare),
            None => self.by_name(&ANYBODY, slot)?,
        };
        let (layer, guessed) = match named {
            Some(layer) => (Some(layer), false),
            None => (self.only_rgb(), true),
        };
        if let Some(layer) = layer {
            self.take(slot, layer, guessed);
            return Ok(());
        }
        let channels = self.tristimulus().or_else(|| self.grey()).ok_or_else(|| self.no_colour())?;
        self.found.push(Match { slot, channels, mean: None, guessed: false });
        Ok(())
    }

    /// The picture as Mitsuba's films of `pixel_format` `xyz` hold it. Elsewhere such channels may be anything.
    fn tristimulus(&self) -> Option<Vec<String>> {
        let there = self.renderer.name == NAMES_ARE_THE_USERS && XYZ.iter().all(|name| self.layers.has(name));
        there.then(|| XYZ.map(String::from).into())
    }

    /// A picture of luminance alone, which is all three of its colours.
    fn grey(&self) -> Option<Vec<String>> {
        let alone = self.layers.has("Y") && !["X", "Z"].iter().any(|name| self.layers.has(name));
        alone.then(|| vec!["Y".into(); 3])
    }

    /// The only layer of red, green and blue, when it has no other role.
    fn only_rgb(&self) -> Option<&'a LayerNames> {
        let mut all = self.list.iter().filter(|layer| layer.has(&["R", "G", "B"]));
        let only = all.next().filter(|_| all.next().is_none())?;
        slot_of(&only.key).is_none().then_some(only)
    }

    fn mean(&mut self, role: Role) -> Result<(), FileError> {
        let slot = Slot { role, measure: Measure::Mean };
        if !self.is_open(slot) {
            return Ok(());
        }
        for renderer in [self.renderer, &ANYBODY] {
            if let Some(layer) = self.by_name(renderer, slot)? {
                self.take(slot, layer, false);
                return Ok(());
            }
        }
        if role == Role::Alpha {
            self.found.extend(self.alpha_of_colour().map(|channels| Match {
                slot,
                channels,
                mean: None,
                guessed: false,
            }));
            return Ok(());
        }
        let guess = match self.by_word(slot)? {
            Some(layer) => Some(layer),
            None => self.by_value(slot)?,
        };
        if let Some(layer) = guess {
            self.take(slot, layer, true);
        }
        Ok(())
    }

    /// The layer that has the most specific of the names `renderer` uses for `slot`.
    fn by_name(&self, renderer: &Renderer, slot: Slot) -> Result<Option<&'a LayerNames>, FileError> {
        let names = renderer.means.iter().filter(|(role, _)| *role == slot.role).flat_map(|(_, names)| *names);
        for name in names {
            let fits = |layer: &&LayerNames| layer.key == **name && layer.channels(slot.role.channels()).is_some();
            let candidates: Vec<&LayerNames> = self.list.iter().filter(fits).filter(|l| self.is_free(l)).collect();
            if let Some(layer) = self.one_of(slot, candidates)? {
                return Ok(Some(layer));
            }
        }
        Ok(None)
    }

    /// The layer whose name contains a word of `slot`'s role.
    fn by_word(&self, slot: Slot) -> Result<Option<&'a LayerNames>, FileError> {
        let Some((_, wanted)) = WORDS.iter().find(|(role, _)| *role == slot.role) else { return Ok(None) };
        let fits = |layer: &&LayerNames| {
            let own = words(layer.name.rsplit('.').next().unwrap_or(&layer.name));
            let any = |list: &[&str]| own.iter().any(|word| list.contains(&word.as_str()));
            any(wanted) && !any(OTHER_WORDS) && layer.channels(slot.role.channels()).is_some() && self.is_free(layer)
        };
        self.one_of(slot, self.list.iter().filter(fits).collect())
    }

    /// The layer whose values are those of `slot`'s role, where names are the user's.
    fn by_value(&self, slot: Slot) -> Result<Option<&'a LayerNames>, FileError> {
        let Role::Feature(feature) = slot.role else { return Ok(None) };
        if self.renderer.name != NAMES_ARE_THE_USERS {
            return Ok(None);
        }
        let free = self.list.iter().filter(|layer| self.is_free(layer) && !is_picture_with_moment(self.list, layer));
        self.one_of(slot, by_value(self.layers, free, feature))
    }

    /// The one of `candidates` that stands beside the colour, or whose name says it is the better one.
    fn one_of(&self, slot: Slot, candidates: Vec<&'a LayerNames>) -> Result<Option<&'a LayerNames>, FileError> {
        let Some(first) = candidates.first() else { return Ok(None) };
        if candidates.len() == 1 {
            return Ok(Some(first));
        }
        let only = |keep: &dyn Fn(&LayerNames) -> bool| {
            let mut kept = candidates.iter().filter(|layer| keep(layer));
            kept.next().filter(|_| kept.next().is_none()).copied()
        };
        let says = |layer: &LayerNames, list: &[&str]| words(&layer.name).iter().any(|w| list.contains(&w.as_str()));
        let is_normal = slot.role == Role::Feature(FeatureRole::Normal);
        let parent = self.colour_parent();
        only(&|layer| parent.as_deref() == Some(&layer.parent))
            .or_else(|| only(&|layer| is_normal && says(layer, SHADING_WORDS)))
            .or_else(|| only(&|layer| is_normal && !says(layer, GEOMETRIC_WORDS)))
            .map_or_else(|| Err(self.ambiguous(slot, &candidates)), |layer| Ok(Some(layer)))
    }

    fn alpha_of_colour(&self) -> Option<Vec<String>> {
        let colour = self.found.iter().find(|m| m.slot == Slot { role: Role::Colour, measure: Measure::Mean })?;
        let is_bare = colour.channels.iter().any(|channel| channel == "Y");
        let holds = |layer: &&LayerNames| {
            layer.triple().as_ref() == Some(&colour.channels) || (is_bare && layer.name.is_empty())
        };
        self.list.iter().find(holds)?.channel("A").map(|alpha| vec![alpha])
    }

    fn colour_parent(&self) -> Option<String> {
        let colour = self.found.iter().find(|m| m.slot.role == Role::Colour && m.slot.measure == Measure::Mean)?;
        self.list
            .iter()
            .find(|layer| layer.triple().as_ref() == Some(&colour.channels))
            .map(|layer| layer.parent.clone())
    }

    fn no_colour(&self) -> FileError {
        FileError::Missing {
            path: self.layers.path.clone(),
            wanted: "colour",
            expected: "R G B, or --map colour=LAYER".into(),
            found: self.layers.names(),
        }
    }

    fn no_such_layer(&self, slot: Slot, prefix: &str) -> FileError {
        FileError::NoSuchLayer {
            path: self.layers.path.clone(),
            slot: slot.to_string(),
            layer: prefix.into(),
            count: slot.role.channels(),
            found: self.list.iter().map(shown).collect::<Vec<_>>().join(", "),
        }
    }

    fn ambiguous(&self, slot: Slot, candidates: &[&LayerNames]) -> FileError {
        FileError::Ambiguous {
            path: self.layers.path.clone(),
            slot: slot.to_string(),
            candidates: candidates.iter().map(|layer| shown(layer)).collect::<Vec<_>>().join(", "),
        }
    }
}

/// Whether `name` is what stands behind the last dot of a layer's name.
fn is_last_part(layer: &LayerNames, name: &str) -> bool {
    layer.name.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(name))
}

fn shown(layer: &LayerNames) -> String {
    if layer.name.is_empty() {
        "the channels without a layer (--map ROLE=)".into()
    } else {
        format!("'{}'", layer.name)
    }
}
