//! What stands around a pixel.

use crate::Size;

/// Radius of the largest window that is searched for a known value.
const LARGEST: usize = 8;

/// Median of the finite values among the 3×3 pixels around `index`, 0 when there is none.
pub fn median_around(plane: &[f32], size: Size, index: usize) -> f32 {
    let mut values: Vec<f32> = around(size, index, 1).map(|i| plane[i]).filter(|v| v.is_finite()).collect();
    values.sort_by(f32::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * values[n / 2 - 1] + 0.5 * values[n / 2],
    }
}

/// Mean of the known values in the smallest window around `index` that has any.
pub fn mean_around(plane: &[f32], size: Size, index: usize, unknown: impl Fn(f32) -> bool) -> Option<f32> {
    let mut radius = 1;
    while radius <= LARGEST {
        let known = around(size, index, radius).map(|i| plane[i]).filter(|v| !unknown(*v));
        let (sum, n) = known.fold((0.0, 0), |(sum, n): (f64, u32), v| (sum + f64::from(v), n + 1));
        if n > 0 {
            return Some((sum / f64::from(n)) as f32);
        }
        radius *= 2;
    }
    None
}

fn around(size: Size, index: usize, radius: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (index % size.width, index / size.width);
    let columns = move || x.saturating_sub(radius)..(x + radius + 1).min(size.width);
    let rows = y.saturating_sub(radius)..(y + radius + 1).min(size.height);
    rows.flat_map(move |row| columns().map(move |column| size.index(column, row)))
}
