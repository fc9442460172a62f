//! Parsers of text files, for the fuzz targets.

use std::path::Path;

use crate::{motion, scene};

/// Parses a scene file, and returns true if the text is one.
///
/// # Panics
///
/// Where a scene ignores pairs of absent bodies, or its margin is not a length.
#[must_use]
pub fn scene_file(text: &str) -> bool {
    let Ok(scene) = scene::parse(text, Path::new("scene.toml")) else { return false };
    let count = scene.bodies.len();
    assert!(scene.ignored.iter().flatten().all(|&body| body < count), "{:?}", scene.ignored);
    assert!(scene.reach.is_finite() && scene.reach >= 0.0, "{}", scene.reach);
    true
}

/// Parses a motion file, and returns true if the text is one.
#[must_use]
pub fn motion_file(text: &str) -> bool {
    motion::parse(text).is_ok()
}
