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

use glam::DVec3;
use kdop::Workspace;

use crate::scene::Body;
use crate::{BodyId, NoInside};

pub use self::patches::ContactPatch;
pub use self::projection::NearVertex;

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
    /// inside; `None` where no vertex is within reach or inside.
    pub min_gap: Option<f64>,
    /// Distance between the surfaces, their edges and faces included: 0 where
    /// they cross or touch, `None` where they are farther apart than the reach.
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
    /// Vertices that are inside or within reach, ascending.
    pub near: Vec<NearVertex>,
}

/// Memory that a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) traversal: Workspace,
    parents: Vec<u32>,
    a: projection::Candidates,
    b: projection::Candidates,
}

/// A body with its number.
pub(crate) type Numbered<'a> = (BodyId, &'a Body);

/// Looks at one pair; `None` where nothing is within reach.
pub(crate) fn examine(
    (a_id, a): Numbered<'_>,
    (b_id, b): Numbered<'_>,
    reach: f64,
    scratch: &mut Scratch,
) -> Option<PairReport> {
    let cut = crossings::find(a, b, scratch);
    projection::find_candidates(a, b, reach, scratch);
    let a_against_b = side((a, &cut.faces_of_a), b, reach, Side::A, scratch);
    let b_against_a = side((b, &cut.faces_of_b), a, reach, Side::B, scratch);

    let near = || a_against_b.near.iter().chain(&b_against_a.near);
    let min_gap = near().map(|vertex| vertex.gap).min_by(f64::total_cmp);
    let distance = if cut.faces_of_a.is_empty() {
        let within = near().map(|vertex| vertex.gap.abs()).fold(reach, f64::min);
        distance::between(a, b, within, scratch)
    } else {
        Some(0.0)
    };
    let inside = |side: &VertexReport| side.inside_count.unwrap_or(0) > 0;
    let overlaps = !cut.crossing.is_empty() || inside(&a_against_b) || inside(&b_against_a);
    if min_gap.is_none() && distance.is_none() && !overlaps {
        return None;
    }
    Some(PairReport {
        a: a_id,
        b: b_id,
        overlaps,
        max_depth: min_gap.map_or(0.0, |gap| (-gap).max(0.0)),
        min_gap,
        distance,
        patches: patches::find(a, &cut.faces_of_a, &a_against_b.near),
        crossing_faces: cut.crossing,
        a_against_b,
        b_against_a,
    })
}

/// Which of a pair's bodies the vertices are of.
#[derive(Clone, Copy)]
enum Side {
    A,
    B,
}

/// One side of a pair: which vertices of `p`, given with its cut faces, are
/// inside or near `q`.
fn side(
    (p, cut_faces): (&Body, &[u32]),
    q: &Body,
    reach: f64,
    side: Side,
    scratch: &mut Scratch,
) -> VertexReport {
    let inside = q.has_inside().map(|()| regions::inside(p, q, cut_faces, scratch));
    let Scratch { traversal, a, b, .. } = scratch;
    let candidates = match side {
        Side::A => a,
        Side::B => b,
    };
    let vertices = inside.as_deref().unwrap_or(&[]);
    let near = projection::project(p, q, vertices, reach, candidates, traversal);
    VertexReport { inside_count: inside.map(|vertices| vertices.len()), near }
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
