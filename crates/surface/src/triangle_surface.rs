//! Triangle surface: connectivity of any list of triangles.
//!
//! Edges are found by a counting sort of half-edges over their smaller vertex,
//! so that building is linear and the numbering depends on the faces alone.

use crate::SurfaceError;
use crate::csr::Csr;

/// Placeholder for the missing edge between two equal corners of a face.
pub const NO_EDGE: u32 = u32::MAX;

/// Maximum number of vertices, or of corners: 32-bit indices with one to spare for
/// [`NO_EDGE`].
pub(crate) const MAX_COUNT: usize = u32::MAX as usize - 1;

/// Vertices and oriented triangles: the connectivity, without positions.
///
/// Any list of faces with valid indices is accepted. An edge may have one face
/// (a border), two, or more; a face may repeat a vertex. [`inspect`](crate::inspect())
/// reports the defects.
///
/// ```
/// use surface::TriangleSurface;
///
/// let tetrahedron = TriangleSurface::new(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// assert_eq!(tetrahedron.edges().len(), 6);
/// assert_eq!(tetrahedron.edge_faces(0).len(), 2);
/// # Ok::<(), surface::SurfaceError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TriangleSurface {
    vertex_count: usize,
    faces: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    face_edges: Vec<[u32; 3]>,
    edge_faces: Csr,
    vertex_faces: Csr,
}

impl TriangleSurface {
    /// Numbers the edges of `faces` over `vertex_count` vertices.
    ///
    /// # Errors
    ///
    /// - [`SurfaceError::TooMany`] when 32-bit indices cannot number the
    ///   vertices or the corners of the faces.
    /// - [`SurfaceError::VertexOutOfRange`] with the first face that refers to
    ///   a vertex that does not exist.
    pub fn new(vertex_count: usize, faces: Vec<[u32; 3]>) -> Result<Self, SurfaceError> {
        check_count("vertices", vertex_count, MAX_COUNT)?;
        check_count("faces", faces.len(), MAX_COUNT / 3)?; // corners are numbered too
        check_indices(vertex_count, &faces)?;

        let vertex_faces = vertex_faces(vertex_count, &faces);
        let (edges, face_edges) = number_edges(vertex_count, &faces);
        let edge_faces = edge_faces(edges.len(), &face_edges);
        Ok(Self { vertex_count, faces, edges, face_edges, edge_faces, vertex_faces })
    }

    /// Returns |V|.
    #[inline]
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Returns the corners of the faces, |F| × 3, counter-clockwise from outside.
    #[inline]
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Returns the ends of the edges, |E| × 2, the smaller first, in ascending order.
    #[inline]
    #[must_use]
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Returns the edges of the faces, |F| × 3: the `k`th runs from corner `k` to the next.
    /// [`NO_EDGE`] where these are one vertex.
    #[inline]
    #[must_use]
    pub fn face_edges(&self) -> &[[u32; 3]] {
        &self.face_edges
    }

    /// Returns the faces at an edge, ascending; a face that runs along it twice counts
    /// twice.
    ///
    /// # Panics
    ///
    /// When there is no such edge.
    #[inline]
    #[must_use]
    pub fn edge_faces(&self, edge: u32) -> &[u32] {
        self.edge_faces.row(edge)
    }

    /// Returns the faces at a vertex, ascending, each once.
    ///
    /// # Panics
    ///
    /// When there is no such vertex.
    #[inline]
    #[must_use]
    pub fn vertex_faces(&self, vertex: u32) -> &[u32] {
        self.vertex_faces.row(vertex)
    }
}

/// Checks that there are at most `limit` elements.
pub(crate) fn check_count(
    what: &'static str,
    count: usize,
    limit: usize,
) -> Result<(), SurfaceError> {
    if count <= limit { Ok(()) } else { Err(SurfaceError::TooMany { what, count, limit }) }
}

fn check_indices(vertex_count: usize, faces: &[[u32; 3]]) -> Result<(), SurfaceError> {
    for (face, corners) in faces.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertex_count) {
            return Err(SurfaceError::VertexOutOfRange { face, vertex, vertex_count });
        }
    }
    Ok(())
}

fn vertex_faces(vertex_count: usize, faces: &[[u32; 3]]) -> Csr {
    let mut pairs = Vec::with_capacity(3 * faces.len());
    for (face, &[a, b, c]) in (0..).zip(faces) {
        pairs.push((a, face));
        if b != a {
            pairs.push((b, face));
        }
        if c != a && c != b {
            pairs.push((c, face));
        }
    }
    Csr::new(vertex_count, &pairs)
}

