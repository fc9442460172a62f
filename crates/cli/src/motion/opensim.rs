//! Body kinematics of OpenSim: tables (`.sto`, `.mot`) of positions and orientations of bodies.
//!
//! ```text
//! Positions
//! nRows=2
//! nColumns=7
//! inDegrees=yes
//! endheader
//! time  femur_r_X  femur_r_Y  femur_r_Z  femur_r_Ox  femur_r_Oy  femur_r_Oz
//! 0.00  0.08  0.91  0.09  0.0  0.0   0.0
//! 0.01  0.09  0.91  0.09  0.5  0.1  12.0
//! ```
//!
//! This is what OpenSim's analysis `BodyKinematics` writes. Positions are those of the mass
//! centers, in meters. Orientations are rotations about the body's x, then its turned y, then its
//! turned z axis. Columns may stand in any order; those without an orientation are ignored.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::{DMat4, DQuat, DVec3};

use super::pose_table::{PoseTable, TableProblem};

/// Suffixes of the six columns of a body.
const SUFFIXES: [&str; 6] = ["_X", "_Y", "_Z", "_Ox", "_Oy", "_Oz"];

/// First line of tables of the same columns that hold no positions.
const RATES: [&str; 2] = ["Velocities", "Accelerations"];

/// Header of a table.
#[derive(Debug, Default)]
struct Header {
    /// Factor that makes radians.
    radians: Option<f64>,
    rows: Option<usize>,
    columns: Option<usize>,
}

/// Columns of one body, in the order of the suffixes.
struct BodyColumns<'a> {
    name: &'a str,
    columns: [usize; 6],
}

/// Parses a table; its lengths stay in the table's unit.
pub(super) fn parse(text: &str) -> Result<PoseTable, TableProblem> {
    let mut lines = (1..).zip(text.lines());
    let header = Header::read(&mut lines)?;

    // Labels follow the header.
    let (line, labels) =
        lines.find(|(_, line)| !line.trim().is_empty()).ok_or(TableProblem::NoLabels)?;
    let labels: Vec<&str> = labels.split_whitespace().collect();
    if let Some(declared) = header.columns
        && declared != labels.len()
    {
        return Err(TableProblem::ColumnCount { line, found: labels.len(), expected: declared });
    }
    let time = time_column(&labels)?;
    let bodies = body_columns(&labels)?;
    let radians = header.radians.ok_or(TableProblem::NoAngleUnit)?;

    // Each row is a frame.
    let mut table = PoseTable::default();
    for (line, row) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let values = numbers(line, row, &labels)?;
        let mut maps = BTreeMap::new();
        for body in &bodies {
            maps.insert(body.name.to_owned(), body.pose(&values, radians));
        }
        table.push(line, values[time], maps)?;
    }

    // A table that ends early has lost its end.
    let found = table.frame_count();
    match header.rows {
        Some(declared) if declared != found => {
            Err(TableProblem::RowCount { found, expected: declared })
        }
        _ => Ok(table),
    }
}

impl Header {
    /// Reads the lines up to `endheader`.
    fn read<'a>(lines: &mut impl Iterator<Item = (usize, &'a str)>) -> Result<Self, TableProblem> {
        let mut header = Self::default();
        for (line, text) in lines {
            let text = text.trim();
            if text.eq_ignore_ascii_case("endheader") {
                return Ok(header);
            }
            if let Some(&kind) = RATES.iter().find(|kind| kind.eq_ignore_ascii_case(text)) {
                return Err(TableProblem::Rates { kind });
            }

            // Other keys do not matter to poses.
            let Some((key, value)) = text.split_once('=') else { continue };
            let (key, value) = (key.trim().to_lowercase(), value.trim());
            let problem = || TableProblem::HeaderValue { line, text: mesh_io::escaped(text) };
            match key.as_str() {
                "indegrees" => {
                    header.radians = Some(match value.to_lowercase().as_str() {
                        "yes" => PI / 180.0,
                        "no" => 1.0,
                        _ => return Err(problem()),
                    });
                }
                "nrows" | "datarows" => {
                    let Ok(rows) = value.parse() else { return Err(problem()) };
                    header.rows = Some(rows);
                }
                "ncolumns" | "datacolumns" => {
                    let Ok(columns) = value.parse() else { return Err(problem()) };
                    header.columns = Some(columns);
                }
                _ => {}
            }
        }
        Err(TableProblem::NoEndOfHeader)
    }
}

/// Finds the column of times, without regard to case.
fn time_column(labels: &[&str]) -> Result<usize, TableProblem> {
    let mut places = (0..labels.len()).filter(|&i| labels[i].eq_ignore_ascii_case("time"));
    let name = || "time".to_owned();
    let column = places.next().ok_or_else(|| TableProblem::MissingColumn { name: name() })?;
    match places.next() {
        Some(_) => Err(TableProblem::DuplicateColumn { name: name() }),
        None => Ok(column),
    }
}

/// Finds the columns of every body that has a position and an orientation, in the order of the
/// names.
fn body_columns<'a>(labels: &[&'a str]) -> Result<Vec<BodyColumns<'a>>, TableProblem> {
    // All columns of one name, by suffix.
    let mut found: BTreeMap<&str, [Option<usize>; 6]> = BTreeMap::new();
    for (column, label) in labels.iter().enumerate() {
        for (suffix, text) in SUFFIXES.iter().enumerate() {
            let Some(name) = label.strip_suffix(text) else { continue };
            if found.entry(name).or_default()[suffix].replace(column).is_some() {
                return Err(TableProblem::DuplicateColumn { name: mesh_io::escaped(label) });
            }
        }
    }

    let mut bodies = Vec::new();
    for (name, columns) in found {
        // Points, as the center of mass of the whole body, have no orientation.
        if columns[3..].iter().all(Option::is_none) {
            continue;
        }
        let mut complete = [0; 6];
        for (suffix, column) in columns.into_iter().enumerate() {
            let Some(column) = column else {
                let name = mesh_io::escaped(&format!("{name}{}", SUFFIXES[suffix]));
                return Err(TableProblem::MissingColumn { name });
            };
            complete[suffix] = column;
        }
        bodies.push(BodyColumns { name, columns: complete });
    }

    if bodies.is_empty() {
        return Err(TableProblem::NoBodyPoses);
    }
    Ok(bodies)
}

/// Parses all values of a row.
fn numbers(line: usize, row: &str, labels: &[&str]) -> Result<Vec<f64>, TableProblem> {
    let words: Vec<&str> = row.split_whitespace().collect();
    if words.len() != labels.len() {
        return Err(TableProblem::ColumnCount { line, found: words.len(), expected: labels.len() });
    }

    let mut values = Vec::with_capacity(words.len());
    for (word, label) in words.into_iter().zip(labels) {
        values.push(super::pose_table::finite_number(line, label, word)?);
    }
    Ok(values)
}

impl BodyColumns<'_> {
    fn pose(&self, values: &[f64], radians: f64) -> DMat4 {
        let [x, y, z, about_x, about_y, about_z] = self.columns.map(|column| values[column]);

        // Rotations about turned axes multiply from the left to the right.
        let rotation = DQuat::from_rotation_x(about_x * radians)
            * DQuat::from_rotation_y(about_y * radians)
            * DQuat::from_rotation_z(about_z * radians);
        DMat4::from_rotation_translation(rotation, DVec3::new(x, y, z))
    }
}
