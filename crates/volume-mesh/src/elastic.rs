//! Linear elastic equilibrium of a volume mesh whose boundary is displaced.
//!
//! The energy is ∫ (μ |ε|² + λ/2 (tr ε)²) with ε the symmetric gradient of the displacement, of one
//! material everywhere: then a displacement that is linear in space is in equilibrium on any mesh.
//! Gradients are integrated at one point of a tetrahedron, at 3 × 2 points of a wedge and at 2 × 2 × 2
//! Gauss points of a hexahedron, which is exact for them.
//!
//! Source: T. J. R. Hughes, "The Finite Element Method", Dover 2000, chapters 2 to 4.

use glam::{DMat3, DVec3};
use surface::progress::{Interrupted, Progress};
use surface::vectors::{add_scaled, dot, outer};

use crate::{Cell, VolumeMesh};

/// Residual at which the solver ends, relative to that at the start: less than single precision
/// shows, more takes steps that no file keeps.
const TOLERANCE: f64 = 1e-11;

/// Steps of the solver between two polls for an interruption.
const POLLED_STEPS: usize = 16;

/// Elastic body at some positions of its nodes.
#[derive(Debug)]
pub(crate) struct ElasticBody {
    points: Vec<IntegrationPoint>,
    /// Nodes of all points with the gradients of their shape functions, one after the other.
    terms: Vec<(u32, DVec3)>,
    /// λ/μ.
    lambda: f64,
}

/// Integration point: its terms, and its volume.
#[derive(Clone, Copy, Debug)]
struct IntegrationPoint {
    first: usize,
    end: usize,
    volume: f64,
}

impl ElasticBody {
    /// Builds the body of a mesh; `positions` leave no cell inverted.
    pub(crate) fn new(mesh: &VolumeMesh, positions: &[DVec3], poisson_ratio: f64) -> Self {
        let lambda = 2.0 * poisson_ratio / (1.0 - 2.0 * poisson_ratio);
        let mut body = Self { points: Vec::new(), terms: Vec::new(), lambda };
        // One point is exact for the constant gradients of a tetrahedron, six and eight for the others.
        for cell in mesh.cells() {
            match cell {
                Cell::Tetrahedron(nodes) => body.push(nodes, &TETRAHEDRON, 1.0 / 6.0, positions),
                Cell::Wedge(nodes) => {
                    for sample in 0..6 {
                        body.push(nodes, &wedge_gradients(sample), 1.0 / 6.0, positions);
                    }
                }
                Cell::Hexahedron(nodes) => {
                    for sample in 0..8 {
                        body.push(nodes, &hexahedron_gradients(sample), 1.0, positions);
                    }
                }
            }
        }
        body
    }

    /// Adds an integration point of a cell, from the gradients in the reference cell.
    fn push(&mut self, nodes: &[u32], reference: &[DVec3], weight: f64, positions: &[DVec3]) {
        // The map from the reference cell, whose inverse turns gradients into those in space.
        let mut jacobian = DMat3::ZERO;
        for (&node, gradient) in nodes.iter().zip(reference) {
            jacobian += outer(positions[node as usize], *gradient);
        }
        let to_space = jacobian.inverse().transpose();

        let first = self.terms.len();
        for (&node, gradient) in nodes.iter().zip(reference) {
            self.terms.push((node, to_space * *gradient));
        }
        let volume = weight * jacobian.determinant();
        self.points.push(IntegrationPoint { first, end: self.terms.len(), volume });
    }

    /// Computes the displacements of all nodes in equilibrium, where those with `is_given` keep
    /// theirs in `u`.
    pub(crate) fn equilibrium(
        &self,
        mut u: Vec<DVec3>,
        is_given: &[bool],
        progress: Progress<'_>,
    ) -> Result<Vec<DVec3>, Interrupted> {
        // Conjugate gradients on the free nodes, with the blocks of single nodes as preconditioner.
        let inverse_blocks = self.inverse_blocks(u.len());
        let mut residual = self.forces(&u, is_given);
        let mut direction = precondition(&residual, &inverse_blocks);
        let start = dot(&residual, &direction);
        let (mut square, mut done) = (start, 0.0_f64);
        let mut last = f64::INFINITY;

        for step in 0..max_steps(u.len()) {
            if square <= TOLERANCE * TOLERANCE * start {
                // Steps carry the residual along, and it drifts by rounding: it is computed anew,
                // and steps begin again while that helps.
                residual = self.forces(&u, is_given);
                direction = precondition(&residual, &inverse_blocks);
                square = dot(&residual, &direction);
                if square <= TOLERANCE * TOLERANCE * start || square >= last {
                    break;
                }
                last = square;
            }
            if step % POLLED_STEPS == 0 {
                // The residual falls by about the same factor per step, and rises at times.
                done = done.max((square / start).ln() / TOLERANCE.powi(2).ln());
                progress.report(done)?;
            }
            let along = self.forces(&direction, is_given);
            let curvature = -dot(&direction, &along);
            if curvature <= 0.0 {
                break;
            }

            // The minimum along the direction; the residual follows without another product.
            let length = square / curvature;
            add_scaled(&mut u, length, &direction);
            add_scaled(&mut residual, length, &along);

            // The next direction is conjugate to all earlier ones.
            let preconditioned = precondition(&residual, &inverse_blocks);
            let next = dot(&residual, &preconditioned);
            let turn = next / square;
            square = next;
            for (direction, along) in direction.iter_mut().zip(preconditioned) {
                *direction = along + turn * *direction;
            }
        }
        Ok(u)
    }

