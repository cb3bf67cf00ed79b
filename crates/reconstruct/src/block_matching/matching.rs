//! Which patches resemble one.

use stack::Size;

use super::group::{PATCH, Patch};

/// The upper left pixel of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
}

impl Corner {
    /// The patch of `plane` there.
    #[inline(always)]
    pub fn patch(self, plane: &[f32], size: Size) -> Patch {
        let mut patch = [[0.0; PATCH]; PATCH];
        for (row, values) in patch.iter_mut().enumerate() {
            values.copy_from_slice(&plane[size.index(self.x, self.y + row)..][..PATCH]);
        }
        patch
    }

    /// Whether one of the patch's pixels is marked.
    pub fn holds_any(self, marks: &[bool], size: Size) -> bool {
        (self.y..self.y + PATCH).any(|y| marks[size.index(self.x, y)..][..PATCH].contains(&true))
    }
}

/// The patches of `plane` nearest to that at `own`, at most `reach` away from it in each direction: as many as the
/// greatest power of two up to `most` that there are, nearest first. That at `own` is the first, also among equals.
#[inline(always)]
pub fn alike(plane: &[f32], size: Size, own: Corner, reach: usize, most: usize) -> Vec<Corner> {
    let patch = own.patch(plane, size);
    let around = |at: usize, length: usize| at.saturating_sub(reach)..(at + reach + 1).min(length - PATCH + 1);
    let mut distances = Vec::with_capacity((2 * reach + 1).pow(2));
    for y in around(own.y, size.height) {
        for x in around(own.x, size.width) {
            let corner = Corner { x, y };
            let distance = if corner == own { -1.0 } else { squared_distance(&patch, &corner.patch(plane, size)) };
            distances.push((distance, corner));
        }
    }
    let count = 1 << distances.len().min(most).ilog2();
    // Among equals the order of pixels counts: results must not depend on how the selection goes about it.
    let nearer =
        |a: &(f32, Corner), b: &(f32, Corner)| a.0.total_cmp(&b.0).then_with(|| (a.1.y, a.1.x).cmp(&(b.1.y, b.1.x)));
    distances.select_nth_unstable_by(count - 1, nearer);
    distances.truncate(count);
    distances.sort_unstable_by(nearer);
    distances.into_iter().map(|(_, corner)| corner).collect()
}

#[inline(always)]
fn squared_distance(a: &Patch, b: &Patch) -> f32 {
    let mut sums = [0.0; PATCH];
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += (a - b) * (a - b);
        }
    }
    sums.iter().sum()
}
