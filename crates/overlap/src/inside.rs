//! Vertices of one surface inside the other, from the edges that the curve cuts.
//!
//! An edge whose passings sum to a net of `+1` runs from outside to inside: its upper end is
//! inside without any ray. From such ends a flood fill over edges with a net of zero visits the
//! inside vertices and no others. A ray checks each region that was filled, and each connected
//! part of the surface that no cut edge settles.
//!
//! If that check finds another winding number than 1, the other surface covers a place twice or
//! the wrong way round; the whole part is then labeled by winding numbers.

use kdop::{Axis, Workspace};
use proximity::SurfaceTree;
use surface::{NO_EDGE, ray_crosses_triangle, ray_crosses_triangle_from_below};

use crate::curve::{Curve, CutEdge};

/// Vertices of one surface inside the other.
#[derive(Debug, Default)]
pub(crate) struct Inside {
    /// The vertices in the order of the fill, region after region, with the winding number of the
    /// other surface about each, which is not zero.
    pub(crate) vertices: Vec<InsideVertex>,
    /// True if some winding number is not 1.
    pub(crate) covers_twice: bool,
    /// One per vertex: 1 + its place in `vertices`, or 0.
    places: Vec<u32>,
    /// One per edge: 1 + its place among the cut edges, or 0.
    cuts: Vec<u32>,
    /// One per vertex: true once a fill by winding numbers has visited it.
    visited: Vec<bool>,
    stack: Vec<InsideVertex>,
    edges: Vec<u32>,
}

