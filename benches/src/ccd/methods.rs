//! Continuous collision methods that are compared.
//!
//! Each takes a query and returns its time of the first contact.

use ccd::{CcdContact, CcdParams};
#[cfg(feature = "peers")]
use del_geo_core::ccd3::{EdgeEdge, FaceVertex, intersecting_time_ee, intersecting_time_fv};
use glam::DVec3;

use super::plain_roots::roots;
use super::queries::{CcdQuery, QueryKind};

/// Answers by the crate `ccd`, which reports what rounding leaves open.
#[must_use]
pub fn certified(query: &CcdQuery, params: &CcdParams) -> Option<f64> {
    contact(query, params).map(|contact| contact.lo)
}

/// Finds the first contact by the crate `ccd`, with the interval that its time is in.
#[must_use]
pub fn contact(query: &CcdQuery, params: &CcdParams) -> Option<CcdContact> {
    let contact = match query.kind {
        QueryKind::VertexFace => ccd::vertex_face(query.x0, query.x1, params),
        QueryKind::EdgeEdge => ccd::edge_edge(query.x0, query.x1, params),
    };
    contact.ok().flatten()
}

/// Answers by the crate `del-geo-core`: an uncertified cubic.
#[cfg(feature = "peers")]
#[must_use]
pub fn del_geo(query: &CcdQuery) -> Option<f64> {
    // The peer takes arrays.
    let s: [[f64; 3]; 4] = query.x0.map(Into::into);
    let e: [[f64; 3]; 4] = query.x1.map(Into::into);
    let epsilon = f64::EPSILON;
    match query.kind {
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
pub fn plain_cubic(query: &CcdQuery) -> Option<f64> {
    let [start, end] = Differences::at_ends(query);
    let (n0, n1) = (start.first.cross(start.last), end.first.cross(end.last));
    let mixed = start.first.cross(end.last) + end.first.cross(start.last);

    // The triple product of the differences, a cubic in time, in Bernstein form.
    let bernstein = [
        start.corner.dot(n0),
        (end.corner.dot(n0) + start.corner.dot(mixed)) / 3.0,
        (start.corner.dot(n1) + end.corner.dot(mixed)) / 3.0,
        end.corner.dot(n1),
    ];
    roots(bernstein).iter().copied().find(|&t| start.lerp(end, t).holds_origin(query.kind))
}

/// Polygon of the differences between points of both primitives: a triangle for a vertex and a
/// face, a parallelogram for two edges. Both touch where it holds the origin.
#[derive(Clone, Copy)]
struct Differences {
    corner: DVec3,
    /// Edges along the polygon from the corner.
    first: DVec3,
    last: DVec3,
}

impl Differences {
    /// Returns the polygons at the start and at the end of the step.
    fn at_ends(query: &CcdQuery) -> [Self; 2] {
        [query.x0, query.x1].map(|x| match query.kind {
            QueryKind::VertexFace => {
                Self { corner: x[1] - x[0], first: x[2] - x[1], last: x[3] - x[1] }
            }
            QueryKind::EdgeEdge => {
                Self { corner: x[2] - x[0], first: x[3] - x[2], last: x[0] - x[1] }
            }
        })
    }

    fn lerp(self, end: Self, t: f64) -> Self {
        Self {
            corner: self.corner * (1.0 - t) + end.corner * t,
            first: self.first * (1.0 - t) + end.first * t,
            last: self.last * (1.0 - t) + end.last * t,
        }
    }

    fn holds_origin(self, kind: QueryKind) -> bool {
        let Self { corner, first, last } = self;

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

/// Intervals of time and of both parameters of a polygon of differences.
#[derive(Clone, Copy)]
struct Cell {
    lower: [f64; 3],
    upper: [f64; 3],
}

/// Answers by subdivision of time and both parameters: boxes whose image is clear of the origin
/// are dropped, the earliest is split first.
///
/// Source: J. Snyder et al., "Interval methods for multi-point collisions between time-dependent
/// curved surfaces", SIGGRAPH 1993; the image of a box is the box of its corners, as in B. Wang
/// et al., ACM TOG 40(5), 2021.
#[must_use]
pub fn interval_subdivision(query: &CcdQuery) -> Option<f64> {
    let mut extent = DVec3::ZERO;
    for x in query.x0.iter().chain(&query.x1) {
        extent = extent.max(x.abs());
    }
    let rounding = 1e-14 * extent.max_element();
    let ends = Differences::at_ends(query);
    let mut open = vec![Cell { lower: [0.0; 3], upper: [1.0; 3] }];
    let mut tested = 0;

    while let Some(cell) = open.pop() {
        tested += 1;
        let is_beyond_face =
            query.kind == QueryKind::VertexFace && cell.lower[1] + cell.lower[2] > 1.0;
        if is_beyond_face || cell.is_clear_of_origin(ends, rounding) {
            continue;
        }

        // A cell small enough is a contact.
        let Cell { lower, upper } = cell;
        let lengths = DVec3::from(upper) - DVec3::from(lower);
        let longest = lengths.max_position();
        if lengths[longest] <= SUBDIVISION_TOLERANCE || tested > MAX_BOXES {
            return Some(lower[0]);
        }

        // The later half goes below the earlier one on the stack.
        let (mut earlier, mut later) = (cell, cell);
        let middle = 0.5 * (lower[longest] + upper[longest]);
        earlier.upper[longest] = middle;
        later.lower[longest] = middle;
        open.extend([later, earlier]);
    }
    None
}

impl Cell {
    /// Returns true if no difference in the cell is the origin, by the box of its corners' images.
    fn is_clear_of_origin(&self, [start, end]: [Differences; 2], rounding: f64) -> bool {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for t in [self.lower[0], self.upper[0]] {
            let Differences { corner, first, last } = start.lerp(end, t);
            for r in [self.lower[1], self.upper[1]] {
                for s in [self.lower[2], self.upper[2]] {
                    let difference = corner + first * r + last * s;
                    min = min.min(difference);
                    max = max.max(difference);
                }
            }
        }
        min.max_element() > rounding || max.min_element() < -rounding
    }
}
