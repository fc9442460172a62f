//! Readers and writers of triangle meshes and of signed distance fields.
//!
//! | format | content | read | written |
//! |---|---|---|---|
//! | PLY | mesh, ASCII or binary | yes | [`write_ply`] |
//! | OBJ | mesh | yes | |
//! | STL | mesh, ASCII or binary | yes | |
//! | VTP | mesh, every encoding of VTK | yes | [`write_vtp`], with values per vertex |
//! | NRRD | distance field | yes | [`FieldFormat::encode`] |
//! | VTI | distance field, every encoding of VTK | yes | [`FieldFormat::encode`] |
//!
//! Formats are recognized by content first, and by extension where content is
//! ambiguous. Vertices and faces keep the order of the file, so that an index in a
//! report can be found in the file. Nothing is repaired: any list of faces with valid
//! indices is a mesh, whatever its defects. Every refusal names the place in the file
//! and, from [`read_mesh`] and [`read_field`], the file.
//!
//! ```
//! let file = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n";
//! let error = mesh_io::parse_mesh(file, "obj").unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "face 0 refers to vertex 3, but there are 3 vertices (counted from 0)"
//! );
//! ```

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod error;
mod field;
mod mesh;
mod nrrd;
mod obj;
mod ply;
mod stl;
mod stored_values;
mod text;
mod vtk;

use std::path::Path;

pub use glam;

pub use self::error::{FileError, FilePlace, ReadError};
pub use self::field::{FieldFormat, read_field};
pub use self::mesh::Mesh;
pub use self::ply::write_ply;
pub use self::vtk::{PointValues, write_vtp};

/// Reads a mesh file.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read or is not a mesh.
pub fn read_mesh(path: &Path) -> Result<Mesh, FileError> {
    let read = || parse_mesh(&std::fs::read(path)?, &extension(path));
    read().map_err(|reason| FileError { path: path.to_owned(), reason })
}

/// Format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MeshFormat {
    Obj,
    Ply,
    Stl,
    Vtp,
}

/// Reads the content of a mesh file, whose name would end in `extension`.
///
/// # Errors
///
/// The reason, where the content is not a mesh.
pub fn parse_mesh(bytes: &[u8], extension: &str) -> Result<Mesh, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    match recognize(bytes, extension) {
        Some(MeshFormat::Obj) => obj::parse(bytes),
        Some(MeshFormat::Ply) => ply::parse(bytes),
        Some(MeshFormat::Stl) => stl::parse(bytes),
        Some(MeshFormat::Vtp) => vtk::parse_vtp(bytes),
        None => Err(ReadError::UnknownFormat { expected: "PLY, OBJ, STL or VTP" }),
    }
}

/// Maximum distance of a VTK file's opening tag from its start, behind an XML
/// declaration and comments.
const VTK_TAG_WITHIN: usize = 1024;

/// Returns the format by the content, or else by the extension.
fn recognize(bytes: &[u8], extension: &str) -> Option<MeshFormat> {
    let head = &bytes[..bytes.len().min(VTK_TAG_WITHIN)];
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return Some(MeshFormat::Ply);
    }
    if head.windows(8).any(|window| window == b"<VTKFile") {
        return Some(MeshFormat::Vtp);
    }
    match extension.to_ascii_lowercase().as_str() {
        "obj" => Some(MeshFormat::Obj),
        "ply" => Some(MeshFormat::Ply),
        "stl" => Some(MeshFormat::Stl),
        "vtp" => Some(MeshFormat::Vtp),
        _ => stl::is_likely(bytes).then_some(MeshFormat::Stl),
    }
}

/// Returns the extension of a path, empty where there is none.
fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().into_owned()
}
