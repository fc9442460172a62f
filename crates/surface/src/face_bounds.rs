//! Box around the faces of a surface.

use glam::DVec3;

use crate::{Aabb, Positions, TriangleSurface};

impl TriangleSurface {
    /// Returns the positions of the vertices that have faces, ascending. Others, as reference nodes of a solver, are no
    /// part of the surface.
    pub fn used_positions(&self, x: Positions<'_>) -> impl Iterator<Item = DVec3> {
        let has_faces = |vertex: &u32| !self.vertex_faces(*vertex).is_empty();
        self.vertices().filter(has_faces).map(move |vertex| x.at(vertex))
    }

    /// Returns the box around all faces: vertices without a face may be out of it.
    #[must_use]
    pub fn bounds(&self, x: Positions<'_>) -> Aabb {
        Aabb::of_points(self.used_positions(x))
    }
}
