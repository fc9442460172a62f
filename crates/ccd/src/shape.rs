//! Polygon of a query: the face relative to the vertex, or the differences of two edges.

use glam::DVec3;

use crate::scalar::fast_min;

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

/// Vectors by coordinates, in lanes.
pub(crate) trait Coordinates: Copy {
    /// Subtracts another vector.
    fn minus(self, other: Self) -> Self;

    /// Returns the smaller of each coordinate.
    fn min(self, other: Self) -> Self;

    /// Returns the larger of each coordinate.
    fn max(self, other: Self) -> Self;
}

/// Differences of the points of a query that make its polygon.
pub(crate) trait PointDifferences {
    /// Computes the differences in each lane.
    fn differences<V: Coordinates>(x: &[V; 4]) -> Differences<V>;
}

/// Formulas that depend on the number of corners.
pub(crate) trait Corners<const N: usize>: PointDifferences + Sized {
    /// Points whose difference each corner is: the first minus the second.
    const PAIRS: [(usize, usize); N];

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

impl PointDifferences for PolygonShape<3> {
    #[inline]
    fn differences<V: Coordinates>(&[p, a, b, c]: &[V; 4]) -> Differences<V> {
        Differences {
            corner: a.minus(p),
            first_edge: b.minus(a),
            last_edge: c.minus(a),
            lower: a.min(b).min(c).minus(p),
            upper: a.max(b).max(c).minus(p),
        }
    }
}

impl Corners<3> for PolygonShape<3> {
    const PAIRS: [(usize, usize); 3] = [(1, 0), (2, 0), (3, 0)];

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

impl PointDifferences for PolygonShape<4> {
    #[inline]
    fn differences<V: Coordinates>(&[a0, a1, b0, b1]: &[V; 4]) -> Differences<V> {
        Differences {
            corner: b0.minus(a0),
            first_edge: b1.minus(b0),
            last_edge: a0.minus(a1),
            lower: b0.min(b1).minus(a0.max(a1)),
            upper: b0.max(b1).minus(a0.min(a1)),
        }
    }
}

impl Corners<4> for PolygonShape<4> {
    const PAIRS: [(usize, usize); 4] = [(2, 0), (3, 0), (3, 1), (2, 1)];

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
