//! Scene files:
//!
//! ```toml
//! unit = "mm"             # of every length here and in the meshes; "mm" if left out
//! reach = 1.0             # how far apart still counts as near; 1 mm if left out
//!
//! motion = "walk.json"    # how the bodies move, for the command `motion`; none if left out
//!
//! [[body]]
//! name = "femur"          # the file's name without extension, if left out
//! file = "femur.ply"      # from the folder of the scene file
//! kind = "rigid"          # or "open" (a sheet), or "deformable", which is meant if left out
//!
//! [[ignore]]              # pairs that are meant to overlap
//! a = "femur"
//! b = "cartilage"
//! ```

use std::path::Path;

use musculo_collide::BodyKind;
use serde::Deserialize;

use super::{Body, DEFAULT_REACH_MM, Scene, SceneError, Unit, stem};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(default)]
    unit: Unit,
    reach: Option<f64>,
    motion: Option<String>,
    #[serde(default)]
    body: Vec<BodyEntry>,
    #[serde(default)]
    ignore: Vec<IgnoreEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyEntry {
    name: Option<String>,
    file: String,
    #[serde(default = "deformable")]
    kind: BodyKind,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct IgnoreEntry {
    a: String,
    b: String,
}

fn deformable() -> BodyKind {
    BodyKind::Deformable
}

/// Reads a scene file; the meshes it names are not touched.
pub(super) fn read(path: &Path) -> Result<Scene, SceneError> {
    let unreadable = |error: std::io::Error| SceneError::Unreadable {
        path: path.to_owned(),
        problem: error.to_string(),
    };
    let text = std::fs::read_to_string(path).map_err(unreadable)?;
    parse(&text, path)
}

/// Reads the text of the scene file at `path`.
pub(crate) fn parse(text: &str, path: &Path) -> Result<Scene, SceneError> {
    let file: SceneFile = toml::from_str(text).map_err(|error| SceneError::Syntax {
        path: path.to_owned(),
        problem: error.to_string().trim_end().to_owned(),
    })?;
    if file.body.is_empty() {
        return Err(SceneError::NoBodies { path: path.to_owned() });
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scene = Scene {
        unit: file.unit,
        reach: 0.0,
        motion: file.motion.map(|motion| folder.join(motion)),
        bodies: file.body.into_iter().map(|entry| body(entry, folder)).collect(),
        ignored: Vec::new(),
    };
    scene.set_reach(file.reach.unwrap_or(file.unit.of_millimetres(DEFAULT_REACH_MM)))?;
    scene.check_names()?;
    scene.ignored =
        file.ignore.into_iter().map(|pair| ignored(&scene, pair)).collect::<Result<_, _>>()?;
    Ok(scene)
}

fn body(entry: BodyEntry, folder: &Path) -> Body {
    let path = folder.join(&entry.file);
    Body {
        name: entry.name.unwrap_or_else(|| stem(&path)),
        file: entry.file,
        path,
        kind: entry.kind,
    }
}

fn ignored(scene: &Scene, pair: IgnoreEntry) -> Result<[usize; 2], SceneError> {
    let [a, b] = [scene.position(&pair.a, "[[ignore]]")?, scene.position(&pair.b, "[[ignore]]")?];
    if a == b {
        return Err(SceneError::IgnoredWithItself { name: pair.a });
    }
    Ok([a.min(b), a.max(b)])
}
