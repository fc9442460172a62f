//! Signed distance fields as volume files: NRRD for 3D Slicer and ITK, VTI for
//! `ParaView` and VTK.
//!
//! Both formats have one number per node, x running fastest, in the frame of the mesh
//! that the field was built from, so that viewers show the field over its mesh. The
//! numbers are 32-bit floats in the mesh's length unit or, of a field stored in steps,
//! 16-bit multiples of the step, whose length stands beside them. NRRD names the frame
//! left–posterior–superior, which is 3D Slicer's for mesh files that name none.
//!
//! A key has the kind of the node values ([`NodeValues`](distance_field::NodeValues)), on
//! which cubic interpolation depends. Without the key they are distances at the nodes.
//!
//! The data are raw or, in NRRD and by choice, compressed by gzip, as 3D Slicer writes
//! them by default. A field that was read back has its grid and its values to the bit,
//! and no build report.

use std::path::Path;

use distance_field::DistanceField;

use crate::nrrd::Encoding;
use crate::vtk::{encode_vti, parse_vti};
use crate::{ReadError, extension, nrrd};

/// File format of a distance field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FieldFormat {
    /// "Nearly raw raster data", uncompressed.
    Nrrd,
    /// The same with its data compressed by gzip.
    GzipNrrd,
    /// VTK XML image data.
    Vti,
}

impl FieldFormat {
    /// Returns the uncompressed format that the extension of a path stands for.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match extension(path).to_ascii_lowercase().as_str() {
            "nrrd" => Some(Self::Nrrd),
            "vti" => Some(Self::Vti),
            _ => None,
        }
    }

    /// Returns the compressed form of the format, if it has one.
    #[must_use]
    pub fn compressed(self) -> Option<Self> {
        match self {
            Self::Nrrd | Self::GzipNrrd => Some(Self::GzipNrrd),
            Self::Vti => None,
        }
    }

    /// Returns a field as a file.
    #[must_use]
    pub fn encode(self, field: &DistanceField) -> Vec<u8> {
        match self {
            Self::Nrrd => nrrd::encode(field, Encoding::Raw),
            Self::GzipNrrd => nrrd::encode(field, Encoding::Gzip),
            Self::Vti => encode_vti(field),
        }
    }

    /// Reads a field from the content of a file. The data of an NRRD file may be raw or
    /// compressed, and decompress to no more than its grid needs.
    ///
    /// # Errors
    ///
    /// The reason, where the content is not a distance field of this format.
    pub fn decode(self, bytes: &[u8]) -> Result<DistanceField, ReadError> {
        match self {
            Self::Nrrd | Self::GzipNrrd => nrrd::decode(bytes),
            Self::Vti => parse_vti(bytes),
        }
    }
}