/// A vertex inside the other body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InsideVertex {
    pub(crate) vertex: u32,
    /// Winding number of the other surface.
    pub(crate) winding: i32,
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
        let cut_edges = &curve.cut_edges[side];
        for (place, cut) in (1..).zip(cut_edges) {
            self.cuts[cut.edge as usize] = place;
        }

        let is_simple = self.fill_from_cuts(side, bodies, cut_edges, traversal);
        if !is_simple {
            self.clear_vertices();
            self.fill_by_winding(side, bodies, cut_edges, traversal);
        }
    }

    /// Takes no vertex to be inside, since the other surface has no inside.
    pub(crate) fn find_none(&mut self, own: &SurfaceTree) {
        self.clear(own);
    }

    /// Returns the winding number of the other surface about a vertex, 0 outside.
    pub(crate) fn winding(&self, vertex: u32) -> i32 {
        match self.places[vertex as usize] {
            0 => 0,
            place => self.vertices[place as usize - 1].winding,
        }
    }

    /// Returns the place of a vertex among those inside.
    pub(crate) fn place(&self, vertex: u32) -> Option<u32> {
        self.places[vertex as usize].checked_sub(1)
    }

    /// Returns the place of an edge among the cut edges.
    pub(crate) fn cut(&self, edge: u32) -> Option<usize> {
        self.cuts[edge as usize].checked_sub(1).map(|place| place as usize)
    }

    /// Empties all lists; arrays grow to the surface's size and stay zero outside of a query.
    fn clear(&mut self, own: &SurfaceTree) {
        self.clear_vertices();
        self.places.resize(own.surface().vertex_count(), 0);
        // Cut edges of the query before are not at hand: the array is cleared as a whole.
        self.cuts.clear();
        self.cuts.resize(own.surface().edges().len(), 0);
    }

    fn clear_vertices(&mut self) {
        for inside in self.vertices.drain(..) {
            self.places[inside.vertex as usize] = 0;
        }
        self.covers_twice = false;
    }

    /// Fills the inside from cut edges and from parts that are inside as a whole. Returns false
    /// where a ray finds a winding number other than 0 outside or 1 inside.
    fn fill_from_cuts(
        &mut self,
        side: usize,
        bodies: [&SurfaceTree; 2],
        cut_edges: &[CutEdge],
        traversal: &mut Workspace,
    ) -> bool {
        // A net of ±1 has its inside end; each region is checked by one ray.
        let own = bodies[side];
        for cut in cut_edges {
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
            if !self.fill(own, start, cut_edges) {
                return false;
            }
        }

        // An end that is outside must not have been filled.
        for cut in cut_edges {
            let [low, high] = own.surface().edges()[cut.edge as usize];
            if self.winding(high) - self.winding(low) != cut.net {
                return false;
            }
        }

        // Parts without such an edge are inside or outside as a whole.
        for &vertex in own.components() {
            if self.places[vertex as usize] != 0 {
                continue;
            }
            match winding_about(side, bodies, vertex, traversal) {
                0 => {}
                1 => {
                    if !self.fill(own, vertex, cut_edges) {
                        return false;
                    }
                }
                _ => return false,
            }
        }
        true
    }

    /// Fills a region of winding number 1 over edges with a net of zero. Returns false where an
    /// edge leads to a winding number of 2.
    fn fill(&mut self, own: &SurfaceTree, start: u32, cut_edges: &[CutEdge]) -> bool {
        self.label(InsideVertex { vertex: start, winding: 1 });
        self.stack.push(InsideVertex { vertex: start, winding: 1 });

        while let Some(InsideVertex { vertex, .. }) = self.stack.pop() {
            self.collect_edges(own, vertex);
            for i in 0..self.edges.len() {
                let edge = self.edges[i];
                if self.net(edge, cut_edges) != 0 {
                    continue;
                }
                let next = other_end(own, edge, vertex);
                if self.places[next as usize] == 0 {
                    let reached = InsideVertex { vertex: next, winding: 1 };
                    self.label(reached);
                    self.stack.push(reached);
                }
            }
        }
        self.stack.is_empty()
    }

    /// Labels every part of the surface by winding numbers, from one ray each.
    fn fill_by_winding(
        &mut self,
        side: usize,
        bodies: [&SurfaceTree; 2],
        cut_edges: &[CutEdge],
        traversal: &mut Workspace,
    ) {
        let own = bodies[side];
        self.covers_twice = true;
        self.visited.clear();
        self.visited.resize(own.surface().vertex_count(), false);

        for &start in own.components() {
            let winding = winding_about(side, bodies, start, traversal);
            self.visited[start as usize] = true;
            self.stack.push(InsideVertex { vertex: start, winding });

            while let Some(at) = self.stack.pop() {
                if at.winding != 0 {
                    self.label(at);
                }
                self.collect_edges(own, at.vertex);
                for i in 0..self.edges.len() {
                    let edge = self.edges[i];
                    let next = other_end(own, edge, at.vertex);
                    if std::mem::replace(&mut self.visited[next as usize], true) {
                        continue;
                    }
                    let net = self.net(edge, cut_edges);
                    let upward = own.surface().edges()[edge as usize][0] == at.vertex;
                    let winding = if upward { at.winding + net } else { at.winding - net };
                    self.stack.push(InsideVertex { vertex: next, winding });
                }
            }
        }
    }

    fn label(&mut self, inside: InsideVertex) {
        self.vertices.push(inside);
        self.places[inside.vertex as usize] = crate::curve::index(self.vertices.len());
    }

    /// Returns the difference of the winding numbers along an edge, from its lower-numbered end.
    fn net(&self, edge: u32, cut_edges: &[CutEdge]) -> i32 {
        self.cut(edge).map_or(0, |place| cut_edges[place].net)
    }

    /// Collects the edges at a vertex, some of them twice.
    fn collect_edges(&mut self, own: &SurfaceTree, vertex: u32) {
        self.edges.clear();
        for &face in own.surface().vertex_faces(vertex) {
            for edge in own.surface().face_edges()[face as usize] {
                if edge != NO_EDGE && own.surface().edges()[edge as usize].contains(&vertex) {
                    self.edges.push(edge);
                }
            }
        }
    }
}

fn other_end(own: &SurfaceTree, edge: u32, vertex: u32) -> u32 {
    let [low, high] = own.surface().edges()[edge as usize];
    if low == vertex { high } else { low }
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
