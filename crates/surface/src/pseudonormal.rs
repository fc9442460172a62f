//! Normals by which the sign of a distance is right on faces, edges and corners.
//!
//! At an edge or a vertex the closest point belongs to several faces, some of
//! which see the query from the front and others from behind. The sum of their
//! normals, each weighted by its face's angle there, points to the right side.
//!
//! Source: J. A. Bærentzen and H. Aanæs, "Signed Distance Computation Using the
//! Angle Weighted Pseudonormal", IEEE Transactions on Visualization and Computer
//! Graphics 11(3), 2005. Differs in taking any list of faces: a face without area
//! has no say, and where all have none the normal is zero.
//!
//! The side is right for a closed, manifold, oriented surface that does not cross
//! itself, and a foot that is the closest point of the *whole* surface. Vertices
//! that only share a place are not one vertex: on a surface sewn from patches
//! without shared vertices the sides along the seams are those of one patch.

use std::f64::consts::PI;

use glam::DVec3;

use crate::{ClosestOnTriangle, NO_EDGE, Positions, TriangleFeature, TriangleSurface};

/// Unit normals of a surface's faces, edges and vertices, in one state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pseudonormals {
    faces: Vec<DVec3>,
    edges: Vec<DVec3>,
    vertices: Vec<DVec3>,
}

impl Pseudonormals {
    /// Normals of `surface` in the state `x`.
    ///
    /// ```
    /// use surface::{Pseudonormals, TriangleFeature, TriangleSurface, closest_on_triangle, glam::DVec3};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let surface = TriangleSurface::new(4, faces)?;
    /// let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let x = surface.positions(&x)?;
    /// let normals = Pseudonormals::new(&surface, x);
    ///
    /// // Closest to a corner, where a face's own normal may say "inside".
    /// let p = DVec3::new(-0.1, -0.2, 1.5);
    /// let foot = closest_on_triangle(p, x.corners(surface.faces()[1]));
    /// assert_eq!(foot.feature, TriangleFeature::Corner(2));
    /// assert!(normals.signed_distance(&surface, p, 1, &foot) > 0.0);
    /// # Ok::<(), surface::SurfaceError>(())
    /// ```
    ///
    /// # Panics
    ///
    /// When `x` was checked against a surface with fewer vertices.
    #[must_use]
    pub fn new(surface: &TriangleSurface, x: Positions<'_>) -> Self {
        let faces: Vec<DVec3> =
            surface.faces().iter().map(|face| face_normal(x.corners(*face))).collect();
        let mut edges = vec![DVec3::ZERO; surface.edges().len()];
        let mut vertices = vec![DVec3::ZERO; surface.vertex_count()];
        for ((corners, along), normal) in
            surface.faces().iter().zip(surface.face_edges()).zip(&faces)
        {
            for edge in along.iter().filter(|edge| **edge != NO_EDGE) {
                edges[*edge as usize] += *normal;
            }
            let angles = corner_angles(x.corners(*corners));
            for (vertex, angle) in corners.iter().zip(angles) {
                vertices[*vertex as usize] += angle * *normal;
            }
        }
        let unit = |sums: Vec<DVec3>| sums.into_iter().map(DVec3::normalize_or_zero).collect();
        Self { faces, edges: unit(edges), vertices: unit(vertices) }
    }

    /// Normals of the faces, |F|: zero where a face has no area.
    #[must_use]
    pub fn faces(&self) -> &[DVec3] {
        &self.faces
    }

    /// Normals of the edges, |E|: of the sum over their faces.
    #[must_use]
    pub fn edges(&self) -> &[DVec3] {
        &self.edges
    }

    /// Normals of the vertices, |V|: of the sum over their faces, weighted by the
    /// angles.
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// The normal of a face, or of one of its edges or corners.
    ///
    /// # Panics
    ///
    /// When there is no such face, or these are not the normals of `surface`.
    #[must_use]
    pub fn at(&self, surface: &TriangleSurface, face: u32, feature: TriangleFeature) -> DVec3 {
        let face = face as usize;
        match feature {
            TriangleFeature::Face => self.faces[face],
            TriangleFeature::Edge(k) => {
                let edge = surface.face_edges()[face][k];
                if edge == NO_EDGE { DVec3::ZERO } else { self.edges[edge as usize] }
            }
            TriangleFeature::Corner(k) => self.vertices[surface.faces()[face][k] as usize],
        }
    }

    /// Distance of `p` from its foot on a face, negative inside.
    ///
    /// The foot must be the closest point of the whole surface. Where the normal
    /// there does not tell, as on the surface itself, the sign is positive.
    ///
    /// # Panics
    ///
    /// As [`at`](Self::at).
    #[must_use]
    pub fn signed_distance(
        &self,
        surface: &TriangleSurface,
        p: DVec3,
        face: u32,
        foot: &ClosestOnTriangle,
    ) -> f64 {
        let away = p - foot.point;
        let inside = away.dot(self.at(surface, face, foot.feature)) < 0.0;
        if inside { -away.length() } else { away.length() }
    }
}

fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Angles of a triangle at its corners \[rad\], which sum to π.
fn corner_angles([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let double_area = (b - a).cross(c - a).length();
    let at = |u: DVec3, v: DVec3| double_area.atan2(u.dot(v));
    let (of_a, of_b) = (at(b - a, c - a), at(c - b, a - b));
    [of_a, of_b, (PI - of_a - of_b).max(0.0)]
}
