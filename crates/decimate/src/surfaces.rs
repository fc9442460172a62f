//! Full surface, and a coarse one that it is mapped to.

use glam::{DMat3, DVec3};
use surface::{TriangleSurface, closest_on_triangle};

use crate::mesh_point::MeshPoint;

/// Full surface without a boundary, and the vertices that a coarse one has kept.
#[derive(Clone, Copy)]
pub(crate) struct Full<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: &'a [DVec3],
    /// Per vertex of the coarse surface, its number.
    pub(crate) kept: &'a [u32],
    /// Per vertex, the kept one that it has moved into.
    pub(crate) moved_into: &'a [u32],
}

impl Full<'_> {
    /// Returns true for a vertex that some face uses, and that was not kept.
    pub(crate) fn is_moved(&self, vertex: u32) -> bool {
        self.moved_into[vertex as usize] != vertex && self.has_faces(vertex)
    }

    pub(crate) fn has_faces(&self, vertex: u32) -> bool {
        !self.surface.vertex_faces(vertex).is_empty()
    }
}

/// Connectivity and positions of a coarse surface.
#[derive(Clone, Copy)]
pub(crate) struct Coarse<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: &'a [DVec3],
}

impl Coarse<'_> {
    /// Finds a face that contains several points.
    pub(crate) fn common_face(&self, points: &[MeshPoint]) -> Option<u32> {
        // All carriers together have at most three vertices.
        let (mut union, mut count) = ([0; 3], 0);
        for point in points {
            for &vertex in point.carrier() {
                if !union[..count].contains(&vertex) {
                    *union.get_mut(count)? = vertex;
                    count += 1;
                }
            }
        }
        self.faces_with(&union[..count]).next()
    }

    /// Returns the faces that have certain corners, at least one.
    pub(crate) fn faces_with<'s>(&'s self, corners: &'s [u32]) -> impl Iterator<Item = u32> + 's {
        let star = self.surface.vertex_faces(corners[0]).iter().copied();
        star.filter(|&face| self.has_corners(face, corners))
    }

    /// Returns true if a face has certain corners.
    pub(crate) fn has_corners(&self, face: u32, corners: &[u32]) -> bool {
        let own = self.surface.faces()[face as usize];
        corners.iter().all(|corner| own.contains(corner))
    }

    /// Returns the signed area of a triangle between points of a face, over that of the face.
    pub(crate) fn area_share(&self, face: u32, points: &[MeshPoint; 3]) -> f64 {
        let corners = self.surface.faces()[face as usize];
        let [a, b, c] = [0, 1, 2].map(|i| DVec3::from(corners.map(|v| points[i].weight(v))));
        DMat3::from_cols(a, b, c).determinant()
    }

    /// Finds the point of a face that is closest to `p`, and its distance.
    pub(crate) fn closest_on_face(&self, p: DVec3, face: u32) -> NearPoint {
        let corners = self.surface.faces()[face as usize];
        let found = closest_on_triangle(p, corners.map(|v| self.x[v as usize]));
        let image = MeshPoint::on_face(corners, found.barycentric);
        NearPoint { image, distance: found.point.distance(p) }
    }

    /// Finds a point near `p`: walks from a vertex to the nearest face around it, then around
    /// that face's nearest corner, while the distance decreases.
    ///
    /// A walk ends on the sheet of the surface that it begins on, also where another one is
    /// nearer.
    pub(crate) fn descend(&self, p: DVec3, start: u32) -> NearPoint {
        let image = MeshPoint::vertex(start);
        let mut nearest = NearPoint { image, distance: p.distance(self.x[start as usize]) };
        loop {
            let (vertex, before) = (nearest.image.main_vertex(), nearest.distance);
            for &face in self.surface.vertex_faces(vertex) {
                let found = self.closest_on_face(p, face);
                if found.distance < nearest.distance {
                    nearest = found;
                }
            }
            if nearest.image.main_vertex() == vertex || nearest.distance >= before {
                return nearest;
            }
        }
    }
}

/// Point of the coarse surface near some other point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearPoint {
    pub(crate) image: MeshPoint,
    pub(crate) distance: f64,
}
