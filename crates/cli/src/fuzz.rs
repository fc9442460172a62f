//! Readers of files as functions of any bytes: what `fuzz` feeds with nonsense.
//!
//! Each returns whether the bytes are such a file, and panics where what was read
//! is not what the reader promises.

use std::path::Path;

use musculo_collide::surface::{TriangleSurface, inspect};

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
