//! Choosing among many lamps by how much each may send to a point.
//!
//! A tree over lamps (Conty Estevez and Kulla 2018; pbrt-v4, section 12.6.3), of which every node knows for each of its
//! children where its lamps are, where they shine and how much in all. A choice walks from the root to a lamp, and takes
//! every child in proportion to what it may send. Nodes have several children, so that clusters, whose sending can only be
//! guessed from near by, are passed over quickly.

mod build;
mod node;
mod scale;

use node::{Child, LANES, NOWHERE, Node};
use scale::Scale;

use super::fork::CHOICES;
use super::receiver::Receiver;

/// A tree over lamps.
#[derive(Debug, Default)]
pub(crate) struct LightTree {
    /// The root first; none when nothing shines.
    nodes: Vec<Node>,
    /// Where each lamp is: number of the node × [`LANES`] + lane; [`NOWHERE`] for one without power.
    slots: Vec<u32>,
    scale: Scale,
    power: f64,
}

/// A lamp that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChosenLamp {
    pub(super) index: usize,
    /// With which probability; above 0.
    pub(super) probability: f32,
}

impl LightTree {
    /// Power of all lamps together.
    pub(super) const fn power(&self) -> f64 {
        self.power
    }

    /// Chooses a lamp for `receiver` by the whole number `choice`, uniform over 2³². `None` when none has power.
    pub(super) fn sample_lamp(&self, receiver: &Receiver, choice: u32) -> Option<ChosenLamp> {
        let position = self.scale.position(receiver.position);
        // What is left of the number after a decision is as uniform as it was, and makes the next one.
        let mut choice = (f64::from(choice) + 0.5) / CHOICES as f64;
        let mut probability = 1.0;
        let mut node = self.nodes.first()?;
        loop {
            let importance = node.importance(position, receiver);
            let total = sum(&importance);
            let (lane, rest) = pick(&importance, choice * f64::from(total));
            probability *= importance[lane] / total;
            choice = rest;
            match node.child(lane) {
                Child::Node(index) => node = &self.nodes[index],
                Child::Lamp(index) => return Some(ChosenLamp { index, probability }),
            }
        }
    }

    /// Probability with which [`sample_lamp`](Self::sample_lamp) chooses lamp `index` for `receiver`. Over all lamps they
    /// add up to 1, if any has power.
    pub(super) fn lamp_probability(&self, receiver: &Receiver, index: usize) -> f32 {
        let Some(&slot) = self.slots.get(index).filter(|slot| **slot != NOWHERE) else { return 0.0 };
        let mut slot = slot;
        let position = self.scale.position(receiver.position);
        let mut probability = 1.0;
        while slot != NOWHERE {
            let node = &self.nodes[slot as usize / LANES];
            let importance = node.importance(position, receiver);
            probability *= importance[slot as usize % LANES] / sum(&importance);
            slot = node.parent();
        }
        probability
    }
}

fn sum(of_lanes: &[f32; LANES]) -> f32 {
    of_lanes.iter().sum()
}

/// The lane in which `target`, from 0 to the sum of all, falls, and how far into it, in [0, 1).
fn pick(importance: &[f32; LANES], target: f64) -> (usize, f64) {
    let (mut before, mut last) = (0.0, 0);
    for (lane, &importance) in importance.iter().enumerate().filter(|(_, importance)| **importance > 0.0) {
        let into = (target - before) / f64::from(importance);
        if into < 1.0 {
            return (lane, into.max(0.0));
        }
        before += f64::from(importance);
        last = lane;
    }
    // The f32 sum may be a rounding above the f64 one.
    (last, 1.0_f64.next_down())
}

#[cfg(test)]
mod tests;
