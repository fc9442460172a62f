//! STL, ASCII and binary: separate triangles, whose corners are merged where all three
//! coordinates are equal.
//!
//! This reader is not a crate's, because many binary files begin with the word that
//! marks ASCII files, and ASCII coordinates deserve double precision. A file is binary
//! if its length fits its number of facets, whatever its first word.

use std::collections::HashMap;
use std::fmt::Write;

use glam::DVec3;
use surface::triangle;

use crate::copy::{Copy, Precision, check_count, check_range};
use crate::error::Format;
use crate::mesh::{Mesh, Polygons, Unread};
use crate::stored_values::single;
use crate::text::{Line, Lines, number, placed_words, quoted, words};
use crate::{FilePlace, ReadError, Space};

const STL: Format = Format { name: "STL", remedy: "save it as PLY" };

/// Size of the header: free text, then the number of facets.
const HEADER: usize = 84;

/// Size of a facet: normal, three corners, two bytes of attributes.
const FACET: usize = 50;

/// Returns true if the content fits STL, where no extension says so.
pub(crate) fn is_likely(bytes: &[u8]) -> bool {
    begins_as_text(bytes) || has_binary_length(bytes)
}

/// Returns a surface as text, with as many digits as distinguish the coordinates.
pub(crate) fn encode(positions: &[DVec3], faces: &[[u32; 3]], space: Option<Space>) -> Vec<u8> {
    let statement = space.map_or_else(String::new, |space| format!(" {}", space.statement()));
    let mut file = format!("solid surface{statement}\n");

    // Writing to a string cannot fail. The form with {:?} has an exponent where it is shorter.
    for face in faces {
        let corners = face.map(|vertex| positions[vertex as usize]);
        let DVec3 { x, y, z } = triangle::normal(corners).normalize_or_zero();
        let _ = writeln!(file, "facet normal {x:?} {y:?} {z:?}\nouter loop");
        for DVec3 { x, y, z } in corners {
            let _ = writeln!(file, "vertex {x:?} {y:?} {z:?}");
        }
        file += "endloop\nendfacet\n";
    }
    (file + "endsolid surface\n").into_bytes()
}

/// Reads the facets of an STL file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let merged = if is_text(bytes) { parse_ascii(bytes)? } else { parse_binary(bytes)? };

    let mesh = Mesh::assemble(merged.positions, &merged.polygons)?;
    Ok(Mesh { unread: merged.unread, space: Space::in_text(header(bytes)), ..mesh })
}

/// Returns the text before the facets: the first line of a text file, the first 80 bytes of a binary one.
fn header(bytes: &[u8]) -> &[u8] {
    if is_text(bytes) {
        return Lines::new(bytes).next().map_or(&[], |line| line.text);
    }
    bytes.get(..HEADER - 4).unwrap_or_default()
}

/// Returns the number type of the coordinates.
pub(crate) fn precision(bytes: &[u8]) -> Precision {
    if is_text(bytes) { Precision::Double } else { Precision::Single }
}

/// Writes a file with other positions, and the normals of facets that move.
pub(crate) fn replace(file: &[u8], positions: &[DVec3]) -> Result<Vec<u8>, ReadError> {
    let mesh = parse(file)?;
    check_count(mesh.positions.len(), positions)?;
    check_range(precision(file), positions, 0)?;
    let copy = Copy::new(file);
    Ok(if is_text(file) {
        replace_text(&mesh, positions, copy)
    } else {
        replace_binary(&mesh, positions, copy)
    })
}

fn replace_text(mesh: &Mesh, positions: &[DVec3], mut copy: Copy<'_>) -> Vec<u8> {
    let (mut facet, mut corner) = (0, 0);
    for line in Lines::new(copy.file()) {
        let mut words = placed_words(line.text, line.start);
        let keyword = words.next().map(|word| word.text.to_ascii_lowercase());
        let Some(face) = mesh.faces.get(facet) else { break };
        let value = match keyword.as_deref() {
            Some(b"facet") => moved_normal(*face, mesh, positions),
            Some(b"vertex") => {
                corner += 1;
                face.get(corner - 1).map(|&vertex| positions[vertex as usize])
            }
            Some(b"endfacet") => {
                (facet, corner) = (facet + 1, 0);
                None
            }
            _ => None,
        };

        // A normal stands behind one word more.
        let skipped = usize::from(keyword.as_deref() == Some(b"facet"));
        for (word, value) in words.skip(skipped).zip(value.iter().flat_map(DVec3::to_array)) {
            copy.put_number(word.place, value, Precision::Double);
        }
    }
    copy.finish()
}

fn replace_binary(mesh: &Mesh, positions: &[DVec3], mut copy: Copy<'_>) -> Vec<u8> {
    // Files without normals have zeros there, which stay.
    for (facet, face) in mesh.faces.iter().enumerate() {
        let start = HEADER + FACET * facet;
        let stored = copy.file()[start..start + 12].iter().any(|&byte| byte != 0);
        let normal = moved_normal(*face, mesh, positions).filter(|_| stored);
        let corners = face.map(|vertex| positions[vertex as usize]);
        let at = [start, start + 12, start + 24, start + 36];
        for (at, value) in
            at.into_iter().zip([normal, Some(corners[0]), Some(corners[1]), Some(corners[2])])
        {
            if let Some(value) = value {
                let numbers = value.to_array().map(|value| single(value).to_le_bytes());
                copy.put(at..at + 12, numbers.as_flattened());
            }
        }
    }
    copy.finish()
}

