//! Interpolation from the corners of a cell, or from the block of 4³ nodes around it.
//!
//! Gradients are per cell; the caller divides by the spacing.
//!
//! Source of the cubics: E. Catmull and R. Rom, "A class of local interpolating splines",
//! Computer Aided Geometric Design, 1974; D. Mitchell and A. Netravali, "Reconstruction
//! filters in computer graphics", SIGGRAPH 1988, whose family with B + 2C = 1 leads from
//! Catmull–Rom (B = 0) to the cubic B-spline (B = 1).

use glam::DVec3;

use crate::NodeValues;
use crate::store::{Block, Corners};

/// Value with its gradient.
pub(super) type ValueAndGradient = (f64, DVec3);

/// Computes the trilinear value and its own gradient, which jumps between cells.
#[inline]
pub(super) fn trilinear<T: Into<f64>>([low, high]: Corners<T>, local: DVec3) -> ValueAndGradient {
    // Written out: as maps over arrays this takes three times as long.
    let [[c0, c1, c2, c3], [c4, c5, c6, c7]] = [low, high];
    let [c0, c1, c2, c3]: [f64; 4] = [c0.into(), c1.into(), c2.into(), c3.into()];
    let [c4, c5, c6, c7]: [f64; 4] = [c4.into(), c5.into(), c6.into(), c7.into()];
    let DVec3 { x, y, z } = local;

    // Along x at the four edges, then along y on the two faces.
    let [e0, e1, e2, e3] = [mix(c0, c1, x), mix(c2, c3, x), mix(c4, c5, x), mix(c6, c7, x)];
    let [f0, f1] = [mix(e0, e1, y), mix(e2, e3, y)];
    let dx = mix(mix(c1 - c0, c3 - c2, y), mix(c5 - c4, c7 - c6, y), z);
    let dy = mix(e1 - e0, e3 - e2, z);
    (mix(f0, f1, z), DVec3::new(dx, dy, f1 - f0))
}

#[inline]
fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Computes the trilinear value, and the trilinear interpolant of the central differences at
/// the corners, which is continuous.
pub(super) fn smooth(block: &Block, local: DVec3) -> ValueAndGradient {
    let weights = [DVec3::ONE - local, local];
    let (mut value, mut gradient) = (0.0, DVec3::ZERO);
    for corner in 0..8 {
        let [a, b, c] = [corner & 1, corner >> 1 & 1, corner >> 2];
        let weight = weights[a].x * weights[b].y * weights[c].z;

        // Nodes of the block are numbered from 1 below the cell.
        let [i, j, k] = [a + 1, b + 1, c + 1];
        let difference = DVec3::new(
            block[k][j][i + 1] - block[k][j][i - 1],
            block[k][j + 1][i] - block[k][j - 1][i],
            block[k + 1][j][i] - block[k - 1][j][i],
        );
        value += weight * block[k][j][i];
        gradient += 0.5 * weight * difference;
    }
    (value, gradient)
}

/// Returns the weight of a node's two neighbors in the cubic's value at the node, B / 6.
///
/// A quasi-interpolation subtracts a twelfth of the second differences from its nodes; this
/// weight adds as much back. The gradient there, the central difference, then errs half as
/// much as that of Catmull and Rom.
pub(super) fn outer_weight(node_values: NodeValues) -> f64 {
    match node_values {
        NodeValues::Interpolating => 0.0,
        NodeValues::QuasiInterpolating => 1.0 / 12.0,
    }
}

/// Computes the value and the continuous gradient of a tensor product cubic, of the family
/// from Catmull–Rom to the B-spline.
pub(super) fn cubic(block: &Block, local: DVec3, outer_weight: f64) -> ValueAndGradient {
    let x = weights(local.x, outer_weight);
    let y = weights(local.y, outer_weight);
    let z = weights(local.z, outer_weight);

    // Along the four nodes of each row, then over the rows of each plane, then the planes.
    let (mut value, mut gradient) = (0.0, DVec3::ZERO);
    for (plane, (wz, dz)) in block.iter().zip(z) {
        for (row, (wy, dy)) in plane.iter().zip(y) {
            let (mut along, mut slope) = (0.0, 0.0);
            for (&node, (wx, dx)) in row.iter().zip(x) {
                along += wx * node;
                slope += dx * node;
            }
            value += along * wy * wz;
            gradient += DVec3::new(slope * wy * wz, along * dy * wz, along * wy * dz);
        }
    }
    (value, gradient)
}

/// Returns the weights of four nodes in a row at `t` between the middle two, with their
/// derivatives.
#[inline]
fn weights(t: f64, outer: f64) -> [(f64, f64); 4] {
    [
        polynomial([outer, -0.5, 1.0 - 3.0 * outer, 2.0 * outer - 0.5], t),
        polynomial([1.0 - 2.0 * outer, 0.0, 9.0 * outer - 2.5, 1.5 - 6.0 * outer], t),
        polynomial([outer, 0.5, 2.0 - 9.0 * outer, 6.0 * outer - 1.5], t),
        polynomial([0.0, 0.0, 3.0 * outer - 0.5, 0.5 - 2.0 * outer], t),
    ]
}

/// Evaluates a polynomial, given the coefficients of ascending powers, and its derivative.
#[inline]
fn polynomial([a, b, c, d]: [f64; 4], t: f64) -> (f64, f64) {
    (a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * 3.0 * d))
}
