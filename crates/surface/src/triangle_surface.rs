//! Triangle surface: connectivity of any list of triangles.
//!
//! The faces of each vertex are found by a counting sort, and the edges from the faces of
//! their smaller vertex, so that building is linear and the numbering depends on the faces
//! alone.

use crate::csr::Csr;
use crate::{SurfaceError, TriangleFeature};

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
    component_roots: Vec<u32>,
}

/// Edges of a list of faces, in ascending order of their ends.
struct Edges {
    ends: Vec<[u32; 2]>,
    /// The edges of each face.
    of_faces: Vec<[u32; 3]>,
    /// The faces of each edge.
    faces: Csr,
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
        let component_roots = component_roots(vertex_count, &faces, &vertex_faces);
        let Edges { ends: edges, of_faces: face_edges, faces: edge_faces } =
            Edges::number(&faces, &vertex_faces);
        Ok(Self {
            vertex_count,
            faces,
            edges,
            face_edges,
            edge_faces,
            vertex_faces,
            component_roots,
        })
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

    /// Returns the faces that share a feature of a face: itself, or those at its edge or corner. An edge
    /// between equal corners is the face's alone.
    ///
    /// # Panics
    ///
    /// When there is no such face.
    #[must_use]
    pub fn faces_around<'a>(&'a self, face: &'a u32, feature: TriangleFeature) -> &'a [u32] {
        let number = *face as usize;
        match feature {
            TriangleFeature::Corner(k) => self.vertex_faces(self.faces[number][k]),
            TriangleFeature::Edge(k) if self.face_edges[number][k] != NO_EDGE => {
                self.edge_faces(self.face_edges[number][k])
            }
            TriangleFeature::Edge(_) | TriangleFeature::Face => std::slice::from_ref(face),
        }
    }

    /// Returns the smallest vertex of each connected component, ascending.
    ///
    /// Vertices without a face belong to no component.
    #[inline]
    #[must_use]
    pub fn component_roots(&self) -> &[u32] {
        &self.component_roots
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

/// Finds the faces at each vertex, ascending, each once.
fn vertex_faces(vertex_count: usize, faces: &[[u32; 3]]) -> Csr {
    let mut sorted = Csr::default();
    sorted.refill(vertex_count, (0..).zip(faces).flat_map(corners_of_face));
    sorted
}

/// Returns the corners of a face with the face, each vertex once.
#[inline]
fn corners_of_face(
    (face, &[a, b, c]): (u32, &[u32; 3]),
) -> impl Iterator<Item = (u32, u32)> + Clone {
    let corners = [(a, true), (b, b != a), (c, c != a && c != b)];
    corners.into_iter().filter(|(_, is_new)| *is_new).map(move |(vertex, _)| (vertex, face))
}

/// Finds the smallest vertex of each connected component, by flood fill over the faces of
/// its vertices.
fn component_roots(vertex_count: usize, faces: &[[u32; 3]], vertex_faces: &Csr) -> Vec<u32> {
    let mut roots = Vec::new();
    let mut is_reached = vec![false; vertex_count];
    let mut stack = Vec::new();

    for (vertex, around) in (0..).zip(vertex_faces.iter()) {
        if around.is_empty() || is_reached[vertex as usize] {
            continue;
        }
        roots.push(vertex);
        is_reached[vertex as usize] = true;
        stack.push(vertex);
        while let Some(at) = stack.pop() {
            for &face in vertex_faces.row(at) {
                for corner in faces[face as usize] {
                    if !std::mem::replace(&mut is_reached[corner as usize], true) {
                        stack.push(corner);
                    }
                }
            }
        }
    }
    roots
}

impl Edges {
    /// Numbers the edges.
    fn number(faces: &[[u32; 3]], vertex_faces: &Csr) -> Self {
        let mut ends: Vec<[u32; 2]> = Vec::with_capacity(faces.len() * 3 / 2);
        let mut of_faces = vec![[NO_EDGE; 3]; faces.len()];
        let (mut starts, mut along) = (Vec::new(), Vec::with_capacity(3 * faces.len()));
        starts.reserve(ends.capacity() + 1);

        let mut half_edges: Vec<HalfEdge> = Vec::new();
        for (smaller, around) in (0..).zip(vertex_faces.iter()) {
            half_edges.clear();
            for &face in around {
                push_upward(smaller, face, faces[face as usize], &mut half_edges);
            }

            // Sorted by the larger end, equal ones are one edge, and its faces ascend.
            half_edges.sort_unstable();
            let mut previous = smaller;
            for half_edge in &half_edges {
                let larger = half_edge.larger();
                if larger != previous {
                    ends.push([smaller, larger]);
                    starts.push(as_index(along.len()));
                    previous = larger;
                }
                let (face, k) = half_edge.side();
                along.push(face);
                of_faces[face as usize][k] = as_index(ends.len() - 1);
            }
        }
        starts.push(as_index(along.len()));
        Self { ends, of_faces, faces: Csr::from_parts(starts, along) }
    }
}

/// Side of a face, seen from its smaller end: the larger end, then the side's number `3 * face + k`,
/// which runs from corner `k` to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct HalfEdge(u64);

impl HalfEdge {
    fn new(larger: u32, face: u32, k: u32) -> Self {
        Self(u64::from(larger) << 32 | u64::from(3 * face + k))
    }

    fn larger(self) -> u32 {
        (self.0 >> 32) as u32
    }

    /// Returns the face, and the place of the side in it.
    #[expect(clippy::cast_possible_truncation, reason = "the low half is the number of the side")]
    fn side(self) -> (u32, usize) {
        let number = self.0 as u32;
        (number / 3, number as usize % 3)
    }
}

/// Appends the sides of a face from one of its corners to larger ones.
#[inline]
fn push_upward(smaller: u32, face: u32, [a, b, c]: [u32; 3], half_edges: &mut Vec<HalfEdge>) {
    if a == b || b == c || c == a {
        for (k, from, to) in [(0, a, b), (1, b, c), (2, c, a)] {
            if from.min(to) == smaller && from != to {
                half_edges.push(HalfEdge::new(from.max(to), face, k));
            }
        }
        return;
    }

    // Two sides meet at a corner: the one that leaves it, and the one before.
    let (leaving, to, arriving, from) = if a == smaller {
        (0, b, 2, c)
    } else if b == smaller {
        (1, c, 0, a)
    } else {
        (2, a, 1, b)
    };
    if to > smaller {
        half_edges.push(HalfEdge::new(to, face, leaving));
    }
    if from > smaller {
        half_edges.push(HalfEdge::new(from, face, arriving));
    }
}

#[expect(clippy::cast_possible_truncation, reason = "corners are numbered in 32 bits")]
fn as_index(count: usize) -> u32 {
    count as u32
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
        fixtures::generate::cases(21, 1000, |u| {
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

    #[test]
    fn features_are_shared_by_the_faces_around_them() {
        let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 0, 4]];
        let surface = TriangleSurface::new(5, faces).expect("valid corners");
        let around = |face: u32, feature| surface.faces_around(&face, feature).to_vec();
        assert_eq!(around(1, TriangleFeature::Face), [1]);
        assert_eq!(around(1, TriangleFeature::Edge(0)), [0, 1], "from 0 to 1");
        assert_eq!(around(1, TriangleFeature::Edge(2)), [1, 3], "from 3 to 0");
        assert_eq!(around(1, TriangleFeature::Corner(1)), [0, 1, 2]);
        assert_eq!(around(4, TriangleFeature::Edge(0)), [4], "of equal corners");
    }
}
