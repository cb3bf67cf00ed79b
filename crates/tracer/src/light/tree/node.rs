//! Nodes of the tree, and what their children may send to a point.

use std::f64::consts::FRAC_PI_2;

use glam::Vec3;

use super::super::light_bounds::LightBounds;
use super::super::receiver::Receiver;
use super::scale::Scale;

/// Slot of lamps that are never chosen, and of the root.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Children of a node, one per lane.
pub(super) const LANES: usize = 4;

/// What a lane leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Another node.
    Node(usize),
    /// A lamp.
    Lamp(usize),
}

/// Children of a node, by lane: the sphere that holds their lamps, the cone that holds their normals, their power. Lanes
/// without a child have no power.
#[derive(Clone, Debug)]
#[repr(align(16))]
pub(super) struct Node {
    centre: [[f32; LANES]; 3],
    radius: [f32; LANES],
    /// 1 ÷ radius².
    most_nearness: [f32; LANES],
    axis: [[f32; LANES]; 3],
    /// Sine of the cone's spread; 2, which outweighs every cosine, when the spread is a right angle or more.
    sin_spread: [f32; LANES],
    power: [f32; LANES],
    children: [Child; LANES],
    /// Slot of the parent that leads here.
    parent: u32,
}

/// Squared distances below this count as this; the lamps fill a box of size one.
const LEAST_SQUARED_DISTANCE: f32 = 1e-30;

impl Node {
    /// A node without children, to which slot `parent` leads.
    pub(super) const fn empty(parent: u32) -> Self {
        Self {
            centre: [[0.0; LANES]; 3],
            radius: [0.0; LANES],
            most_nearness: [0.0; LANES],
            axis: [[0.0; LANES]; 3],
            sin_spread: [0.0; LANES],
            power: [0.0; LANES],
            children: [Child::Lamp(NOWHERE as usize); LANES],
            parent,
        }
    }

    /// Puts a child that holds `lamps` into `lane`. `power` is that of all lamps of the tree.
    pub(super) fn set(&mut self, lane: usize, lamps: &LightBounds, child: Child, scale: &Scale, power: f64) {
        let (min, max) = (scale.position(lamps.bounds.min), scale.position(lamps.bounds.max));
        let centre = 0.5 * (min + max);
        for axis in 0..3 {
            self.centre[axis][lane] = centre[axis];
            self.axis[axis][lane] = lamps.cone.axis()[axis];
        }
        let radius = 0.5 * (max - min).length();
        self.radius[lane] = radius;
        self.most_nearness[lane] = (radius * radius).max(LEAST_SQUARED_DISTANCE).recip();
        let spread = lamps.cone.spread();
        self.sin_spread[lane] = if spread < FRAC_PI_2 { spread.sin() as f32 } else { 2.0 };
        // What is shared out must not vanish, else it would never be found.
        self.power[lane] = ((lamps.power / power) as f32).max(f32::MIN_POSITIVE);
        self.children[lane] = child;
    }

    /// Where `lane` leads.
    #[inline]
    pub(super) fn child(&self, lane: usize) -> Child {
        self.children[lane]
    }

    /// Slot of the parent, [`NOWHERE`] for the root.
    #[inline]
    pub(super) fn parent(&self) -> u32 {
        self.parent
    }

    /// What each child may send to `receiver` at the scaled position `position`, at least one of them above 0: power over
    /// squared distance, times the cosines at lamp and receiver, as large as sphere and cone allow. Where no child may send
    /// anything, their powers alone, so that probabilities add up to one.
    #[inline]
    pub(super) fn importance(&self, position: Vec3, receiver: &Receiver) -> [f32; LANES] {
        let importance = self.sent(position, receiver);
        if importance.iter().any(|i| *i > 0.0) { importance } else { self.power }
    }

    /// The same, 0 where nothing comes from. No branches, so that lanes are computed side by side.
    ///
    /// The greatest cosine within a cone of half angle β round a direction at the angle α is cos max(0, α − β) (pbrt-v4,
    /// section 12.6.3). In its place stands min(1, cos α + sin β): it is 0 for the same α, as good for small β, and needs no
    /// other sines and cosines. For a cone round the directions of another one the sines are added, which is never less than
    /// the sine of both angles.
    #[inline]
    fn sent(&self, position: Vec3, receiver: &Receiver) -> [f32; LANES] {
        let mut sent = [0.0; LANES];
        let normal = receiver.normal;
        for lane in 0..LANES {
            let x = position.x - self.centre[0][lane];
            let y = position.y - self.centre[1][lane];
            let z = position.z - self.centre[2][lane];
            let squared = x * x + y * y + z * z;
            let nearness = 1.0 / if squared > LEAST_SQUARED_DISTANCE { squared } else { LEAST_SQUARED_DISTANCE };
            let inverse = nearness.sqrt();
            // Of the angle under which the sphere is seen; above 1 inside it.
            let sin_half = self.radius[lane] * inverse;
            let cos_lamp = (self.axis[0][lane] * x + self.axis[1][lane] * y + self.axis[2][lane] * z) * inverse;
            let cos_there = -(normal.x * x + normal.y * y + normal.z * z) * inverse;
            let cos_there = if receiver.two_sided { cos_there.abs() } else { cos_there };
            let cosines = unit(cos_lamp + self.sin_spread[lane] + sin_half) * unit(cos_there + sin_half);
            // Within the sphere lamps are not all at its centre.
            let most = self.most_nearness[lane];
            sent[lane] = self.power[lane] * cosines * if nearness < most { nearness } else { most };
        }
        sent
    }
}

/// `x` clamped to 0 … 1. The standard library's functions heed NaN, which costs several instructions.
#[inline]
fn unit(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}
