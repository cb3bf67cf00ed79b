//! Where tables of albedo by angle and roughness have their entries.

/// The `i`-th of `n` cosines, at the fourth powers of 0 … 1: albedo bends most near the horizon.
pub(super) fn cosine(i: usize, n: usize) -> f32 {
    place(i, n).powi(4).max(1e-6)
}

/// The `i`-th of `n` roughnesses, at the cubes of 0 … 1.
pub(super) fn roughness(i: usize, n: usize) -> f32 {
    place(i, n).powi(3).max(1e-4)
}

/// The entry before a cosine among `n`, and the share of the one after it.
#[inline]
pub(super) fn locate_cosine(cosine: f32, n: usize) -> (usize, f32) {
    locate(cosine.sqrt().sqrt(), n)
}

/// The entry before a roughness among `n`, and the share of the one after it.
#[inline]
pub(super) fn locate_roughness(alpha: f32, n: usize) -> (usize, f32) {
    locate(alpha.cbrt(), n)
}

/// The `i`-th of `n` even places of 0 … 1.
fn place(i: usize, n: usize) -> f32 {
    i as f32 / (n - 1) as f32
}

/// The place before `x` among `n` even ones, and the share of the one after it.
#[inline]
fn locate(x: f32, n: usize) -> (usize, f32) {
    let at = x.clamp(0.0, 1.0) * (n - 1) as f32;
    let before = (at as usize).min(n - 2);
    (before, at - before as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_where_they_are() {
        // The first ones are moved away from 0.
        for i in 3..48 {
            for (before, share) in [locate_cosine(cosine(i, 48), 48), locate_roughness(roughness(i, 48), 48)] {
                assert!((before as f32 + share - i as f32).abs() < 1e-3, "{i}: {before} {share}");
            }
        }
        assert_eq!((locate_cosine(1.0, 48), locate_cosine(0.0, 48)), ((46, 1.0), (0, 0.0)));
    }
}
