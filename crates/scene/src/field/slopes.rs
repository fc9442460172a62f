//! How steep a field is, block by block of its grid.
//!
//! Near one smooth side of a bone values change by one over a unit of length. Only
//! where nodes on the two sides of a thin part or of a fold are next to each other
//! do they jump by more, and one such place would make the bound for a whole field
//! useless.

use distance_field::FieldGrid;
use glam::DVec3;

/// Cells of a block along each axis.
const BLOCK: usize = 4;

/// Blocks that are looked at for one way; one through more is taken to be as steep as
/// the field is anywhere.
const MOST_BLOCKS: usize = 64;

/// Bounds on the gradient of a field, one a block.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    origin: DVec3,
    spacing: f64,
    blocks_per_unit: f64,
    dims: [usize; 3],
    /// Squares of the steepest rises over a spacing.
    squared: Vec<f32>,
    /// The slope of the steepest block.
    pub(super) anywhere: f64,
}

impl Slopes {
    /// Looks at every cell. A trilinear value's gradient is bounded along each axis by
    /// the steepest of the cell's four edges along it.
    pub(super) fn of(grid: &FieldGrid, values: &[f32]) -> Self {
        let [nx, ny, nz] = grid.dims();
        let dims = grid.dims().map(|n| (n - 1).div_ceil(BLOCK));
        let mut squared = vec![0.0_f32; dims.iter().product()];
        for k in 0..nz - 1 {
            for j in 0..ny - 1 {
                let row = |j: usize, k: usize| &values[nx * (j + ny * k)..][..nx];
                let rows = [row(j, k), row(j + 1, k), row(j, k + 1), row(j + 1, k + 1)];
                let blocks = &mut squared[dims[0] * (j / BLOCK + dims[1] * (k / BLOCK))..];
                for (block, steepest) in blocks[..dims[0]].iter_mut().enumerate() {
                    let cells = BLOCK * block..(BLOCK * (block + 1)).min(nx - 1);
                    let of_cells =
                        cells.map(|i| rise_squared(rows.map(|row| [row[i], row[i + 1]])));
                    *steepest = of_cells.fold(*steepest, f32::max);
                }
            }
        }
        let (origin, spacing) = (grid.origin(), grid.spacing());
        let blocks_per_unit = 1.0 / (count(BLOCK) * spacing);
        let anywhere = slope(squared.iter().copied().fold(0.0, f32::max), spacing);
        Self { origin, spacing, blocks_per_unit, dims, squared, anywhere }
    }

    /// Most that a value changes over a unit of length anywhere in the box of two
    /// points of the grid.
    pub(super) fn between(&self, [a, b]: [DVec3; 2]) -> f64 {
        let block = |p: DVec3, hair: f64| {
            let blocks = (p - self.origin) * self.blocks_per_unit + hair;
            std::array::from_fn(|axis| number(blocks[axis]).min(self.dims[axis] - 1))
        };
        // What is on the border of two blocks by rounding is of both.
        let [lo, hi]: [[usize; 3]; 2] = [block(a.min(b), -1e-9), block(a.max(b), 1e-9)];
        let size: [usize; 3] = std::array::from_fn(|axis| hi[axis] - lo[axis] + 1);
        if size.iter().product::<usize>() > MOST_BLOCKS {
            return self.anywhere;
        }
        let mut steepest = 0.0_f32;
        for k in lo[2]..=hi[2] {
            for j in lo[1]..=hi[1] {
                let row = self.dims[0] * (j + self.dims[1] * k);
                let blocks = &self.squared[row + lo[0]..=row + hi[0]];
                steepest = blocks.iter().copied().fold(steepest, f32::max);
            }
        }
        slope(steepest, self.spacing)
    }

    /// Bytes it holds.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.squared[..])
    }
}

/// The slope where the square of the rise over a spacing is this.
fn slope(squared: f32, spacing: f64) -> f64 {
    // The differences and their squares were rounded to 24 bits.
    f64::from(squared).sqrt() / spacing * (1.0 + 1e-6)
}

/// The largest whole number at or below `x`; 0 for what is below that.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn number(x: f64) -> usize {
    x as usize
}

/// The square of the most that a cell's values rise over a spacing, from its edges
/// along x.
fn rise_squared([a, b, c, d]: [[f32; 2]; 4]) -> f32 {
    let along = [a, b, c, d].map(|[from, to]| (to - from).abs());
    let between = |p: [f32; 2], q: [f32; 2]| (q[0] - p[0]).abs().max((q[1] - p[1]).abs());
    let x = along[0].max(along[1]).max(along[2].max(along[3]));
    let y = between(a, b).max(between(c, d));
    let z = between(a, c).max(between(b, d));
    x * x + y * y + z * z
}

#[expect(clippy::cast_precision_loss, reason = "no count here comes near 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}
