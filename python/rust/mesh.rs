//! Mesh files.

use std::ffi::CString;
use std::fs;
use std::path::PathBuf;

use mesh_io::{MeshFormat, Space};
use numpy::PyArray2;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

use crate::arrays::{Faces, Points, corners, point_array, points, row_array, surface};
use crate::error::{refused, unreadable};

/// Vertices and faces of a mesh, the name of the space that its file states, and true if it is rigid there.
type Mesh<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>, Option<String>, bool);

/// Level of the frame that warnings are of: that which calls the package.
const CALLER: i32 = 2;

/// Reads a mesh file, or some parts of a model of FEBio or Abaqus, and warns of what it holds beside the mesh.
#[pyfunction]
pub(crate) fn read_mesh(
    py: Python<'_>,
    path: PathBuf,
    parts: Vec<String>,
) -> PyResult<Mesh<'_>> {
    let meshes = py.detach(|| mesh_io::read_parts(&path, &[&parts])).map_err(unreadable)?;
    let mesh = meshes.into_iter().next().ok_or_else(|| refused("the file has no mesh"))?;
    let unread = mesh.unread.map(|unread| unread.to_string());
    let skipped = mesh.skipped.map(|skipped| skipped.to_string());
    for rest in unread.into_iter().chain(skipped) {
        let warning = CString::new(format!("{}: {rest}", path.display())).map_err(refused)?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &warning, CALLER)?;
    }
    let space = mesh.space.map(|space| space.to_string());
    Ok((point_array(py, &mesh.positions), row_array(py, &mesh.faces), space, mesh.is_rigid))
}

/// Writes a mesh in the format of the path's extension, which states the space that is named.
#[pyfunction]
pub(crate) fn write_mesh(
    py: Python<'_>,
    path: PathBuf,
    vertices: Points<'_>,
    faces: Faces<'_>,
    space: Option<String>,
) -> PyResult<()> {
    let space = space.as_deref().map(named).transpose()?;
    let Some(format) = MeshFormat::of(&path) else {
        let shown = path.display();
        return Err(unreadable(format!("{shown}: expected .ply, .obj, .off, .stl or .vtp")));
    };
    let (positions, corners) = (points(&vertices)?, corners(&faces)?);
    py.detach(|| {
        // What is refused here could not be read again.
        let surface = surface("the mesh", positions.len(), corners).map_err(refused)?;
        if surface.faces().is_empty() {
            return Err(refused("the mesh has no faces"));
        }
        surface.positions(positions).map_err(|error| refused(format!("the mesh: {error}")))?;
        let written = fs::write(&path, format.encode(positions, surface.faces(), space));
        written.map_err(|error| unreadable(format!("{}: {error}", path.display())))
    })
}

/// Returns the space of a name.
fn named(name: &str) -> PyResult<Space> {
    let spaces = [Space::LeftPosteriorSuperior, Space::RightAnteriorSuperior];
    let space = spaces.into_iter().find(|space| space.to_string() == name);
    space.ok_or_else(|| {
        refused(format!("space is '{}': expected 'LPS' or 'RAS'", mesh_io::escaped(name)))
    })
}