/// Numbers the edges in ascending order of their ends; returns them, and those of each
/// face.
fn number_edges(vertex_count: usize, faces: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
    // Half-edges, numbered `3 * face + k`, by their smaller end.
    let mut by_smaller = Vec::with_capacity(3 * faces.len());
    for (face, &[a, b, c]) in (0..).zip(faces) {
        let (ab, bc, ca) = (3 * face, 3 * face + 1, 3 * face + 2);
        by_smaller.extend([(a.min(b), ab), (b.min(c), bc), (c.min(a), ca)]);
    }
    let by_smaller = Csr::new(vertex_count, &by_smaller);

    // Sorted by the larger end, equal ones are one edge.
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(faces.len() * 3 / 2);
    let mut face_edges = vec![[NO_EDGE; 3]; faces.len()];
    let mut by_larger: Vec<(u32, u32)> = Vec::new();
    for (smaller, half_edges) in (0_u32..).zip(by_smaller.iter()) {
        by_larger.clear();
        by_larger.extend(half_edges.iter().map(|&h| (larger_end(faces, h), h)));
        by_larger.sort_unstable();
        for &(larger, half_edge) in &by_larger {
            if larger == smaller {
                continue; // between two equal corners
            }
            if edges.last() != Some(&[smaller, larger]) {
                edges.push([smaller, larger]);
            }
            face_edges[half_edge as usize / 3][half_edge as usize % 3] = last_index(&edges);
        }
    }
    (edges, face_edges)
}

/// Returns the larger end of half-edge `3 * face + k`.
fn larger_end(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    let (face, k) = (half_edge as usize / 3, half_edge as usize % 3);
    faces[face][k].max(faces[face][(k + 1) % 3])
}

#[expect(clippy::cast_possible_truncation, reason = "there are fewer edges than corners")]
fn last_index(edges: &[[u32; 2]]) -> u32 {
    (edges.len() - 1) as u32
}

fn edge_faces(edge_count: usize, face_edges: &[[u32; 3]]) -> Csr {
    let mut pairs = Vec::with_capacity(3 * face_edges.len());
    for (face, edges) in (0..).zip(face_edges) {
        for &edge in edges.iter().filter(|edge| **edge != NO_EDGE) {
            pairs.push((edge, face));
        }
    }
    Csr::new(edge_count, &pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Finds the edges from every face, by sorting.
    fn reference_edges(faces: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = faces
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .filter(|[from, to]| from != to)
            .map(|[from, to]| [from.min(to), from.max(to)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    #[test]
    fn numbers_any_list_as_brute_force_does() {
        arbtest::arbtest(|u| {
            let vertex_count = u.int_in_range(1..=9_u32)?;
            let mut faces = Vec::new();
            for _ in 0..u.int_in_range(0..=14)? {
                let mut corner = || u.int_in_range(0..=vertex_count - 1);
                faces.push([corner()?, corner()?, corner()?]);
            }
            let surface = TriangleSurface::new(vertex_count as usize, faces.clone()).unwrap();
            assert_eq!(surface.edges(), reference_edges(&faces));
            for (edge, ends) in (0..).zip(surface.edges()) {
                let along: Vec<u32> = (0..)
                    .zip(surface.face_edges())
                    .flat_map(|(face, edges)| edges.map(|e| (e, face)))
                    .filter_map(|(e, face)| (e == edge).then_some(face))
                    .collect();
                assert_eq!(surface.edge_faces(edge), along, "{ends:?}");
                for &face in &along {
                    assert!(ends.iter().all(|end| faces[face as usize].contains(end)));
                }
            }
            for vertex in 0..vertex_count {
                let at: Vec<u32> = (0..)
                    .zip(&faces)
                    .filter_map(|(f, c)| c.contains(&vertex).then_some(f))
                    .collect();
                assert_eq!(surface.vertex_faces(vertex), at);
            }
            Ok(())
        });
    }

    #[test]
    fn refuses_what_is_not_a_list_of_faces() {
        let outside = SurfaceError::VertexOutOfRange { face: 1, vertex: 9, vertex_count: 4 };
        assert_eq!(TriangleSurface::new(4, vec![[0, 1, 2], [0, 9, 1]]), Err(outside));
        let limit = u32::MAX as usize - 1;
        let many = SurfaceError::TooMany { what: "vertices", count: limit + 1, limit };
        assert_eq!(TriangleSurface::new(limit + 1, vec![]), Err(many));
    }

    #[test]
    fn nothing_is_a_surface() {
        let empty = TriangleSurface::new(0, vec![]).unwrap();
        assert!(empty.edges().is_empty() && empty.faces().is_empty());
    }
}
