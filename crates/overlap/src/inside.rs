//! Vertices of one surface inside the other, from the edges that the curve cuts.
//!
//! An edge whose passings sum to a net of `+1` runs from outside to inside: its upper end is
//! inside without any ray. From such ends a flood fill over edges with a net of zero visits the
//! inside vertices and no others. A ray checks each fill, and each connected part of the surface
//! that no cut edge settles.
//!
//! If that check finds another winding number than 1, the other surface covers a place twice or
//! the wrong way round; the whole part is then labeled by winding numbers.

use kdop::{Axis, Workspace};
use proximity::SurfaceTree;
use surface::{NO_EDGE, TriangleSurface, ray_crosses_triangle, ray_crosses_triangle_from_below};

use crate::curve::{Curve, index};
use crate::cut_edges::CutEdges;

/// Vertices of one surface inside the other.
#[derive(Debug, Default)]
pub(crate) struct Inside {
    /// The vertices in the order of the fill, cluster after cluster.
    pub(crate) vertices: Vec<InsideVertex>,
    /// One per cluster: the vertex that its fill began at.
    pub(crate) cluster_starts: Vec<u32>,
    /// Faces whose corners are all inside, in one cluster and of one winding number, cluster after
    /// cluster; faces without area that repeat a vertex may be among them wherever they lead.
    faces: Vec<u32>,
    /// One per cluster: where its vertices and its faces end.
    cluster_ends: Vec<[u32; 2]>,
    /// True if the other surface covers a place of the overlap more than once, or inside out: some
    /// winding number is not 1, or a part of the other surface is inverted.
    pub(crate) covers_twice: bool,
    /// True if the other surface was compared, and has an inside.
    pub(crate) is_defined: bool,
    /// One per vertex: 1 + its place in `vertices`, or 0.
    places: Vec<u32>,
    /// One per vertex: true for ends of cut edges.
    is_rim: Vec<bool>,
    /// Vertices that `is_rim` is set for.
    rim: Vec<u32>,
    /// One per vertex: true once a fill by winding numbers has visited it.
    visited: Vec<bool>,
    /// Vertices that a fill by winding numbers has reached and not left.
    stack: Vec<InsideVertex>,
    /// Vertices that a fill from cut edges has reached and not left.
    reached: Vec<u32>,
    /// Inside ends of cut edges, still to be filled from.
    pending: Vec<u32>,
    neighbors: Vec<Neighbor>,
}

/// A vertex inside the other body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InsideVertex {
    pub(crate) vertex: u32,
    /// Winding number of the other surface about it, not zero.
    pub(crate) winding: i32,
    /// Cluster of vertices that edges without a passing connect.
    pub(crate) cluster: u32,
}

/// A vertex and an edge that leads to it.
#[derive(Clone, Copy, Debug)]
struct Neighbor {
    vertex: u32,
    edge: u32,
}

impl Inside {
    /// Finds the vertices of body `side` inside the other, in place of what was found before.
    pub(crate) fn find(
        &mut self,
        side: usize,
        bodies: [&SurfaceTree; 2],
        curve: &Curve,
        traversal: &mut Workspace,
    ) {
        let own = bodies[side];
        self.clear(own);
        self.is_defined = true;
        let cut_edges = &curve.cut_edges[side];
        for cut in cut_edges.as_slice() {
            for end in own.surface().edges()[cut.edge as usize] {
                self.is_rim[end as usize] = true;
                self.rim.push(end);
            }
        }

        let is_simple = self.fill_from_cuts(side, bodies, cut_edges, traversal);
        if !is_simple {
            self.clear_vertices();
            self.fill_by_winding(side, bodies, cut_edges, traversal);
        }
    }

    /// Notes that the other surface covers a place of the overlap twice, at none of the vertices.
    pub(crate) fn note_covered_place(&mut self) {
        self.covers_twice |= self.is_defined;
    }

