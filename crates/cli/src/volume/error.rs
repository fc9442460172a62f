//! Why a file is not a distance field, and where in it.

use musculo_collide::distance_field::FieldError;

use crate::read::MeshError;

/// What is wrong with a volume file. The path is the caller's to name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum VolumeError {
    /// The operating system could not hand over the file.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// The text or bytes do not follow the format.
    #[error("{format} file: {place}: {problem}")]
    Malformed { format: &'static str, place: String, problem: String },
    /// The format allows it, a distance field or this program does not.
    #[error("{format} file: {feature} cannot be read as a distance field; {advice}")]
    Unsupported { format: &'static str, feature: String, advice: &'static str },
    /// The file holds more or fewer values than its grid has nodes.
    #[error("{format} file: a grid of {dims} nodes needs {expected} bytes of data, but {found} {are} there", dims = dims.map(|n| n.to_string()).join(" x "), are = if *found == 1 { "is" } else { "are" })]
    Size { format: &'static str, dims: [usize; 3], expected: u128, found: usize },
    /// Its grid or its values are not those of a field.
    #[error(transparent)]
    Field(#[from] FieldError),
}

impl From<MeshError> for VolumeError {
    /// Of what mesh and volume files of VTK have in common.
    fn from(error: MeshError) -> Self {
        let format = "VTI";
        match error {
            MeshError::Malformed { place, problem, .. } => {
                Self::Malformed { format, place, problem }
            }
            MeshError::Unsupported { feature, .. } => {
                let advice = "save it as image data, uncompressed or compressed by zlib";
                Self::Unsupported { format, feature, advice }
            }
            other => {
                Self::Malformed { format, place: "file".to_owned(), problem: other.to_string() }
            }
        }
    }
}
