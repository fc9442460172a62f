//! Topological defects: reasons why a list of triangles is not a closed, oriented
//! manifold.
//!
//! Each search yields its offenders in ascending order, so that the first is
//! the same on every run and can be found in the file the mesh came from.

use std::cmp::Ordering;

use crate::{NO_EDGE, SurfaceError, TriangleSurface};

impl TriangleSurface {
    /// Returns true if no edge has one face only.
    ///
    /// True of a surface without faces. An edge with three faces is no border
    /// either: only a surface that is also manifold is sure to enclose a solid.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.boundary_edges().next().is_none()
    }

    /// Checks that no edge has one face only.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Open`] with the number of border edges and the first.
    pub fn require_closed(&self) -> Result<(), SurfaceError> {
        let Some(edge) = self.boundary_edges().next() else { return Ok(()) };
        let [from, to] = self.edges()[edge as usize];
        let (count, face) = (self.boundary_edges().count(), self.edge_faces(edge)[0]);
        Err(SurfaceError::Open { count, from, to, face })
    }

    /// Checks that no edge has more than two faces, and that the faces at each vertex are
    /// connected by edges at it.
    ///
    /// # Errors
    ///
    /// - [`SurfaceError::NonManifold`] where an edge has more than two faces.
    /// - [`SurfaceError::NonManifoldVertex`] where only a vertex joins faces.
    pub fn require_manifold(&self) -> Result<(), SurfaceError> {
        if let Some(edge) = self.non_manifold_edges().next() {
            let [from, to] = self.edges()[edge as usize];
            let count = self.non_manifold_edges().count();
            return Err(SurfaceError::NonManifold { count, from, to });
        }
        if let Some(vertex) = self.non_manifold_vertices().next() {
            let count = self.non_manifold_vertices().count();
            return Err(SurfaceError::NonManifoldVertex { count, vertex });
        }
        Ok(())
    }

    /// Checks that no two faces run along an edge in the same direction.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Misoriented`] with the first edge, in the direction that
    /// more than one face runs along.
    pub fn require_oriented(&self) -> Result<(), SurfaceError> {
        let Some([from, to]) = self.repeated_half_edges().next() else { return Ok(()) };
        let count = self.repeated_half_edges().count();
        Err(SurfaceError::Misoriented { count, from, to })
    }

    /// Finds the edges with one face.
    pub(crate) fn boundary_edges(&self) -> impl Iterator<Item = u32> {
        self.edge_numbers().filter(|edge| self.edge_faces(*edge).len() == 1)
    }

    /// Finds the edges with more than two faces.
    pub(crate) fn non_manifold_edges(&self) -> impl Iterator<Item = u32> {
        self.edge_numbers().filter(|edge| self.edge_faces(*edge).len() > 2)
    }

    /// Finds the directions `[from, to]` in which more than one face runs along an edge.
    ///
    /// One pass over the faces settles that there are none, as on nearly all surfaces.
    pub(crate) fn repeated_half_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let is_oriented = self.is_oriented();
        let edges = self.edge_numbers().filter(move |_| !is_oriented);
        edges.flat_map(|edge| {
            let [from, to] = self.edges()[edge as usize];
            let [forward, backward] = self.half_edge_counts(edge);
            let forward = (forward > 1).then_some([from, to]);
            forward.into_iter().chain((backward > 1).then_some([to, from]))
        })
    }

    /// Finds the directions `[from, to]` in which more faces run along an edge than against it.
    ///
    /// Without any, the surface bounds a solid that covers each place a whole number of times, also
    /// where four faces meet at an edge.
    pub fn unbalanced_half_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.edge_numbers().filter_map(|edge| {
            let [from, to] = self.edges()[edge as usize];
            let [forward, backward] = self.half_edge_counts(edge);
            match forward.cmp(&backward) {
                Ordering::Equal => None,
                Ordering::Greater => Some([from, to]),
                Ordering::Less => Some([to, from]),
            }
        })
    }

    /// Returns true if no two faces run along an edge in the same direction.
    fn is_oriented(&self) -> bool {
        let mut has_face = vec![[false; 2]; self.edges().len()];
        for (corners, edges) in self.faces().iter().zip(self.face_edges()) {
            for (k, &edge) in edges.iter().enumerate() {
                if edge == NO_EDGE {
                    continue;
                }
                let is_backward = corners[k] > corners[(k + 1) % 3];
                let has_face = &mut has_face[edge as usize][usize::from(is_backward)];
                if std::mem::replace(has_face, true) {
                    return false;
                }
            }
        }
        true
    }

    /// Counts the faces that run from an edge's smaller vertex to its larger one, and back.
    fn half_edge_counts(&self, edge: u32) -> [usize; 2] {
        let [smaller, _] = self.edges()[edge as usize];
        let faces = self.edge_faces(edge);
        let mut counts = [0, 0];

        for (i, &face) in faces.iter().enumerate() {
            if i > 0 && faces[i - 1] == face {
                continue; // a face that repeats a vertex runs along one edge twice
            }
            for k in (0..3).filter(|k| self.face_edges()[face as usize][*k] == edge) {
                counts[usize::from(self.faces()[face as usize][k] != smaller)] += 1;
            }
        }
        counts
    }

    /// Finds the vertices whose faces are not all connected by edges at the vertex.
    pub(crate) fn non_manifold_vertices(&self) -> impl Iterator<Item = u32> {
        let mut search =
            FaceSearch { reached: Vec::new(), reached_for: vec![u32::MAX; self.faces().len()] };
        self.vertices().filter(move |&vertex| match self.is_one_fan(vertex) {
            Some(is_one_fan) => !is_one_fan,
            None => !search.reaches_all_faces(self, vertex),
        })
    }

    /// Returns true if the faces of a vertex are one closed fan; `None` where a face repeats a
    /// vertex, or an edge has another number of faces than two.
    ///
    /// Nearly all vertices of a closed surface are decided by this walk around them.
    fn is_one_fan(&self, vertex: u32) -> Option<bool> {
        let faces = self.vertex_faces(vertex);
        let first = *faces.first()?;
        let (mut face, mut crossed, mut count) = (first, NO_EDGE, 0);
        loop {
            let corners = self.faces()[face as usize];
            let edges = self.face_edges()[face as usize];
            if edges.contains(&NO_EDGE) {
                return None;
            }

            // Of the two edges at the vertex, the walk leaves by the one it did not come by.
            let (leaving, arriving) = if corners[0] == vertex {
                (edges[0], edges[2])
            } else if corners[1] == vertex {
                (edges[1], edges[0])
            } else {
                (edges[2], edges[1])
            };
            crossed = if leaving == crossed { arriving } else { leaving };
            let &[one, other] = self.edge_faces(crossed) else { return None };
            face = if one == face { other } else { one };
            count += 1;
            if face == first {
                return Some(count == faces.len());
            }
        }
    }

    /// Finds the vertices without a face.
    pub(crate) fn isolated_vertices(&self) -> impl Iterator<Item = u32> {
        self.vertices().filter(|vertex| self.vertex_faces(*vertex).is_empty())
    }

    /// Finds the faces that refer to one vertex more than once.
    pub(crate) fn faces_with_repeats(&self) -> impl Iterator<Item = u32> {
        self.face_numbers().filter(|face| self.face_edges()[*face as usize].contains(&NO_EDGE))
    }

    /// Finds the faces with the three corners of an earlier one, in whatever order, among those at
    /// vertices with at most `max_faces` faces.
    pub(crate) fn duplicate_faces(&self, max_faces: usize) -> impl Iterator<Item = u32> {
        self.face_numbers().filter(move |&face| {
            let corner = self.faces()[face as usize][0];
            self.vertex_faces(corner).len() <= max_faces && self.is_duplicate(face)
        })
    }

    fn is_duplicate(&self, face: u32) -> bool {
        let edges = self.face_edges()[face as usize];
        if edges.contains(&NO_EDGE) {
            return false;
        }

        // A duplicate is at all three edges: search the one with the fewest faces, which
        // on a manifold is any.
        let mut fewest = self.edge_faces(edges[0]);
        for edge in &edges[1..] {
            if fewest.len() > 2 && self.edge_faces(*edge).len() < fewest.len() {
                fewest = self.edge_faces(*edge);
            }
        }
        let [a, b, c] = self.faces()[face as usize];
        for &other in fewest {
            if other >= face {
                break;
            }
            let corners = self.faces()[other as usize];
            if corners.contains(&a) && corners.contains(&b) && corners.contains(&c) {
                return true;
            }
        }
        false
    }

    /// Returns the numbers of the faces; `new` refuses more than can be numbered.
    pub(crate) fn face_numbers(&self) -> impl Iterator<Item = u32> + use<> {
        (0..u32::MAX).take(self.faces().len())
    }

    fn edge_numbers(&self) -> impl Iterator<Item = u32> + use<> {
        (0..u32::MAX).take(self.edges().len())
    }

    pub(crate) fn vertices(&self) -> impl Iterator<Item = u32> + use<> {
        (0..u32::MAX).take(self.vertex_count())
    }
}