    /// Takes no vertex to be inside, since the other surface has no inside.
    pub(crate) fn find_none(&mut self, own: &SurfaceTree) {
        self.clear(own);
        self.is_defined = false;
    }

    /// Returns the winding number of the other surface about a vertex, 0 outside.
    pub(crate) fn winding(&self, vertex: u32) -> i32 {
        self.vertex(vertex).map_or(0, |found| found.winding)
    }

    /// Returns the winding number of the other surface about one of [`faces`](Self::faces).
    #[inline]
    pub(crate) fn face_winding(&self, own: &SurfaceTree, face: u32) -> i32 {
        if self.covers_twice { self.winding(own.surface().faces()[face as usize][0]) } else { 1 }
    }

    /// Returns the place of a vertex among those inside.
    #[inline]
    pub(crate) fn place(&self, vertex: u32) -> Option<u32> {
        self.places.get(vertex as usize)?.checked_sub(1)
    }

    /// Returns a vertex if it is inside.
    #[inline]
    pub(crate) fn vertex(&self, vertex: u32) -> Option<InsideVertex> {
        self.place(vertex).map(|place| self.vertices[place as usize])
    }

    /// Returns true if all corners of a face are in one cluster.
    #[inline]
    pub(crate) fn holds_face(&self, [a, b, c]: [u32; 3]) -> bool {
        let key = |vertex| self.vertex(vertex).map(|found| (found.cluster, found.winding));
        let first = key(a);
        first.is_some() && key(b) == first && key(c) == first
    }

    /// Returns the faces whose corners are all inside, in one cluster and of one winding number, and
    /// some that repeat a vertex.
    pub(crate) fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// Returns the vertices of each cluster, and the faces whose corners are all among them and of
    /// one winding number.
    pub(crate) fn clusters(&self) -> impl Iterator<Item = (&[InsideVertex], &[u32])> {
        let mut begin = [0; 2];
        self.cluster_ends.iter().map(move |&end| {
            let [vertices, faces] = std::mem::replace(&mut begin, end).map(|at| at as usize);
            let [last_vertex, last_face] = end.map(|at| at as usize);
            (&self.vertices[vertices..last_vertex], &self.faces[faces..last_face])
        })
    }

    /// Returns the cluster of a vertex, if it is inside.
    pub(crate) fn cluster(&self, vertex: u32) -> Option<u32> {
        self.place(vertex).map(|place| self.vertices[place as usize].cluster)
    }

    /// Empties all lists. Arrays grow to the surface's size and stay zero outside of a query: only
    /// what the query before has set is reset.
    fn clear(&mut self, own: &SurfaceTree) {
        self.clear_vertices();
        for vertex in self.rim.drain(..) {
            self.is_rim[vertex as usize] = false;
        }

        let vertices = own.surface().vertex_count();
        grow(&mut self.places, vertices);
        grow(&mut self.is_rim, vertices);
    }

    fn clear_vertices(&mut self) {
        for inside in self.vertices.drain(..) {
            self.places[inside.vertex as usize] = 0;
        }
        self.cluster_starts.clear();
        self.cluster_ends.clear();
        self.faces.clear();
        self.covers_twice = false;
    }

    /// Fills the inside from cut edges and from parts that are inside as a whole. Returns false
    /// where a ray finds a winding number other than 0 outside or 1 inside.
    fn fill_from_cuts(
        &mut self,
        side: usize,
        bodies: [&SurfaceTree; 2],
        cut_edges: &CutEdges,
        traversal: &mut Workspace,
    ) -> bool {
        // A net of ±1 has its inside end; each fill is checked by one ray.
        let own = bodies[side];
        for cut in cut_edges.as_slice() {
            let [low, high] = own.surface().edges()[cut.edge as usize];
            let start = match cut.net {
                0 => continue,
                1 => high,
                -1 => low,
                _ => return false,
            };
            if self.places[start as usize] != 0 {
                continue;
            }
            if winding_about(side, bodies, start, traversal) != 1 {
                return false;
            }
            self.fill(own, start, cut_edges);
        }

        // An end that is outside must not have been filled.
        for cut in cut_edges.as_slice() {
            let [low, high] = own.surface().edges()[cut.edge as usize];
            if self.winding(high) - self.winding(low) != cut.net {
                return false;
            }
        }

        // Parts without such an edge are inside or outside as a whole.
        for &vertex in own.surface().component_roots() {
            if self.places[vertex as usize] != 0 {
                continue;
            }
            match winding_about(side, bodies, vertex, traversal) {
                0 => {}
                1 => self.fill(own, vertex, cut_edges),
                _ => return false,
            }
        }
        true
    }

