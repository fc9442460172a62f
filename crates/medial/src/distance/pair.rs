//! Distance between two slabs: the pair of balls that come nearest to each other or overlap
//! deepest.
//!
//! `f(v, w) = |a(v) − b(w)| − r_a(v) − r_b(w)` is convex in both weights together, so that its
//! minimum is the deepest overlap, globally. The minimum is always attained at one of finitely many
//! places, each in closed form:
//!
//! - a ball at a corner of one against the whole other slab;
//! - a stationary pair of one edge each;
//! - where centers coincide, the crossing of an edge with the face of the other slab.
//!
//! Elsewhere (an edge against the inside of a face, or both insides) stationarity is more
//! conditions on the direction `n = (a − b)/|a − b|` than it has degrees of freedom. Where it holds
//! by coincidence, as for parallel slabs, f is constant along some line of weights, which leads to
//! one of these places.
//!
//! The same minimum is a quadratically constrained program solved by iteration in L. Lan, R. Luo,
//! M. Fratarcangeli, W. Xu, H. Wang, X. Guo, J. Yao and Y. Yang, "Medial Elastics", ACM TOG 39(3),
//! 2020.

use glam::DVec3;
use surface::triangle;

use super::plane::are_inside;
use super::{direction, slab_foot};
use crate::Ball;

/// Balls of two primitives that define their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairFoot {
    /// Weights of the first primitive's balls, `>= 0`, with sum one.
    pub weights_a: [f64; 3],
    /// Weights of the second primitive's balls.
    pub weights_b: [f64; 3],
    /// The first primitive's ball.
    pub a: Ball,
    /// The second primitive's ball.
    pub b: Ball,
    /// `|a − b| − r_a − r_b`, negative where they overlap.
    pub distance: f64,
}

/// Weights of the corners of a slab.
const CORNERS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl PairFoot {
    fn at(a: &[Ball; 3], b: &[Ball; 3], weights_a: [f64; 3], weights_b: [f64; 3]) -> Self {
        let (ball_a, ball_b) = (Ball::interpolate(a, weights_a), Ball::interpolate(b, weights_b));
        let distance = ball_b.distance(ball_a.center) - ball_a.radius;
        Self { weights_a, weights_b, a: ball_a, b: ball_b, distance }
    }

    /// Returns the nearer of two feet, the first of equals.
    fn nearer(self, other: Self) -> Self {
        if other.distance < self.distance { other } else { self }
    }

    /// Computes the unit vector from the second ball's center to the first's; `None` where they
    /// coincide.
    #[must_use]
    pub fn normal(&self) -> Option<DVec3> {
        direction(self.b.center, self.a.center)
    }
}

/// Computes the distance or deepest overlap of two slabs, exactly.
///
/// A cone is a slab with one ball given twice, a ball one with three.
///
/// ```
/// use glam::DVec3;
/// use medial::{Ball, pair_foot};
///
/// // Two capsules that cross at right angles, 3 apart at their middles.
/// let cone = |from, to| [Ball::new(from, 1.0), Ball::new(to, 1.0), Ball::new(to, 1.0)];
/// let along_x = cone(-6.0 * DVec3::X, 6.0 * DVec3::X);
/// let along_y = cone(DVec3::new(0.0, -6.0, 3.0), DVec3::new(0.0, 6.0, 3.0));
/// let foot = pair_foot(&along_x, &along_y);
/// assert!((foot.distance - 1.0).abs() < 1e-15);
/// assert_eq!(foot.normal(), Some(-DVec3::Z));
/// ```
#[must_use]
pub fn pair_foot(a: &[Ball; 3], b: &[Ball; 3]) -> PairFoot {
    // Corners against whole slabs.
    let mut best = PairFoot::at(a, b, CORNERS[0], slab_foot(a[0].center, b).weights);
    for (k, corner) in CORNERS.into_iter().enumerate() {
        best = best.nearer(PairFoot::at(a, b, corner, slab_foot(a[k].center, b).weights));
        best = best.nearer(PairFoot::at(a, b, slab_foot(b[k].center, a).weights, corner));
    }

    // Edges against edges, and against faces.
    for i in 0..3 {
        for j in 0..3 {
            if let Some([s, t]) = stationary_on_edges(edge(a, i), edge(b, j)) {
                best = best.nearer(PairFoot::at(a, b, on_edge(i, s), on_edge(j, t)));
            }
        }
        if let Some(crossing) = EdgeCrossing::find(edge(a, i), b) {
            best = best.nearer(PairFoot::at(a, b, on_edge(i, crossing.t), crossing.weights));
        }
        if let Some(crossing) = EdgeCrossing::find(edge(b, i), a) {
            best = best.nearer(PairFoot::at(a, b, crossing.weights, on_edge(i, crossing.t)));
        }
    }
    best
}

