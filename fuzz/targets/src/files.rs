//! Readers of files.

use distance_field::Interpolation;
use mesh_io::{FieldFormat, parse_mesh};
use surface::{TriangleSurface, inspect};

/// Reads a mesh file, whose first byte selects its extension, and returns true if the
/// rest is a mesh.
///
/// # Panics
///
/// Where a mesh has faces without vertices, or positions that are not finite.
#[must_use]
pub fn mesh(bytes: &[u8]) -> bool {
    const EXTENSIONS: [&str; 5] = ["ply", "obj", "stl", "vtp", ""];
    let Some((first, rest)) = bytes.split_first() else { return false };
    let extension = EXTENSIONS[usize::from(*first) % EXTENSIONS.len()];
    let Ok(mesh) = parse_mesh(rest, extension) else { return false };

    let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces).expect("valid corners");
    let x = surface.positions(&mesh.positions).expect("finite positions");
    let _ = inspect(&surface, x);
    true
}

/// Reads a file of a distance field, whose first byte selects its format, and returns
/// true if the rest is a field.
///
/// # Panics
///
/// Where a field differs from what is read after writing it, or has no value at its
/// first node.
pub fn volume(bytes: &[u8]) -> bool {
    const FORMATS: [FieldFormat; 2] = [FieldFormat::Nrrd, FieldFormat::Vti];
    let Some((first, rest)) = bytes.split_first() else { return false };
    let format = FORMATS[usize::from(*first) % FORMATS.len()];
    let Ok(field) = format.decode(rest) else { return false };

    let file = format.encode(&field);
    let again = format.decode(&file).expect("a file of our own");
    assert!(again.grid() == field.grid(), "another grid is read back");
    assert!(again.node_values() == field.node_values(), "another kind of nodes is read back");
    assert!(format.encode(&again) == file, "other values are read back");

    let node = field.grid().position([0; 3]);
    for interpolation in [Interpolation::Trilinear, Interpolation::Cubic] {
        let distance = field.evaluate(node, interpolation).map(|sample| sample.distance);
        assert!(distance.is_some_and(f64::is_finite), "{distance:?} at {node}");
    }
    true
}

/// Reads a scene file or a motion file, and returns true if the bytes are either.
///
/// # Panics
///
/// Where a scene ignores pairs of absent bodies, or its margin is not a length.
#[must_use]
pub fn scene(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    cli::fuzz::scene_file(&text) || cli::fuzz::motion_file(&text)
}
