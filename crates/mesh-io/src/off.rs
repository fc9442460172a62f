//! Object file format (OFF) as text: positions and polygons, as many as a line of counts says.
//!
//! A vertex is a line of its own, and so is a face. The first word of a file names what vertices have
//! beside positions: normals (`NOFF`), colors (`COFF`), texture coordinates (`STOFF`), in any order. These,
//! and colors behind the corners of a face, are checked to be numbers and skipped. Binary files and those
//! of four or any number of dimensions are refused.
//!
//! This reader is not a crate's, because places matter: errors name the line, and a file is written again
//! with other coordinates and all else as it was.
//!
//! Source: Geomview manual, section "OFF Files".

use std::fmt::Write;

use glam::DVec3;

use crate::copy::{Copy, Precision, check_count, check_range, position as position_of};
use crate::error::{FilePlace, Format};
use crate::mesh::{Mesh, Polygons, Unread};
use crate::text::{Line, Lines, number, placed_words, quoted, words};
use crate::{ReadError, Space};

const OFF: Format =
    Format { name: "OFF", remedy: "save it as text with three coordinates per vertex" };

/// Returns a surface as a file, with as many digits as distinguish the coordinates.
pub(crate) fn encode(positions: &[DVec3], faces: &[[u32; 3]], space: Option<Space>) -> Vec<u8> {
    // Other readers take the first line for the keyword alone.
    let mut file = "OFF\n".to_owned();
    if let Some(space) = space {
        file += &format!("# {}\n", space.statement());
    }

    // Writing to a string cannot fail. Edges are not counted: no reader uses their number.
    let _ = writeln!(file, "{} {} 0", positions.len(), faces.len());
    for DVec3 { x, y, z } in positions {
        let _ = writeln!(file, "{x:?} {y:?} {z:?}");
    }
    for [a, b, c] in faces {
        let _ = writeln!(file, "3 {a} {b} {c}");
    }
    file.into_bytes()
}

/// Returns true if a file begins with the first word of such a file.
pub(crate) fn is_likely(head: &[u8]) -> bool {
    let first = next_line(&mut Lines::new(head));
    first.is_some_and(|line| words(line.text).next().and_then(FirstWord::parse).is_some())
}

/// Reads the vertices and faces of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut file = OffFile::open(bytes)?;
    let mut positions = Vec::new();
    for vertex in 0..file.vertices {
        let line = file.entry("vertices", vertex, file.vertices)?;
        positions.push(file.position(&line)?);
    }

    let (mut polygons, mut corners) = (Polygons::default(), Vec::new());
    for face in 0..file.faces {
        let line = file.entry("faces", face, file.faces)?;
        read_corners(&line, &mut corners)?;
        polygons.push(corners.iter().copied());
    }

    let unread = next_line(&mut file.lines).map(|line| Unread {
        place: FilePlace::Line(line.number),
        bytes: bytes[line.start..].trim_ascii().len(),
    });
    Ok(Mesh { unread, space: file.space, ..Mesh::assemble(positions, &polygons)? })
}

/// Writes a file with other positions; normals and colors behind them stay.
pub(crate) fn replace(bytes: &[u8], positions: &[DVec3]) -> Result<Vec<u8>, ReadError> {
    let mut file = OffFile::open(bytes)?;
    check_count(file.vertices, positions)?;
    check_range(Precision::Double, positions, 0)?;

    let mut copy = Copy::new(bytes);
    for vertex in 0..file.vertices {
        let line = file.entry("vertices", vertex, file.vertices)?;
        file.position(&line)?;
        let x = position_of(&OFF, positions, vertex)?;
        for (word, value) in placed_words(line.text, line.start).zip(x.to_array()) {
            copy.put_number(word.place, value, Precision::Double);
        }
    }
    Ok(copy.finish())
}

/// First word of a file.
#[derive(Clone, Copy, Debug)]
struct FirstWord<'a> {
    /// Count of vertices that stands behind the keyword without a blank, as in `OFF490 518 0`.
    count: &'a [u8],
    /// Numbers of a vertex beside its position and a color.
    others: usize,
    /// True if positions have three coordinates.
    is_spatial: bool,
}

impl<'a> FirstWord<'a> {
    /// Returns `None` for words that begin no such file.
    fn parse(word: &'a [u8]) -> Option<Self> {
        let end = word.iter().rposition(|byte| !byte.is_ascii_digit())? + 1;
        let (keyword, count) = word.split_at(end);
        let mut marks = keyword.strip_suffix(b"OFF")?;
        let mut first = Self { count, others: 0, is_spatial: true };
        while !marks.is_empty() {
            marks = match marks {
                [b'S', b'T', rest @ ..] => {
                    first.others += 2;
                    rest
                }
                [b'N', rest @ ..] => {
                    first.others += 3;
                    rest
                }
                [b'C', rest @ ..] => rest,
                [b'4' | b'n', rest @ ..] => {
                    first.is_spatial = false;
                    rest
                }
                _ => return None,
            };
        }
        Some(first)
    }
}

