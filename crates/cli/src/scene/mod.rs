//! Scenes before their meshes are read: bodies with their files and kinds, ignored pairs,
//! unit and margin, from a scene file, from an OpenSim model or from the command line.
//!
//! ```toml
//! unit = "mm"             # of every length here and in the meshes; default "mm"
//! margin = 1.0            # largest distance of a near pair; default: the mean edge length
//!
//! motion = "walk.json"    # for the commands `motion` and `plan`; default none
//!
//! [[body]]
//! name = "femur"          # default: the first part, or the file's name without extension
//! file = "femur.ply"      # relative to the folder of the scene file; / between folders
//! parts = ["Part1"]       # of a model of FEBio, Abaqus or Gmsh, those that are this body; default: its only one
//! kind = "rigid"          # or "open" (a sheet), or "deformable", the default unless it is rigid in its file
//! follows = "femur_r"     # name in the motion; default: the body's name
//! stiffness = 2.0         # for `resolve`: yields half as much as others, from 1e-9 to 1e9; default: 1
//! uncross = true          # for `resolve`: parts that cross each other come apart; default: false
//!
//! [[ignore]]              # pair that overlaps on purpose
//! a = "femur"
//! b = "cartilage"
//!
//! [[tie]]                 # for `resolve`: attached where they are near, no gap between them
//! a = "femur"
//! b = "ligament"
//! within = 0.5            # largest distance of attached vertices
//!
//! [[fixed]]               # for `resolve`: vertices that stay, selected by one of
//! body = "tendon"
//! within = 1.0            # a distance from another body,
//! of = "femur"
//! # vertices = "ids.txt"  # a file of their numbers,
//! # box = [[0, 0, 0], [10, 10, 5]]
//! ```
//!
//! Numbers of vertices are those of the nodes in INP, FEB and MSH files, and count from 0 in others, also in OBJ files, whose
//! own count from 1; STL files have none.

mod conditions;
mod error;
mod model;
mod unit;
mod unit_check;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use glam::DAffine3;
use mesh_io::{FileError, ReadError};
use musculo_collide::BodyKind;
use serde::Deserialize;
use toml::Spanned;

pub(crate) use self::conditions::{FixedDescription, Selection, TieDescription};
pub(crate) use self::error::SceneProblem;
pub(crate) use self::unit::Unit;
pub(crate) use self::unit_check::unit_warnings;
use crate::failure::Failure;
use crate::file_id::is_same_file;

/// Scene before its meshes are read.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneDescription {
    #[serde(default)]
    pub(crate) unit: Unit,
    /// Largest distance of a near pair, in `unit`.
    pub(crate) margin: Option<f64>,
    /// Motion file, relative to the working directory.
    pub(crate) motion: Option<PathBuf>,
    #[serde(default, rename = "body")]
    pub(crate) bodies: Vec<BodyDescription>,
    #[serde(default, rename = "ignore")]
    pub(crate) ignored: Vec<IgnoredPair>,
    /// True if meshes stand in the frames of the bodies of an OpenSim model.
    #[serde(skip)]
    pub(crate) is_model: bool,
    #[serde(default, rename = "tie")]
    pub(crate) ties: Vec<Spanned<TieDescription>>,
    #[serde(default)]
    pub(crate) fixed: Vec<Spanned<FixedDescription>>,
}

/// Body before its mesh is read.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyDescription {
    #[serde(default)]
    pub(crate) name: String,
    /// File as the scene or the command line has it.
    pub(crate) file: String,
    /// The same file, relative to the working directory.
    #[serde(skip)]
    pub(crate) path: PathBuf,
    /// Names of the parts of the file that are the body; none for its only part.
    #[serde(default)]
    pub(crate) parts: Vec<String>,
    /// Kind; where it is left out, rigid if the mesh is rigid in its file, and else deformable.
    pub(crate) kind: Option<BodyKind>,
    /// Name in the motion that the body follows; none for its own.
    pub(crate) follows: Option<String>,
    /// Stiffness in overlap removal, relative to bodies without one.
    pub(crate) stiffness: Option<Spanned<f64>>,
    /// True if overlap removal takes parts of the body out of each other.
    #[serde(default)]
    pub(crate) uncross: bool,
    /// Map from the coordinates of the file to those of the body; none where they are the same.
    #[serde(skip)]
    pub(crate) placement: Option<DAffine3>,
}

