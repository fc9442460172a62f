//! Legacy VTK files (`.vtk`), as text or binary: polygonal data and unstructured grids.
//!
//! Sections stand one after the other without an index: all before the last cells are passed in
//! order, and values at points and cells, which follow, are not read.
//!
//! Source: "VTK File Formats", section "Simple legacy formats".

use glam::DVec3;

use super::elements::GridElements;
use super::legacy_reader::{LEGACY, Place, Points, Reader};
use super::piece::CellPoints;
use crate::copy::{Copy, Precision, check_count, check_range};
use crate::mesh::{Mesh, Polygons};
use crate::stored_values::single;
use crate::text::quoted;
use crate::volume::NumberedNodes;
use crate::{ReadError, Space};

/// Returns true if a file begins as all legacy files do.
pub(crate) fn is_legacy(bytes: &[u8]) -> bool {
    const BEGINNING: &[u8] = b"# vtk datafile version";
    bytes.get(..BEGINNING.len()).is_some_and(|start| start.eq_ignore_ascii_case(BEGINNING))
}

/// Reads the points and cells of a legacy file.
pub(crate) fn parse_legacy(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let LegacyFile { points, cells, space } = LegacyFile::parse(bytes)?;
    let mesh = match cells {
        LegacyCells::Polygons(polygons) => Mesh::assemble(points.positions, &polygons)?,
        LegacyCells::Grid { cells, types } => {
            let mut elements = GridElements::default();
            for (points, &kind) in cells.iter().zip(&types) {
                let malformed = |problem| LEGACY.in_section("CELLS", problem);
                elements.push(&LEGACY, kind, points, malformed)?;
            }
            let numbers = (0..points.positions.len() as u64).collect();
            let nodes = NumberedNodes { positions: points.positions, numbers };
            elements.into_mesh(&LEGACY, nodes)?
        }
    };
    Ok(Mesh { space, ..mesh })
}

/// Returns the number type of the points.
pub(crate) fn legacy_precision(bytes: &[u8]) -> Result<Precision, ReadError> {
    Ok(LegacyFile::parse(bytes)?.points.precision)
}

/// Writes a file with other points.
pub(crate) fn replace_legacy(bytes: &[u8], positions: &[DVec3]) -> Result<Vec<u8>, ReadError> {
    let Points { positions: before, precision, place } = LegacyFile::parse(bytes)?.points;
    check_count(before.len(), positions)?;
    check_range(precision, positions, 0)?;

    let mut copy = Copy::new(bytes);
    let coordinates = positions.iter().flat_map(DVec3::to_array);
    match place {
        Place::Words(words) => {
            for (word, value) in words.into_iter().zip(coordinates) {
                copy.put_number(word, value, precision);
            }
        }
        Place::Block(block) if precision == Precision::Single => {
            let numbers: Vec<[u8; 4]> = coordinates.map(|x| single(x).to_be_bytes()).collect();
            copy.put(block, numbers.as_flattened());
        }
        Place::Block(block) => {
            let numbers: Vec<[u8; 8]> = coordinates.map(f64::to_be_bytes).collect();
            copy.put(block, numbers.as_flattened());
        }
    }
    Ok(copy.finish())
}

/// Content of a file, as far as it is read.
#[derive(Debug)]
struct LegacyFile {
    points: Points,
    cells: LegacyCells,
    space: Option<Space>,
}

#[derive(Debug)]
enum LegacyCells {
    Polygons(Polygons),
    Grid { cells: CellPoints, types: Vec<i64> },
}

impl LegacyFile {
    fn parse(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut reader = Reader::after_header(bytes)?;
        let kind = reader.keyword()?.to_ascii_uppercase();
        let is_grid = match &kind[..] {
            b"POLYDATA" => false,
            b"UNSTRUCTURED_GRID" => true,
            _ => return Err(LEGACY.unsupported(format!("data of type {}", quoted(kind)))),
        };

        let (mut points, mut space) = (None, None);
        let (mut polygons, mut cells, mut types) =
            (Polygons::default(), CellPoints::default(), Vec::new());
        while let Some(word) = reader.word() {
            match &word.text.to_ascii_uppercase()[..] {
                b"FIELD" => space = reader.field_data()?.or(space),
                b"METADATA" => reader.pass_meta_data(),
                b"POINTS" => points = Some(reader.points()?),
                b"VERTICES" | b"LINES" => drop(reader.cells()?),
                b"POLYGONS" => {
                    for corners in reader.cells()?.iter() {
                        polygons.push(corners.iter().copied());
                    }
                }
                b"TRIANGLE_STRIPS" => match reader.cells()?.iter().count() {
                    0 => {}
                    count => return Err(LEGACY.unsupported(format!("{count} triangle strips"))),
                },
                b"CELLS" => cells = reader.cells()?,
                b"CELL_TYPES" => {
                    let count = reader.number("a number of cells")?;
                    types = reader.integers(count, 4)?;
                }
                b"POINT_DATA" | b"CELL_DATA" => break,
                other => {
                    let problem = format!("unknown keyword {}", quoted(other));
                    return Err(reader.malformed(word.place.start, problem));
                }
            }
        }

        let Some(points) = points else { return Err(LEGACY.in_section("POINTS", "is missing")) };
        let count = cells.iter().count();
        if types.len() != count {
            let problem = format!("{count} cells, but {} types", types.len());
            return Err(LEGACY.in_section("CELL_TYPES", problem));
        }
        let cells = if is_grid {
            LegacyCells::Grid { cells, types }
        } else {
            LegacyCells::Polygons(polygons)
        };
        Ok(Self { points, cells, space })
    }
}
