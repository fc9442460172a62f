//! Signed distance fields as volume files: NRRD for 3D Slicer and ITK, VTI for
//! `ParaView` and VTK.
//!
//! Both formats have one number per node, x running fastest, in the frame of the mesh
//! that the field was built from, so that viewers show the field over its mesh. The
//! numbers are 32-bit floats in the mesh's length unit or, of a field stored in steps,
//! 16-bit multiples of the step, whose length stands beside them. NRRD names the frame
//! left–posterior–superior, which is 3D Slicer's for mesh files that name none.
//!
//! A key says which kind of node values these are ([`NodeValues`]), since cubic
//! interpolation depends on it. Without the key they are distances at the nodes.
//!
//! The data are raw. A field that was read back has its grid and its values to the bit,
//! and no build report.

use std::path::Path;

use distance_field::{DistanceField, FieldGrid, NodeValues, Storage};

use crate::vtk::{encode_vti, parse_vti};
use crate::{FileError, ReadError, extension, nrrd};

/// File format of a distance field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FieldFormat {
    /// "Nearly raw raster data".
    Nrrd,
    /// VTK XML image data.
    Vti,
}

impl FieldFormat {
    /// Returns the format that the extension of a path stands for.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match extension(path).to_ascii_lowercase().as_str() {
            "nrrd" => Some(Self::Nrrd),
            "vti" => Some(Self::Vti),
            _ => None,
        }
    }

    /// Returns a field as a file.
    #[must_use]
    pub fn encode(self, field: &DistanceField) -> Vec<u8> {
        match self {
            Self::Nrrd => nrrd::encode(field),
            Self::Vti => encode_vti(field),
        }
    }

    /// Reads a field from the content of a file.
    ///
    /// # Errors
    ///
    /// The reason, where the content is not a distance field of this format.
    pub fn decode(self, bytes: &[u8]) -> Result<DistanceField, ReadError> {
        match self {
            Self::Nrrd => nrrd::decode(bytes),
            Self::Vti => parse_vti(bytes),
        }
    }
}

/// Reads a field from a file, in the format of its extension.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read or is not a field.
pub fn read_field(path: &Path) -> Result<DistanceField, FileError> {
    let unknown = ReadError::UnknownFormat { expected: ".nrrd or .vti" };
    let field = FieldFormat::of(path)
        .ok_or(unknown)
        .and_then(|format| format.decode(&std::fs::read(path)?));
    field.map_err(|reason| FileError { path: path.to_owned(), reason })
}

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
        match field.storage() {
            Storage::Float => Self::Distances(field.values()),
            Storage::Quantized { step } => {
                let steps = field.values().iter().map(|&value| whole_steps(value, step)).collect();
                Self::Steps { steps, step }
            }
        }
    }

    /// Returns the bytes that both formats store.
    pub(crate) fn little_endian(&self) -> Vec<u8> {
        match self {
            Self::Distances(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::Steps { steps, .. } => steps.iter().flat_map(|v| v.to_le_bytes()).collect(),
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
    dims.iter().fold(1, |count, &n| count.saturating_mul(n as u128))
}

/// Returns the one value of all three, compared to the bit.
pub(crate) fn common_value([x, y, z]: [f64; 3]) -> Option<f64> {
    (x.total_cmp(&y).is_eq() && x.total_cmp(&z).is_eq()).then_some(x)
}

#[expect(clippy::cast_possible_truncation, reason = "fields store 32-bit floats")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
