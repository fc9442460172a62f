//! STL, ascii and binary: loose triangles, whose corners are merged where all
//! three coordinates are equal.
//!
//! Read here rather than through a crate because many binary files begin with
//! the word that is meant to mark ascii ones, and ascii coordinates deserve
//! double precision. A file is binary if its length is the one its count of
//! facets asks for, whatever its first word.

use std::collections::HashMap;

use glam::DVec3;

use super::MeshError;
use super::mesh::{Mesh, Polygons, assemble};

/// Whether the content, without an extension to help, can be taken for STL.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(b"solid") || has_binary_length(bytes)
}

/// Reads an STL file's facets.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let is_text = bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0);
    if is_text && !has_binary_length(bytes) { parse_ascii(bytes) } else { parse_binary(bytes) }
}

/// Free text, then the count of facets.
const HEADER: usize = 84;
/// Normal, three corners, two bytes of attributes.
const FACET: usize = 50;

fn declared_facets(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

fn has_binary_length(bytes: &[u8]) -> bool {
    declared_facets(bytes).is_some_and(|facets| bytes.len() == HEADER + FACET * facets)
}

fn parse_binary(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let Some(declared) = declared_facets(bytes) else {
        let problem = format!("{HEADER} bytes expected, the file has {}", bytes.len());
        return Err(malformed("header", problem));
    };
    let (facets, _) = bytes[HEADER..].as_chunks::<FACET>();
    if facets.len() < declared {
        let problem = format!("the file ends here, but declares {declared} facets");
        return Err(malformed(&format!("facet {}", facets.len()), problem));
    }
    let mut merged = Merged::default();
    for facet in &facets[..declared] {
        merged.push_facet([12, 24, 36].map(|corner| {
            let float = |at: usize| {
                f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]])
            };
            DVec3::new(float(corner).into(), float(corner + 4).into(), float(corner + 8).into())
        }));
    }
    assemble(merged.positions, &merged.polygons)
}

fn parse_ascii(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut merged = Merged::default();
    let mut facet = Vec::new();
    let (mut ended, mut last_line) = (false, 0);
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let keyword = words.next().map(<[u8]>::to_ascii_lowercase);
        match keyword.as_deref() {
            Some(b"vertex") => facet.push(corner(line, words)?),
            Some(b"endfacet") => merged.push_facet(three(line, &std::mem::take(&mut facet))?),
            Some(b"solid") => ended = false,
            Some(b"endsolid") => ended = true,
            None | Some(b"facet" | b"outer" | b"endloop") => {}
            Some(word) => {
                let word = String::from_utf8_lossy(word).into_owned();
                return Err(malformed(&format!("line {line}"), format!("unknown word '{word}'")));
            }
        }
        last_line = line;
    }
    if !ended || !facet.is_empty() {
        let problem = "the file ends without 'endsolid'".to_owned();
        return Err(malformed(&format!("line {last_line}"), problem));
    }
    assemble(merged.positions, &merged.polygons)
}

fn corner<'a>(line: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<DVec3, MeshError> {
    let numbers: Option<Vec<f64>> =
        words.map(|word| std::str::from_utf8(word).ok()?.parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => {
            let problem = "a vertex needs three coordinates".to_owned();
            Err(malformed(&format!("line {line}"), problem))
        }
    }
}

fn three(line: usize, facet: &[DVec3]) -> Result<[DVec3; 3], MeshError> {
    facet.try_into().map_err(|_| {
        let problem = format!("a facet has three vertices, this one has {}", facet.len());
        malformed(&format!("line {line}"), problem)
    })
}

/// Corners that are numbered in order of first appearance.
#[derive(Debug, Default)]
struct Merged {
    numbers: HashMap<[u64; 3], i64>,
    positions: Vec<DVec3>,
    polygons: Polygons,
}

impl Merged {
    fn push_facet(&mut self, corners: [DVec3; 3]) {
        let corners = corners.map(|corner| self.number(corner));
        self.polygons.push(corners);
    }

    fn number(&mut self, corner: DVec3) -> i64 {
        // Adding 0 turns −0 into 0, so that equal coordinates have equal bits.
        let bits = corner.to_array().map(|coordinate| (coordinate + 0.0).to_bits());
        let next = i64::try_from(self.positions.len()).unwrap_or(i64::MAX);
        *self.numbers.entry(bits).or_insert_with(|| {
            self.positions.push(corner);
            next
        })
    }
}

fn malformed(place: &str, problem: String) -> MeshError {
    MeshError::Malformed { format: "STL", place: place.to_owned(), problem }
}