/// Names of two bodies that overlap on purpose.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct IgnoredPair {
    pub(crate) a: String,
    pub(crate) b: String,
}

impl SceneDescription {
    /// Describes a scene by one scene file or by any number of mesh files.
    pub(crate) fn from_inputs(inputs: &[PathBuf]) -> Result<Self, Failure> {
        if let [path] = inputs
            && is_scene_file(path)
        {
            return Self::read(path).map_err(|problem| Failure::in_file(path, problem));
        }
        if let [path] = inputs
            && model::is_model_file(path)
        {
            return model::read(path);
        }

        // Mesh files describe bodies by their names; a scene file among them would be lost.
        let is_scene = |path: &&PathBuf| is_scene_file(path) || model::is_model_file(path);
        if let Some(path) = inputs.iter().find(is_scene) {
            return Err(SceneProblem::SceneAmongOthers(path.clone()).into());
        }

        let mut scene = Self::default();
        for path in inputs {
            let parts = part_names(path)?;
            if parts.len() < 2 {
                scene.bodies.push(BodyDescription::of_file(stem(path), path, &[]));
                continue;
            }
            for part in &parts {
                let parts = std::slice::from_ref(part);
                scene.bodies.push(BodyDescription::of_file(part.clone(), path, parts));
            }
        }
        scene.check_names()?;
        Ok(scene)
    }

    fn read(path: &Path) -> Result<Self, SceneProblem> {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&mesh_io::read_text(path)?, folder)
    }

    /// Parses a scene file in a folder; the meshes are not read.
    pub(crate) fn parse(text: &str, folder: &Path) -> Result<Self, SceneProblem> {
        // The parser's error quotes the line.
        let mut scene: Self = toml::from_str(text).map_err(|error| syntax_problem(&error))?;
        if scene.bodies.is_empty() {
            return Err(SceneProblem::NoBodies);
        }

        // Paths and names that the file leaves out.
        scene.motion = scene.motion.map(|motion| folder.join(motion));
        for body in &mut scene.bodies {
            body.path = folder.join(&body.file);
            if body.name.is_empty() {
                let part = body.parts.first().cloned();
                body.name = part.unwrap_or_else(|| stem(&body.path));
            }
        }

        // References need names that are checked.
        scene.check_names()?;
        scene.check_margin()?;
        for IgnoredPair { a, b } in &scene.ignored {
            if scene.index_of(a)? == scene.index_of(b)? {
                return Err(SceneProblem::IgnoredWithItself(a.clone()));
            }
        }
        scene.check_conditions(text, folder)?;
        Ok(scene)
    }

    /// Makes the named bodies rigid.
    pub(crate) fn set_rigid(&mut self, names: &[String]) -> Result<(), SceneProblem> {
        for name in names {
            let body = self.index_of(name)?;
            self.bodies[body].kind = Some(BodyKind::Rigid);
        }
        Ok(())
    }

    /// Replaces the margin, if a new one is given.
    pub(crate) fn set_margin(&mut self, margin: Option<f64>) -> Result<(), SceneProblem> {
        self.margin = margin.or(self.margin);
        self.check_margin()
    }

    /// Returns the number of a body.
    pub(crate) fn index_of(&self, name: &str) -> Result<usize, SceneProblem> {
        let exact = self.bodies.iter().position(|body| body.name == name);
        // In Abaqus, names of one spelling in other cases are the same.
        let is_same = |body: &BodyDescription| {
            has_extension(&body.path, "inp") && body.name.eq_ignore_ascii_case(name)
        };
        if let Some(number) = exact.or_else(|| self.bodies.iter().position(is_same)) {
            return Ok(number);
        }
        let known: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
        Err(SceneProblem::NoSuchBody { name: name.to_owned(), known: known.join(", ") })
    }

    /// Returns the numbers of the bodies of each file: one, or those that are parts of it.
    pub(crate) fn bodies_by_file(&self) -> Vec<Vec<usize>> {
        let mut files: Vec<Vec<usize>> = Vec::new();
        for (number, body) in self.bodies.iter().enumerate() {
            let file = files.iter_mut().find(|file| self.bodies[file[0]].shares_file(body));
            match file {
                Some(file) => file.push(number),
                None => files.push(vec![number]),
            }
        }
        files
    }

    fn check_margin(&self) -> Result<(), SceneProblem> {
        match self.margin {
            Some(margin) if !(margin.is_finite() && margin >= 0.0) => {
                Err(SceneProblem::Margin(margin))
            }
            _ => Ok(()),
        }
    }

    /// Checks that names differ and can name output files.
    fn check_names(&self) -> Result<(), SceneProblem> {
        // A name must not lead to another folder, nor control a terminal.
        let is_in_file_name = |c: char| !matches!(c, '/' | '\\') && !c.is_control();
        for (number, body) in self.bodies.iter().enumerate() {
            let BodyDescription { name, file, path, .. } = body;
            if name.is_empty() || !name.chars().all(is_in_file_name) {
                // A name that is that of the file is as the path gave it.
                let advice = mesh_io::separator_advice(path).filter(|_| *name == stem(path));
                let advice = advice.map(|advice| format!(": {advice}")).unwrap_or_default();
                let (name, file) = (name.clone(), file.clone());
                return Err(SceneProblem::BadName { name, file, advice });
            }

            // A part of two bodies would be two bodies in one place.
            let others = self.bodies[..number].iter();
            for other in others.filter(|other| other.shares_file(body)) {
                let mut parts = other.parts.iter();
                if let Some(part) = parts.find(|part| body.has_part(part)) {
                    let names = [other.name.clone(), name.clone()];
                    return Err(SceneProblem::SamePart { part: part.clone(), names });
                }
            }

            // Both files are named, as either may be the mistake.
            let first = self.bodies[..number].iter().find(|other| other.name == *name);
            if let Some(BodyDescription { file: first, .. }) = first {
                return Err(SceneProblem::SameName {
                    name: name.clone(),
                    first: first.clone(),
                    second: file.clone(),
                });
            }
        }
        Ok(())
    }
}

