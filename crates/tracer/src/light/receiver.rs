//! What asks for light.

use glam::Vec3;

/// Who looks for light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Where it is, in scene units.
    pub position: Vec3,
    /// The surface's unit normal, on the viewer's side.
    pub normal: Vec3,
    /// Whether light from beyond the surface matters, too.
    pub two_sided: bool,
}