/// File behind its line of counts.
#[derive(Debug)]
struct OffFile<'a> {
    lines: Lines<'a>,
    vertices: usize,
    faces: usize,
    /// Numbers of a vertex beside its position and a color.
    others: usize,
    space: Option<Space>,
}

impl<'a> OffFile<'a> {
    /// Reads the first word and the counts, which may stand on its line.
    fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut lines = Lines::new(bytes);
        let line = needed(&mut lines, "the first word")?;
        let word = words(line.text).next().unwrap_or_default();
        let Some(first) = FirstWord::parse(word) else {
            let problem = format!("{} is not OFF, COFF, NOFF or such", quoted(word));
            return Err(OFF.on_line(line.number, problem));
        };
        if !first.is_spatial {
            let kind = format!("a file that begins with {}", quoted(word));
            return Err(OFF.unsupported(kind));
        }

        let mut counts = counts_of(first.count, words(line.text).skip(1));
        let mut last = line;
        if counts.is_empty() {
            last = needed(&mut lines, "the counts")?;
            counts = words(last.text).collect();
        }
        if counts.first() == Some(&&b"BINARY"[..]) {
            return Err(OFF.unsupported("binary data"));
        }
        let (&[vertices, faces] | &[vertices, faces, _]) = &counts[..] else {
            let problem = "the numbers of vertices, of faces and of edges are expected";
            return Err(OFF.on_line(last.number, problem));
        };

        // Comments above the counts may state the space.
        let space = Space::in_text(&bytes[..last.start]);
        let [vertices, faces] = [count_on(last.number, vertices)?, count_on(last.number, faces)?];
        Ok(Self { lines, vertices, faces, others: first.others, space })
    }

    /// Returns the line of a vertex or a face, of which there are `found` so far.
    fn entry(&mut self, kind: &str, found: usize, expected: usize) -> Result<Line<'a>, ReadError> {
        let last = self.lines.number();
        next_line(&mut self.lines).ok_or_else(|| {
            let problem = format!("the file ends here, behind {found} of {expected} {kind}");
            OFF.on_line(last, problem)
        })
    }

    /// Reads the position that a line begins with.
    fn position(&self, line: &Line<'_>) -> Result<DVec3, ReadError> {
        let (mut position, mut count) = (DVec3::ZERO, 0);
        for word in words(line.text) {
            let value = number_on(line.number, word)?;
            if count < 3 {
                position[count] = value;
            }
            count += 1;
        }

        // Many files have colors that their first word does not name.
        let plain = 3 + self.others;
        if ![plain, plain + 3, plain + 4].contains(&count) {
            let problem = format!(
                "a vertex has {plain} numbers, and 3 or 4 more of a color, but here are {count}"
            );
            return Err(OFF.on_line(line.number, problem));
        }
        Ok(position)
    }
}

/// Returns the counts on the line of the first word, the first of which may be part of that word.
fn counts_of<'a>(first: &'a [u8], others: impl Iterator<Item = &'a [u8]>) -> Vec<&'a [u8]> {
    let first = (!first.is_empty()).then_some(first);
    first.into_iter().chain(others).collect()
}

/// Replaces the content of `corners` by the corners that a line lists behind their number.
fn read_corners(line: &Line<'_>, corners: &mut Vec<i64>) -> Result<(), ReadError> {
    let mut words = words(line.text);
    let count = count_on(line.number, words.next().unwrap_or_default())?;
    corners.clear();
    for found in 0..count {
        let Some(word) = words.next() else {
            let problem = format!("a face of {count} corners lists {found}");
            return Err(OFF.on_line(line.number, problem));
        };
        let Some(corner) = number(word) else {
            let problem = format!("{} is not the number of a vertex", quoted(word));
            return Err(OFF.on_line(line.number, problem));
        };
        corners.push(corner);
    }

    // A color: its number in a map, or its parts.
    let mut rest = 0;
    for word in words {
        number_on(line.number, word)?;
        rest += 1;
    }
    if ![0, 1, 3, 4].contains(&rest) {
        let problem = format!("{rest} numbers behind {count} corners are no color");
        return Err(OFF.on_line(line.number, problem));
    }
    Ok(())
}

/// Returns the next line with content, without the comment at its end.
fn next_line<'a>(lines: &mut Lines<'a>) -> Option<Line<'a>> {
    lines.find_map(|line| {
        let text = line.text.split(|&byte| byte == b'#').next().unwrap_or_default();
        (!text.trim_ascii().is_empty()).then_some(Line { text, ..line })
    })
}

/// Returns the next line with content, or a refusal of a file that ends before.
fn needed<'a>(lines: &mut Lines<'a>, content: &str) -> Result<Line<'a>, ReadError> {
    let line = next_line(lines);
    line.ok_or_else(|| OFF.on_line(lines.number(), format!("the file ends before {content}")))
}

fn number_on(line: usize, word: &[u8]) -> Result<f64, ReadError> {
    number(word).ok_or_else(|| OFF.on_line(line, format!("{} is not a number", quoted(word))))
}

fn count_on(line: usize, word: &[u8]) -> Result<usize, ReadError> {
    number(word).ok_or_else(|| OFF.on_line(line, format!("{} is not a count", quoted(word))))
}
