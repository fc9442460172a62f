//! Node values of a distance field as files store them.

use distance_field::{DistanceField, FieldGrid, NodeValues, Storage};

use crate::ReadError;

/// Node values as a file stores them.
#[derive(Debug)]
pub(crate) enum StoredValues {
    Distances(Vec<f32>),
    /// Multiples of a step.
    Steps {
        steps: Vec<i16>,
        step: f64,
    },
}

impl StoredValues {
    pub(crate) fn of(field: &DistanceField) -> Self {
        let values = field.values();
        match field.storage() {
            Storage::Float => Self::Distances(values),
            Storage::Quantized { step } => {
                // Rounding undoes that of the values to single precision.
                let steps = values.iter().map(|&value| whole_steps(value, step)).collect();
                Self::Steps { steps, step }
            }
        }
    }

    /// Returns the bytes that both formats store.
    pub(crate) fn little_endian(&self) -> Vec<u8> {
        match self {
            Self::Distances(values) => values.iter().copied().flat_map(f32::to_le_bytes).collect(),
            Self::Steps { steps, .. } => steps.iter().copied().flat_map(i16::to_le_bytes).collect(),
        }
    }

    pub(crate) fn into_field(
        self,
        grid: FieldGrid,
        nodes: NodeValues,
    ) -> Result<DistanceField, ReadError> {
        let (values, storage) = match self {
            Self::Distances(values) => (values, Storage::Float),
            Self::Steps { steps, step } => {
                let lengths = steps.iter().map(|&steps| single(step * f64::from(steps)));
                (lengths.collect(), Storage::Quantized { step })
            }
        };
        Ok(DistanceField::from_values(grid, values, storage)?.with_node_values(nodes))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a value stored in steps is at most 32767 of them"
)]
fn whole_steps(value: f32, step: f64) -> i16 {
    (f64::from(value) / step).round() as i16
}

/// Returns the number of nodes of a grid, which may exceed any memory.
pub(crate) fn node_count(dims: [usize; 3]) -> u128 {
    let [nx, ny, nz] = dims.map(|n| n as u128);
    nx.saturating_mul(ny).saturating_mul(nz)
}

/// Returns the one value of all three, compared to the bit.
pub(crate) fn common_value([x, y, z]: [f64; 3]) -> Option<f64> {
    (x.total_cmp(&y).is_eq() && x.total_cmp(&z).is_eq()).then_some(x)
}

#[expect(clippy::cast_possible_truncation, reason = "fields store 32-bit floats")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
