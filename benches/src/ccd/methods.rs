//! Continuous collision methods that are compared.
//!
//! Each takes a query and returns its time of the first contact.

use ccd::CcdParams;
use del_geo_core::ccd3::{EdgeEdge, FaceVertex, intersecting_time_ee, intersecting_time_fv};
use glam::DVec3;

use super::plain_roots::roots;
use super::queries::{CcdQuery, QueryKind};

/// Answers by the crate `ccd`, which reports what rounding leaves open.
#[must_use]
pub fn certified(kind: QueryKind, query: &CcdQuery, params: &CcdParams) -> Option<f64> {
    let contact = match kind {
        QueryKind::VertexFace => ccd::vertex_face(query.x0, query.x1, params),
        QueryKind::EdgeEdge => ccd::edge_edge(query.x0, query.x1, params),
    };
    contact.ok().flatten().map(|contact| contact.lo)
}

/// Answers by the crate `del-geo-core`: an uncertified cubic.
#[must_use]
pub fn del_geo(kind: QueryKind, query: &CcdQuery) -> Option<f64> {
    let s = query.x0.map(|x| x.to_array());
    let e = query.x1.map(|x| x.to_array());
    let epsilon = f64::EPSILON;
    match kind {
        QueryKind::VertexFace => intersecting_time_fv(
            FaceVertex { f0: &s[1], f1: &s[2], f2: &s[3], v: &s[0] },
            FaceVertex { f0: &e[1], f1: &e[2], f2: &e[3], v: &e[0] },
            epsilon,
        ),
        QueryKind::EdgeEdge => intersecting_time_ee(
            EdgeEdge { a0: &s[0], a1: &s[1], b0: &s[2], b1: &s[3] },
            EdgeEdge { a0: &e[0], a1: &e[1], b0: &e[2], b1: &e[3] },
            epsilon,
        ),
    }
}

/// Answers by the cubic of Provot 1997 in plain arithmetic: each root of [`roots`] is
/// tested with barycentric coordinates.
#[must_use]
pub fn plain_cubic(kind: QueryKind, query: &CcdQuery) -> Option<f64> {
    let (start, end) = (Differences::new(kind, &query.x0), Differences::new(kind, &query.x1));
    let (n0, n1) = (start.first.cross(start.last), end.first.cross(end.last));
    let mixed = start.first.cross(end.last) + end.first.cross(start.last);

    // The triple product of the differences, a cubic in time, in Bernstein form.
    let bernstein = [
        start.corner.dot(n0),
        (end.corner.dot(n0) + start.corner.dot(mixed)) / 3.0,
        (start.corner.dot(n1) + end.corner.dot(mixed)) / 3.0,
        end.corner.dot(n1),
    ];
    roots(bernstein).iter().copied().find(|&t| start.lerp(&end, t).holds_origin(kind))
}

/// Polygon of the differences between points of both primitives: a triangle for a vertex and a
/// face, a parallelogram for two edges. Both touch where it holds the origin.
struct Differences {
    corner: DVec3,
    /// Edges along the polygon from the corner.
    first: DVec3,
    last: DVec3,
}

impl Differences {
    fn new(kind: QueryKind, x: &[DVec3; 4]) -> Self {
        match kind {
            QueryKind::VertexFace => {
                Self { corner: x[1] - x[0], first: x[2] - x[1], last: x[3] - x[1] }
            }
            QueryKind::EdgeEdge => {
                Self { corner: x[2] - x[0], first: x[3] - x[2], last: x[0] - x[1] }
            }
        }
    }

    fn lerp(&self, end: &Self, t: f64) -> Self {
        let mix = |a: DVec3, b: DVec3| a * (1.0 - t) + b * t;
        Self {
            corner: mix(self.corner, end.corner),
            first: mix(self.first, end.first),
            last: mix(self.last, end.last),
        }
    }

