//! The pattern of the propagation filter: which pixels it reaches, and over which paths.

/// One pixel of the pattern and how its weight follows from its parent's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Offset of the pixel q from the centre c.
    pub offset: [isize; 2],
    /// Offset of its parent p, the pixel before it on the path.
    pub parent: [isize; 2],
    /// Which of [`NEIGHBOURS`] leads from p to q.
    pub direction: usize,
    /// Steps from the centre, the Manhattan distance.
    pub depth: usize,
}

/// The four steps a path is made of.
pub const NEIGHBOURS: [[isize; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

/// All pixels within Manhattan distance `radius` of the centre, except itself: 2r² + 2r of them.
///
/// Parents come before their children and no other branch comes between (depth first), so that the weights of at most
/// `radius` pixels need to be kept at any time.
pub fn steps(radius: usize) -> Vec<Step> {
    let reach = radius as isize;
    let mut found = Vec::new();
    visit([0, 0], reach, &mut found);
    found
}

fn visit(parent: [isize; 2], reach: isize, found: &mut Vec<Step>) {
    for (direction, [dx, dy]) in NEIGHBOURS.into_iter().enumerate() {
        let offset = [parent[0] + dx, parent[1] + dy];
        let distance = offset[0].abs() + offset[1].abs();
        if distance <= reach && offset != [0, 0] && parent_of(offset) == parent {
            found.push(Step { offset, parent, direction, depth: distance as usize });
            visit(offset, reach, found);
        }
    }
}

/// The pixel before `offset` on its path from the centre (the paper's figure 6): on an axis one step towards the
/// centre; off it one step vertically where the Manhattan distance is odd, horizontally where it is even.
fn parent_of([x, y]: [isize; 2]) -> [isize; 2] {
    let vertical = x == 0 || (y != 0 && (x.abs() + y.abs()) % 2 == 1);
    if vertical { [x, y - y.signum()] } else { [x - x.signum(), y] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pattern_is_the_whole_diamond_once() {
        for radius in 0..7 {
            let steps = steps(radius);
            assert_eq!(steps.len() + 1, 2 * radius * radius + 2 * radius + 1);
            let mut offsets: Vec<_> = steps.iter().map(|s| s.offset).collect();
            offsets.sort_unstable();
            offsets.dedup();
            assert_eq!(offsets.len(), steps.len());
        }
    }

    #[test]
    fn paths_turn_as_the_figure_shows() {
        assert_eq!(parent_of([3, 0]), [2, 0]);
        assert_eq!(parent_of([0, -2]), [0, -1]);
        assert_eq!(parent_of([2, 1]), [2, 0], "distance 3: vertical");
        assert_eq!(parent_of([1, -1]), [0, -1], "distance 2: horizontal");
        assert_eq!(parent_of([-2, 2]), [-1, 2]);
        assert_eq!(parent_of([-1, 2]), [-1, 1]);
    }

    #[test]
    fn the_parent_is_the_last_step_one_level_up() {
        let mut last = [[0, 0]; 8];
        for step in steps(5) {
            assert_eq!(last[step.depth - 1], step.parent);
            let [dx, dy] = NEIGHBOURS[step.direction];
            assert_eq!(step.offset, [step.parent[0] + dx, step.parent[1] + dy]);
            last[step.depth] = step.offset;
        }
    }
}
