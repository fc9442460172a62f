//! What two surfaces do to each other in one state.
//!
//! The trees of both give candidate faces; exact predicates say which of them
//! cross; the rest of each surface falls into regions that lie wholly on one
//! side of the other, so that one count of crossings tells where a whole region
//! is; what is inside or near is projected to the other surface.

mod contacts;
mod crossings;
mod distance;
mod patches;
mod projection;
mod regions;
mod segments;

use glam::DVec3;
use kdop::Workspace;

use self::crossings::Cut;
use self::projection::Candidates;
use self::regions::Regions;
use crate::scene::Body;
use crate::shape::Shape;
use crate::{BodyId, NoInside};

pub(crate) use self::contacts::{Party, contact};
pub use self::patches::ContactPatch;
pub use self::projection::NearVertex;
pub(crate) use self::projection::{NO_HINT, nearest};
pub(crate) use self::regions::parts;
pub use self::segments::{Region, Side};

/// What was found between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairReport {
    /// The first body.
    pub a: BodyId,
    /// The second body, of the higher number.
    pub b: BodyId,
    /// Whether faces cross or a vertex of one is inside the other. Surfaces
    /// that only touch do not overlap.
    pub overlaps: bool,
    /// Depth of the deepest vertex inside the other body, `>= 0`; 0 where none
    /// is, even when faces cross.
    pub max_depth: f64,
    /// Smallest signed distance of a vertex to the other surface, negative
    /// inside; `None` where no vertex is within the margin or inside.
    pub min_gap: Option<f64>,
    /// Distance between the surfaces, their edges and faces included: 0 where
    /// they cross or touch, `None` where they are farther apart than the margin.
    pub distance: Option<f64>,
    /// Pairs of faces (of `a`, of `b`) that properly cross, ascending.
    pub crossing_faces: Vec<[u32; 2]>,
    /// Vertices of `a` against the surface of `b`.
    pub a_against_b: VertexReport,
    /// Vertices of `b` against the surface of `a`.
    pub b_against_a: VertexReport,
    /// Connected parts of `a`'s surface that are in contact with `b`, largest
    /// first.
    pub patches: Vec<ContactPatch>,
}

/// One body's vertices against the other's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexReport {
    /// How many vertices are inside the other body, or why that means nothing.
    pub inside_count: Result<usize, NoInside>,
    /// Vertices that are inside or within the margin, ascending.
    pub near: Vec<NearVertex>,
}

/// What is between two shapes, in memory that is reused from pair to pair.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    traversal: Workspace,
    regions: Regions,
    cut: Cut,
    a: Half,
    b: Half,
}

/// One shape's vertices against the other.
#[derive(Debug, Default)]
pub(crate) struct Half {
    candidates: Candidates,
    inside: Vec<u32>,
    /// Why there is no inside.
    no_inside: Option<NoInside>,
    pub(crate) near: Vec<NearVertex>,
}

impl Scratch {
    /// Looks at one pair, in place of what was found before.
    pub(crate) fn look(&mut self, a: &Shape, b: &Shape, margin: f64) {
        let Self { traversal, regions, cut, a: of_a, b: of_b } = self;
        cut.find(a, b, traversal);
        let both = [(a, &mut of_a.candidates), (b, &mut of_b.candidates)];
        projection::find_candidates(both, (margin, &cut.meeting), traversal);
        for (half, p, cut_faces, q) in
            [(of_a, a, &cut.faces_of_a, b), (of_b, b, &cut.faces_of_b, a)]
        {
            half.no_inside = q.has_inside().err();
            half.inside.clear();
            if half.no_inside.is_none() {
                regions.inside((p, cut_faces), q, traversal, &mut half.inside);
            }
            let Half { candidates, inside, near, .. } = half;
            projection::project((p, inside), q, margin, candidates, traversal, near);
        }
    }

    /// Vertices of the first shape, and of the second.
    pub(crate) fn halves(&self) -> [&Half; 2] {
        [&self.a, &self.b]
    }

    /// Whether faces cross or a vertex of one is inside the other.
    pub(crate) fn overlaps(&self) -> bool {
        let Self { cut, a, b, .. } = self;
        !(cut.crossing.is_empty() && a.inside.is_empty() && b.inside.is_empty())
    }

    /// Smallest signed distance of a vertex.
    pub(crate) fn min_gap(&self) -> Option<f64> {
        let near = self.a.near.iter().chain(&self.b.near);
        near.map(|vertex| vertex.gap).min_by(f64::total_cmp)
    }

    /// Whether anything overlaps or a vertex is within the margin.
    fn has_contact(&self) -> bool {
        self.overlaps() || self.min_gap().is_some()
    }

    /// What was found, without the distance and the patches.
    fn report(&mut self, a: BodyId, b: BodyId) -> PairReport {
        let min_gap = self.min_gap();
        PairReport {
            a,
            b,
            overlaps: self.overlaps(),
            max_depth: min_gap.map_or(0.0, |gap| (-gap).max(0.0)),
            min_gap,
            distance: None,
            patches: Vec::new(),
            crossing_faces: std::mem::take(&mut self.cut.crossing),
            a_against_b: self.a.report(),
            b_against_a: self.b.report(),
        }
    }

    /// Distance between the surfaces, edges included, if it is within the margin.
    fn distance(&mut self, a: &Shape, b: &Shape, margin: f64) -> Option<f64> {
        if !self.cut.faces_of_a.is_empty() {
            return Some(0.0);
        }
        let near = self.a.near.iter().chain(&self.b.near);
        let within = near.map(|vertex| vertex.gap.abs()).fold(margin, f64::min);
        distance::between(a, b, within, &mut self.traversal)
    }
}

impl Half {
    fn report(&mut self) -> VertexReport {
        let inside_count = self.no_inside.map_or(Ok(self.inside.len()), Err);
        VertexReport { inside_count, near: std::mem::take(&mut self.near) }
    }
}

/// A body with its number.
pub(crate) type Numbered<'a> = (BodyId, &'a Body);

/// Looks at one pair; `None` where nothing is within the margin.
pub(crate) fn examine(
    (a_id, a): Numbered<'_>,
    (b_id, b): Numbered<'_>,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<PairReport> {
    scratch.look(a.shape(), b.shape(), margin);
    let distance = scratch.distance(a.shape(), b.shape(), margin);
    if distance.is_none() && !scratch.has_contact() {
        return None;
    }
    let patches = patches::find(a.shape(), &scratch.cut.faces_of_a, &scratch.a.near);
    Some(PairReport { distance, patches, ..scratch.report(a_id, b_id) })
}

/// Looks at one pair, and leaves out the distance between the surfaces and the
/// patches; `None` where no vertex is within the margin and nothing overlaps.
pub(crate) fn glance(
    (a_id, a): Numbered<'_>,
    (b_id, b): Numbered<'_>,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<PairReport> {
    scratch.look(a.shape(), b.shape(), margin);
    scratch.has_contact().then(|| scratch.report(a_id, b_id))
}

/// The unit vector along `v`, or along `otherwise` where `v` is lost in the
/// rounding of coordinates of size `scale`.
fn direction_or(v: DVec3, scale: f64, otherwise: DVec3) -> DVec3 {
    /// Multiple of the rounding of one coordinate below which the difference
    /// of two points has no trustworthy direction: the foot is computed with
    /// some ten roundings. Smaller would return noise as a normal; larger
    /// would replace good directions of gaps below a picometre by face normals.
    const ROUNDINGS: f64 = 64.0;
    let length = v.length();
    if length > ROUNDINGS * f64::EPSILON * scale { v / length } else { otherwise }
}
