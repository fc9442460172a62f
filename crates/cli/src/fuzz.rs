//! Parsers of text files, for the fuzz targets.

use std::path::Path;

use crate::motion::Motion;
use crate::scene::{SceneDescription, Unit};

/// Parses a scene file, and returns true if the text is one.
///
/// # Panics
///
/// Where a scene ignores pairs or fixes vertices of absent bodies, or its margin is not a length.
#[must_use]
pub fn scene_file(text: &str) -> bool {
    let Ok(scene) = SceneDescription::parse(text, Path::new("")) else { return false };

    // The parser promises what loading relies on.
    for pair in &scene.ignored {
        let (a, b) = (scene.index_of(&pair.a), scene.index_of(&pair.b));
        assert!(a.is_ok() && b.is_ok(), "{pair:?}");
        assert!(a.ok() != b.ok(), "{pair:?}");
    }
    for fixed in &scene.fixed {
        let fixed = fixed.get_ref();
        assert!(fixed.selection().is_ok() && scene.index_of(&fixed.body).is_ok(), "{fixed:?}");
    }
    let margin = scene.margin.unwrap_or(0.0);
    assert!(margin.is_finite() && margin >= 0.0, "{margin}");
    true
}

/// Parses a motion file or a table of poses, and returns true if the text is one.
#[must_use]
pub fn motion_file(text: &str) -> bool {
    Motion::parse(text, Unit::Millimeter).is_ok() || Motion::is_table(text)
}