    fn holds_origin(&self, kind: QueryKind) -> bool {
        let Self { corner, first, last } = *self;
        // Barycentric coordinates of the origin.
        let area = first.cross(last);
        let squared = area.length_squared();
        let r = area.dot(last.cross(corner)) / squared;
        let s = area.dot(corner.cross(first)) / squared;
        let max = match kind {
            QueryKind::VertexFace => r + s,
            QueryKind::EdgeEdge => r.max(s),
        };
        r >= 0.0 && s >= 0.0 && max <= 1.0
    }
}

/// Extent of time and of both parameters below which [`interval_subdivision`] reports a contact.
pub const SUBDIVISION_TOLERANCE: f64 = 1e-6;

/// Boxes tested before [`interval_subdivision`] gives up and reports a contact.
const MAX_BOXES: usize = 1 << 20;

/// Interval of a parameter.
#[derive(Clone, Copy)]
struct Interval {
    lower: f64,
    upper: f64,
}

/// Answers by subdivision of time and both parameters: boxes whose image is clear of the origin
/// are dropped, the earliest is split first.
///
/// Source: J. Snyder et al., "Interval methods for multi-point collisions between time-dependent
/// curved surfaces", SIGGRAPH 1993; the image of a box is the box of its corners, as in B. Wang
/// et al., ACM TOG 40(5), 2021.
#[must_use]
pub fn interval_subdivision(kind: QueryKind, query: &CcdQuery) -> Option<f64> {
    let coordinates = query.x0.iter().chain(&query.x1).map(|x| x.abs().max_element());
    let rounding = 1e-14 * coordinates.fold(0.0, f64::max);
    let mut open = vec![[Interval { lower: 0.0, upper: 1.0 }; 3]];
    let mut tested = 0;

    while let Some(cell) = open.pop() {
        tested += 1;
        let is_beyond_face = kind == QueryKind::VertexFace && cell[1].lower + cell[2].lower > 1.0;
        if is_beyond_face || is_clear_of_origin(kind, query, &cell, rounding) {
            continue;
        }

        // A cell small enough is a contact.
        let lengths = cell.map(|side| side.upper - side.lower);
        let longest = (0..3).max_by(|&i, &j| lengths[i].total_cmp(&lengths[j])).unwrap_or(0);
        if lengths[longest] <= SUBDIVISION_TOLERANCE || tested > MAX_BOXES {
            return Some(cell[0].lower);
        }

        // The later half goes below the earlier one on the stack.
        let Interval { lower, upper } = cell[longest];
        let middle = 0.5 * (lower + upper);
        let halves = [Interval { lower: middle, upper }, Interval { lower, upper: middle }];
        for half in halves {
            let mut part = cell;
            part[longest] = half;
            open.push(part);
        }
    }
    None
}

fn is_clear_of_origin(
    kind: QueryKind,
    query: &CcdQuery,
    cell: &[Interval; 3],
    rounding: f64,
) -> bool {
    // The image of a cell is within the box of its corners' images.
    let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |i: usize| if corner >> i & 1 == 0 { cell[i].lower } else { cell[i].upper };
        let q = difference(kind, query, [pick(0), pick(1), pick(2)]);
        lower = lower.min(q);
        upper = upper.max(q);
    }
    lower.max_element() > rounding || upper.min_element() < -rounding
}

/// Returns the difference between the points of both primitives at time `t` and parameters `r`, `s`.
fn difference(kind: QueryKind, query: &CcdQuery, [t, r, s]: [f64; 3]) -> DVec3 {
    let x: [DVec3; 4] = std::array::from_fn(|i| query.x0[i] * (1.0 - t) + query.x1[i] * t);
    match kind {
        QueryKind::VertexFace => x[1] * (1.0 - r - s) + x[2] * r + x[3] * s - x[0],
        QueryKind::EdgeEdge => x[2] * (1.0 - r) + x[3] * r - x[0] * (1.0 - s) - x[1] * s,
    }
}
