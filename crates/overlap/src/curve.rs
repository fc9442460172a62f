//! The curve in which two surfaces cross, as stretches between named passings.
//!
//! Each pair of faces that cross holds one stretch. Its ends are passings: points where an edge of
//! one surface passes through a face of the other. Both faces at that edge find the same passing
//! under the same name, so that the curve is connected by names and no tolerance decides.
//!
//! Positions come last and are computed once per passing, from the edge's lower-numbered end.

use std::ops::Range;

use glam::DVec3;
use proximity::SurfaceTree;
use surface::progress::{Interrupted, Progress};
use surface::{NO_EDGE, PerturbedMeeting, Stretch, StretchEnd, meet_perturbed, passing_share};

use crate::cut_edges::CutEdges;

/// Pairs of faces between two polls for interruption: a few milliseconds at most.
const POLL_INTERVAL: u32 = 1024;

/// The crossing curve of two surfaces; its memory is reused from pair to pair.
#[derive(Debug, Default)]
pub(crate) struct Curve {
    /// Stretches by their faces (of A, of B), ascending.
    pub(crate) stretches: Vec<CurveStretch>,
    /// Passings, edge by edge, and those of an edge by the faces of the other surface.
    pub(crate) passings: Vec<Passing>,
    /// Edges that are passed, of A and of B.
    pub(crate) cut_edges: [CutEdges; 2],
    /// Faces that are cut, of A and of B, ascending.
    pub(crate) cut_faces: [Vec<u32>; 2],
    /// Pairs of faces that lie in one plane, ascending.
    pub(crate) coplanar: Vec<CoplanarPair>,
    crossings: Vec<([u32; 2], Stretch)>,
    /// Ends of all stretches in the order of these.
    unsorted_ends: Vec<NamedEnd>,
    /// Ends of all stretches, in the order of their passings.
    ends: Vec<NamedEnd>,
    visited: Vec<bool>,
    chain: Vec<u32>,
}

/// The stretch in which a face of A and a face of B cross.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveStretch {
    /// The face of A, then that of B.
    pub(crate) faces: [u32; 2],
    /// Passings at which it begins and ends, run with the inside of B on the left in A's face.
    pub(crate) ends: [u32; 2],
    /// True if the faces may only touch, and the infinitesimal move makes them cross.
    pub(crate) is_tie: bool,
}

/// A point where an edge of one surface passes through a face of the other.
#[derive(Clone, Debug)]
pub(crate) struct Passing {
    pub(crate) name: PassingName,
    /// True if the edge, run from its lower-numbered end, enters the other body here.
    pub(crate) enters: bool,
    /// Share of the way from the edge's lower-numbered end.
    pub(crate) share: f64,
    /// Ends of the stretches that meet here: one at the border of a surface, as many as there are
    /// faces at the edge elsewhere.
    ends: Range<u32>,
}

/// Identity of a passing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassingName {
    /// 0 if the edge is of A, 1 if it is of B.
    pub(crate) side: u8,
    /// The edge.
    pub(crate) edge: u32,
    /// The face of the other surface.
    pub(crate) face: u32,
}

/// Two faces in one plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct CoplanarPair {
    /// The face of A, then that of B.
    pub(crate) faces: [u32; 2],
    /// True if both normals point the same way.
    pub(crate) same_normal: bool,
    /// True if the infinitesimal that settles ties moves A's face to the side of its normal.
    pub(crate) a_moves_outward: bool,
}

/// One end of one stretch, before equal names are joined.
#[derive(Clone, Copy, Debug)]
struct NamedEnd {
    name: PassingName,
    stretch: u32,
    /// 0 for the beginning, 1 for the end.
    end: u8,
    enters: bool,
}

impl Curve {
    /// Finds the curve among pairs of faces that may meet, in place of what was found before.
    pub(crate) fn find(
        &mut self,
        bodies: [&SurfaceTree; 2],
        candidates: &[[u32; 2]],
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        self.find_crossings(bodies, candidates, progress)?;
        self.list_stretches(bodies);
        self.sort_ends(bodies);
        self.join_ends(bodies);
        Ok(())
    }

