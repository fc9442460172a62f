//! Distance fields as volume files, out and in: NRRD for 3D Slicer and ITK, VTI
//! for `ParaView` and VTK.
//!
//! Both hold one number a node, x running fastest, in the frame of the mesh that
//! the field was built from, so that a viewer shows the field over its mesh: a
//! 32-bit float in the mesh's length unit, or, of a field that is kept in steps, the
//! 16-bit number of these, and beside them the length of one. NRRD names that frame
//! left–posterior–superior, which is how 3D Slicer takes mesh files that name none.
//!
//! Beside the numbers stands what they are right for, on which cubic interpolation
//! rests: the nodes themselves, or all that lies between them ([`NodeValues`]). Of a
//! file that does not say, they are taken to be distances at nodes.
//!
//! The data are raw. Nothing else of a field is kept: what is read back has its
//! grid and its values to the bit, and no build report.

mod error;
mod nrrd;
#[cfg(test)]
mod tests;
mod vti;

use std::path::Path;

use glam::DVec3;
use musculo_collide::distance_field::{DistanceField, FieldGrid, NodeValues, Storage};

pub(crate) use self::error::VolumeError;

/// The formats, known by their extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VolumeFormat {
    Nrrd,
    Vti,
}

impl VolumeFormat {
    /// What a path's extension stands for, if it is one of a volume.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "nrrd" => Some(Self::Nrrd),
            "vti" => Some(Self::Vti),
            _ => None,
        }
    }

    /// A field as a file.
    pub(crate) fn encode(self, field: &DistanceField) -> Vec<u8> {
        match self {
            Self::Nrrd => nrrd::encode(field),
            Self::Vti => vti::encode(field),
        }
    }

    /// A file as a field.
    pub(crate) fn decode(self, bytes: &[u8]) -> Result<DistanceField, VolumeError> {
        match self {
            Self::Nrrd => nrrd::decode(bytes),
            Self::Vti => vti::decode(bytes),
        }
    }

    pub(crate) fn read(self, path: &Path) -> Result<DistanceField, VolumeError> {
        let bytes = std::fs::read(path).map_err(|e| VolumeError::Unreadable(e.to_string()))?;
        self.decode(&bytes)
    }
}

/// The nodes of a field as a file holds them.
enum Values {
    /// Distances.
    Floats(Vec<f32>),
    /// Whole steps, and the length of one.
    Steps(Vec<i16>, f64),
}

impl Values {
    fn of(field: &DistanceField) -> Self {
        match field.storage() {
            Storage::Float => Self::Floats(field.values()),
            Storage::Quantized { step } => {
                let steps = field.values().iter().map(|&value| whole_steps(value, step)).collect();
                Self::Steps(steps, step)
            }
        }
    }

    /// As both formats hold them, the least byte of each number first.
    fn little_endian(&self) -> Vec<u8> {
        match self {
            Self::Floats(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::Steps(values, _) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a value kept in steps is at most 32767 of them"
)]
fn whole_steps(value: f32, step: f64) -> i16 {
    (f64::from(value) / step).round() as i16
}

/// A field of what a file says.
fn field(
    (origin, spacing, dims): (DVec3, f64, [usize; 3]),
    values: Values,
    nodes: NodeValues,
) -> Result<DistanceField, VolumeError> {
    let grid = FieldGrid::new(origin, spacing, dims)?;
    let (values, storage) = match values {
        Values::Floats(values) => (values, Storage::Float),
        Values::Steps(values, step) => {
            let lengths = values.iter().map(|&steps| single(step * f64::from(steps))).collect();
            (lengths, Storage::Quantized { step })
        }
    };
    Ok(DistanceField::from_values(grid, values, storage)?.with_node_values(nodes))
}

/// How many values a grid has, unless no memory could hold them.
fn count(dims: [usize; 3]) -> Option<usize> {
    dims.iter().try_fold(1_usize, |count, &n| count.checked_mul(n))
}

#[expect(clippy::cast_possible_truncation, reason = "a field keeps 32-bit floats")]
fn single(value: f64) -> f32 {
    value as f32
}
