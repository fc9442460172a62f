//! Closed bodies: read from files, moved, and the depths of points in them.

use std::collections::BTreeMap;
use std::path::Path;

use fixtures::Mesh;
use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::Aabb;

use crate::measure::as_f64;

/// Returns a generated body with its tree.
///
/// # Panics
///
/// When the vertices of the mesh are not finite.
#[must_use]
pub fn body(mesh: Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("finite positions")
}

/// Reads a body from a file.
///
/// # Panics
///
/// When the file is missing, or not of the form that [`fixtures::ply`] writes.
#[must_use]
pub fn read(path: &Path) -> SurfaceTree {
    body(fixtures::data::mesh(path))
}

/// Returns the body moved by a vector.
///
/// # Panics
///
/// When the vector is not finite.
#[must_use]
pub fn moved(body: &SurfaceTree, by: DVec3) -> SurfaceTree {
    let positions = body.positions().as_slice().iter().map(|p| *p + by).collect();
    SurfaceTree::new(body.shared_surface(), positions).expect("a finite vector")
}

/// Returns the mean of points.
#[must_use]
pub fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / as_f64(points.len())
}

/// Returns the bounding box of a body.
#[must_use]
pub fn bounds(body: &SurfaceTree) -> Aabb {
    Aabb::of_points(body.positions().as_slice().iter().copied())
}

/// Returns the depth of a point in a body, negative outside.
#[must_use]
pub fn depth(body: &SurfaceTree, p: DVec3, workspace: &mut Workspace) -> f64 {
    let closest = body.closest_point(p, f64::INFINITY, None, workspace);
    let distance = closest.map_or(f64::INFINITY, |closest| closest.distance);
    if body.contains(p, workspace) { distance } else { -distance }
}

/// Returns the numbers and depths of the points that are in a body.
#[must_use]
pub fn points_inside(points: &[DVec3], body: &SurfaceTree) -> BTreeMap<u32, f64> {
    let bounds = bounds(body);
    let workspace = &mut Workspace::default();
    let mut inside = BTreeMap::new();
    for (number, &p) in (0..).zip(points) {
        if bounds.contains(p) && body.contains(p, workspace) {
            inside.insert(number, depth(body, p, workspace));
        }
    }
    inside
}