    /// Computes the exact stretch of each pair of faces that cross.
    fn find_crossings(
        &mut self,
        [a, b]: [&SurfaceTree; 2],
        candidates: &[[u32; 2]],
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        self.crossings.clear();
        self.coplanar.clear();
        let mut polls = progress.every(POLL_INTERVAL);
        for &faces in candidates {
            polls.step()?;
            match meet_perturbed(a.corners(faces[0]), b.corners(faces[1])) {
                PerturbedMeeting::Apart => {}
                PerturbedMeeting::Crossing(stretch) => {
                    if have_three_edges([a, b], faces) {
                        self.crossings.push((faces, stretch));
                    }
                }
                PerturbedMeeting::Coplanar { same_normal, first_moves_outward } => {
                    let a_moves_outward = first_moves_outward;
                    self.coplanar.push(CoplanarPair { faces, same_normal, a_moves_outward });
                }
            }
        }

        // The order of the faces is that of all sums, whatever order the candidates came in.
        self.crossings.sort_unstable_by_key(|&(faces, _)| rank(faces));
        self.coplanar.sort_unstable();
        progress.report(0.0)
    }

    /// Lists the stretches and the cut faces, and names the ends of the stretches.
    fn list_stretches(&mut self, bodies: [&SurfaceTree; 2]) {
        for (side, cut_faces) in self.cut_faces.iter_mut().enumerate() {
            cut_faces.clear();
            for (faces, _) in &self.crossings {
                cut_faces.push(faces[side]);
            }
            cut_faces.sort_unstable();
            cut_faces.dedup();
        }

        self.stretches.clear();
        self.unsorted_ends.clear();
        for (stretch, &(faces, Stretch { begin, end, is_tie })) in (0..).zip(&self.crossings) {
            self.stretches.push(CurveStretch { faces, ends: [u32::MAX; 2], is_tie });
            for (end, at) in [(0, begin), (1, end)] {
                let (name, enters) = named(at, bodies, faces);
                self.unsorted_ends.push(NamedEnd { name, stretch, end, enters });
            }
        }
    }

    /// Sorts the ends: into the room of their edge, and there among a few by their faces.
    fn sort_ends(&mut self, bodies: [&SurfaceTree; 2]) {
        let Self { cut_edges, unsorted_ends, ends, .. } = self;
        for (cut_edges, body) in cut_edges.iter_mut().zip(bodies) {
            cut_edges.clear(body.surface().edges().len());
        }
        for NamedEnd { name, .. } in &*unsorted_ends {
            cut_edges[usize::from(name.side)].count(name.edge);
        }
        let mut start = 0;
        for cut_edges in cut_edges.iter_mut() {
            start = cut_edges.make_room(start);
        }

        ends.clone_from(unsorted_ends);
        for end in unsorted_ends {
            ends[cut_edges[usize::from(end.name.side)].take_place(end.name.edge)] = *end;
        }
        for cut in cut_edges.iter().flat_map(CutEdges::as_slice) {
            let ends = &mut ends[cut.passings.start as usize..cut.passings.end as usize];
            ends.sort_unstable_by_key(|end| (end.name.face, end.stretch, end.end));
        }
    }

    /// Makes one passing of the ends of equal names, which stand beside each other.
    fn join_ends(&mut self, bodies: [&SurfaceTree; 2]) {
        self.passings.clear();
        for cut in self.cut_edges.iter_mut().flat_map(CutEdges::as_mut_slice) {
            let mut start = cut.passings.start;
            let ends = &self.ends[start as usize..cut.passings.end as usize];
            cut.passings.start = index(self.passings.len());
            for ends in ends.chunk_by(|p, q| p.name.face == q.name.face) {
                let NamedEnd { name, enters, .. } = ends[0];
                let passing = index(self.passings.len());
                for end in ends {
                    self.stretches[end.stretch as usize].ends[usize::from(end.end)] = passing;
                }
                let end = start + index(ends.len());
                let share = share(name, bodies);
                self.passings.push(Passing { name, enters, share, ends: start..end });
                cut.net += if enters { 1 } else { -1 };
                start = end;
            }
            cut.passings.end = index(self.passings.len());
        }
    }

