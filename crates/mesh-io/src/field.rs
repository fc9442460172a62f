//! Signed distance fields as volume files: NRRD for 3D Slicer and ITK, VTI for
//! `ParaView` and VTK.
//!
//! Both formats have one number per node, x running fastest, in the frame of the mesh
//! that the field was built from, so that viewers show the field over its mesh. The
//! numbers are 32-bit floats in the mesh's length unit or, of a field stored in steps,
//! 16-bit multiples of the step, whose length stands beside them. NRRD names the frame
//! left–posterior–superior, which is 3D Slicer's for mesh files that name none.
//!
//! A key says which kind of node values these are ([`NodeValues`](distance_field::NodeValues)), since cubic
//! interpolation depends on it. Without the key they are distances at the nodes.
//!
//! The data are raw. A field that was read back has its grid and its values to the bit,
//! and no build report.

use std::path::Path;

use distance_field::DistanceField;

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
    let read = || match FieldFormat::of(path) {
        Some(format) => format.decode(&std::fs::read(path)?),
        None => Err(ReadError::UnknownFormat { expected: ".nrrd or .vti" }),
    };
    read().map_err(|reason| FileError { path: path.to_owned(), reason })
}