impl BodyDescription {
    /// Describes a body that is a file, or parts of one.
    fn of_file(name: String, path: &Path, parts: &[String]) -> Self {
        Self {
            name,
            file: path.display().to_string(),
            path: path.to_owned(),
            parts: parts.to_vec(),
            kind: None,
            follows: None,
            stiffness: None,
            uncross: false,
            placement: None,
        }
    }

    /// Returns true if a part of the file is named as one of the body. Case does not matter in Abaqus files.
    pub(crate) fn has_part(&self, name: &str) -> bool {
        let is_abaqus = has_extension(&self.path, "inp");
        let is_same = |part: &String| {
            if is_abaqus { part.eq_ignore_ascii_case(name) } else { part == name }
        };
        self.parts.iter().any(is_same)
    }

    /// Returns true if both bodies are parts of one file.
    fn shares_file(&self, other: &Self) -> bool {
        !self.parts.is_empty() && !other.parts.is_empty() && is_same_file(&self.path, &other.path)
    }
}

/// Returns the names of the parts of a file that may have several, which is read for them.
fn part_names(path: &Path) -> Result<Vec<String>, Failure> {
    // A pipe is read once.
    let is_model = has_extension(path, "feb");
    let may_have_parts = is_model || has_extension(path, "inp") || has_extension(path, "msh");
    let is_pipe = path.exists() && !path.is_file();
    if is_pipe || !may_have_parts {
        return Ok(Vec::new());
    }
    match mesh_io::read_part_names(path) {
        // Meshes that cannot be read are named together, when all are.
        Err(FileError { reason: ReadError::Unreadable(_) | ReadError::Empty, .. }) if !is_model => {
            Ok(Vec::new())
        }
        names => Ok(names?),
    }
}

fn has_extension(path: &Path, expected: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(expected))
}

/// Returns the refusal of a text that is no scene; a path of Windows in double quotes has escapes.
fn syntax_problem(error: &toml::de::Error) -> SceneProblem {
    let mut problem = error.to_string().trim_end().to_owned();
    if error.message().contains("escaped value") {
        problem += ": a backslash begins an escape: write / between folders";
    }
    SceneProblem::Syntax(problem)
}

fn is_scene_file(path: &Path) -> bool {
    has_extension(path, "toml")
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
