//! The ways to answer a query that are compared: each takes a query and
//! returns the time it would give for the first contact.

use ccd::{CcdParams, cubic};
use del_geo_core::ccd3::{EdgeEdge, FaceVertex, intersecting_time_ee, intersecting_time_fv};
use glam::DVec3;

use super::queries::{Kind, Query};

/// The crate `ccd`, reporting what rounding leaves open.
#[must_use]
pub fn certified(kind: Kind, query: &Query, params: &CcdParams) -> Option<f64> {
    let contact = match kind {
        Kind::VertexFace => ccd::vertex_face(query.x0, query.x1, params),
        Kind::EdgeEdge => ccd::edge_edge(query.x0, query.x1, params),
    };
    contact.ok().flatten().map(|contact| contact.lo)
}

/// The crate `del-geo-core`: an uncertified cubic.
#[must_use]
pub fn del_geo(kind: Kind, query: &Query) -> Option<f64> {
    let s = query.x0.map(|x| x.to_array());
    let e = query.x1.map(|x| x.to_array());
    let epsilon = f64::EPSILON;
    match kind {
        Kind::VertexFace => intersecting_time_fv(
            FaceVertex { f0: &s[1], f1: &s[2], f2: &s[3], v: &s[0] },
            FaceVertex { f0: &e[1], f1: &e[2], f2: &e[3], v: &e[0] },
            epsilon,
        ),
        Kind::EdgeEdge => intersecting_time_ee(
            EdgeEdge { a0: &s[0], a1: &s[1], b0: &s[2], b1: &s[3] },
            EdgeEdge { a0: &e[0], a1: &e[1], b0: &e[2], b1: &e[3] },
            epsilon,
        ),
    }
}

/// The cubic of Provot 1997 in plain arithmetic, solved by
/// [`cubic::roots`]; each root is tested with barycentric coordinates.
#[must_use]
pub fn plain_cubic(kind: Kind, query: &Query) -> Option<f64> {
    let [corner0, first0, last0] = corner_and_edges(kind, &query.x0);
    let [corner1, first1, last1] = corner_and_edges(kind, &query.x1);
    let (n0, n1) = (first0.cross(last0), first1.cross(last1));
    let mixed = first0.cross(last1) + first1.cross(last0);
    let bernstein = [
        corner0.dot(n0),
        (corner1.dot(n0) + corner0.dot(mixed)) / 3.0,
        (corner0.dot(n1) + corner1.dot(mixed)) / 3.0,
        corner1.dot(n1),
    ];
    cubic::roots(bernstein).iter().copied().find(|&t| {
        let mix = |a: DVec3, b: DVec3| a * (1.0 - t) + b * t;
        holds_origin(kind, mix(corner0, corner1), mix(first0, first1), mix(last0, last1))
    })
}

/// A corner of the polygon of differences, and its two edges.
fn corner_and_edges(kind: Kind, x: &[DVec3; 4]) -> [DVec3; 3] {
    match kind {
        Kind::VertexFace => [x[1] - x[0], x[2] - x[1], x[3] - x[1]],
        Kind::EdgeEdge => [x[2] - x[0], x[3] - x[2], x[0] - x[1]],
    }
}

fn holds_origin(kind: Kind, corner: DVec3, first: DVec3, last: DVec3) -> bool {
    let area = first.cross(last);
    let squared = area.length_squared();
    let (r, s) = (area.dot(last.cross(corner)) / squared, area.dot(corner.cross(first)) / squared);
    let most = match kind {
        Kind::VertexFace => r + s,
        Kind::EdgeEdge => r.max(s),
    };
    r >= 0.0 && s >= 0.0 && most <= 1.0
}

/// How short a piece of time and of both parameters is, in
/// [`interval_subdivision`], when it counts as a contact.
pub const SUBDIVISION_TOLERANCE: f64 = 1e-6;

/// Boxes tested before [`interval_subdivision`] gives up and calls it a contact.
const MOST_BOXES: usize = 1 << 20;

/// Subdivision of time and both parameters: boxes whose image keeps clear of
/// the origin are dropped, the earliest is split first.
///
/// Source: J. Snyder et al., "Interval methods for multi-point collisions
/// between time-dependent curved surfaces", SIGGRAPH 1993; the image of a box
/// is the box of its corners, as in B. Wang et al., ACM TOG 40(5), 2021.
#[must_use]
pub fn interval_subdivision(kind: Kind, query: &Query) -> Option<f64> {
    let rounding = rounding_of(query);
    let mut open = vec![[(0.0, 1.0); 3]];
    let mut tested = 0;
    while let Some(cell) = open.pop() {
        tested += 1;
        let outside_face = kind == Kind::VertexFace && cell[1].0 + cell[2].0 > 1.0;
        if outside_face || clear_of_origin(kind, query, &cell, rounding) {
            continue;
        }
        let lengths = cell.map(|(lo, hi): (f64, f64)| hi - lo);
        let longest = (0..3).max_by(|&i, &j| lengths[i].total_cmp(&lengths[j])).unwrap_or(0);
        if lengths[longest] <= SUBDIVISION_TOLERANCE || tested > MOST_BOXES {
            return Some(cell[0].0);
        }
        let (lo, hi) = cell[longest];
        let middle = 0.5 * (lo + hi);
        for half in [(middle, hi), (lo, middle)] {
            let mut part = cell;
            part[longest] = half;
            open.push(part);
        }
    }
    None
}

fn rounding_of(query: &Query) -> f64 {
    let largest = query.x0.iter().chain(&query.x1).map(|x| x.abs().max_element());
    1e-14 * largest.fold(0.0, f64::max)
}

fn clear_of_origin(kind: Kind, query: &Query, cell: &[(f64, f64); 3], rounding: f64) -> bool {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |i: usize| if corner >> i & 1 == 0 { cell[i].0 } else { cell[i].1 };
        let q = difference(kind, query, [pick(0), pick(1), pick(2)]);
        low = low.min(q);
        high = high.max(q);
    }
    low.max_element() > rounding || high.min_element() < -rounding
}

fn difference(kind: Kind, query: &Query, [t, r, s]: [f64; 3]) -> DVec3 {
    let x: [DVec3; 4] = std::array::from_fn(|i| query.x0[i] * (1.0 - t) + query.x1[i] * t);
    match kind {
        Kind::VertexFace => x[1] * (1.0 - r - s) + x[2] * r + x[3] * s - x[0],
        Kind::EdgeEdge => x[2] * (1.0 - r) + x[3] * r - x[0] * (1.0 - s) - x[1] * s,
    }
}