    /// Visits each connected chain of stretches: arcs first, from their ends, then loops.
    ///
    /// `visit` is given the passings in order, the first not repeated for a loop, and true for a
    /// loop.
    pub(crate) fn visit_chains(&mut self, mut visit: impl FnMut(&[u32], bool)) {
        self.visited.clear();
        self.visited.resize(self.stretches.len(), false);

        // Arcs begin where an odd number of stretches meet. Once they are walked, whatever is left is
        // closed.
        for start in 0..index(self.passings.len()) {
            let is_odd = self.passings[start as usize].ends.len() % 2 == 1;
            if let Some(first) = self.unvisited(start).filter(|_| is_odd) {
                self.walk(start, first, false);
                visit(&self.chain, false);
            }
        }
        for start in 0..index(self.passings.len()) {
            while let Some(first) = self.unvisited(start) {
                self.walk(start, first, true);
                visit(&self.chain, true);
            }
        }
    }

    /// Returns the first stretch at a passing that was not visited.
    fn unvisited(&self, passing: u32) -> Option<u32> {
        let Range { start, end } = self.passings[passing as usize].ends;
        let ends = &self.ends[start as usize..end as usize];
        ends.iter().map(|end| end.stretch).find(|&stretch| !self.visited[stretch as usize])
    }

    /// Follows stretches from a passing until there is none that was not visited.
    fn walk(&mut self, start: u32, first: u32, is_closed: bool) {
        self.chain.clear();
        self.chain.push(start);
        let (mut at, mut stretch) = (start, first);
        loop {
            self.visited[stretch as usize] = true;
            let [begin, end] = self.stretches[stretch as usize].ends;
            at = if begin == at { end } else { begin };
            if at == start && is_closed {
                return;
            }
            self.chain.push(at);
            let Some(next) = self.unvisited(at) else { return };
            stretch = next;
        }
    }
}

/// Returns a number that orders pairs as their entries do, in one comparison.
fn rank([first, second]: [u32; 2]) -> u64 {
    (u64::from(first) << 32) | u64::from(second)
}

/// Returns true if both faces have three corners. One that repeats a vertex leads there and back.
fn have_three_edges(bodies: [&SurfaceTree; 2], faces: [u32; 2]) -> bool {
    bodies
        .iter()
        .zip(faces)
        .all(|(body, face)| !body.surface().face_edges()[face as usize].contains(&NO_EDGE))
}

/// Names an end of a stretch, with the sense in which the edge, run from its lower-numbered end,
/// passes.
fn named(end: StretchEnd, bodies: [&SurfaceTree; 2], faces: [u32; 2]) -> (PassingName, bool) {
    let (of, other) = (end.triangle, 1 - end.triangle);
    let surface = bodies[of].surface();
    let face = faces[of] as usize;
    let edge = surface.face_edges()[face][end.edge];
    debug_assert_ne!(edge, NO_EDGE, "a crossed face has three edges");

    let corners = surface.faces()[face];
    let is_upward = corners[end.edge] < corners[(end.edge + 1) % 3];
    let side = u8::from(of == 1);
    (PassingName { side, edge, face: faces[other] }, end.enters == is_upward)
}

/// Computes where an edge passes a face, as its share of the way from the edge's lower end.
fn share(name: PassingName, bodies: [&SurfaceTree; 2]) -> f64 {
    let of = usize::from(name.side);
    let ends = edge_ends(bodies[of], name.edge);
    passing_share(ends, bodies[1 - of].corners(name.face))
}

/// Returns the ends of an edge, the lower-numbered one first.
pub(crate) fn edge_ends(body: &SurfaceTree, edge: u32) -> [DVec3; 2] {
    let [low, high] = body.surface().edges()[edge as usize];
    [body.position(low), body.position(high)]
}

/// Converts a length to an index of 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "stretches are fewer than pairs of faces")]
pub(crate) fn index(length: usize) -> u32 {
    debug_assert!(u32::try_from(length).is_ok(), "{length} stretches");
    length as u32
}