    /// Labels the vertices of winding number 1 that edges with a net of zero connect to `start`.
    ///
    /// A cut edge with a net of zero leads to another cluster: the edge leaves the inside between
    /// its ends.
    fn fill(&mut self, own: &SurfaceTree, start: u32, cut_edges: &CutEdges) {
        self.pending.push(start);
        while let Some(start) = self.pending.pop() {
            if self.places[start as usize] == 0 {
                self.fill_cluster(own, start, cut_edges);
            }
        }
    }

    fn fill_cluster(&mut self, own: &SurfaceTree, start: u32, cut_edges: &CutEdges) {
        let cluster = self.begin_cluster(start);
        let first = self.vertices.len();
        self.reach(start, cluster);

        let is_one_way = own.has_winding_number().is_ok();
        while let Some(at) = self.reached.pop() {
            // No edge at most vertices is cut: their neighbors need no edges.
            if is_one_way && !self.is_rim[at as usize] {
                self.fill_uncut_neighbors(own.surface(), at, cluster);
                continue;
            }

            self.collect_neighbors(own, at);
            for i in 0..self.neighbors.len() {
                let Neighbor { vertex, edge } = self.neighbors[i];
                if self.places[vertex as usize] != 0 {
                    continue;
                }
                let cut = if self.is_rim[vertex as usize] { cut_edges.get(edge) } else { None };
                // Beyond an edge with a net of zero the inside begins again, as another cluster.
                match cut {
                    None => self.reach(vertex, cluster),
                    Some(cut) if cut.net == 0 => self.pending.push(vertex),
                    Some(_) => {}
                }
            }
        }
        self.end_cluster(own.surface(), first, is_one_way);
    }

    /// Labels the neighbors of a vertex without a cut edge on a closed oriented surface, and collects
    /// its faces.
    #[inline]
    fn fill_uncut_neighbors(&mut self, surface: &TriangleSurface, at: u32, cluster: u32) {
        for &face in surface.vertex_faces(at) {
            let [a, b, c] = surface.faces()[face as usize];
            // Each neighbor is the next corner of one face, and each face is taken at its first.
            let vertex = if a == at {
                self.faces.push(face);
                b
            } else if b == at {
                c
            } else {
                a
            };
            if self.places[vertex as usize] == 0 {
                self.reach(vertex, cluster);
            }
        }
    }

    /// Labels a vertex, from which the fill goes on.
    fn reach(&mut self, vertex: u32, cluster: u32) {
        self.label(InsideVertex { vertex, winding: 1, cluster });
        self.reached.push(vertex);
    }

    /// Labels every part of the surface by winding numbers, from one ray each.
    fn fill_by_winding(
        &mut self,
        side: usize,
        bodies: [&SurfaceTree; 2],
        cut_edges: &CutEdges,
        traversal: &mut Workspace,
    ) {
        let own = bodies[side];
        self.covers_twice = true;
        self.visited.clear();
        self.visited.resize(own.surface().vertex_count(), false);

        for &start in own.surface().component_roots() {
            let winding = winding_about(side, bodies, start, traversal);
            let cluster = self.begin_cluster(start);
            let first = self.vertices.len();
            self.visited[start as usize] = true;
            self.stack.push(InsideVertex { vertex: start, winding, cluster });

            while let Some(at) = self.stack.pop() {
                if at.winding != 0 {
                    self.label(at);
                }
                self.collect_neighbors(own, at.vertex);
                for i in 0..self.neighbors.len() {
                    let Neighbor { vertex, edge } = self.neighbors[i];
                    if std::mem::replace(&mut self.visited[vertex as usize], true) {
                        continue;
                    }
                    let net = cut_edges.get(edge).map_or(0, |cut| cut.net);
                    let change = if at.vertex < vertex { net } else { -net };
                    self.stack.push(InsideVertex { vertex, winding: at.winding + change, cluster });
                }
            }
            self.end_cluster(own.surface(), first, false);
        }
    }

