//! Conditions on overlap removal in scene files: tied pairs and fixed vertices.

use std::path::{Path, PathBuf};

use glam::DVec3;
use musculo_collide::BodyStiffness;
use serde::Deserialize;
use toml::Spanned;

use super::{SceneDescription, SceneProblem};

/// Two bodies that are attached where they are near each other.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TieDescription {
    pub(crate) a: String,
    pub(crate) b: String,
    /// Largest distance of attached vertices from the other surface.
    pub(crate) within: f64,
}

/// Vertices of a body that stay, selected in one of three ways.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FixedDescription {
    pub(crate) body: String,
    /// File of vertex numbers, relative to the working directory once it is parsed.
    vertices: Option<PathBuf>,
    /// Two opposite corners.
    #[serde(rename = "box")]
    corners: Option<[[f64; 3]; 2]>,
    /// Largest distance from the surface of another body.
    within: Option<f64>,
    /// The other body.
    of: Option<String>,
}

/// Selection of vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Selection<'a> {
    File(&'a Path),
    Box { min: DVec3, max: DVec3 },
    Near { other: &'a str, distance: f64 },
}

impl FixedDescription {
    /// Returns the selection, or the offense against its form.
    pub(crate) fn selection(&self) -> Result<Selection<'_>, String> {
        let Self { vertices, corners, within, of, .. } = self;

        // Exactly one way of selection, with all of its fields.
        match (vertices, corners, within, of) {
            (Some(file), None, None, None) => Ok(Selection::File(file)),
            (None, Some([p, q]), None, None) => {
                let [p, q] = [*p, *q].map(DVec3::from_array);
                if !(p.is_finite() && q.is_finite()) {
                    return Err("a corner of the box is not finite".to_owned());
                }
                Ok(Selection::Box { min: p.min(q), max: p.max(q) })
            }
            (None, None, Some(distance), Some(other)) => {
                check_distance(*distance)?;
                Ok(Selection::Near { other, distance: *distance })
            }
            (None, None, Some(_), None) => Err("'within' needs the body 'of'".to_owned()),
            (None, None, None, Some(_)) => Err("'of' needs a distance 'within'".to_owned()),
            _ => {
                Err("select vertices in one way: 'vertices', 'box', or 'within' and 'of'"
                    .to_owned())
            }
        }
    }
}

impl SceneDescription {
    /// Checks stiffnesses, ties and selections, and finds the files of the latter in a folder. `text` is the
    /// scene file, whose lines are named.
    pub(super) fn check_conditions(
        &mut self,
        text: &str,
        folder: &Path,
    ) -> Result<(), SceneProblem> {
        for fixed in &mut self.fixed {
            let file = &mut fixed.get_mut().vertices;
            *file = file.take().map(|file| folder.join(file));
        }

        for stiffness in self.bodies.iter().filter_map(|body| body.stiffness.as_ref()) {
            let value = *stiffness.get_ref();
            let range = BodyStiffness::FACTORS;
            if !range.contains(&value) {
                let (min, max) = (range.start(), range.end());
                let problem =
                    format!("stiffness is {value:?}, but must be from {min:e} to {max:e}");
                return Err(at_line(text, stiffness, "body", problem));
            }
        }
        for tie in &self.ties {
            let TieDescription { a, b, within } = tie.get_ref();
            let checked = self.check_pair(a, b).and_then(|()| check_distance(*within));
            checked.map_err(|problem| at_line(text, tie, "tie", problem))?;
        }
        for fixed in &self.fixed {
            self.check_fixed(fixed.get_ref())
                .map_err(|problem| at_line(text, fixed, "fixed", problem))?;
        }
        Ok(())
    }

    /// Returns the files of vertex numbers.
    pub(crate) fn vertex_files(&self) -> impl Iterator<Item = PathBuf> {
        self.fixed.iter().filter_map(|fixed| fixed.get_ref().vertices.clone())
    }

    fn check_pair(&self, a: &str, b: &str) -> Result<(), String> {
        let [a_number, b_number] = [self.number(a)?, self.number(b)?];
        if a_number == b_number { Err(format!("'{a}' is paired with itself")) } else { Ok(()) }
    }

    fn check_fixed(&self, fixed: &FixedDescription) -> Result<(), String> {
        let selection = fixed.selection()?;
        self.number(&fixed.body)?;
        if let Selection::Near { other, .. } = selection {
            self.check_pair(&fixed.body, other)?;
        }
        Ok(())
    }

    fn number(&self, name: &str) -> Result<usize, String> {
        self.index_of(name).map_err(|problem| problem.to_string())
    }
}

fn check_distance(distance: f64) -> Result<(), String> {
    if distance.is_finite() && distance >= 0.0 {
        return Ok(());
    }
    Err(format!("within is {distance}, but must be finite and at least 0"))
}

/// Returns a refusal of a table, with its line.
fn at_line<T>(text: &str, at: &Spanned<T>, table: &'static str, problem: String) -> SceneProblem {
    let before = text.get(..at.span().start).unwrap_or_default();
    let line = 1 + before.matches('\n').count();
    SceneProblem::Condition { line, table, problem }
}
