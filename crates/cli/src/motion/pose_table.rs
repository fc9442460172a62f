//! Poses of bodies over time, as tables have them.

use std::collections::BTreeMap;

use clap::ValueEnum;
use glam::DMat4;

/// Frame of the scene's meshes, of a motion by poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MeshFrame {
    /// Meshes stand in space as the first pose of the table has their bodies.
    #[default]
    FirstPose,
    /// Meshes stand in the frames of their bodies.
    Body,
}

/// Poses of bodies, frame by frame, in the table's unit of length.
#[derive(Debug, Default)]
pub(super) struct PoseTable {
    pub(super) times: Vec<f64>,
    pub(super) poses: Vec<BTreeMap<String, DMat4>>,
}

/// Reason why a table of poses cannot be read.
#[derive(Debug, thiserror::Error, PartialEq)]
pub(crate) enum TableProblem {
    #[error("{0}")]
    Malformed(String),
    #[error("the header does not end: no line is `endheader`")]
    NoEndOfHeader,
    #[error("no labels of columns follow the header")]
    NoLabels,
    #[error("line {line}: the header has '{text}', whose value is unknown")]
    HeaderValue { line: usize, text: String },
    #[error("the header has no `inDegrees=yes` or `inDegrees=no`: the unit of angles is unknown")]
    NoAngleUnit,
    #[error("holds {kind}, but a motion needs positions: take the table of positions beside it")]
    Rates { kind: &'static str },
    #[error(
        "has no poses of bodies (columns NAME_X, NAME_Y, NAME_Z, NAME_Ox, NAME_Oy, NAME_Oz); from joint coordinates OpenSim's analysis BodyKinematics computes them"
    )]
    NoBodyPoses,
    #[error("has no column '{name}'")]
    MissingColumn { name: String },
    #[error("has no commas between its columns, but {found}: save it with commas")]
    NoCommas { found: &'static str },
    #[error("has the columns 'qw' and 'r11': a rotation is a quaternion or a matrix, not both")]
    TwoRotations,
    #[error("has the column '{name}' more than once")]
    DuplicateColumn { name: String },
    #[error("line {line} has {found} columns, but {expected} are declared")]
    ColumnCount { line: usize, found: usize, expected: usize },
    #[error("has {found} rows, but its header declares {expected}: the file may be cut")]
    RowCount { found: usize, expected: usize },
    #[error("line {line}, column '{column}': '{text}' is not a finite number")]
    NotANumber { line: usize, column: String, text: String },
    #[error(
        "line {line}, column 'time': {time}, but times must rise: that of the row before is {last}{advice}"
    )]
    TimeOrder { line: usize, time: f64, last: f64, advice: &'static str },
    #[error("line {line}, column 'body': '{name}' has a pose at time {time} already")]
    DuplicateBody { line: usize, name: String, time: f64 },
    #[error("line {line}: the quaternion has length {length}, but that of a rotation is 1")]
    NotUnit { line: usize, length: f64 },
    #[error("line {line}: the matrix is not a rotation: it mirrors")]
    Mirrors { line: usize },
    #[error(
        "line {line}: the matrix is not a rotation: it changes lengths or angles by {change:.1e}"
    )]
    NotRotation { line: usize, change: f64 },
}

impl PoseTable {
    pub(super) fn frame_count(&self) -> usize {
        self.times.len()
    }

    /// Adds the frame that begins at a line; times must rise.
    pub(super) fn push(
        &mut self,
        line: usize,
        time: f64,
        poses: BTreeMap<String, DMat4>,
    ) -> Result<(), TableProblem> {
        if let Some(&last) = self.times.last()
            && time <= last
        {
            return Err(TableProblem::TimeOrder { line, time, last, advice: "" });
        }
        self.times.push(time);
        self.poses.push(poses);
        Ok(())
    }

    /// Computes the maps from rest of all frames, with lengths times a factor.
    ///
    /// Where meshes stand as in the first pose, any point of a body may be the origin of its poses:
    /// it drops out of the map from the first pose to a later one.
    pub(super) fn maps(self, factor: f64, meshes: MeshFrame) -> Vec<BTreeMap<String, DMat4>> {
        let mut frames = self.poses;
        for pose in frames.iter_mut().flat_map(BTreeMap::values_mut) {
            let position = pose.w_axis.truncate() * factor;
            pose.w_axis = position.extend(1.0);
        }
        if meshes == MeshFrame::Body || frames.is_empty() {
            return frames;
        }

        // Nothing moves in the first frame, not even by rounding.
        let first = frames[0].clone();
        frames[0].values_mut().for_each(|map| *map = DMat4::IDENTITY);
        for frame in &mut frames[1..] {
            for (name, pose) in frame {
                // A body that the first frame lacks is refused with the names of all frames.
                let Some(rest) = first.get(name) else { continue };
                *pose *= rigid_inverse(*rest);
            }
        }
        frames
    }
}

/// Returns the inverse of a rigid map, by the transpose of its rotation.
fn rigid_inverse(map: DMat4) -> DMat4 {
    let rotation = glam::DMat3::from_mat4(map).transpose();
    DMat4::from_mat3_translation(rotation, -(rotation * map.w_axis.truncate()))
}

/// Parses a finite number of a table.
pub(super) fn finite_number(line: usize, column: &str, text: &str) -> Result<f64, TableProblem> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(TableProblem::NotANumber {
            line,
            column: mesh_io::escaped(column),
            text: mesh_io::escaped(text),
        }),
    }
}