/// Breadth-first search over the faces of one vertex, with reused memory.
struct FaceSearch {
    /// Faces of the present vertex, in the order reached.
    reached: Vec<u32>,
    /// For each face, the last vertex about which it was reached.
    reached_for: Vec<u32>,
}

impl FaceSearch {
    /// Returns true if all faces of a vertex are reached from its first across edges at
    /// the vertex.
    fn reaches_all_faces(&mut self, surface: &TriangleSurface, vertex: u32) -> bool {
        // Start from the first face.
        let faces = surface.vertex_faces(vertex);
        self.reached.clear();
        if let Some(&first) = faces.first() {
            self.reach(vertex, first);
        }

        // Cross the two edges at the vertex of each face reached.
        let mut next = 0;
        while next < self.reached.len() && self.reached.len() < faces.len() {
            let edges = surface.face_edges()[self.reached[next] as usize];
            next += 1;
            for edge in edges {
                if edge == NO_EDGE || !surface.edges()[edge as usize].contains(&vertex) {
                    continue;
                }
                for &face in surface.edge_faces(edge) {
                    self.reach(vertex, face);
                }
            }
        }
        self.reached.len() == faces.len()
    }

    fn reach(&mut self, vertex: u32, face: u32) {
        if self.reached_for[face as usize] != vertex {
            self.reached_for[face as usize] = vertex;
            self.reached.push(face);
        }
    }
}
