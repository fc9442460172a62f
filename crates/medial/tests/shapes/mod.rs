//! Closed shapes about as large as muscles, in millimetres.

use fixtures::Mesh;
use fixtures::shapes::{ellipsoid, torus};
use glam::DVec3;

/// A flat, bent belly, 120 long.
#[must_use]
pub fn muscle() -> Mesh {
    ellipsoid(DVec3::new(60.0, 22.0, 9.0), 3)
        .mapped(|p| p + DVec3::Z * (0.004 * p.x * p.x + 2.0 * (p.y / 12.0).sin()))
}

/// The belly and a ring.
#[must_use]
pub fn all() -> [(&'static str, Mesh); 2] {
    [("muscle", muscle()), ("torus", torus(30.0, 9.0, [36, 16]))]
}

/// Weights on a regular grid over a triangle.
pub fn weights(steps: u32) -> impl Iterator<Item = [f64; 3]> {
    (0..=steps).flat_map(move |i| {
        (0..=steps - i).map(move |j| {
            let [b, c] = [i, j].map(|k| f64::from(k) / f64::from(steps));
            [1.0 - b - c, b, c]
        })
    })
}
