//! Wavefront OBJ: the positions (`v`) and faces (`f`) of all groups as one mesh.
//!
//! This reader is not a crate's, because places matter: known crates renumber
//! vertices per group and use, and their errors name no line.

use std::str::FromStr;

use glam::DVec3;

use crate::mesh::{Mesh, Polygons};
use crate::text::{number, words};
use crate::{FilePlace, ReadError};

/// Reads the vertices and faces of an OBJ file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut positions = Vec::new();
    let mut polygons = Polygons::default();
    let mut corners = Vec::new();
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
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
    Mesh::assemble(positions, &polygons)
}

/// Reads three coordinates; a weight or a color behind them is skipped.
fn position<'a>(
    line: usize,
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<DVec3, ReadError> {
    let mut position = DVec3::ZERO;
    for axis in 0..3 {
        let Some(word) = words.next() else {
            return Err(malformed(line, "a vertex needs three coordinates"));
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
    let end = word.iter().position(|&byte| byte == b'/').unwrap_or(word.len());
    let index: i64 = number_on(line, &word[..end])?;
    if index == 0 {
        return Err(malformed(line, "vertex 0 does not exist: OBJ counts from 1"));
    }
    if index > 0 {
        return Ok(index - 1);
    }

    // A sum below zero, or beyond the range of i64, is no vertex.
    let count = i64::try_from(count).unwrap_or(i64::MAX);
    match count.checked_add(index) {
        Some(absolute) if absolute >= 0 => Ok(absolute),
        _ => Err(malformed(line, format!("there is no vertex {index} above it"))),
    }
}

fn number_on<T: FromStr>(line: usize, word: &[u8]) -> Result<T, ReadError> {
    let problem = || format!("'{}' is not a number", String::from_utf8_lossy(word));
    number(word).ok_or_else(|| malformed(line, problem()))
}

fn malformed(line: usize, problem: impl Into<String>) -> ReadError {
    ReadError::malformed("OBJ", FilePlace::Line(line), problem)
}
