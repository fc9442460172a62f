//! What a list of triangles lacks to be a closed, oriented manifold, by its
//! connectivity alone.
//!
//! Each search yields its offenders in ascending order, so that the first is
//! the same on every run and can be found in the file the mesh came from.

use crate::{NO_EDGE, SurfaceError, TriangleSurface, UnionFind};

impl TriangleSurface {
    /// Whether no edge has one face only.
    ///
    /// True of a surface without faces. An edge with three faces is no border
    /// either: only a surface that is also manifold encloses a solid for sure.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.boundary_edges().next().is_none()
    }

    /// Whether no edge has more than two faces, and the faces at each vertex
    /// hang together by edges.
    #[must_use]
    pub fn is_manifold(&self) -> bool {
        self.non_manifold_edges().next().is_none() && self.non_manifold_vertices().next().is_none()
    }

    /// Whether no two faces run along an edge in the same direction.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.repeated_half_edges().next().is_none()
    }

    /// Refuses a surface that [is not closed](Self::is_closed).
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

    /// Refuses a surface that [is not manifold](Self::is_manifold).
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

    /// Refuses a surface that [is not oriented](Self::is_oriented).
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

    /// Edges with one face.
    pub(crate) fn boundary_edges(&self) -> impl Iterator<Item = u32> {
        self.edges_with(|faces| faces == 1)
    }

    /// Edges with more than two faces.
    pub(crate) fn non_manifold_edges(&self) -> impl Iterator<Item = u32> {
        self.edges_with(|faces| faces > 2)
    }

    fn edges_with(&self, wanted: impl Fn(usize) -> bool) -> impl Iterator<Item = u32> {
        (0..)
            .zip(self.edges())
            .map(|(edge, _)| edge)
            .filter(move |e| wanted(self.edge_faces(*e).len()))
    }

    /// Directions `[from, to]` in which more than one face runs along an edge.
    pub(crate) fn repeated_half_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        (0..).zip(self.edges()).flat_map(|(edge, &[from, to])| {
            let [there, back] = self.runs_along(edge);
            let there = (there > 1).then_some([from, to]);
            there.into_iter().chain((back > 1).then_some([to, from]))
        })
    }

    /// How many times faces run from an edge's smaller vertex to its larger one,
    /// and back.
    fn runs_along(&self, edge: u32) -> [usize; 2] {
        let [smaller, _] = self.edges()[edge as usize];
        let faces = self.edge_faces(edge);
        let mut runs = [0, 0];
        for (i, &face) in faces.iter().enumerate() {
            if i > 0 && faces[i - 1] == face {
                continue; // a face that repeats a vertex runs along one edge twice
            }
            for k in (0..3).filter(|k| self.face_edges()[face as usize][*k] == edge) {
                runs[usize::from(self.faces()[face as usize][k] != smaller)] += 1;
            }
        }
        runs
    }

    /// Vertices whose faces do not all hang together by edges at the vertex.
    pub(crate) fn non_manifold_vertices(&self) -> impl Iterator<Item = u32> {
        let mut walk =
            Walk { reached: Vec::new(), reached_for: vec![u32::MAX; self.faces().len()] };
        self.vertices().filter(move |vertex| !walk.reaches_all_faces(self, *vertex))
    }

    fn ends_at(&self, edge: u32, vertex: u32) -> bool {
        edge != NO_EDGE && self.edges()[edge as usize].contains(&vertex)
    }

    /// Vertices without a face.
    pub(crate) fn isolated_vertices(&self) -> impl Iterator<Item = u32> {
        self.vertices().filter(|vertex| self.vertex_faces(*vertex).is_empty())
    }

    /// Faces that refer to one vertex more than once.
    pub(crate) fn faces_with_repeats(&self) -> impl Iterator<Item = u32> {
        (0..).zip(self.face_edges()).filter(|(_, edges)| edges.contains(&NO_EDGE)).map(|(f, _)| f)
    }

    /// Faces with the three corners of an earlier one, in whatever order.
    pub(crate) fn duplicate_faces(&self) -> impl Iterator<Item = u32> {
        (0..).zip(self.face_edges()).filter_map(|(face, edges)| {
            let whole = !edges.contains(&NO_EDGE);
            (whole && self.has_earlier_twin(face, *edges)).then_some(face)
        })
    }

    fn has_earlier_twin(&self, face: u32, edges: [u32; 3]) -> bool {
        let corners = self.faces()[face as usize];
        let is_twin = |other: &u32| {
            let others = self.faces()[*other as usize];
            corners.iter().all(|corner| others.contains(corner))
        };
        let first = self.edge_faces(edges[0]);
        let fewest = if first.len() <= 2 {
            Some(first)
        } else {
            edges.into_iter().map(|edge| self.edge_faces(edge)).min_by_key(|faces| faces.len())
        };
        fewest.into_iter().flatten().take_while(|other| **other < face).any(is_twin)
    }

    /// Returns the smallest vertex of each connected component, ascending.
    ///
    /// Vertices without a face belong to no component.
    pub fn component_roots(&self) -> impl Iterator<Item = u32> {
        let mut sets = UnionFind::new(self.vertex_count());
        for &[a, b, c] in self.faces() {
            sets.join(a, b);
            sets.join(a, c);
        }
        self.vertices().filter(move |v| sets.is_root(*v) && !self.vertex_faces(*v).is_empty())
    }

    pub(crate) fn vertices(&self) -> impl Iterator<Item = u32> + use<> {
        let count = u32::try_from(self.vertex_count());
        0..count.unwrap_or_default() // `new` refuses more than can be numbered
    }
}

/// Scratch for walking about vertices.
struct Walk {
    /// Faces reached about the present vertex.
    reached: Vec<u32>,
    /// For each face, the last vertex about which it was reached.
    reached_for: Vec<u32>,
}

impl Walk {
    /// Whether all faces of a vertex are reached from its first across edges at
    /// the vertex.
    fn reaches_all_faces(&mut self, surface: &TriangleSurface, vertex: u32) -> bool {
        let faces = surface.vertex_faces(vertex);
        self.reached.clear();
        faces.first().into_iter().for_each(|face| self.reach(vertex, *face));
        let mut next = 0;
        while next < self.reached.len() && self.reached.len() < faces.len() {
            let edges = surface.face_edges()[self.reached[next] as usize];
            next += 1;
            for edge in edges.into_iter().filter(|edge| surface.ends_at(*edge, vertex)) {
                surface.edge_faces(edge).iter().for_each(|face| self.reach(vertex, *face));
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
