//! Values of nodes as they are kept: floats, 16-bit steps, or bricks of these.

use crate::grid::{Grid, check_positive};
use crate::num::{nearest, single};
use crate::{FieldError, Storage};

/// Cells along each side of a brick. Fewer leave out more of the grid, but keep
/// more nodes twice: a brick of 8 has 9 nodes a side, 1.4 times its share.
const BRICK: usize = 8;
const SIDE: usize = BRICK + 1;

/// The values of a grid's nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Store {
    Dense(Vec<f32>),
    Steps { step: f32, values: Vec<i16> },
    Bricks(Bricks),
}

/// Cells in bricks of 8³, each with all its nodes; bricks that hold nothing but
/// one and the same value are not kept.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bricks {
    step: f32,
    /// Bricks along x and y.
    columns: [usize; 2],
    /// For each brick, where its nodes start, or its only value.
    table: Vec<Place>,
    values: Vec<i16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    At(u32),
    All(i16),
}

/// Where values are read, one way for each store.
pub(crate) trait Nodes: Sync {
    /// The value of a node.
    fn node(&self, node: [usize; 3]) -> f32;

    /// The values at the corners of the cell whose lowest node is given, x
    /// running fastest.
    fn cell(&self, node: [usize; 3]) -> [f32; 8];
}

impl Store {
    /// Keeps `values` as `storage` says.
    pub(crate) fn new(values: Vec<f32>, grid: &Grid, storage: Storage) -> Result<Self, FieldError> {
        Ok(match storage {
            Storage::Dense => Self::Dense(values),
            Storage::Steps { step } => {
                let values = in_steps(&values, step)?;
                Self::Steps { step: single(step), values }
            }
            Storage::Bricks { step } => {
                let values = in_steps(&values, step)?;
                Self::Bricks(Bricks::new(&values, grid, single(step)))
            }
        })
    }

    /// Bytes that the values take.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Dense(values) => size_of_val(&values[..]),
            Self::Steps { values, .. } => size_of_val(&values[..]),
            Self::Bricks(bricks) => {
                size_of_val(&bricks.values[..]) + size_of_val(&bricks.table[..])
            }
        }
    }

    /// Most that storing may have changed a value.
    pub(crate) fn rounding(&self) -> f64 {
        match self {
            Self::Dense(_) => 0.0,
            Self::Steps { step, .. } => 0.5 * f64::from(*step),
            Self::Bricks(bricks) => 0.5 * f64::from(bricks.step),
        }
    }
}

fn in_steps(values: &[f32], step: f64) -> Result<Vec<i16>, FieldError> {
    check_positive("storage step", step)?;
    let needed = f64::from(values.iter().fold(0.0_f32, |most, value| most.max(value.abs())));
    let reach = step * f64::from(i16::MAX);
    if needed > reach {
        return Err(FieldError::StepTooSmall { step, reach, needed });
    }
    let rounded = |&value: &f32| {
        let steps = nearest(f64::from(value) / step);
        i16::try_from(steps).unwrap_or(if steps < 0 { -i16::MAX } else { i16::MAX })
    };
    Ok(values.iter().map(rounded).collect())
}

impl Bricks {
    fn new(values: &[i16], grid: &Grid, step: f32) -> Self {
        let [nx, ny, nz] = grid.dims();
        let [bx, by, bz] = [nx, ny, nz].map(|n| (n - 1).div_ceil(BRICK));
        let mut bricks = Self { step, columns: [bx, by], table: Vec::new(), values: Vec::new() };
        let mut nodes = [0; SIDE * SIDE * SIDE];
        for brick in 0..bx * by * bz {
            let first = [brick % bx, brick / bx % by, brick / (bx * by)].map(|b| b * BRICK);
            for (place, value) in nodes.iter_mut().enumerate() {
                let offset = [place % SIDE, place / SIDE % SIDE, place / (SIDE * SIDE)];
                // Beyond the grid the last node repeats; no cell reads it.
                let at = |axis: usize| (first[axis] + offset[axis]).min(grid.dims()[axis] - 1);
                *value = values[grid.index([at(0), at(1), at(2)])];
            }
            bricks.push(&nodes);
        }
        bricks
    }

