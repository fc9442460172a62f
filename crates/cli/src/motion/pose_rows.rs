//! Tables of poses, a row per body and time, separated by commas (`.csv`).
//!
//! ```text
//! time,body,qw,qx,qy,qz,x,y,z
//! 0.00,femur,1,0,0,0,0,0,0
//! 0.00,tibia,1,0,0,0,0,0,0
//! 0.01,femur,0.99619470,0.08715574,0,0,0,0,0.5
//! 0.01,tibia,1,0,0,0,0,0,1
//! ```
//!
//! Instead of the quaternion, the rotation matrix may stand in `r11`, `r12` … `r33`. Columns stand
//! in any order, and others are ignored. Rows of one time are a frame.

use std::collections::BTreeMap;

use csv::{ErrorKind, Position, ReaderBuilder, StringRecord, Trim};
use glam::{DMat3, DMat4, DQuat, DVec3};

use super::pose_table::{PoseTable, TableProblem, finite_number};

/// Names of the columns of a rotation matrix, row by row.
const MATRIX: [&str; 9] = ["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];

/// Largest deviation of a quaternion's length from 1, and of a matrix from a rotation: files round to some three digits
/// at least, and other numbers than those of a rotation are farther from it.
const UNIT_TOLERANCE: f64 = 1e-2;

/// Deviation of a matrix up to which it is taken as it is: its digits are all of its number type.
const EXACT: f64 = 1e-12;

/// Places of the columns that are read.
struct Columns {
    time: usize,
    body: usize,
    position: [usize; 3],
    rotation: RotationColumns,
}

enum RotationColumns {
    /// In the order w, x, y, z.
    Quaternion([usize; 4]),
    Matrix([usize; 9]),
}

/// Row that is being read.
struct Row<'a> {
    line: usize,
    labels: &'a StringRecord,
    values: &'a StringRecord,
}

/// Parses a table whose lines end with line feeds; its lengths stay in the table's unit.
pub(super) fn parse(text: &str) -> Result<PoseTable, TableProblem> {
    let mut reader =
        ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let labels = reader.headers().map_err(|error| malformed(text, error))?.clone();
    let columns = Columns::find(&labels)?;

    // Rows of one time are gathered until the time changes.
    let mut table = PoseTable::default();
    let mut frame: Option<(usize, f64, BTreeMap<String, DMat4>)> = None;
    for values in reader.records() {
        let values = values.map_err(|error| malformed(text, error))?;
        let line = values.position().map_or(0, |start| line_of(text, start));
        let row = Row { line, labels: &labels, values: &values };
        let (time, pose) = (row.number(columns.time)?, columns.pose(&row)?);
        let name = &values[columns.body];

        match &mut frame {
            Some((_, of_frame, maps)) if time.total_cmp(of_frame).is_eq() => {
                if maps.insert(name.to_owned(), pose).is_some() {
                    let name = mesh_io::escaped(name);
                    return Err(TableProblem::DuplicateBody { line, name, time });
                }
            }
            _ => {
                let maps = BTreeMap::from([(name.to_owned(), pose)]);
                if let Some((line, time, maps)) = frame.replace((line, time, maps)) {
                    push(&mut table, line, time, maps)?;
                }
            }
        }
    }
    if let Some((line, time, maps)) = frame {
        push(&mut table, line, time, maps)?;
    }
    Ok(table)
}

/// Adds a frame; where its time is not later, rows may be sorted otherwise.
fn push(
    table: &mut PoseTable,
    line: usize,
    time: f64,
    maps: BTreeMap<String, DMat4>,
) -> Result<(), TableProblem> {
    table.push(line, time, maps).map_err(|problem| match problem {
        TableProblem::TimeOrder { line, time, last, .. } => {
            let advice = "; rows of one time stand together, those of all bodies";
            TableProblem::TimeOrder { line, time, last, advice }
        }
        other => other,
    })
}

/// Returns the problem of a table that the reader refuses.
fn malformed(text: &str, error: csv::Error) -> TableProblem {
    if let ErrorKind::UnequalLengths { pos: Some(start), expected_len, len } = error.kind() {
        let [found, expected] = [*len, *expected_len].map(to_usize);
        return TableProblem::ColumnCount { line: line_of(text, start), found, expected };
    }
    TableProblem::Malformed(mesh_io::escaped(&error.to_string()))
}

