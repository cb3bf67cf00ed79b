//! Polygons cut into triangles.

use glam::{DVec2, DVec3, Vec3};

/// Looks at another corner that cutting ears takes at most, for each corner: a polygon that folds back on itself a
/// thousand times is cut, one made to take for ever is not.
const LOOKS: usize = 4096;

/// Triangles, as corners' numbers, of the polygon with these corners, wound as the polygon is; `None` when a fan round the
/// first corner will do, because it is convex.
///
/// Others lose one ear after the other (Meisters 1975), in the plane of their mean normal (Newell's). What has no ears,
/// because it crosses itself, becomes a fan, and so does what is not flat or not finite.
pub(super) fn cut_concave(corners: &[Vec3]) -> Option<Vec<[usize; 3]>> {
    let normal = mean_normal(corners);
    if corners.len() <= 3 || is_convex(corners, normal) {
        return None;
    }
    let (mut triangles, rest) = cut_ears(&flattened(corners, normal.try_normalize()?), (0..corners.len()).collect());
    triangles.extend(fan(rest.len()).map(|t| t.map(|i| rest[i])));
    Some(triangles)
}

/// Triangles, as corners' numbers, of a fan round the first of `count` corners.
pub(super) fn fan(count: usize) -> impl Iterator<Item = [usize; 3]> {
    (1..count.saturating_sub(1)).map(|i| [0, i, i + 1])
}

/// Twice the area of the polygon times its unit normal.
fn mean_normal(corners: &[Vec3]) -> DVec3 {
    let at = |i: usize| (corners[i % corners.len()] - corners[0]).as_dvec3();
    (0..corners.len()).map(|i| at(i).cross(at(i + 1))).sum()
}

/// Whether every corner turns left round `normal`, or not at all. Also what is not finite, which no cut would mend.
fn is_convex(corners: &[Vec3], normal: DVec3) -> bool {
    let n = corners.len();
    let turn = |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|step| corners[(i + step) % n].as_dvec3());
        (b - a).cross(c - b).dot(normal)
    };
    !(0..n).any(|i| turn(i) < 0.0)
}

/// Corners in the plane across the unit vector `normal`, round which they run counter-clockwise.
fn flattened(corners: &[Vec3], normal: DVec3) -> Vec<DVec2> {
    let (x, y) = normal.any_orthonormal_pair();
    let from_first = |corner: &Vec3| (*corner - corners[0]).as_dvec3();
    corners.iter().map(|corner| DVec2::new(from_first(corner).dot(x), from_first(corner).dot(y))).collect()
}

/// Twice the area of a triangle; positive when it runs counter-clockwise.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Ears of the polygon `ring`, and what is left of it when no more are found: three corners at best.
fn cut_ears(flat: &[DVec2], mut ring: Vec<usize>) -> (Vec<[usize; 3]>, Vec<usize>) {
    let mut triangles = vec![];
    let mut looks = LOOKS * ring.len();
    let (mut at, mut tried) = (0, 0);
    while ring.len() > 3 && tried < ring.len() && looks > ring.len() {
        looks -= ring.len();
        let n = ring.len();
        let ear = [ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]];
        if is_ear(flat, &ring, ear) {
            triangles.push(ear);
            ring.remove(at);
            // Go on beside the ear: cutting one corner after another would make a fan of needles.
            at = (at + 1) % ring.len();
            tried = 0;
        } else {
            at = (at + 1) % n;
            tried += 1;
        }
    }
    (triangles, ring)
}

/// Whether the triangle turns left and holds no other corner of `ring`.
fn is_ear(flat: &[DVec2], ring: &[usize], ear: [usize; 3]) -> bool {
    let [a, b, c] = ear.map(|i| flat[i]);
    if area(a, b, c) <= 0.0 {
        return false;
    }
    let holds = |p: DVec2| area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0;
    // Holes are joined to the outline by an edge there and back: its corners come twice, and do not count.
    let is_corner = |p: DVec2| p == a || p == b || p == c;
    !ring.iter().any(|&i| !ear.contains(&i) && !is_corner(flat[i]) && holds(flat[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulate(corners: &[Vec3]) -> Vec<[usize; 3]> {
        cut_concave(corners).unwrap_or_else(|| fan(corners.len()).collect())
    }

    /// A star of `points` points, tilted in space.
    fn star(points: usize, inner: f32) -> Vec<Vec3> {
        let corner = |i: usize| {
            let radius = [1.0, inner][i % 2];
            let (sin, cos) = (std::f32::consts::PI * i as f32 / points as f32).sin_cos();
            Vec3::new(radius * cos + 5.0, radius * sin, 0.5 * radius * sin + 2.0)
        };
        (0..2 * points).map(corner).collect()
    }

    /// Sum of the areas, and the area of the whole by Newell: equal only when triangles neither overlap nor stick out.
    fn areas(corners: &[Vec3], triangles: &[[usize; 3]]) -> (f32, f32) {
        let n = corners.len();
        let whole: Vec3 = (0..n).map(|i| (corners[i] - corners[0]).cross(corners[(i + 1) % n] - corners[0])).sum();
        let of = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).length();
        (triangles.iter().map(of).sum(), whole.length())
    }

    #[test]
    fn convex_polygons_become_fans() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        assert_eq!(triangulate(&square), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangulate(&square[..3]), [[0, 1, 2]]);
        let bent = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.2), Vec3::Y];
        assert_eq!(triangulate(&bent), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let arrow = vec![Vec3::ZERO, Vec3::new(2.0, -1.0, 0.0), Vec3::new(0.5, 0.0, 0.0), Vec3::new(2.0, 1.0, 0.0)];
        // A square with a square hole, joined by an edge there and back.
        let hole = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0], [1, 1], [1, 3], [3, 3], [3, 1], [1, 1]];
        let hole = hole.map(|[x, y]| Vec3::new(x as f32, y as f32, 1.0)).to_vec();
        for turn in 0..4 {
            for polygon in [&arrow, &star(5, 0.3), &star(40, 0.9), &hole] {
                let mut polygon = polygon.clone();
                polygon.rotate_left(turn);
                for reversed in [false, true] {
                    if reversed {
                        polygon.reverse();
                    }
                    let triangles = triangulate(&polygon);
                    assert_eq!(triangles.len(), polygon.len() - 2);
                    let (sum, whole) = areas(&polygon, &triangles);
                    assert!((sum / whole - 1.0).abs() < 1e-4, "{} {turn}: {sum} {whole}", polygon.len());
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_cut_becomes_as_many_triangles() {
        let crossed = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)];
        let point = [Vec3::ONE; 5];
        let bad = [Vec3::ZERO, Vec3::NAN, Vec3::Y, Vec3::X, Vec3::Z];
        for polygon in [&crossed[..], &point, &bad] {
            assert_eq!(triangulate(polygon).len(), polygon.len() - 2);
        }
        // A comb of four thousand teeth ends, cut or not.
        let comb = (0..8000).map(|i| Vec3::new((i % 2) as f32 * 100.0, i as f32, 0.0));
        let comb: Vec<Vec3> = comb.chain([Vec3::new(-1.0, 8000.0, 0.0), Vec3::new(-1.0, -1.0, 0.0)]).collect();
        assert_eq!(triangulate(&comb).len(), comb.len() - 2);
    }
}
