//! Readers and writers of triangle meshes, of volume meshes and of signed distance fields.
//!
//! | format | content | read | written |
//! |---|---|---|---|
//! | PLY | mesh, ASCII or binary | yes | [`MeshFormat::encode`] |
//! | OBJ | mesh | yes | [`MeshFormat::encode`] |
//! | OFF | mesh, text | yes | [`MeshFormat::encode`] |
//! | STL | mesh, ASCII or binary | yes | [`MeshFormat::encode`] |
//! | VTP | mesh, every encoding of VTK | yes | [`write_vtp`], with values per vertex; [`write_vtp_cells`] |
//! | VTU | volume mesh or surface, every encoding of VTK | yes | [`write_vtu`], with values per node |
//! | VTK | volume mesh or surface, legacy files of VTK as text or binary | yes | [`replace_positions`] |
//! | MSH | volume mesh or surface, text of versions 2 and 4.1 | yes | [`replace_positions`] |
//! | INP | volume mesh or surface, or parts of an Abaqus model | yes, [`read_parts`] | [`replace_positions`], [`move_nodes`] |
//! | FEB | parts of an FEBio model: volume meshes or surfaces | [`read_parts`] | [`move_nodes`] |
//! | OSIM | OpenSim model: meshes of its bodies | [`read_model`] | no |
//! | NRRD | distance field, raw or gzip | yes | [`FieldFormat::encode`] |
//! | VTI | distance field, every encoding of VTK | yes | [`FieldFormat::encode`] |
//!
//! A volume mesh is read with the surface around it, which is the mesh ([`Mesh::volume`]). Every mesh
//! file can be written again with other positions and all else as it was: [`replace_positions`].
//!
//! Formats are recognized by content first, and by extension where content is
//! ambiguous. Vertices and faces keep the order of the file, so that an index in a
//! report can be found in the file. Nothing is repaired: any list of faces with valid
//! indices is a mesh, whatever its defects. Positions are as the file has them, in the space that it may
//! state ([`Mesh::space`]). Content behind the end that a header declares
//! is reported ([`Mesh::unread`]), and so are elements that are no part of the mesh ([`Mesh::skipped`]). Every
//! refusal names the place in the file and, from [`read_mesh`] and [`read_field`], the file. Control
//! characters in quoted text are escaped, and a file that never ends is refused ([`MAX_STREAM_BYTES`]).
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

mod copy;
mod error;
mod feb;
mod field;
mod inp;
mod inp_keyword;
mod inp_model;
mod inp_outline;
mod inp_placement;
mod inp_rigid;
#[cfg(test)]
mod inp_tests;
mod mesh;
mod mesh_format;
mod msh;
mod msh_copies;
mod msh_elements;
mod msh_groups;
mod nrrd;
mod obj;
mod off;
mod osim;
mod osim_frames;
mod osim_values;
mod parts;
mod ply;
mod ply_binary;
mod ply_header;
mod ply_replace;
mod ply_text;
mod replace;
mod shared_elements;
mod skipped;
mod solid;
mod source;
mod space;
mod stl;
mod stored_values;
mod text;
mod text_nodes;
mod volume;
mod vtk;

use std::path::Path;

pub use glam;

pub use self::copy::Precision;
pub use self::error::{FileError, FilePlace, ReadError};
pub use self::field::FieldFormat;
pub use self::mesh::{Mesh, Unread};
pub use self::mesh_format::{
    MeshFormat, instances_by_part, nodes_by_part, parse_mesh, parse_parts, part_names, set_names,
    tie_names,
};
pub use self::osim::{ModelBody, ModelMesh, OpenSimModel};
pub use self::parts::PartNodes;
pub use self::replace::{coordinate_precision, move_nodes, placement_roundings, replace_positions};
pub use self::skipped::SkippedElements;
pub use self::source::{MAX_FILE_BYTES, MAX_STREAM_BYTES, read_file, read_text, separator_advice};
pub use self::space::Space;
pub use self::text::escaped;
pub use self::volume::Volume;
pub use self::vtk::{CellValues, Cells, PointValues, write_vtp, write_vtp_cells, write_vtu};

/// Reads a mesh file.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read or is not a mesh.
pub fn read_mesh(path: &Path) -> Result<Mesh, FileError> {
    let mesh = content(path).and_then(|bytes| parse_mesh(&bytes, &extension(path)));
    mesh.map_err(|reason| FileError { path: path.to_owned(), reason })
}

/// Reads the meshes of bodies in one file, each by the names of its parts; without names, it is the only part.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read, has no such parts, or these are no mesh.
pub fn read_parts(path: &Path, bodies: &[&[String]]) -> Result<Vec<Mesh>, FileError> {
    let meshes = content(path).and_then(|bytes| parse_parts(&bytes, &extension(path), bodies));
    meshes.map_err(|reason| FileError { path: path.to_owned(), reason })
}

/// Reads the names of the parts of a file that are meshes, none of a format without parts.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read or does not follow its format.
pub fn read_part_names(path: &Path) -> Result<Vec<String>, FileError> {
    let names = content(path).and_then(|bytes| part_names(&bytes, &extension(path)));
    names.map_err(|reason| FileError { path: path.to_owned(), reason })
}

/// Reads an OpenSim model.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read or is not a model.
pub fn read_model(path: &Path) -> Result<OpenSimModel, FileError> {
    let model = content(path).and_then(|bytes| OpenSimModel::parse(&bytes));
    model.map_err(|reason| FileError { path: path.to_owned(), reason })
}

/// Reads a distance field from a file, in the format of its extension.
///
/// # Errors
///
/// The path with the reason, where the file cannot be read or is not a field.
pub fn read_field(path: &Path) -> Result<distance_field::DistanceField, FileError> {
    let field = match FieldFormat::of(path) {
        Some(format) => content(path).and_then(|bytes| format.decode(&bytes)),
        None => Err(ReadError::UnknownFormat { expected: ".nrrd or .vti" }),
    };
    field.map_err(|reason| FileError { path: path.to_owned(), reason })
}

fn content(path: &Path) -> Result<Vec<u8>, ReadError> {
    Ok(read_file(path)?)
}

/// Returns the extension of a path, empty where there is none.
#[must_use]
pub fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().into_owned()
}
