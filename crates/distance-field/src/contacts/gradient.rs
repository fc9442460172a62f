//! Bounds on the gradient of a field, per block of cells.
//!
//! Near one smooth side of a body, values change by one per unit of length. They change by
//! more only where nodes on the two sides of a thin part or of a fold are neighbors, and one
//! such place would make a bound for the whole field useless.

use glam::DVec3;
use surface::Aabb;

use crate::FieldGrid;
use crate::num::{coordinate, floor_index, single};

/// Cells along each side of a block.
const BLOCK: usize = 4;

/// Maximum number of blocks that are visited for one box; a larger box takes the bound of
/// the whole field.
const MAX_BLOCKS: usize = 64;

/// Relative widening of a bound: differences, their slopes and the squares of these were rounded to
/// 24 bits.
const ROUNDING: f64 = 1e-6;

/// Widening of a squared slope: squares below it underflow.
const UNDERFLOW: f64 = f32::MIN_POSITIVE as f64;

/// Widening of a box, in blocks: a point on the border of two blocks belongs to both.
const BORDER: f64 = 1e-9;

/// Upper bounds on the gradient of a trilinear field, per block of cells.
#[derive(Clone, Debug)]
pub(super) struct GradientBounds {
    origin: DVec3,
    /// Blocks per unit of length.
    density: f64,
    /// Blocks along each axis.
    dims: [usize; 3],
    /// Squares of the largest slopes.
    squared: Vec<f32>,
    /// Bound over all blocks.
    max: f64,
}

impl GradientBounds {
    /// Computes the bounds in one pass over the cells.
    pub(super) fn new(grid: &FieldGrid, values: &[f32]) -> Self {
        let [nx, ny, nz] = grid.dims();
        let dims = grid.dims().map(|n| (n - 1).div_ceil(BLOCK));
        let mut squared = vec![0.0_f32; dims.iter().product()];
        let per_spacing = single(grid.spacing().recip());

        // Row by row of cells, between four rows of nodes; the cells of a block are consecutive,
        // so that its bound stays in a register.
        for k in 0..nz - 1 {
            for j in 0..ny - 1 {
                let row = |j: usize, k: usize| &values[nx * (j + ny * k)..][..nx];
                let rows = [row(j, k), row(j + 1, k), row(j, k + 1), row(j + 1, k + 1)];
                let first = dims[0] * (j / BLOCK + dims[1] * (k / BLOCK));
                for (block, max) in squared[first..first + dims[0]].iter_mut().enumerate() {
                    for i in BLOCK * block..(BLOCK * (block + 1)).min(nx - 1) {
                        let edges = rows.map(|row| [row[i], row[i + 1]]);
                        *max = max.max(squared_slope(edges, per_spacing));
                    }
                }
            }
        }

        let (origin, spacing) = (grid.origin(), grid.spacing());
        let density = 1.0 / (coordinate(BLOCK) * spacing);
        let max = gradient(squared.iter().copied().fold(0.0, f32::max));
        Self { origin, density, dims, squared, max }
    }

    /// Returns the bound over the whole field.
    pub(super) fn max(&self) -> f64 {
        self.max
    }

    /// Returns a bound over a box within the grid.
    pub(super) fn max_in(&self, region: Aabb) -> f64 {
        let min = self.block(region.min, -BORDER);
        let max = self.block(region.max, BORDER);
        let count = (max[0] - min[0] + 1) * (max[1] - min[1] + 1) * (max[2] - min[2] + 1);
        if count > MAX_BLOCKS {
            return self.max;
        }

        let mut squared = 0.0_f32;
        for k in min[2]..=max[2] {
            for j in min[1]..=max[1] {
                let row = self.dims[0] * (j + self.dims[1] * k);
                let blocks = &self.squared[row + min[0]..=row + max[0]];
                squared = blocks.iter().copied().fold(squared, f32::max);
            }
        }
        gradient(squared)
    }

    /// Returns the block that contains a point moved by `shift` blocks.
    fn block(&self, p: DVec3, shift: f64) -> [usize; 3] {
        let blocks = (p - self.origin) * self.density + shift;
        let [nx, ny, nz] = self.dims;
        [
            floor_index(blocks.x).min(nx - 1),
            floor_index(blocks.y).min(ny - 1),
            floor_index(blocks.z).min(nz - 1),
        ]
    }

    /// Returns the memory of the bounds, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.squared[..])
    }
}

/// Returns a bound on the gradient, for a bound on its square.
fn gradient(squared: f32) -> f64 {
    (f64::from(squared) + UNDERFLOW).sqrt() * (1.0 + ROUNDING)
}

/// Returns a bound on the squared gradient of a cell's values, up to rounding.
///
/// A trilinear gradient is bounded along each axis by the largest slope of the four edges
/// along it. The edges along x are given, y running fastest. Slopes are squared, not rises, whose
/// squares underflow in small units.
fn squared_slope([a, b, c, d]: [[f32; 2]; 4], per_spacing: f32) -> f32 {
    let along = [a, b, c, d].map(|[from, to]| (to - from).abs());
    let x = along[0].max(along[1]).max(along[2].max(along[3])) * per_spacing;
    let y = max_rise(a, b).max(max_rise(c, d)) * per_spacing;
    let z = max_rise(a, c).max(max_rise(b, d)) * per_spacing;
    x * x + y * y + z * z
}

/// Returns the larger rise of the two edges between two parallel ones.
#[inline]
fn max_rise(p: [f32; 2], q: [f32; 2]) -> f32 {
    (q[0] - p[0]).abs().max((q[1] - p[1]).abs())
}
