//! Where a path is.

use glam::Vec3;

use super::path_state::Path;
use crate::bsdf::Bsdf;
use crate::interaction::Interaction;

/// A surface on a path.
pub(super) struct Surface<'a> {
    /// Where.
    pub(super) hit: &'a Interaction<'a>,
    /// How it scatters.
    pub(super) bsdf: &'a Bsdf,
    /// How many surfaces the path met before.
    pub(super) bounce: u32,
    /// Whether what leaves it is gathered.
    pub(super) gathers: bool,
}

impl Surface<'_> {
    /// Share of the light from the unit vector `direction` that `path` finds for others, too.
    pub(super) fn shared_from(&self, direction: Vec3, path: &Path) -> Vec3 {
        if self.gathers { self.bsdf.even_share(direction) } else { path.shared }
    }
}
