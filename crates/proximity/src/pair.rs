//! Static proximity of two surfaces.
//!
//! The trees of both give candidate faces; exact predicates decide which of them cross; the rest
//! of each surface falls into regions that lie wholly on one side of the other, so that one ray
//! decides for a whole region; vertices that are inside or near are projected to the other
//! surface.

use kdop::Workspace;
use surface::progress::{Interrupted, Progress};

use crate::crossings::Crossings;
use crate::distance::distance_between;
use crate::inside::InsideVertices;
use crate::near_faces::{NearFaces, list_near_faces};
use crate::projection::Candidates;
use crate::rounding::distance_rounding;
use crate::{NearVertex, NoInside, PairError, SurfaceTree};

/// Proximity of two surfaces in one state, in memory that is reused from pair to pair.
///
/// Exact: which faces cross, and which vertices are inside. Right up to rounding: distances, and what a surface with holes
/// surrounds.
#[derive(Debug, Default)]
pub struct PairProximity {
    workspace: Workspace,
    inside: InsideVertices,
    crossings: Crossings,
    /// Pairs of faces within the margin; without one, those that meet.
    near_faces: Vec<[u32; 2]>,
    a: PairSide,
    b: PairSide,
}

/// Vertices of one surface against the other one of a pair.
#[derive(Debug, Default)]
pub struct PairSide {
    /// Per face, the faces of the other surface that may be within the margin.
    near_faces: NearFaces,
    candidates: Candidates,
    inside: Vec<u32>,
    /// Reason why the other surface has no inside.
    no_inside: Option<NoInside>,
    near: Vec<NearVertex>,
}

/// Neighborhood of one side in the other surface, before its vertices are computed.
struct Neighborhood<'a> {
    /// Faces of it that meet the other surface, ascending.
    cut_faces: &'a [u32],
    margin: f64,
    progress: Progress<'a>,
}

impl PairProximity {
    /// Computes the proximity of `a` and `b`, in place of an earlier pair's.
    ///
    /// Vertices outside are reported within `margin` (`>= 0`) of the other surface, all that are, and
    /// with them some that are farther by no more than the rounding of a distance: 2.5e-13 of the
    /// largest coordinate. Without a margin these are of faces that meet.
    ///
    /// # Errors
    ///
    /// [`PairError::TooManyNearFaces`] when more than 2²⁶ pairs of faces are within the margin.
    pub fn compute(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
    ) -> Result<(), PairError> {
        self.try_compute(a, b, margin, Progress::none())
    }