/// Returns the `i`th edge, from corner `i` to the next.
fn edge(balls: &[Ball; 3], i: usize) -> [Ball; 2] {
    [balls[i], balls[(i + 1) % 3]]
}

/// Returns the weights of a point of the `i`th edge.
fn on_edge(i: usize, t: f64) -> [f64; 3] {
    let mut weights = [0.0; 3];
    weights[i] = 1.0 - t;
    weights[(i + 1) % 3] = t;
    weights
}

/// Computes the parameters of the pair of balls on two edges where f is stationary; `None` where it
/// is not on both edges, and for parallel edges.
///
/// With edge vectors `e_a`, `e_b` and radius growths `g_a`, `g_b`, stationarity is `n·e_a = g_a` and
/// `n·e_b = −g_b`. That fixes the part m of n in the plane of both, and the length h of the common
/// perpendicular then gives `|d| = h/√(1 − m²)`.
fn stationary_on_edges(a: [Ball; 2], b: [Ball; 2]) -> Option<[f64; 2]> {
    let (e_a, e_b) = (a[1].center - a[0].center, b[1].center - b[0].center);
    let growth = [a[1].radius - a[0].radius, b[0].radius - b[1].radius];
    let cross = e_a.cross(e_b);
    let determinant = cross.length_squared();
    if determinant <= 0.0 {
        return None;
    }

    // The part of the normal in the plane of both edges.
    let (g_aa, g_ab, g_bb) = (e_a.length_squared(), e_a.dot(e_b), e_b.length_squared());
    let solve =
        |x: f64, y: f64| [(g_bb * x - g_ab * y) / determinant, (g_aa * y - g_ab * x) / determinant];
    let [m_a, m_b] = solve(growth[0], growth[1]);
    let m_squared = m_a * growth[0] + m_b * growth[1];
    if m_squared >= 1.0 {
        return None;
    }

    // The parameters, from the length of the vector between the centers.
    let apart = a[0].center - b[0].center;
    let length = apart.dot(cross).abs() / (determinant * (1.0 - m_squared)).sqrt();
    let [s, minus_t] =
        solve(length * growth[0] - apart.dot(e_a), length * growth[1] - apart.dot(e_b));
    let t = -minus_t;
    let are_on_edges = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    are_on_edges.then_some([s, t])
}

/// Crossing of an edge of centers with a face of centers.
struct EdgeCrossing {
    /// Parameter on the edge.
    t: f64,
    /// Weights on the face.
    weights: [f64; 3],
}

impl EdgeCrossing {
    fn find(edge: [Ball; 2], face: &[Ball; 3]) -> Option<Self> {
        let [a, b, c] = Ball::centers(face);
        let (start, along) = (edge[0].center, edge[1].center - edge[0].center);
        let normal = triangle::normal([a, b, c]);
        let t = -(start - a).dot(normal) / along.dot(normal);
        // An edge in the plane of the face gives NaN, which is not on the edge.
        if !(0.0..=1.0).contains(&t) {
            return None;
        }

        // Barycentric coordinates of the crossing, as ratios of areas.
        let (e1, e2, w) = (b - a, c - a, start - a + t * along);
        let area_squared = normal.length_squared();
        let v = w.cross(e2).dot(normal) / area_squared;
        let u = e1.cross(w).dot(normal) / area_squared;
        let weights = [1.0 - v - u, v, u];
        are_inside(weights).then_some(Self { t, weights })
    }
}
