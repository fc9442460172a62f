//! Polygon of a query: the face relative to the vertex, or the differences of two edges.

use glam::DVec3;

use crate::scalar::{fast_min, max_each, min_each};

/// Marker for the polygon of a query with `N` corners: 3 for a vertex and a face, 4 for two edges.
pub(crate) struct PolygonShape<const N: usize>;

/// Corner 0, its edges to corners 1 and `N - 1`, and the coordinate bounds of all corners, at one
/// time.
///
/// All are differences of the input, not of each other, so each is rounded once.
pub(crate) struct Differences<V> {
    pub(crate) corner: V,
    pub(crate) first_edge: V,
    pub(crate) last_edge: V,
    pub(crate) lower: V,
    pub(crate) upper: V,
}

/// Formulas that depend on the number of corners.
pub(crate) trait Corners<const N: usize>: Sized {
    /// Points whose difference each corner is: the first minus the second.
    const PAIRS: [(usize, usize); N];

    /// Computes the differences at one time.
    fn differences(x: &[DVec3; 4]) -> Differences<DVec3>;

    /// Returns the minimum that corners add to the height of corner 0.
    ///
    /// It is the smallest of 0, `a` for corner 1, `b` for corner `N - 1`, and their sum for a corner
    /// between them.
    fn min_rise(a: f64, b: f64) -> f64;

    /// Returns the edge functions, given those of the first and the last edge and `total`.
    ///
    /// `total` is the sum of all of them for a triangle, and of opposite ones for a parallelogram.
    fn edge_functions(first: f64, last: f64, total: f64) -> [f64; N];

    /// Returns the edges in order, given those of corner 0.
    fn edges(first: DVec3, last: DVec3) -> [DVec3; N];

    /// Converts weights of the corners to weights of the four points of the query.
    fn stencil(corners: [f64; N]) -> [f64; 4];

    /// Returns the weights of the corners for the origin, given its edge functions.
    ///
    /// An edge function is the area that the origin spans with the edge from corner `i` to `i + 1`.
    fn corner_weights(edge_functions: [f64; N]) -> [f64; N];
}

impl Corners<3> for PolygonShape<3> {
    const PAIRS: [(usize, usize); 3] = [(1, 0), (2, 0), (3, 0)];

    #[inline]
    fn differences(&[p, a, b, c]: &[DVec3; 4]) -> Differences<DVec3> {
        Differences {
            corner: a - p,
            first_edge: b - a,
            last_edge: c - a,
            lower: min_each(min_each(a, b), c) - p,
            upper: max_each(max_each(a, b), c) - p,
        }
    }

    #[inline]
    fn min_rise(a: f64, b: f64) -> f64 {
        fast_min(fast_min(a, b), 0.0)
    }

    #[inline]
    fn edge_functions(first: f64, last: f64, total: f64) -> [f64; 3] {
        [first, total - first - last, last]
    }

    #[inline]
    fn edges(first: DVec3, last: DVec3) -> [DVec3; 3] {
        [first, last - first, -last]
    }

    #[inline]
    fn stencil([a, b, c]: [f64; 3]) -> [f64; 4] {
        [-1.0, a, b, c]
    }

    #[inline]
    fn corner_weights([ab, bc, ca]: [f64; 3]) -> [f64; 3] {
        let scale = 1.0 / (ab + bc + ca);
        [bc * scale, ca * scale, ab * scale]
    }
}

impl Corners<4> for PolygonShape<4> {
    const PAIRS: [(usize, usize); 4] = [(2, 0), (3, 0), (3, 1), (2, 1)];

    #[inline]
    fn differences(&[a0, a1, b0, b1]: &[DVec3; 4]) -> Differences<DVec3> {
        Differences {
            corner: b0 - a0,
            first_edge: b1 - b0,
            last_edge: a0 - a1,
            lower: min_each(b0, b1) - max_each(a0, a1),
            upper: max_each(b0, b1) - min_each(a0, a1),
        }
    }

    #[inline]
    fn min_rise(a: f64, b: f64) -> f64 {
        fast_min(a, 0.0) + fast_min(b, 0.0)
    }

    #[inline]
    fn edge_functions(first: f64, last: f64, total: f64) -> [f64; 4] {
        [first, total - last, total - first, last]
    }

    #[inline]
    fn edges(first: DVec3, last: DVec3) -> [DVec3; 4] {
        [first, last, -first, -last]
    }

    #[inline]
    fn stencil([b0a0, b1a0, b1a1, b0a1]: [f64; 4]) -> [f64; 4] {
        [-(b0a0 + b1a0), -(b1a1 + b0a1), b0a0 + b0a1, b1a0 + b1a1]
    }

    #[inline]
    fn corner_weights([at_a0, at_b1, at_a1, at_b0]: [f64; 4]) -> [f64; 4] {
        let (a, b) = (at_a0 / (at_a0 + at_a1), at_b0 / (at_b0 + at_b1));
        [(1.0 - a) * (1.0 - b), (1.0 - a) * b, a * b, a * (1.0 - b)]
    }
}
