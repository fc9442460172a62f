//! Angle-weighted pseudonormals, which give a distance the right sign on faces, edges
//! and corners.
//!
//! At an edge or a vertex the closest point belongs to several faces; the query is in
//! front of some and behind others. The sum of their normals, each weighted by its
//! face's angle there, decides the side.
//!
//! Source: J. A. Bærentzen and H. Aanæs, "Signed Distance Computation Using the
//! Angle Weighted Pseudonormal", IEEE Transactions on Visualization and Computer
//! Graphics 11(3), 2005. Differs in accepting any list of faces: a face without area
//! does not count, and where no face has area the normal is zero.
//!
//! The side is right for a closed, manifold, oriented surface that does not cross
//! itself, and a foot that is the closest point of the *whole* surface. At an edge of
//! a face without area the normals of one side alone count, and the side may be
//! wrong where the surface turns by more than a right angle there. Vertices
//! that only share a place are not one vertex: on a surface sewn from patches
//! without shared vertices the sides along the seams are those of one patch.

use std::f64::consts::PI;

use glam::DVec3;

use crate::measures::normalized;
use crate::{ClosestOnTriangle, NO_EDGE, Positions, TriangleFeature, TriangleSurface, triangle};

/// Angle-weighted pseudonormals of a surface's faces, edges and vertices, in one state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pseudonormals {
    faces: Vec<DVec3>,
    edges: Vec<DVec3>,
    vertices: Vec<DVec3>,
}

impl Pseudonormals {
    /// Computes the normals of `surface` at positions `x`.
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
    /// // Closest to a corner, where the face's own normal may point away.
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
        let mut faces = Vec::with_capacity(surface.faces().len());
        let mut edges = vec![DVec3::ZERO; surface.edges().len()];
        let mut vertices = vec![DVec3::ZERO; surface.vertex_count()];

        // Each face adds its normal to its edges and, by its angles, to its corners.
        for (&face, along) in surface.faces().iter().zip(surface.face_edges()) {
            let normal = triangle::unit_normal(x.corners(face));
            for &edge in along.iter().filter(|edge| **edge != NO_EDGE) {
                edges[edge as usize] += normal;
            }
            for (vertex, angle) in face.into_iter().zip(corner_angles(x.corners(face))) {
                vertices[vertex as usize] += angle * normal;
            }
            faces.push(normal);
        }
        Self { faces, edges: normalized(edges), vertices: normalized(vertices) }
    }

    /// Computes the normal of one face, edge or corner without those of all others.
    ///
    /// # Panics
    ///
    /// When there is no such face, or `x` was checked against a surface with fewer
    /// vertices.
    #[must_use]
    pub fn of_feature(
        surface: &TriangleSurface,
        x: Positions<'_>,
        face: u32,
        feature: TriangleFeature,
    ) -> DVec3 {
        let corners = surface.faces()[face as usize];
        let mut sum = DVec3::ZERO;
        match feature {
            TriangleFeature::Face => return triangle::unit_normal(x.corners(corners)),
            // Plain sum: both faces subtend the same angle at an edge.
            TriangleFeature::Edge(k) => {
                let edge = surface.face_edges()[face as usize][k];
                let faces = if edge == NO_EDGE { &[] } else { surface.edge_faces(edge) };
                for &face in faces {
                    sum += triangle::unit_normal(x.corners(surface.faces()[face as usize]));
                }
            }
            TriangleFeature::Corner(k) => {
                for &face in surface.vertex_faces(corners[k]) {
                    let face = surface.faces()[face as usize];
                    let normal = triangle::unit_normal(x.corners(face));
                    let angles = corner_angles(x.corners(face));
                    for (_, angle) in face.iter().zip(angles).filter(|at| *at.0 == corners[k]) {
                        sum += angle * normal;
                    }
                }
            }
        }
        sum.normalize_or_zero()
    }

    /// Returns the normals of the faces, |F|: zero where a face has no area.
    #[must_use]
    pub fn faces(&self) -> &[DVec3] {
        &self.faces
    }

    /// Returns the normals of the edges, |E|: of the sum over their faces.
    #[must_use]
    pub fn edges(&self) -> &[DVec3] {
        &self.edges
    }

    /// Returns the normals of the vertices, |V|: of the sum over their faces, weighted by
    /// the angles.
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Returns the normal of a face, or of one of its edges or corners.
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

    /// Computes the distance of `p` from its foot on a face, negative inside.
    ///
    /// The foot must be the closest point of the whole surface. Where the normal there
    /// does not decide, as on the surface itself, the sign is positive.
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

/// Computes the angles of a triangle at its corners \[rad\], which sum to π.
fn corner_angles([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let double_area = triangle::normal([a, b, c]).length();
    let at = |u: DVec3, v: DVec3| double_area.atan2(u.dot(v));
    let (of_a, of_b) = (at(b - a, c - a), at(c - b, a - b));
    [of_a, of_b, (PI - of_a - of_b).max(0.0)]
}