    fn begin_cluster(&mut self, start: u32) -> u32 {
        self.cluster_starts.push(start);
        index(self.cluster_starts.len() - 1)
    }

    /// Collects the faces of a cluster, whose vertices are those from `first` on: each at its first
    /// corner, and at those of the rim alone where the fill has collected the others.
    fn end_cluster(&mut self, surface: &TriangleSurface, first: usize, rim_only: bool) {
        for place in first..self.vertices.len() {
            let vertex = self.vertices[place].vertex;
            let is_rim = self.is_rim[vertex as usize];
            if rim_only && !is_rim {
                continue;
            }
            for &face in surface.vertex_faces(vertex) {
                // Uncut edges end in one cluster: only beside the curve are corners compared.
                let corners = surface.faces()[face as usize];
                if corners[0] == vertex && (!is_rim || self.holds_face(corners)) {
                    self.faces.push(face);
                }
            }
        }
        self.cluster_ends.push([index(self.vertices.len()), index(self.faces.len())]);
    }

    fn label(&mut self, inside: InsideVertex) {
        self.vertices.push(inside);
        self.places[inside.vertex as usize] = index(self.vertices.len());
    }

    /// Collects the neighbors of a vertex.
    ///
    /// On a closed oriented surface each neighbor ends the edge that one face runs along from the
    /// vertex; elsewhere the edges that lead to the vertex are taken, too.
    fn collect_neighbors(&mut self, own: &SurfaceTree, vertex: u32) {
        let surface = own.surface();
        let is_one_way = own.has_winding_number().is_ok();
        self.neighbors.clear();
        // Two edges of each face meet at the vertex: the one that leaves it, and the one before.
        for &face in surface.vertex_faces(vertex) {
            let corners = surface.faces()[face as usize];
            let edges = surface.face_edges()[face as usize];
            let k = if corners[0] == vertex { 0 } else { 2 - usize::from(corners[1] == vertex) };
            let (next, before) = ((k + 1) % 3, (k + 2) % 3);
            self.push_neighbor(corners[next], edges[k]);
            if !is_one_way {
                self.push_neighbor(corners[before], edges[before]);
            }
        }
    }

    fn push_neighbor(&mut self, vertex: u32, edge: u32) {
        if edge != NO_EDGE {
            self.neighbors.push(Neighbor { vertex, edge });
        }
    }
}

/// Extends an array of zeros to a length, if it is shorter.
fn grow<T: Clone + Default>(array: &mut Vec<T>, length: usize) {
    if array.len() < length {
        array.resize(length, T::default());
    }
}

/// Computes the winding number of the other surface about a vertex of body `side`.
///
/// The first body is the one that is moved by an infinitesimal, upward: a vertex of the second
/// meets the first as if it were itself moved downward.
fn winding_about(
    side: usize,
    bodies: [&SurfaceTree; 2],
    vertex: u32,
    traversal: &mut Workspace,
) -> i32 {
    let point = bodies[side].position(vertex);
    let other = bodies[1 - side];
    let passes = if side == 0 { ray_crosses_triangle } else { ray_crosses_triangle_from_below };

    let mut winding = 0;
    other.tree().ray(point, Axis::X, traversal, |face| {
        winding += passes(point, other.corners(face)).unwrap_or(0);
    });
    winding
}