/// Computes the normal of a face, if it moves.
fn moved_normal(face: [u32; 3], mesh: &Mesh, positions: &[DVec3]) -> Option<DVec3> {
    let corners = face.map(|vertex| positions[vertex as usize]);
    let before = face.map(|vertex| mesh.positions[vertex as usize]);
    (corners != before).then(|| triangle::normal(corners).normalize_or_zero())
}

/// Returns true for text, whatever the first word of a binary file.
fn is_text(bytes: &[u8]) -> bool {
    begins_as_text(bytes) && !bytes.contains(&0) && !has_binary_length(bytes)
}

/// Returns true for the first word of a text file, in any case.
fn begins_as_text(bytes: &[u8]) -> bool {
    let word = bytes.trim_ascii_start().first_chunk::<5>();
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

fn has_binary_length(bytes: &[u8]) -> bool {
    declared_facets(bytes).is_some_and(|facets| bytes.len() == HEADER + FACET * facets)
}

fn declared_facets(bytes: &[u8]) -> Option<usize> {
    Some(u32::from_le_bytes(*bytes.get(HEADER - 4..)?.first_chunk()?) as usize)
}

fn parse_binary(bytes: &[u8]) -> Result<Merged, ReadError> {
    let Some(declared) = declared_facets(bytes) else {
        let problem = format!("{HEADER} bytes expected, the file has {}", bytes.len());
        return Err(STL.in_header(problem));
    };
    let (facets, _) = bytes[HEADER..].as_chunks::<FACET>();
    if facets.len() < declared {
        let problem = format!("the file ends here, but declares {declared} facets");
        return Err(STL.malformed(FilePlace::Facet(facets.len()), problem));
    }

    let mut merged = Merged::default();
    for facet in &facets[..declared] {
        // The first three numbers are the normal, which the corners give better.
        let mut corners = [DVec3::ZERO; 3];
        for (number, bytes) in facet.as_chunks::<4>().0[3..].iter().enumerate() {
            corners[number / 3][number % 3] = f32::from_le_bytes(*bytes).into();
        }
        merged.push_facet(corners);
    }

    // More facets than declared, or bytes that are none.
    let end = HEADER + FACET * declared;
    if bytes.len() > end {
        let place = FilePlace::Byte(end as u64);
        merged.unread = Some(Unread { place, bytes: bytes.len() - end });
    }
    Ok(merged)
}

fn parse_ascii(bytes: &[u8]) -> Result<Merged, ReadError> {
    let (mut merged, mut facet) = (Merged::default(), Vec::new());
    let (mut ended, mut last_line) = (false, 0);

    // Keywords that only frame the vertices of a facet are skipped.
    for Line { number: line, text, .. } in Lines::new(bytes) {
        last_line = line;
        let mut words = words(text);
        let keyword = words.next().map(<[u8]>::to_ascii_lowercase);

        match keyword.as_deref() {
            Some(b"vertex") => facet.push(corner(line, words)?),
            Some(b"endfacet") => {
                let Ok(corners) = facet[..].try_into() else {
                    let count = facet.len();
                    let problem = format!("a facet has three vertices, this one has {count}");
                    return Err(STL.on_line(line, problem));
                };
                merged.push_facet(corners);
                facet.clear();
            }
            Some(b"solid") => ended = false,
            Some(b"endsolid") => ended = true,
            None | Some(b"facet" | b"outer" | b"endloop") => {}
            Some(word) => {
                return Err(STL.on_line(line, format!("unknown word {}", quoted(word))));
            }
        }
    }

    if !ended || !facet.is_empty() {
        return Err(STL.on_line(last_line, "the file ends without 'endsolid'"));
    }
    Ok(merged)
}

fn corner<'a>(line: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<DVec3, ReadError> {
    let numbers: Option<Vec<f64>> = words.map(number).collect();
    let Some(&[x, y, z]) = numbers.as_deref() else {
        return Err(STL.on_line(line, "a vertex needs three coordinates"));
    };
    Ok(DVec3::new(x, y, z))
}

/// Merged corners, numbered in the order of their first appearance.
#[derive(Debug, Default)]
struct Merged {
    numbers: HashMap<[u64; 3], i64>,
    positions: Vec<DVec3>,
    polygons: Polygons,
    unread: Option<Unread>,
}

impl Merged {
    fn push_facet(&mut self, corners: [DVec3; 3]) {
        let numbers = corners.map(|corner| self.number(corner));
        self.polygons.push(numbers);
    }

    fn number(&mut self, corner: DVec3) -> i64 {
        // Adding 0 turns −0 into 0, so that equal coordinates have equal bits.
        let bits = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
        let next = i64::try_from(self.positions.len()).unwrap_or(i64::MAX);
        let number = *self.numbers.entry(bits).or_insert(next);
        if number == next {
            self.positions.push(corner);
        }
        number
    }
}
