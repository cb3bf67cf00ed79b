//! The decisions a path makes.

/// Names one decision of a path, and with it a point set of its own. A decision at a given bounce has the same name
/// whatever happened before, so paths of a pixel stay stratified against one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision(u32);

/// Decisions taken at the camera.
const AT_CAMERA: u32 = 3;
/// Decisions taken at every bounce.
const AT_BOUNCE: u32 = 5;

impl Decision {
    /// Where in the pixel; two-dimensional.
    pub const FILM: Self = Self(0);
    /// Where on the lens; two-dimensional.
    pub const LENS: Self = Self(1);
    /// When while the shutter is open; one-dimensional.
    pub const TIME: Self = Self(2);

    /// Which light is sampled at bounce `bounce`; one-dimensional.
    pub const fn light(bounce: u32) -> Self {
        Self::at(bounce, 0)
    }

    /// Which point of that light; two-dimensional.
    pub const fn light_point(bounce: u32) -> Self {
        Self::at(bounce, 1)
    }

    /// Which lobe scatters; one-dimensional.
    pub const fn lobe(bounce: u32) -> Self {
        Self::at(bounce, 2)
    }

    /// Into which direction; two-dimensional.
    pub const fn direction(bounce: u32) -> Self {
        Self::at(bounce, 3)
    }

    /// Whether the path goes on; one-dimensional.
    pub const fn roulette(bounce: u32) -> Self {
        Self::at(bounce, 4)
    }

    const fn at(bounce: u32, which: u32) -> Self {
        Self(AT_CAMERA + AT_BOUNCE * bounce + which)
    }

    /// A number that no other decision has.
    pub(super) const fn number(self) -> u32 {
        self.0
    }
}
