//! Values between the nodes of a grid: products of one spline along each axis.
//!
//! All are linear in the nodes, which is what a fit needs: `read` takes a value and its
//! gradient from the nodes, `add` is its transpose.

use distance_field::{Cell, Grid};
use glam::DVec3;

/// Weights of `N` nodes in a row at a place between the middle two, and how each changes.
type Weights<const N: usize> = [(f64, f64); N];

/// A spline, of `N` nodes at any place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spline<const N: usize> {
    weights: fn(f64) -> Weights<N>,
}

/// Straight from node to node.
pub(crate) const LINEAR: Spline<2> = Spline { weights: |t| [(1.0 - t, -1.0), (t, 1.0)] };
/// The cubic through interpolating nodes.
pub(crate) const CATMULL_ROM: Spline<4> = Spline { weights: |t| cubic(t, 0.0) };
/// The cubic through nodes of a quasi-interpolation.
pub(crate) const MEAN: Spline<4> = Spline { weights: |t| cubic(t, 0.5) };
/// The smoothest cubic.
pub(crate) const B_SPLINE: Spline<4> = Spline { weights: |t| cubic(t, 1.0) };

/// From Catmull and Rom's, where `b` is 0, to the B-spline, where it is 1.
///
/// Source: D. Mitchell and A. Netravali, "Reconstruction filters in computer graphics",
/// SIGGRAPH 1988, the family with B + 2C = 1, as a function of the distance to a node.
fn cubic(t: f64, b: f64) -> Weights<4> {
    let c = (1.0 - b) / 2.0;
    let near = [6.0 - 2.0 * b, 0.0, -18.0 + 12.0 * b + 6.0 * c, 12.0 - 9.0 * b - 6.0 * c];
    let far = [8.0 * b + 24.0 * c, -12.0 * b - 48.0 * c, 6.0 * b + 30.0 * c, -b - 6.0 * c];
    let at = |[p, q, r, s]: [f64; 4], x: f64, sign: f64| {
        let value = p + x * (q + x * (r + x * s));
        let slope = q + x * (2.0 * r + x * 3.0 * s);
        (value / 6.0, sign * slope / 6.0)
    };
    [at(far, 1.0 + t, 1.0), at(near, t, 1.0), at(near, 1.0 - t, -1.0), at(far, 2.0 - t, -1.0)]
}

/// Where a point is among the nodes that have to do with it.
pub(crate) struct Place<const N: usize> {
    /// The lowest of these.
    pub(crate) first: [usize; 3],
    axes: [Weights<N>; 3],
    per_length: f64,
}

impl<const N: usize> Spline<N> {
    /// Of a point of the grid that has all its nodes around it.
    #[inline]
    pub(crate) fn place(&self, grid: &Grid, p: DVec3) -> Place<N> {
        let Cell { node, place } = grid.locate(p).expect("a point of the grid");
        let first = node.map(|n| n - (N / 2 - 1));
        let axes = place.to_array().map(self.weights);
        Place { first, axes, per_length: 1.0 / grid.spacing() }
    }
}

impl<const N: usize> Place<N> {
    /// The rows of nodes, each by how far it lies above the first along y and z.
    pub(crate) fn rows(&self) -> impl Iterator<Item = [usize; 2]> + use<N> {
        (0..N * N).map(|row| [row % N, row / N])
    }

    /// The first node of a row.
    #[inline]
    pub(crate) fn node(&self, grid: &Grid, [j, k]: [usize; 2]) -> usize {
        let [x, y, z] = self.first;
        grid.index([x, y + j, z + k])
    }

    /// Value and gradient, of values from the first node of each row on.
    #[inline]
    pub(crate) fn read<'a>(&self, row: impl Fn([usize; 2]) -> &'a [f64]) -> (f64, DVec3) {
        let [x, y, z] = &self.axes;
        let (mut value, mut gradient) = (0.0, DVec3::ZERO);
        for (k, &(wz, dz)) in z.iter().enumerate() {
            for (j, &(wy, dy)) in y.iter().enumerate() {
                let (mut along, mut slope) = (0.0, 0.0);
                for (&(wx, dx), &node) in x.iter().zip(&row([j, k])[..N]) {
                    along += wx * node;
                    slope += dx * node;
                }
                value += along * wy * wz;
                gradient += DVec3::new(slope * wy * wz, along * dy * wz, along * wy * dz);
            }
        }
        (value, gradient * self.per_length)
    }

    /// Adds a value and a gradient to `nodes`, as many times as each has to do with them; a row
    /// begins where `row` says.
    #[inline]
    pub(crate) fn add(
        &self,
        (value, gradient): (f64, DVec3),
        nodes: &mut [f64],
        row: impl Fn([usize; 2]) -> usize,
    ) {
        let [x, y, z] = &self.axes;
        let gradient = gradient * self.per_length;
        for (k, &(wz, dz)) in z.iter().enumerate() {
            for (j, &(wy, dy)) in y.iter().enumerate() {
                let along = (value * wy + gradient.y * dy) * wz + gradient.z * wy * dz;
                let slope = gradient.x * wy * wz;
                let first = row([j, k]);
                for (&(wx, dx), node) in x.iter().zip(&mut nodes[first..first + N]) {
                    *node += along * wx + slope * dx;
                }
            }
        }
    }
}