/// Returns the line of a record, for which the reader begins to look at a place: it passes over
/// blank lines and comments.
fn line_of(text: &str, start: &Position) -> usize {
    let rest = text.get(to_usize(start.byte())..).unwrap_or_default();
    let is_passed_over = |line: &&str| line.is_empty() || line.starts_with('#');
    to_usize(start.line()) + rest.lines().take_while(is_passed_over).count()
}

fn to_usize(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

impl Columns {
    fn find(labels: &StringRecord) -> Result<Self, TableProblem> {
        let separators = [(';', "semicolons"), ('\t', "tabs")];
        let separator =
            separators.iter().find(|(it, _)| labels.len() == 1 && labels[0].contains(*it));
        if let Some((_, found)) = separator {
            return Err(TableProblem::NoCommas { found });
        }
        let has = |name: &str| labels.iter().any(|label| label.eq_ignore_ascii_case(name));
        let has_matrix = has(MATRIX[0]);
        if has_matrix && has("qw") {
            return Err(TableProblem::TwoRotations);
        }
        let rotation = if has_matrix {
            RotationColumns::Matrix(columns(labels, MATRIX)?)
        } else {
            RotationColumns::Quaternion(columns(labels, ["qw", "qx", "qy", "qz"])?)
        };
        let [time, body] = columns(labels, ["time", "body"])?;
        Ok(Self { time, body, position: columns(labels, ["x", "y", "z"])?, rotation })
    }

    fn pose(&self, row: &Row<'_>) -> Result<DMat4, TableProblem> {
        let position = DVec3::from(row.numbers(self.position)?);
        let rotation = match self.rotation {
            RotationColumns::Quaternion(columns) => {
                let [w, x, y, z] = row.numbers(columns)?;
                let quaternion = DQuat::from_xyzw(x, y, z, w);

                // The error of rounded digits is divided out.
                let length = quaternion.length();
                if (length - 1.0).abs() > UNIT_TOLERANCE {
                    return Err(TableProblem::NotUnit { line: row.line, length });
                }
                DMat3::from_quat(quaternion.normalize())
            }
            RotationColumns::Matrix(columns) => {
                let matrix = DMat3::from_cols_array(&row.numbers(columns)?).transpose();
                rotation_near(matrix, row.line)?
            }
        };
        Ok(DMat4::from_mat3_translation(rotation, position))
    }
}

/// Returns the rotation next to a matrix, the error of whose rounded digits is divided out.
fn rotation_near(matrix: DMat3, line: usize) -> Result<DMat3, TableProblem> {
    let residue = matrix.transpose() * matrix - DMat3::IDENTITY;
    let change = residue.to_cols_array().into_iter().fold(0.0, |max: f64, it| max.max(it.abs()));
    if change > UNIT_TOLERANCE {
        return Err(TableProblem::NotRotation { line, change });
    }
    if matrix.determinant() < 0.0 {
        return Err(TableProblem::Mirrors { line });
    }
    if change <= EXACT {
        return Ok(matrix);
    }
    Ok(DMat3::from_quat(DQuat::from_mat3(&matrix).normalize()))
}

/// Finds columns by their names, without regard to case.
fn columns<const N: usize>(
    labels: &StringRecord,
    names: [&str; N],
) -> Result<[usize; N], TableProblem> {
    let mut found = [0; N];
    for (column, name) in found.iter_mut().zip(names) {
        let mut places = (0..labels.len()).filter(|&i| labels[i].eq_ignore_ascii_case(name));
        let missing = || TableProblem::MissingColumn { name: name.to_owned() };
        *column = places.next().ok_or_else(missing)?;
        if places.next().is_some() {
            return Err(TableProblem::DuplicateColumn { name: name.to_owned() });
        }
    }
    Ok(found)
}

impl Row<'_> {
    fn number(&self, column: usize) -> Result<f64, TableProblem> {
        finite_number(self.line, &self.labels[column], &self.values[column])
    }

    fn numbers<const N: usize>(&self, columns: [usize; N]) -> Result<[f64; N], TableProblem> {
        let mut values = [0.0; N];
        for (value, column) in values.iter_mut().zip(columns) {
            *value = self.number(column)?;
        }
        Ok(values)
    }
}
