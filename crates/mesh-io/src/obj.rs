//! Wavefront OBJ: the positions (`v`) and faces (`f`) of all groups as one mesh.
//!
//! This reader is not a crate's, because places matter: known crates renumber
//! vertices per group and use, and their errors name no line.

use std::fmt::Write;
use std::str::FromStr;

use glam::DVec3;

use crate::copy::{Copy, Precision, check_count, check_range, position as position_of};
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::text::{Line, Lines, number, placed_words, quoted, words};
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
    let mut vertex = 0;
    for line in Lines::new(file) {
        let mut words = placed_words(line.text, line.start);
        if words.next().is_none_or(|keyword| keyword.text != b"v") {
            continue;
        }
        let x = position_of(&OBJ, positions, vertex)?;
        for (word, value) in words.zip(x.to_array()) {
            copy.put_number(word.place, value, Precision::Double);
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
    let mut corners = Vec::new();

    // Words other than these two concern normals, groups, materials and the like.
    for Line { number: line, text, .. } in Lines::new(bytes) {
        let mut words = words(text);
        match words.next() {
            Some(b"v") => positions.push(position(line, words)?),
            Some(b"f") => {
                corners.clear();
                for word in words {
                    corners.push(corner(line, word, positions.len())?);
                }
                polygons.push(corners.iter().copied());
            }
            _ => {}
        }
    }

    let mesh = Mesh::assemble(positions, &polygons)?;
    Ok(Mesh { space: Space::in_first_comments(bytes), ..mesh })
}

/// Reads three coordinates; a weight or a color behind them is skipped.
fn position<'a>(
    line: usize,
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<DVec3, ReadError> {
    let mut position = DVec3::ZERO;
    for axis in 0..3 {
        let Some(word) = words.next() else {
            return Err(OBJ.on_line(line, "a vertex needs three coordinates"));
        };
        position[axis] = number_on(line, word)?;
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
