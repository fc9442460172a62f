//! Wavefront OBJ: the positions (`v`) and faces (`f`) of all its groups as one
//! mesh.
//!
//! Read here rather than through a crate because places matter: the known
//! crates renumber vertices by group and use, and their errors name no line.

use glam::DVec3;

use super::MeshError;
use super::mesh::{Mesh, Polygons, assemble};

/// Reads an OBJ file's vertices and faces.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut positions = Vec::new();
    let mut polygons = Polygons::default();
    let mut corners = Vec::new();
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
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
    assemble(positions, &polygons)
}

/// The three coordinates; a weight or a colour behind them is not needed.
fn position<'a>(
    line: usize,
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<DVec3, MeshError> {
    let mut coordinate = || match words.next() {
        Some(word) => number(word).ok_or_else(|| not_a_number(line, word)),
        None => Err(malformed(line, "a vertex needs three coordinates".to_owned())),
    };
    Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}

/// The vertex of `vertex`, `vertex/texture` or `vertex/texture/normal`. Files
/// count from 1, or backwards from the vertices `so_far` where negative.
fn corner(line: usize, word: &[u8], so_far: usize) -> Result<i64, MeshError> {
    let vertex = word.split(|&byte| byte == b'/').next().unwrap_or(word);
    match number::<i64>(vertex) {
        Some(0) => Err(malformed(line, "vertex 0 does not exist: OBJ counts from 1".to_owned())),
        Some(index) if index > 0 => Ok(index - 1),
        Some(index) => i64::try_from(so_far)
            .ok()
            .and_then(|so_far| so_far.checked_add(index))
            .filter(|vertex| *vertex >= 0)
            .ok_or_else(|| malformed(line, format!("there is no vertex {index} before it"))),
        None => Err(not_a_number(line, vertex)),
    }
}

fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn not_a_number(line: usize, word: &[u8]) -> MeshError {
    malformed(line, format!("'{}' is not a number", String::from_utf8_lossy(word)))
}

fn malformed(line: usize, problem: String) -> MeshError {
    MeshError::Malformed { format: "OBJ", place: format!("line {line}"), problem }
}
