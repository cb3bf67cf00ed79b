//! Shading normals that what mirrors can live with.

use glam::Vec3;

/// Least cosine between what is mirrored and the real surface's normal.
const HORIZON: f32 = 0.01;

/// The unit normal `normal`, turned as far towards `geometric` as it takes that the light a mirror would send to `outgoing` comes
/// from above the real surface: what mirrors would be black there. Cycles does the same (`ensure_valid_specular_reflection`).
pub(super) fn lifted(normal: Vec3, geometric: Vec3, outgoing: Vec3) -> Vec3 {
    let mirrored = 2.0 * normal.dot(outgoing) * normal - outgoing;
    let above = mirrored.dot(geometric);
    // What is seen from nearly along the surface cannot be mirrored far above it.
    let least = HORIZON.min(0.9 * geometric.dot(outgoing));
    if above >= least {
        return normal;
    }
    let raised = (mirrored + (least - above) * geometric).normalize_or(geometric);
    (raised + outgoing).normalize_or(geometric)
}