    fn push(&mut self, nodes: &[i16]) {
        let place = match u32::try_from(self.values.len()) {
            _ if nodes.iter().all(|&value| value == nodes[0]) => Place::All(nodes[0]),
            Ok(start) => Place::At(start),
            // 2^32 values of bricks come from grids beyond any budget in bytes.
            Err(_) => Place::All(nodes[0]),
        };
        if matches!(place, Place::At(_)) {
            self.values.extend_from_slice(nodes);
        }
        self.table.push(place);
    }

    fn place(&self, brick: [usize; 3]) -> Place {
        let [bx, by] = self.columns;
        self.table[brick[0] + bx * (brick[1] + by * brick[2])]
    }
}

impl Nodes for Bricks {
    #[inline]
    fn node(&self, node: [usize; 3]) -> f32 {
        let rows = [
            self.columns[0],
            self.columns[1],
            self.table.len() / (self.columns[0] * self.columns[1]),
        ];
        let brick = [0, 1, 2].map(|axis| (node[axis] / BRICK).min(rows[axis] - 1));
        let [x, y, z] = [0, 1, 2].map(|axis| node[axis] - brick[axis] * BRICK);
        let steps = match self.place(brick) {
            Place::All(value) => value,
            Place::At(start) => self.values[start as usize + x + SIDE * (y + SIDE * z)],
        };
        f32::from(steps) * self.step
    }

    #[inline]
    fn cell(&self, [i, j, k]: [usize; 3]) -> [f32; 8] {
        let start = match self.place([i / BRICK, j / BRICK, k / BRICK]) {
            Place::All(value) => return [f32::from(value) * self.step; 8],
            Place::At(start) => start as usize,
        };
        let first = start + i % BRICK + SIDE * (j % BRICK + SIDE * (k % BRICK));
        corners(&self.values, first, [SIDE, SIDE * SIDE]).map(|v| f32::from(v) * self.step)
    }
}

/// All nodes in one list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole<'a, T> {
    pub(crate) values: &'a [T],
    /// Nodes from one row, and from one plane, to the next.
    pub(crate) strides: [usize; 2],
}

impl<'a, T> Whole<'a, T> {
    pub(crate) fn new(values: &'a [T], grid: &Grid) -> Self {
        let [nx, ny, _] = grid.dims();
        Self { values, strides: [nx, nx * ny] }
    }

    #[inline]
    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.strides[0] * j + self.strides[1] * k
    }
}

impl Nodes for Whole<'_, f32> {
    #[inline]
    fn node(&self, node: [usize; 3]) -> f32 {
        self.values[self.index(node)]
    }

    #[inline]
    fn cell(&self, node: [usize; 3]) -> [f32; 8] {
        corners(self.values, self.index(node), self.strides)
    }
}

/// All nodes in steps, and the step.
pub(crate) struct Stepped<'a>(pub(crate) Whole<'a, i16>, pub(crate) f32);

impl Nodes for Stepped<'_> {
    #[inline]
    fn node(&self, node: [usize; 3]) -> f32 {
        f32::from(self.0.values[self.0.index(node)]) * self.1
    }

    #[inline]
    fn cell(&self, node: [usize; 3]) -> [f32; 8] {
        corners(self.0.values, self.0.index(node), self.0.strides).map(|v| f32::from(v) * self.1)
    }
}

#[inline]
fn corners<T: Copy>(values: &[T], first: usize, [row, plane]: [usize; 2]) -> [T; 8] {
    // Checks the whole span once.
    let values = &values[first..first + row + plane + 2];
    let (low, high) = (&values[..row + 2], &values[plane..]);
    [low[0], low[1], low[row], low[row + 1], high[0], high[1], high[row], high[row + 1]]
}
