//! Relief that is in a texture and not in the mesh.

use glam::{Vec2, Vec3};

/// Least share of the normal that points outwards: a map that says less is taken for one that lies in the surface.
const LEAST_HEIGHT: f32 = 0.01;

/// The normal that a normal map's `texel` stands for, on a triangle with these corners and texture coordinates whose
/// interpolated normal is `smooth`.
///
/// +x of the map runs along u, +y along v. `smooth` where the texture coordinates do not say where that is, or where the
/// map's normal would point into the surface.
pub(super) fn normal(texel: Vec3, smooth: Vec3, geometric: Vec3, corners: [Vec3; 3], uvs: [Vec2; 3]) -> Vec3 {
    let Some([tangent, bitangent]) = tangents(smooth, corners, uvs) else { return smooth };
    let local = 2.0 * texel - Vec3::ONE;
    let local = Vec3::new(local.x, local.y, local.z.max(LEAST_HEIGHT));
    let bent = local.x * tangent + local.y * bitangent + local.z * smooth;
    match bent.try_normalize() {
        Some(bent) if bent.dot(geometric) > 0.0 => bent,
        _ => smooth,
    }
}

/// Unit vectors across `normal` along u and v; a right angle apart, whatever the texture coordinates do.
fn tangents(normal: Vec3, corners: [Vec3; 3], uvs: [Vec2; 3]) -> Option<[Vec3; 2]> {
    let [along, across] = [corners[1] - corners[0], corners[2] - corners[0]];
    let [a, b] = [uvs[1] - uvs[0], uvs[2] - uvs[0]];
    let turn = a.perp_dot(b);
    if turn == 0.0 || !turn.is_finite() {
        return None;
    }
    let of_u = turn.signum() * (along * b.y - across * a.y);
    let of_v = turn.signum() * (across * a.x - along * b.x);
    let tangent = (of_u - of_u.dot(normal) * normal).try_normalize()?;
    let bitangent = normal.cross(tangent);
    Some([tangent, if bitangent.dot(of_v) < 0.0 { -bitangent } else { bitangent }])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn texel(normal: Vec3) -> Vec3 {
        0.5 * (normal + Vec3::ONE)
    }

    #[test]
    fn the_map_s_axes_are_those_of_the_texture_coordinates() {
        let tilted = Vec3::new(0.6, 0.0, 0.8);
        for (uvs, expected) in [
            ([Vec2::ZERO, Vec2::X, Vec2::Y], tilted),
            // Turned by a quarter, shrunk, mirrored, shifted.
            ([Vec2::ZERO, Vec2::Y, -Vec2::X], Vec3::new(0.0, -0.6, 0.8)),
            ([Vec2::ZERO, 9.0 * Vec2::X, 9.0 * Vec2::Y], tilted),
            ([Vec2::ZERO, -Vec2::X, Vec2::Y], Vec3::new(-0.6, 0.0, 0.8)),
            ([Vec2::ONE, Vec2::new(2.0, 1.0), Vec2::new(1.0, 2.0)], tilted),
        ] {
            let found = normal(texel(tilted), Vec3::Z, Vec3::Z, CORNERS, uvs);
            assert!((found - expected).length() < 1e-6, "{uvs:?}: {found}");
        }
        let up = Vec3::new(0.0, 0.6, 0.8);
        let mirrored = [Vec2::ZERO, -Vec2::X, Vec2::Y];
        assert!((normal(texel(up), Vec3::Z, Vec3::Z, CORNERS, mirrored) - up).length() < 1e-6);
    }

    #[test]
    fn a_flat_map_changes_nothing_and_neither_does_one_without_coordinates() {
        let smooth = Vec3::new(0.28, 0.0, 0.96);
        let uvs = [Vec2::ZERO, Vec2::X, Vec2::Y];
        assert!((normal(texel(Vec3::Z), smooth, Vec3::Z, CORNERS, uvs) - smooth).length() < 1e-6);
        assert_eq!(normal(texel(Vec3::X), smooth, Vec3::Z, CORNERS, [Vec2::ONE; 3]), smooth);
        assert!(normal(texel(-Vec3::X), smooth, Vec3::Z, CORNERS, uvs).z > 0.0);
    }
}