    /// As [`compute`](Self::compute), where a handler may end the call.
    ///
    /// # Errors
    ///
    /// As [`compute`](Self::compute), and [`PairError::Interrupted`] when `progress` ends the call;
    /// nothing is computed then, and nothing is left of an earlier pair.
    pub fn try_compute(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<(), PairError> {
        let computed = self.find_both(a, b, margin, progress);
        if computed.is_err() {
            self.clear();
        }
        computed
    }

    fn clear(&mut self) {
        self.crossings.clear();
        self.near_faces.clear();
        self.a.clear();
        self.b.clear();
    }

    /// Finds the proximity of both sides; leaves a part where it fails.
    fn find_both(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<(), PairError> {
        self.find_first(a, b, margin, progress)?;
        let Self { workspace, inside, crossings, near_faces, b: of_b, .. } = self;

        let near_to_a = near_faces.iter().map(|&[face_a, face_b]| (face_b, face_a));
        of_b.near_faces.refill(b.surface().faces().len(), near_to_a);
        let of_pair = Neighborhood { cut_faces: &crossings.cut_faces_of_b, margin, progress };
        Ok(of_b.compute(b, a, of_pair, inside, workspace)?)
    }

    /// Computes the vertices of `a` against `b`, in place of an earlier pair's; those of `b` are
    /// left out.
    ///
    /// For vertices of `b` that are found by other means: of the same work, each surface takes its
    /// part. [`overlaps`](Self::overlaps) then holds where faces cross or a vertex of `a` is inside.
    ///
    /// # Errors
    ///
    /// As [`compute`](Self::compute).
    pub fn compute_first(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
    ) -> Result<(), PairError> {
        let computed = self.find_first(a, b, margin, Progress::none());
        if computed.is_err() {
            self.clear();
        }
        computed
    }

    fn find_first(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<(), PairError> {
        self.crossings.find(a, b, &mut self.workspace, progress)?;
        self.find_near_faces(a, b, margin, progress)?;
        let Self { workspace, inside, crossings, near_faces, a: of_a, b: of_b } = self;
        of_b.clear();

        let near_to_b = near_faces.iter().map(|&[face_a, face_b]| (face_a, face_b));
        of_a.near_faces.refill(a.surface().faces().len(), near_to_b);
        let of_pair = Neighborhood { cut_faces: &crossings.cut_faces_of_a, margin, progress };
        Ok(of_a.compute(a, b, of_pair, inside, workspace)?)
    }

    /// Finds the pairs of faces that may be within the margin; without a margin, those that meet.
    fn find_near_faces(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<(), PairError> {
        let Self { workspace, crossings, near_faces, .. } = self;
        near_faces.clear();
        if margin > 0.0 {
            list_near_faces([a, b], margin, workspace, near_faces, progress)?;
        } else {
            near_faces.extend_from_slice(&crossings.meeting);
        }
        Ok(())
    }

    /// Returns the vertices of the first surface against the second, and of the second against
    /// the first.
    #[must_use]
    pub fn sides(&self) -> [&PairSide; 2] {
        [&self.a, &self.b]
    }

    /// Returns the pairs of faces (of the first, of the second) that properly cross, ascending.
    #[must_use]
    pub fn crossing_faces(&self) -> &[[u32; 2]] {
        &self.crossings.crossing
    }

    /// Returns the pairs of faces (of the first, of the second) that share a point, in no order:
    /// those that cross, and those that touch.
    #[must_use]
    pub fn meeting_faces(&self) -> &[[u32; 2]] {
        &self.crossings.meeting
    }

    /// Returns the number of pairs of faces that were tested, since their bounds overlap.
    #[must_use]
    pub fn tested_faces(&self) -> usize {
        self.crossings.tested
    }

    /// Returns true if faces cross or a vertex of one is inside the other. Surfaces that only
    /// touch do not overlap.
    #[must_use]
    pub fn overlaps(&self) -> bool {
        let Self { crossings, a, b, .. } = self;
        !(crossings.crossing.is_empty() && a.inside.is_empty() && b.inside.is_empty())
    }

    /// Returns the smallest signed distance of a vertex to the other surface; `None` where no
    /// vertex is inside or within the margin.
    #[must_use]
    pub fn min_gap(&self) -> Option<f64> {
        let near = self.a.near.iter().chain(&self.b.near);
        near.map(|vertex| vertex.gap).min_by(f64::total_cmp)
    }

    /// Returns the depth of the deepest vertex, `>= 0`: 0 where none is inside, even when faces
    /// cross.
    #[must_use]
    pub fn max_vertex_depth(&self) -> f64 {
        self.min_gap().map_or(0.0, |gap| (-gap).max(0.0))
    }

    /// Returns true if the surfaces overlap, or a vertex is within the margin.
    #[must_use]
    pub fn has_contact(&self) -> bool {
        self.overlaps() || self.min_gap().is_some()
    }

    /// Computes the distance between the surfaces, edges included: 0 where they meet, `None`
    /// where it exceeds the margin. One that exceeds it by no more than rounding may be returned.
    ///
    /// Surfaces and margin are those of the last [`compute`](Self::compute).
    pub fn distance(&mut self, a: &SurfaceTree, b: &SurfaceTree, margin: f64) -> Option<f64> {
        // Without a handler nothing interrupts.
        self.try_distance(a, b, margin, Progress::none()).ok().flatten()
    }

    /// As [`distance`](Self::distance), where a handler may end the call.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when `progress` ends the call.
    pub fn try_distance(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<Option<f64>, Interrupted> {
        if !self.crossings.cut_faces_of_a.is_empty() {
            return Ok(Some(0.0));
        }
        let near = self.a.near.iter().chain(&self.b.near);
        let limit = margin + distance_rounding([a, b]);
        let bound = near.map(|vertex| vertex.gap.abs()).fold(limit, f64::min);
        distance_between(a, b, bound, &mut self.workspace, progress)
    }
}

impl PairSide {
    fn clear(&mut self) {
        self.near_faces.clear();
        self.inside.clear();
        self.no_inside = None;
        self.near.clear();
    }

    fn compute(
        &mut self,
        p: &SurfaceTree,
        q: &SurfaceTree,
        Neighborhood { cut_faces, margin, progress }: Neighborhood<'_>,
        inside: &mut InsideVertices,
        workspace: &mut Workspace,
    ) -> Result<(), Interrupted> {
        self.no_inside = q.has_inside().err();
        self.inside.clear();
        match self.no_inside {
            None => inside.find(p, cut_faces, q, workspace, &mut self.inside),
            Some(NoInside::OddEdges { .. }) if cut_faces.is_empty() && q.surrounds(p) => {
                let vertices = p.surface().faces().iter().flatten();
                self.inside.extend(vertices);
                self.inside.sort_unstable();
                self.inside.dedup();
            }
            Some(_) => {}
        }
        self.candidates.find(p, &self.near_faces, q, margin, progress)?;
        self.candidates.project(p, &self.inside, q, workspace, &mut self.near, progress)
    }

    /// Returns, per face, faces of the other surface, all that are within the margin among them; none
    /// for the second surface after [`compute_first`](PairProximity::compute_first).
    #[must_use]
    pub fn near_faces(&self) -> &NearFaces {
        &self.near_faces
    }

    /// Returns the vertices inside the other surface, ascending. Where that has no inside, since edges are open or have
    /// a third face, all vertices of a surface that it surrounds without meeting it; none otherwise.
    #[must_use]
    pub fn inside_vertices(&self) -> &[u32] {
        &self.inside
    }

    /// Returns the number of vertices inside the other surface.
    ///
    /// # Errors
    ///
    /// The reason why the other surface has no inside.
    pub fn inside_count(&self) -> Result<usize, NoInside> {
        self.no_inside.map_or(Ok(self.inside.len()), Err)
    }

    /// Returns the vertices that are inside the other surface or within the margin, ascending. Vertices beyond it by no
    /// more than rounding may be among them.
    #[must_use]
    pub fn near(&self) -> &[NearVertex] {
        &self.near
    }
}
