//! Readers of files.

use distance_field::Interpolation;
use std::collections::BTreeMap;

use mesh_io::{
    FieldFormat, Mesh, MeshFormat, ReadError, move_nodes, parse_mesh, parse_parts,
    replace_positions, set_names, tie_names,
};
use surface::{SurfaceError, TriangleSurface, inspect};

/// Reads a mesh file, whose first byte selects its extension, and returns true if the
/// rest is a mesh.
///
/// # Panics
///
/// Where a mesh has faces without vertices, or positions that are not finite; where it
/// differs from what is read after writing it, in other formats or with its positions put in their
/// own places; where a file of several parts changes though no node moves; where a refusal holds control characters.
#[must_use]
pub fn mesh(bytes: &[u8]) -> bool {
    const EXTENSIONS: [&str; 8] = ["ply", "obj", "stl", "vtp", "", "vtu", "msh", "inp"];
    let Some((first, rest)) = bytes.split_first() else { return false };
    let extension = EXTENSIONS[usize::from(*first) % EXTENSIONS.len()];
    let mesh = match parse_mesh(rest, extension) {
        Ok(mesh) => mesh,
        Err(refusal) => {
            let message = refusal.to_string();
            assert!(!message.contains(char::is_control), "{message:?}");
            if let ReadError::SeveralParts { known } = refusal {
                check_parts(rest, extension, &known);
            }
            return false;
        }
    };

    check_replaced(rest, extension, &mesh);
    for format in
        [MeshFormat::Obj, MeshFormat::Off, MeshFormat::Ply, MeshFormat::Stl, MeshFormat::Vtp]
    {
        check_written(&mesh, format);
    }
    // Surface elements of sets are not read with the solids of a whole file.
    let sets = set_names(rest, extension).unwrap_or_default();
    if !sets.is_empty() {
        check_parts(rest, extension, &sets);
    }
    let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces).expect("valid corners");
    match surface.positions(&mesh.positions) {
        Ok(x) => {
            let _ = inspect(&surface, x);
            true
        }
        Err(refusal) => {
            // Coordinates of a file are finite, but may be beyond the range of geometry.
            let is_range =
                matches!(refusal, SurfaceError::TooLarge { .. } | SurfaceError::TooSmall { .. });
            assert!(is_range, "{refusal}");
            false
        }
    }
}

/// Checks that all parts of a file are meshes with valid corners, or refused, and that the file stays as it is where
/// none of its nodes moves.
fn check_parts(file: &[u8], extension: &str, known: &[String]) {
    let _ = tie_names(file, extension);
    for part in known {
        let Ok(meshes) = parse_parts(file, extension, &[std::slice::from_ref(part)]) else {
            continue;
        };
        for Mesh { positions, faces, nodes, .. } in meshes {
            TriangleSurface::new(positions.len(), faces).expect("valid corners");
            assert_eq!(nodes.map(|nodes| nodes.len()), Some(positions.len()), "{part}");
        }
    }
    let same = move_nodes(file, extension, &BTreeMap::new()).expect("a file that is read");
    assert!(same == file, "nothing moves");
}

/// Checks that a file with its own positions put in their places reads back to the same mesh, where
/// it can be written.
fn check_replaced(file: &[u8], extension: &str, mesh: &Mesh) {
    let positions = mesh.volume.as_ref().map_or(&mesh.positions, |volume| &volume.nodes);
    let Ok(written) = replace_positions(file, extension, positions) else { return };
    let again = parse_mesh(&written, extension).expect("a file of our own");
    assert!(again.faces == mesh.faces, "other faces are read back");
}

/// Checks that a mesh reads back from a file of a format, corner by corner.
fn check_written(mesh: &Mesh, format: MeshFormat) {
    let file = format.encode(&mesh.positions, &mesh.faces, mesh.space);
    let again = parse_mesh(&file, format.extension()).expect("a file of our own");
    assert_eq!((again.unread, again.space), (None, mesh.space), "{format:?}");
    assert_eq!(again.faces.len(), mesh.faces.len(), "{format:?}");
    for (face, expected) in again.faces.iter().zip(&mesh.faces) {
        for (vertex, expected) in face.iter().zip(expected) {
            let x = again.positions[*vertex as usize];
            assert!(x == mesh.positions[*expected as usize], "{format:?}: {x}");
        }
    }
}

/// Reads a file of a distance field, whose first byte selects its format, and returns
/// true if the rest is a field.
///
/// # Panics
///
/// Where a field differs from what is read after writing it, compressed or not, or has no
/// value at its first node; where a refusal holds control characters.
pub fn volume(bytes: &[u8]) -> bool {
    const FORMATS: [FieldFormat; 2] = [FieldFormat::Nrrd, FieldFormat::Vti];
    let Some((first, rest)) = bytes.split_first() else { return false };
    let format = FORMATS[usize::from(*first) % FORMATS.len()];
    let field = match format.decode(rest) {
        Ok(field) => field,
        Err(refusal) => {
            let message = refusal.to_string();
            assert!(!message.contains(char::is_control), "{message:?}");
            return false;
        }
    };

    for format in [format].into_iter().chain(format.compressed()) {
        let file = format.encode(&field);
        let again = format.decode(&file).expect("a file of our own");
        assert!(again.grid() == field.grid(), "another grid is read back");
        assert!(again.node_values() == field.node_values(), "another kind of nodes is read back");
        assert!(format.encode(&again) == file, "other values are read back");
    }

    let node = field.grid().position([0; 3]);
    for interpolation in [Interpolation::Trilinear, Interpolation::Cubic] {
        let distance = field.evaluate(node, interpolation).map(|sample| sample.distance);
        assert!(distance.is_some_and(f64::is_finite), "{distance:?} at {node}");
    }
    true
}

/// Reads a scene file, a motion file or a table of poses, and returns true if the bytes are one.
///
/// # Panics
///
/// Where a scene ignores pairs of absent bodies, or its margin is not a length.
#[must_use]
pub fn scene(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    cli::fuzz::scene_file(&text) || cli::fuzz::motion_file(&text)
}
