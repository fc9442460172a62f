//! Node values in memory, as floats or as 16-bit steps.

use glam::DVec3;

use crate::error::check_positive;
use crate::num::{coordinate, nearest, single, whole_index};
use crate::{FieldError, FieldGrid, Storage};

/// Values of a grid's nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NodeStore {
    Floats(NodeArray<f32>),
    Steps(NodeArray<i16>),
}

/// Node values as multiples of a step, x running fastest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NodeArray<T> {
    values: Vec<T>,
    /// Length of a step; 1 for floats.
    step: f64,
    /// Distance in memory of neighbors along y and along z.
    strides: [usize; 2],
    /// Strides of all axes, as coordinates.
    weights: DVec3,
}

/// Values at the corners of a cell: the four at the lower z, x running fastest, and the
/// four above them.
pub(crate) type Corners<T> = [[T; 4]; 2];

/// Values of 4³ nodes, z outermost.
pub(crate) type Block = [[[f64; 4]; 4]; 4];

impl NodeStore {
    /// Stores values in the given format.
    pub(crate) fn new(
        values: Vec<f32>,
        grid: &FieldGrid,
        storage: Storage,
    ) -> Result<Self, FieldError> {
        Ok(match storage {
            Storage::Float => Self::Floats(NodeArray::new(values, 1.0, grid)),
            Storage::Quantized { step } => {
                Self::Steps(NodeArray::new(quantize(&values, step)?, step, grid))
            }
        })
    }

    /// Returns the format.
    pub(crate) fn storage(&self) -> Storage {
        match self {
            Self::Floats(_) => Storage::Float,
            Self::Steps(nodes) => Storage::Quantized { step: nodes.step },
        }
    }

    /// Returns the memory of the values, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Floats(nodes) => size_of_val(&nodes.values[..]),
            Self::Steps(nodes) => size_of_val(&nodes.values[..]),
        }
    }

    /// Returns the value of a node, in the length unit.
    pub(crate) fn node(&self, node: [usize; 3]) -> f64 {
        match self {
            Self::Floats(nodes) => nodes.node(node).into(),
            Self::Steps(nodes) => nodes.step * f64::from(nodes.node(node)),
        }
    }

    /// Returns all values, in the length unit.
    pub(crate) fn to_floats(&self) -> Vec<f32> {
        match self {
            Self::Floats(nodes) => nodes.values.clone(),
            Self::Steps(NodeArray { values, step, .. }) => {
                values.iter().map(|&value| single(step * f64::from(value))).collect()
            }
        }
    }
}

/// Rounds values to whole steps.
fn quantize(values: &[f32], step: f64) -> Result<Vec<i16>, FieldError> {
    check_positive("storage step", step)?;
    let needed = f64::from(values.iter().fold(0.0_f32, |max, value| max.max(value.abs())));
    let range = step * f64::from(i16::MAX);
    // Rounded, since the largest value may be a rounded multiple of the step itself.
    if nearest(needed / step) > i64::from(i16::MAX) {
        return Err(FieldError::StepTooSmall { step, range, needed });
    }

    let mut steps = Vec::with_capacity(values.len());
    for &value in values {
        let rounded = nearest(f64::from(value) / step);
        let limit = if rounded < 0 { -i16::MAX } else { i16::MAX };
        steps.push(i16::try_from(rounded).unwrap_or(limit));
    }
    Ok(steps)
}

impl<T: Copy + Into<f64>> NodeArray<T> {
    fn new(values: Vec<T>, step: f64, grid: &FieldGrid) -> Self {
        let [nx, ny, _] = grid.dims();
        let strides = [nx, nx * ny];
        let weights = DVec3::new(1.0, coordinate(nx), coordinate(nx * ny));
        Self { values, step, strides, weights }
    }

    /// Returns the length of a step.
    #[inline]
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Returns the value of a node.
    #[inline]
    pub(crate) fn node(&self, node: [usize; 3]) -> T {
        self.values[self.index(node)]
    }

    /// Returns the values at the corners of the cell with the given lowest node.
    #[inline]
    pub(crate) fn corners(&self, cell: DVec3) -> Corners<T> {
        // Exact: these are whole numbers.
        corners(&self.values, whole_index(self.weights.dot(cell)), self.strides)
    }

    /// Returns the values at the corners of a cell, in the length unit.
    #[inline]
    pub(crate) fn corner_lengths(&self, cell: DVec3) -> Corners<f64> {
        let mut lengths = [[0.0; 4]; 2];
        for (lengths, values) in lengths.iter_mut().zip(self.corners(cell)) {
            for (length, value) in lengths.iter_mut().zip(values) {
                *length = self.step * value.into();
            }
        }
        lengths
    }

    /// Returns the values of 4³ nodes from the lowest one on.
    #[inline]
    pub(crate) fn block(&self, lowest: [usize; 3]) -> Block {
        let [along_y, along_z] = self.strides;
        let values = &self.values[self.index(lowest)..];
        let mut block = [[[0.0; 4]; 4]; 4];
        for (c, plane) in block.iter_mut().enumerate() {
            for (b, row) in plane.iter_mut().enumerate() {
                let nodes = &values[along_y * b + along_z * c..][..4];
                *row = [nodes[0].into(), nodes[1].into(), nodes[2].into(), nodes[3].into()];
            }
        }
        block
    }

    #[inline]
    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.strides[0] * j + self.strides[1] * k
    }
}

/// Returns the values at the corners of the cell whose lowest node has index `first`.
///
/// Always inlined: a call returns the values through memory, for as many instructions again
/// as the loads.
#[inline(always)]
pub(crate) fn corners<T: Copy>(values: &[T], first: usize, [row, plane]: [usize; 2]) -> Corners<T> {
    // One bounds check for the whole span.
    let values = &values[first..first + row + plane + 2];
    let (low, high) = (&values[..row + 2], &values[plane..]);
    [[low[0], low[1], low[row], low[row + 1]], [high[0], high[1], high[row], high[row + 1]]]
}
