//! Values of nodes as they are kept: floats, 16-bit steps, or bricks of these.

use glam::DVec3;

use crate::grid::{FieldGrid, check_positive};
use crate::num::{coordinate, nearest, whole_index};
use crate::{FieldError, Storage};

/// The values of a grid's nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Store {
    Floats(Whole<f32>),
    Steps(Whole<i16>),
}

/// Where values are read, one way for each store; all in steps.
pub(crate) trait Nodes: Sync {
    /// What is kept for a node.
    type Value: Copy + Default + Into<f64>;

    /// Length of a step.
    fn step(&self) -> f64;

    /// The value of a node.
    fn node(&self, node: [usize; 3]) -> Self::Value;

    /// The values at the corners of the cell whose lowest node is given, x
    /// running fastest: at the lower z, and above.
    fn cell(&self, cell: DVec3) -> [[Self::Value; 4]; 2];

    /// The values of four nodes along x.
    fn four(&self, [i, j, k]: [usize; 3]) -> [Self::Value; 4] {
        std::array::from_fn(|a| self.node([i + a, j, k]))
    }
}

impl Store {
    /// Keeps `values` as `storage` says.
    pub(crate) fn new(
        values: Vec<f32>,
        grid: &FieldGrid,
        storage: Storage,
    ) -> Result<Self, FieldError> {
        Ok(match storage {
            Storage::Float => Self::Floats(Whole::new(values, 1.0, grid)),
            Storage::Quantized { step } => {
                Self::Steps(Whole::new(in_steps(&values, step)?, step, grid))
            }
        })
    }

    /// What the values are kept as.
    pub(crate) fn storage(&self) -> Storage {
        match self {
            Self::Floats(_) => Storage::Float,
            Self::Steps(nodes) => Storage::Quantized { step: nodes.step() },
        }
    }

    /// Bytes that the values take.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Floats(nodes) => size_of_val(&nodes.values[..]),
            Self::Steps(nodes) => size_of_val(&nodes.values[..]),
        }
    }

    /// Most that storing may have changed a value.
    pub(crate) fn rounding(&self) -> f64 {
        match self {
            Self::Floats(_) => 0.0,
            Self::Steps(nodes) => 0.5 * nodes.step(),
        }
    }

    /// Value of a node, in the length unit.
    pub(crate) fn node(&self, node: [usize; 3]) -> f64 {
        match self {
            Self::Floats(nodes) => nodes.node(node).into(),
            Self::Steps(nodes) => nodes.step() * f64::from(nodes.node(node)),
        }
    }
}

fn in_steps(values: &[f32], step: f64) -> Result<Vec<i16>, FieldError> {
    check_positive("storage step", step)?;
    let needed = f64::from(values.iter().fold(0.0_f32, |most, value| most.max(value.abs())));
    let reach = step * f64::from(i16::MAX);
    // Rounded, since the largest that is stored may have been so as a float.
    if nearest(needed / step) > i64::from(i16::MAX) {
        return Err(FieldError::StepTooSmall { step, reach, needed });
    }
    let rounded = |&value: &f32| {
        let steps = nearest(f64::from(value) / step);
        i16::try_from(steps).unwrap_or(if steps < 0 { -i16::MAX } else { i16::MAX })
    };
    Ok(values.iter().map(rounded).collect())
}

/// All nodes in one list.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Whole<T> {
    pub(crate) values: Vec<T>,
    step: f64,
    /// Nodes from one row, and from one plane, to the next; also as coordinates.
    strides: [usize; 2],
    weights: DVec3,
}

impl<T> Whole<T> {
    pub(crate) fn new(values: Vec<T>, step: f64, grid: &FieldGrid) -> Self {
        let [nx, ny, _] = grid.dims();
        let strides = [nx, nx * ny];
        let weights = DVec3::new(1.0, coordinate(nx), coordinate(nx * ny));
        Self { values, step, strides, weights }
    }

    #[inline]
    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.strides[0] * j + self.strides[1] * k
    }
}

impl<T: Copy + Default + Into<f64> + Sync> Nodes for Whole<T> {
    type Value = T;

    #[inline]
    fn step(&self) -> f64 {
        self.step
    }

    #[inline]
    fn node(&self, node: [usize; 3]) -> T {
        self.values[self.index(node)]
    }

    #[inline]
    fn cell(&self, cell: DVec3) -> [[T; 4]; 2] {
        // Exact: these are whole numbers.
        corners(&self.values, whole_index(self.weights.dot(cell)), self.strides)
    }

    #[inline]
    fn four(&self, node: [usize; 3]) -> [T; 4] {
        let first = self.index(node);
        let row = &self.values[first..first + 4];
        [row[0], row[1], row[2], row[3]]
    }
}

/// The corners of the cell that begins with value `first`: those at the lower z,
/// and those above.
#[inline]
pub(crate) fn corners<T: Copy>(
    values: &[T],
    first: usize,
    [row, plane]: [usize; 2],
) -> [[T; 4]; 2] {
    // Checks the whole span once.
    let values = &values[first..first + row + plane + 2];
    let (low, high) = (&values[..row + 2], &values[plane..]);
    [[low[0], low[1], low[row], low[row + 1]], [high[0], high[1], high[row], high[row + 1]]]
}
