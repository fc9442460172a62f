//! What is to be checked: bodies, their files and kinds, pairs to leave out,
//! unit and reach. It comes from a scene file or from the command line.

mod error;
mod file;
mod size;
mod unit;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use musculo_collide::BodyKind;

pub(crate) use self::error::SceneError;
pub(crate) use self::file::parse;
pub(crate) use self::size::{Bounds, unit_warnings};
pub(crate) use self::unit::Unit;

/// A body before its file is read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Body {
    pub(crate) name: String,
    /// The file as the scene or the command line names it.
    pub(crate) file: String,
    /// The same, from the working directory.
    pub(crate) path: PathBuf,
    pub(crate) kind: BodyKind,
}

/// A scene before its files are read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scene {
    pub(crate) unit: Unit,
    /// How far apart surfaces still count as near, in `unit`.
    pub(crate) reach: f64,
    /// How the bodies move, from the working directory.
    pub(crate) motion: Option<PathBuf>,
    pub(crate) bodies: Vec<Body>,
    /// Pairs to leave out, by position in `bodies`.
    pub(crate) ignored: Vec<[usize; 2]>,
}

/// Reach where none is given: a millimetre, a few edges of a fine mesh, in
/// which near surfaces of adjoining tissues lie.
const DEFAULT_REACH_MM: f64 = 1.0;

impl Scene {
    /// From one scene file or any number of mesh files.
    pub(crate) fn from_inputs(inputs: &[PathBuf]) -> Result<Self, SceneError> {
        match inputs {
            [path] if is_scene_file(path) => file::read(path),
            paths => match paths.iter().find(|path| is_scene_file(path)) {
                Some(path) => Err(SceneError::SceneAmongOthers { path: path.clone() }),
                None => Self::of_files(paths),
            },
        }
    }

    fn of_files(paths: &[PathBuf]) -> Result<Self, SceneError> {
        let body = |path: &PathBuf| Body {
            name: stem(path),
            file: path.display().to_string(),
            path: path.clone(),
            kind: BodyKind::Deformable,
        };
        let unit = Unit::default();
        let scene = Self {
            unit,
            reach: unit.of_millimetres(DEFAULT_REACH_MM),
            motion: None,
            bodies: paths.iter().map(body).collect(),
            ignored: Vec::new(),
        };
        scene.check_names()?;
        Ok(scene)
    }

    /// Makes the named bodies rigid, whatever they were.
    pub(crate) fn set_rigid(&mut self, names: &[String]) -> Result<(), SceneError> {
        for name in names {
            let body = self.position(name, "--rigid")?;
            self.bodies[body].kind = BodyKind::Rigid;
        }
        Ok(())
    }

    /// Replaces the reach.
    pub(crate) fn set_reach(&mut self, reach: f64) -> Result<(), SceneError> {
        if !reach.is_finite() || reach < 0.0 {
            return Err(SceneError::Reach { reach });
        }
        self.reach = reach;
        Ok(())
    }

    fn position(&self, name: &str, place: &'static str) -> Result<usize, SceneError> {
        self.bodies.iter().position(|body| body.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
            SceneError::NoSuchBody { place, name: name.to_owned(), known: known.join(", ") }
        })
    }

    fn check_names(&self) -> Result<(), SceneError> {
        for (number, body) in self.bodies.iter().enumerate() {
            let is_file_name = |c: char| !matches!(c, '/' | '\\') && !c.is_control();
            if body.name.is_empty() || !body.name.chars().all(is_file_name) {
                return Err(SceneError::Name { name: body.name.clone(), file: body.file.clone() });
            }
            if let Some(first) = self.bodies[..number].iter().find(|other| other.name == body.name)
            {
                return Err(SceneError::SameName {
                    name: body.name.clone(),
                    first: first.file.clone(),
                    second: body.file.clone(),
                });
            }
        }
        Ok(())
    }
}

fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