    /// Computes the elastic forces −∂E/∂u, 0 where displacements are given.
    fn forces(&self, u: &[DVec3], is_given: &[bool]) -> Vec<DVec3> {
        let mut forces = vec![DVec3::ZERO; u.len()];
        for point in &self.points {
            let terms = &self.terms[point.first..point.end];
            let mut gradient = DMat3::ZERO;
            for &(node, shape) in terms {
                gradient += outer(u[node as usize], shape);
            }

            // Stress 2 μ ε + λ tr ε, with μ = 1.
            let trace = gradient.x_axis.x + gradient.y_axis.y + gradient.z_axis.z;
            let pressure = DMat3::from_diagonal(DVec3::splat(self.lambda * trace));
            let stress = (gradient + gradient.transpose() + pressure) * point.volume;
            for &(node, shape) in terms {
                forces[node as usize] -= stress * shape;
            }
        }

        // Nodes with a given displacement feel no force: the solver leaves them.
        for (force, is_given) in forces.iter_mut().zip(is_given) {
            if *is_given {
                *force = DVec3::ZERO;
            }
        }
        forces
    }

    /// Inverts the stiffness of each node by itself; 0 for nodes without a cell.
    fn inverse_blocks(&self, node_count: usize) -> Vec<DMat3> {
        let mut blocks = vec![DMat3::ZERO; node_count];
        for point in &self.points {
            for &(node, shape) in &self.terms[point.first..point.end] {
                let along = DMat3::from_diagonal(DVec3::splat(shape.length_squared()));
                let across = (1.0 + self.lambda) * outer(shape, shape);
                blocks[node as usize] += point.volume * (along + across);
            }
        }
        // Nodes without a cell have no stiffness, and no force either.
        for block in &mut blocks {
            *block = if block.determinant() > 0.0 { block.inverse() } else { DMat3::ZERO };
        }
        blocks
    }
}

/// Gradients of a tetrahedron's shape functions in the reference cell.
const TETRAHEDRON: [DVec3; 4] = [DVec3::NEG_ONE, DVec3::X, DVec3::Y, DVec3::Z];

/// Signs of a hexahedron's nodes in the reference cell, a cube from −1 to 1.
const HEXAHEDRON: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Places of a wedge's nodes in the reference cell: a corner of its triangle, and the end, −1 or 1.
const WEDGE: [(usize, f64); 6] = [(0, -1.0), (1, -1.0), (2, -1.0), (0, 1.0), (1, 1.0), (2, 1.0)];

/// Gradients of a triangle's three barycentric coordinates in the reference cell.
const TRIANGLE: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

/// Computes the gradients of a wedge's shape functions at one of its 6 integration points: two thirds of
/// the way to a corner of the triangle, from the middle of the edge across, at a Gauss point along the axis.
fn wedge_gradients(sample: usize) -> [DVec3; 6] {
    let (nearest, sign) = WEDGE[sample];
    let height = sign / 3.0_f64.sqrt();
    WEDGE.map(|(corner, end)| {
        let weight = if corner == nearest { 2.0 / 3.0 } else { 1.0 / 6.0 };
        let along = 1.0 + height * end;
        let [x, y] = TRIANGLE[corner];
        DVec3::new(x * along, y * along, weight * end) / 2.0
    })
}

/// Computes the gradients of a hexahedron's shape functions at one of its 8 Gauss points.
fn hexahedron_gradients(sample: usize) -> [DVec3; 8] {
    let at = HEXAHEDRON[sample].map(|sign| sign / 3.0_f64.sqrt());
    HEXAHEDRON.map(|sign| {
        let [x, y, z] = std::array::from_fn(|axis| 1.0 + at[axis] * sign[axis]);
        DVec3::new(sign[0] * y * z, x * sign[1] * z, x * y * sign[2]) / 8.0
    })
}

/// Returns a number of steps that no mesh of fair quality needs.
fn max_steps(node_count: usize) -> usize {
    100 + 3 * node_count
}

fn precondition(residual: &[DVec3], inverse_blocks: &[DMat3]) -> Vec<DVec3> {
    residual.iter().zip(inverse_blocks).map(|(r, block)| *block * *r).collect()
}
