//! Wavefront OBJ: the positions (`v`) and faces (`f`) of all objects and groups as one mesh; objects (`o`) are counted.
//!
//! A statement is a line, and those below it while lines end with a backslash; a comment ends it.
//!
//! This reader is not a crate's, because places matter: known crates renumber
//! vertices per group and use, and their errors name no line.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::str::FromStr;

use glam::DVec3;

use crate::copy::{Copy, Precision, check_count, check_range, position as position_of};
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::text::{Lines, PlacedWord, number, placed_words, quoted};
use crate::{ReadError, Space};

const OBJ: Format = Format { name: "OBJ", remedy: "save it as PLY" };

/// Returns a surface as a file, with as many digits as distinguish the coordinates.
pub(crate) fn encode(positions: &[DVec3], faces: &[[u32; 3]], space: Option<Space>) -> Vec<u8> {
    let mut file = space.map_or_else(String::new, |space| format!("# {}\n", space.statement()));

    // Writing to a string cannot fail. The form with {:?} has an exponent where it is shorter.
    for DVec3 { x, y, z } in positions {
        let _ = writeln!(file, "v {x:?} {y:?} {z:?}");
    }
    // The file counts from 1.
    for [a, b, c] in faces.iter().map(|face| face.map(|corner| u64::from(corner) + 1)) {
        let _ = writeln!(file, "f {a} {b} {c}");
    }
    file.into_bytes()
}

/// Writes a file with other positions; weights and colors behind them stay.
pub(crate) fn replace(file: &[u8], positions: &[DVec3]) -> Result<Vec<u8>, ReadError> {
    // Vertices are the lines that begin with v, as the reader counts them.
    let mut copy = Copy::new(file);
    let (mut statements, mut words, mut vertex) = (Statements::new(file), Vec::new(), 0);
    while statements.read_next(&mut words).is_some() {
        let Some((keyword, values)) = words.split_first() else { continue };
        if keyword.text != b"v" {
            continue;
        }
        let x = position_of(&OBJ, positions, vertex)?;
        for (word, value) in values.iter().zip(x.to_array()) {
            copy.put_number(word.place.clone(), value, Precision::Double);
        }
        vertex += 1;
    }
    check_count(vertex, positions)?;
    check_range(Precision::Double, positions, 0)?;
    Ok(copy.finish())
}

/// Reads the vertices and faces of an OBJ file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let (mut positions, mut polygons) = (Vec::new(), Polygons::default());
    let (mut corners, mut object, mut objects) = (Vec::new(), None, BTreeSet::new());

    // Words other than these concern normals, groups, materials and the like.
    let (mut statements, mut words) = (Statements::new(bytes), Vec::new());
    while let Some(line) = statements.read_next(&mut words) {
        let Some((keyword, values)) = words.split_first() else { continue };
        match keyword.text {
            b"v" => positions.push(position(line, values)?),
            b"f" => {
                corners.clear();
                for word in values {
                    corners.push(corner(line, word.text, positions.len())?);
                }
                polygons.push(corners.iter().copied());
                objects.extend(object.take());
            }
            b"o" => object = Some(values.iter().map(|word| word.text).collect::<Vec<_>>()),
            _ => {}
        }
    }

    let mesh = Mesh::assemble(positions, &polygons)?;
    let object_count = objects.len().max(1);
    Ok(Mesh { space: Space::in_first_comments(bytes), object_count, ..mesh })
}

/// Statements of a file.
#[derive(Debug)]
struct Statements<'a> {
    lines: Lines<'a>,
}

impl<'a> Statements<'a> {
    fn new(file: &'a [u8]) -> Self {
        Self { lines: Lines::new(file) }
    }

    /// Replaces the content of `words` by the words of the next statement, and returns the number of its
    /// first line; `None` behind the last.
    fn read_next(&mut self, words: &mut Vec<PlacedWord<'a>>) -> Option<usize> {
        words.clear();
        let first = self.lines.next()?;
        let mut next = Some(first);
        while let Some(line) = next {
            let text = line.text.split(|&byte| byte == b'#').next().unwrap_or_default();
            let going_on = text.trim_ascii_end().strip_suffix(b"\\");
            words.extend(placed_words(going_on.unwrap_or(text), line.start));
            next = going_on.and_then(|_| self.lines.next());
        }
        Some(first.number)
    }
}

/// Reads three coordinates; a weight or a color behind them is skipped.
fn position(line: usize, words: &[PlacedWord<'_>]) -> Result<DVec3, ReadError> {
    let mut position = DVec3::ZERO;
    for axis in 0..3 {
        let Some(word) = words.get(axis) else {
            return Err(OBJ.on_line(line, "a vertex needs three coordinates"));
        };
        position[axis] = number_on(line, word.text)?;
    }
    Ok(position)
}

/// Returns the vertex index of `vertex`, `vertex/texture` or `vertex/texture/normal`.
///
/// The file counts from 1, or, where negative, backwards from the `count` vertices
/// above the line.
fn corner(line: usize, word: &[u8], count: usize) -> Result<i64, ReadError> {
    let vertex = word.split(|&byte| byte == b'/').next().unwrap_or_default();
    let index: i64 = number_on(line, vertex)?;
    if index == 0 {
        return Err(OBJ.on_line(line, "vertex 0 does not exist: OBJ counts from 1"));
    }
    if index > 0 {
        return Ok(index - 1);
    }

    // A sum below zero, or beyond the range of i64, is no vertex.
    let count = i64::try_from(count).unwrap_or(i64::MAX);
    match count.checked_add(index) {
        Some(absolute) if absolute >= 0 => Ok(absolute),
        _ => Err(OBJ.on_line(line, format!("there is no vertex {index} above it"))),
    }
}

fn number_on<T: FromStr>(line: usize, word: &[u8]) -> Result<T, ReadError> {
    match number(word) {
        Some(number) => Ok(number),
        None => Err(OBJ.on_line(line, format!("{} is not a number", quoted(word)))),
    }
}
