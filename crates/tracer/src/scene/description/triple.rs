//! Three numbers that may be written as one.

use glam::Vec3;

use super::keys::TomlValue;

/// Three numbers, or one that stands for all three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Triple(pub(super) [f64; 3]);

impl Triple {
    pub(super) const fn splat(number: f64) -> Self {
        Self([number; 3])
    }

    pub(super) fn vec3(self) -> Vec3 {
        Vec3::from_array(self.0.map(|n| n as f32))
    }

    /// The one number it is.
    pub(super) fn one(self) -> Option<f32> {
        let [a, b, c] = self.0;
        (a == b && b == c).then_some(a as f32)
    }
}

impl TomlValue for Triple {
    fn kind() -> String {
        "number or 3 numbers".into()
    }

    fn written(&self) -> String {
        if self.one().is_some() { self.0[0].written() } else { self.0.written() }
    }

    fn numbers(&self) -> Vec<f64> {
        self.0.to_vec()
    }
}
