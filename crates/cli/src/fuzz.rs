//! Readers of files as functions of any bytes: what `fuzz` feeds with nonsense.
//!
//! Each returns whether the bytes are such a file, and panics where what was read
//! is not what the reader promises.

use std::path::Path;

use musculo_collide::distance_field::Interpolation;
use musculo_collide::surface::{TriangleSurface, inspect};

use crate::volume::VolumeFormat;
use crate::{motion, read, scene};

/// A mesh file, recognised by its content or by the extension that it would have.
///
/// # Panics
///
/// Where a mesh was read that has faces without vertices, or positions that are
/// not finite.
#[must_use]
pub fn mesh_file(bytes: &[u8], extension: &str) -> bool {
    let Ok(mesh) = read::parse(bytes, &Path::new("mesh").with_extension(extension)) else {
        return false;
    };
    let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces).expect("valid corners");
    let x = surface.positions(&mesh.positions).expect("finite positions");
    let _ = inspect(&surface, x);
    true
}

/// A file of a distance field, recognised by the extension that it would have.
///
/// # Panics
///
/// Where a field that was read is not the same when it is written and read again, or
/// has no answer at its first node.
#[must_use]
pub fn volume_file(bytes: &[u8], extension: &str) -> bool {
    let Some(format) = VolumeFormat::of(&Path::new("field").with_extension(extension)) else {
        return false;
    };
    let Ok(field) = format.decode(bytes) else { return false };
    let file = format.encode(&field);
    let again = format.decode(&file).expect("a file of our own");
    assert!(again.grid() == field.grid(), "another grid is read back");
    assert!(again.node_values() == field.node_values(), "another kind of nodes is read back");
    assert!(format.encode(&again) == file, "other values are read back");
    let node = field.grid().position([0; 3]);
    for interpolation in [Interpolation::Trilinear, Interpolation::Cubic] {
        let told = field.evaluate(node, interpolation).map(|sample| sample.distance);
        assert!(told.is_some_and(f64::is_finite), "{told:?} at {node}");
    }
    true
}

/// A scene file.
///
/// # Panics
///
/// Where pairs are left out of bodies that are not there, or the reach is no
/// length.
#[must_use]
pub fn scene_file(text: &str) -> bool {
    let Ok(scene) = scene::parse(text, Path::new("scene.toml")) else { return false };
    let known = |pair: &[usize; 2]| pair.iter().all(|&body| body < scene.bodies.len());
    assert!(scene.ignored.iter().all(known), "{:?}", scene.ignored);
    assert!(scene.reach.is_finite() && scene.reach >= 0.0, "{}", scene.reach);
    true
}

/// A motion file.
#[must_use]
pub fn motion_file(text: &str) -> bool {
    motion::parse(text).is_ok()
}
