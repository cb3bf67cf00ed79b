//! Building the tree, from the root down.

use std::ops::Range;

use super::super::light_bounds::LightBounds;
use super::LightTree;
use super::node::{Child, LANES, NOWHERE, Node};
use super::scale::Scale;

/// Places between which an axis may be cut.
const BUCKETS: usize = 12;

/// A lamp with its index.
#[derive(Clone, Copy)]
struct Member {
    lamp: LightBounds,
    index: u32,
}

/// Members that stand side by side.
#[derive(Clone)]
struct Part {
    range: Range<usize>,
    lights: LightBounds,
}

impl LightTree {
    /// A tree over `lamps`, which keep their indices. Lamps whose power is 0 are never chosen.
    pub(in crate::light) fn new(lamps: &[LightBounds]) -> Self {
        let with_index = lamps.iter().enumerate().map(|(i, lamp)| Member { lamp: *lamp, index: i as u32 });
        let mut members: Vec<Member> = with_index.filter(|member| member.lamp.power > 0.0).collect();
        let Some(whole) = Part::of(&members, 0..members.len()) else { return Self::default() };
        let (scale, power) = (Scale::of(&whole.lights.bounds), whole.lights.power);
        let mut nodes = vec![Node::empty(NOWHERE)];
        let mut slots = vec![NOWHERE; lamps.len()];
        // Node i is made of waiting[i].
        let mut waiting = vec![whole];
        for parent in 0.. {
            let Some(part) = waiting.get(parent).cloned() else { break };
            for (lane, part) in split_into_lanes(&mut members, part).into_iter().enumerate() {
                let slot = (parent * LANES + lane) as u32;
                let child = match part.range.len() {
                    1 => Child::Lamp(members[part.range.start].index as usize),
                    _ => Child::Node(nodes.len()),
                };
                nodes[parent].set(lane, &part.lights, child, &scale, power);
                match child {
                    Child::Lamp(index) => slots[index] = slot,
                    Child::Node(_) => {
                        nodes.push(Node::empty(slot));
                        waiting.push(part);
                    }
                }
            }
        }
        Self { nodes, slots, scale, power }
    }
}

impl Part {
    /// The members in `range`, if there are any.
    fn of(members: &[Member], range: Range<usize>) -> Option<Self> {
        let lights = members[range.clone()].iter().map(|member| member.lamp).reduce(LightBounds::union)?;
        Some(Self { range, lights })
    }
}

/// Splits a part, and the dearest of what comes of it again, until there is one for each lane or nothing to split.
fn split_into_lanes(members: &mut [Member], part: Part) -> Vec<Part> {
    if part.range.len() <= LANES {
        return part.range.filter_map(|i| Part::of(members, i..i + 1)).collect();
    }
    let mut parts = vec![part];
    while parts.len() < LANES {
        let several = (0..parts.len()).filter(|&i| parts[i].range.len() > 1);
        let cost = |i: usize| parts[i].lights.cost();
        let Some(dearest) = several.max_by(|&a, &b| cost(a).total_cmp(&cost(b))) else { break };
        let range = parts[dearest].range.clone();
        let middle = split(members, &parts[dearest]);
        let halves = [range.start..middle, middle..range.end].map(|range| Part::of(members, range));
        parts.splice(dearest..=dearest, halves.into_iter().flatten());
    }
    parts
}

/// Puts the members of a part in order so that the cheapest two halves come one after the other; says where the second
/// begins. Neither is empty.
fn split(members: &mut [Member], part: &Part) -> usize {
    let members = &mut members[part.range.clone()];
    let cuts = (0..3).flat_map(|axis| cuts_along(members, axis));
    let cheapest = cuts.min_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(Cut { axis, bucket, .. }) = cheapest else { return part.range.start + members.len() / 2 };
    let buckets = Buckets::along(axis, members);
    let is_second = |member: &Member| buckets.bucket_of(member) >= bucket;
    members.sort_by_key(is_second);
    part.range.start + members.partition_point(|member| !is_second(member))
}

/// A way to split: what lies in `bucket` or beyond goes to the second half.
struct Cut {
    axis: usize,
    bucket: usize,
    cost: f64,
}

/// All cuts along an axis that leave something on either side.
fn cuts_along(members: &[Member], axis: usize) -> Vec<Cut> {
    let buckets = Buckets::along(axis, members);
    let mut lights = [None; BUCKETS];
    for member in members {
        let lights = &mut lights[buckets.bucket_of(member)];
        *lights = either(*lights, Some(member.lamp));
    }
    let mut beyond = lights;
    for bucket in (1..BUCKETS).rev() {
        beyond[bucket - 1] = either(beyond[bucket], lights[bucket - 1]);
    }
    let (mut cuts, mut before) = (vec![], lights[0]);
    for bucket in 1..BUCKETS {
        // Beside an empty bucket is the same cut again.
        if let (Some(before), Some(_), Some(beyond)) = (before, lights[bucket], beyond[bucket]) {
            cuts.push(Cut { axis, bucket, cost: before.cost() + beyond.cost() });
        }
        before = either(before, lights[bucket]);
    }
    cuts
}

fn either(a: Option<LightBounds>, b: Option<LightBounds>) -> Option<LightBounds> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union(b)),
        (a, b) => a.or(b),
    }
}

/// Even parts of the extent of the members' middles along an axis.
struct Buckets {
    axis: usize,
    first: f64,
    extent: f64,
}

impl Buckets {
    fn along(axis: usize, members: &[Member]) -> Self {
        let middles = members.iter().map(|member| member.lamp.middle(axis));
        let (first, last) = middles.fold((f64::MAX, f64::MIN), |(first, last), m| (first.min(m), last.max(m)));
        Self { axis, first, extent: last - first }
    }

    fn bucket_of(&self, member: &Member) -> usize {
        // 0 ÷ 0, where all lie at one place, is bucket 0.
        let share = (member.lamp.middle(self.axis) - self.first) / self.extent;
        ((share * BUCKETS as f64) as usize).min(BUCKETS - 1)
    }
}
