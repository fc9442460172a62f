//! Mesh files in: PLY, OBJ, STL and VTP, recognised by content first and by
//! extension where content does not tell.
//!
//! Vertices and faces keep the order of the file, so that a place named in a
//! report is found again in it. Nothing is repaired: what can be read and
//! points at existing vertices is a mesh, whatever its defects.

mod error;
mod mesh;
mod obj;
mod ply;
mod stl;
mod vtk_array;
mod vtp;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod vtp_tests;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub(crate) use self::error::MeshError;
pub(crate) use self::mesh::Mesh;
pub(crate) use self::vtk_array::{Appended, Array, Conventions};
pub(crate) use self::vtp::{attribute, cut_appended, text_of};

/// Reads every file, in parallel; the results stand in the order of the paths.
pub(crate) fn meshes(paths: &[PathBuf]) -> Vec<Result<Mesh, MeshError>> {
    paths.par_iter().map(|path| mesh(path)).collect()
}

pub(crate) fn mesh(path: &Path) -> Result<Mesh, MeshError> {
    let bytes = std::fs::read(path).map_err(|error| MeshError::Unreadable(error.to_string()))?;
    parse(&bytes, path)
}

/// The formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
    Stl,
    Vtp,
}

pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<Mesh, MeshError> {
    if bytes.is_empty() {
        return Err(MeshError::Empty);
    }
    match recognise(bytes, path).ok_or(MeshError::Unrecognised)? {
        Format::Obj => obj::parse(bytes),
        Format::Ply => ply::parse(bytes),
        Format::Stl => stl::parse(bytes),
        Format::Vtp => vtp::parse(bytes),
    }
}

/// How far into a file the opening tag of a VTK file may stand, behind an XML
/// declaration and comments.
const VTK_TAG_WITHIN: usize = 1024;

fn recognise(bytes: &[u8], path: &Path) -> Option<Format> {
    let head = &bytes[..bytes.len().min(VTK_TAG_WITHIN)];
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return Some(Format::Ply);
    }
    if head.windows(8).any(|window| window == b"<VTKFile") {
        return Some(Format::Vtp);
    }
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("obj") => Some(Format::Obj),
        Some("ply") => Some(Format::Ply),
        Some("stl") => Some(Format::Stl),
        Some("vtp") => Some(Format::Vtp),
        _ => stl::looks_like(bytes).then_some(Format::Stl),
    }
}
