//! Closed shapes about as large as muscles, in millimetres.

use fixtures::Mesh;
use fixtures::shapes::ellipsoid;
use glam::DVec3;

/// A flat, bent belly, 120 long.
pub(crate) fn muscle() -> Mesh {
    ellipsoid(DVec3::new(60.0, 22.0, 9.0), 3)
        .mapped(|p| p + DVec3::Z * (0.004 * p.x * p.x + 2.0 * (p.y / 12.0).sin()))
}
