//! Sections of legacy VTK files: words, and blocks of numbers, which are big-endian where they are binary.
//!
//! Source: "VTK File Formats", section "Simple legacy formats"; for lists of version 5.1, meta data and
//! text in binary files, VTK's `vtkDataReader`.

use std::ops::Range;
use std::str::FromStr;

use glam::DVec3;

use super::piece::CellPoints;
use crate::copy::Precision;
use crate::error::Format;
use crate::text::{PlacedWord, end_of_line, line_number, number, quoted};
use crate::{FilePlace, ReadError, Space};

pub(super) const LEGACY: Format = Format {
    name: "VTK",
    remedy: "save it as polygonal data of plain polygons, or as an unstructured grid of \
             tetrahedra, wedges and hexahedra, with points of type float or double",
};

/// First version whose lists of cells are two arrays.
const TWO_ARRAYS: (u32, u32) = (5, 1);

/// Points with the place of their coordinates.
#[derive(Debug)]
pub(super) struct Points {
    pub(super) positions: Vec<DVec3>,
    pub(super) precision: Precision,
    pub(super) place: Place,
}

/// Place of the coordinates of all points in a file.
#[derive(Debug)]
pub(super) enum Place {
    /// Three words per point.
    Words(Vec<Range<usize>>),
    /// Bytes of all numbers.
    Block(Range<usize>),
}

impl Format {
    pub(super) fn in_section(&self, name: &str, problem: impl AsRef<str>) -> ReadError {
        self.malformed(FilePlace::Element(name.to_owned()), problem)
    }
}

/// Position in a file of words and blocks of numbers.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_binary: bool,
    /// True if a list of cells is an array of ends and one of points.
    has_two_arrays: bool,
}

impl<'a> Reader<'a> {
    /// Reads the version, the title and the encoding, up to the type of the data.
    pub(super) fn after_header(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut reader = Self { bytes, at: 0, is_binary: false, has_two_arrays: false };
        let first = reader.line();
        let version = first.split(|byte| byte.is_ascii_whitespace()).rfind(|word| !word.is_empty());
        let version = version.and_then(|version| std::str::from_utf8(version).ok());
        let parts = version.and_then(|version| version.split_once('.'));
        let Some((Ok(major), Ok(minor))) = parts.map(|(a, b)| (a.parse(), b.parse::<u32>())) else {
            return Err(LEGACY.in_header("the first line ends with a version"));
        };
        reader.has_two_arrays = (major, minor) >= TWO_ARRAYS;

        // The title is any text.
        reader.line();
        let encoding = reader.keyword()?;
        reader.is_binary = encoding.eq_ignore_ascii_case(b"BINARY");
        if !reader.is_binary && !encoding.eq_ignore_ascii_case(b"ASCII") {
            let problem = format!("{} is neither ASCII nor BINARY", quoted(encoding));
            return Err(LEGACY.in_header(problem));
        }
        if !reader.keyword()?.eq_ignore_ascii_case(b"DATASET") {
            return Err(LEGACY.in_header("the type of the data is missing"));
        }
        Ok(reader)
    }

    /// Returns a refusal at a byte.
    pub(super) fn malformed(&self, at: usize, problem: impl AsRef<str>) -> ReadError {
        let place = if self.is_binary {
            FilePlace::Byte(at as u64)
        } else {
            FilePlace::Line(line_number(self.bytes, at))
        };
        LEGACY.malformed(place, problem)
    }

    /// Returns the next word, on this line or a later one.
    pub(super) fn word(&mut self) -> Option<PlacedWord<'a>> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let start = self.at + rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = &self.bytes[start..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at = start + length;
        Some(PlacedWord { text: &self.bytes[start..self.at], place: start..self.at })
    }

    /// Returns the rest of the line, and passes its end.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = end_of_line(rest);
        self.at += length + 1;
        &rest[..length]
    }

    fn needed(&mut self) -> Result<PlacedWord<'a>, ReadError> {
        let word = self.word();
        word.ok_or_else(|| self.malformed(self.bytes.len(), "the file ends within a section"))
    }

    pub(super) fn keyword(&mut self) -> Result<&'a [u8], ReadError> {
        Ok(self.needed()?.text)
    }

    /// Reads a number of a kind that is named in a refusal.
    pub(super) fn number<T: FromStr>(&mut self, kind: &str) -> Result<T, ReadError> {
        let word = self.needed()?;
        let wrong =
            || self.malformed(word.place.start, format!("{} is not {kind}", quoted(word.text)));
        number(word.text).ok_or_else(wrong)
    }

    /// Passes the bytes of numbers, which begin on the next line.
    fn block(&mut self, count: usize, width: usize) -> Result<Range<usize>, ReadError> {
        self.line();
        let end = count.checked_mul(width).and_then(|length| self.at.checked_add(length));
        match end.filter(|&end| end <= self.bytes.len()) {
            Some(end) => {
                let block = self.at..end;
                self.at = end;
                Ok(block)
            }
            None => Err(self.malformed(self.at, format!("the file ends within {count} numbers"))),
        }
    }

    /// Reads whole numbers, of 4 or 8 bytes where they are binary.
    pub(super) fn integers(&mut self, count: usize, width: usize) -> Result<Vec<i64>, ReadError> {
        if !self.is_binary {
            return (0..count).map(|_| self.number("a whole number")).collect();
        }
        let block = &self.bytes[self.block(count, width)?];
        Ok(if width == 8 {
            block.as_chunks().0.iter().copied().map(i64::from_be_bytes).collect()
        } else {
            block.as_chunks().0.iter().map(|&bytes| i32::from_be_bytes(bytes).into()).collect()
        })
    }

    /// Reads positions, in the number type that the section names.
    pub(super) fn points(&mut self) -> Result<Points, ReadError> {
        let count: usize = self.number("a number of points")?;
        let kind = self.keyword()?.to_ascii_lowercase();
        let precision = match &kind[..] {
            b"float" => Precision::Single,
            b"double" => Precision::Double,
            _ => return Err(LEGACY.unsupported(format!("points of type {}", quoted(kind)))),
        };
        let is_single = precision == Precision::Single;
        let count = count.saturating_mul(3);

        // Text is read in the number type of the file.
        let (coordinates, place) = if self.is_binary {
            let block = self.block(count, if is_single { 4 } else { 8 })?;
            let bytes = &self.bytes[block.clone()];
            let numbers: Vec<f64> = if is_single {
                bytes.as_chunks().0.iter().map(|&bytes| f32::from_be_bytes(bytes).into()).collect()
            } else {
                bytes.as_chunks().0.iter().copied().map(f64::from_be_bytes).collect()
            };
            (numbers, Place::Block(block))
        } else {
            let (mut numbers, mut words) = (Vec::new(), Vec::new());
            for _ in 0..count {
                numbers.push(if is_single {
                    self.number::<f32>("a coordinate")?.into()
                } else {
                    self.number("a coordinate")?
                });
                words.push(self.last_word());
            }
            (numbers, Place::Words(words))
        };
        let positions = coordinates.as_chunks().0.iter().copied().map(DVec3::from_array).collect();
        Ok(Points { positions, precision, place })
    }

    /// Returns the place of the word that was read last.
    fn last_word(&self) -> Range<usize> {
        let before = &self.bytes[..self.at];
        let start = before.iter().rposition(u8::is_ascii_whitespace).map_or(0, |blank| blank + 1);
        start..self.at
    }

    /// Reads a list of cells: ends and points in two arrays, or before each cell the number of its points.
    pub(super) fn cells(&mut self) -> Result<CellPoints, ReadError> {
        let (at, count, size) = (self.at, self.number("a count")?, self.number("a size")?);
        let (ends, connectivity) = if !self.has_two_arrays {
            split_cells(&self.integers(size, 4)?, count).ok_or_else(|| {
                self.malformed(at, format!("a list of {size} numbers is not that of {count} cells"))
            })?
        } else if count == 0 {
            return Ok(CellPoints::default());
        } else {
            // The first of the ends is the beginning.
            let ends = self.array("OFFSETS", count)?;
            (ends[1..].to_vec(), self.array("CONNECTIVITY", size)?)
        };
        CellPoints::new(connectivity, ends).map_err(|problem| self.malformed(at, problem))
    }

    /// Reads an array of whole numbers behind its name and type.
    fn array(&mut self, name: &str, count: usize) -> Result<Vec<i64>, ReadError> {
        let word = self.needed()?;
        if !word.text.eq_ignore_ascii_case(name.as_bytes()) {
            let problem = format!("{name} expected, not {}", quoted(word.text));
            return Err(self.malformed(word.place.start, problem));
        }
        let kind = self.keyword()?;
        match width(kind) {
            Some(width @ (4 | 8)) => self.integers(count, width),
            _ => Err(LEGACY.unsupported(format!("cells of type {}", quoted(kind)))),
        }
    }

    /// Passes the arrays of field data; returns the space that one of them names.
    pub(super) fn field_data(&mut self) -> Result<Option<Space>, ReadError> {
        let (_, arrays) = (self.keyword()?, self.number::<usize>("a number of arrays")?);
        let mut space = None;
        for _ in 0..arrays {
            let mut name = self.keyword()?;
            while name == b"METADATA" {
                self.pass_meta_data();
                name = self.keyword()?;
            }
            let components: usize = self.number("a number of components")?;
            let tuples: usize = self.number("a number of tuples")?;
            let (kind, count) = (self.keyword()?, components.saturating_mul(tuples));

            if kind.eq_ignore_ascii_case(b"string") {
                self.line();
                for _ in 0..count {
                    let text = self.text()?;
                    space = Space::named(text).filter(|_| name == b"SPACE").or(space);
                }
            } else if !self.is_binary {
                for _ in 0..count {
                    self.needed()?;
                }
            } else if kind.eq_ignore_ascii_case(b"bit") {
                self.block(count.div_ceil(8), 1)?;
            } else if let Some(width) = width(kind) {
                self.block(count, width)?;
            } else {
                return Err(LEGACY.unsupported(format!("field data of type {}", quoted(kind))));
            }
        }
        Ok(space)
    }

    /// Returns the text of a line, or of a binary array: the width of its length stands in two bits before it.
    fn text(&mut self) -> Result<&'a [u8], ReadError> {
        if !self.is_binary {
            if self.at >= self.bytes.len() {
                return Err(self.malformed(self.at, "the file ends within field data"));
            }
            return Ok(self.line().trim_ascii());
        }
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let width = rest.first().map_or(0, |first| 8_usize >> (first >> 6));
        let Some(head) = rest.get(..width).filter(|head| !head.is_empty()) else {
            return Err(self.malformed(self.at, "the file ends within field data"));
        };
        let mut length = u64::from(head[0] & 0x3f);
        for &byte in &head[1..] {
            length = length << 8 | u64::from(byte);
        }
        let end = usize::try_from(length).unwrap_or(usize::MAX).saturating_add(width);
        let Some(text) = rest.get(width..end) else {
            return Err(self.malformed(self.at, "the file ends within a text"));
        };
        self.at += end;
        Ok(text)
    }

    /// Passes meta data, which end with an empty line.
    pub(super) fn pass_meta_data(&mut self) {
        self.line();
        while self.at < self.bytes.len() && !self.line().trim_ascii().is_empty() {}
    }
}

/// Returns the bytes of a number of a type.
fn width(kind: &[u8]) -> Option<usize> {
    match &kind.to_ascii_lowercase()[..] {
        b"char" | b"signed_char" | b"unsigned_char" => Some(1),
        b"short" | b"unsigned_short" => Some(2),
        b"int" | b"unsigned_int" | b"float" | b"vtkidtype" => Some(4),
        b"long" | b"unsigned_long" | b"double" | b"vtktypeint64" | b"vtktypeuint64" => Some(8),
        _ => None,
    }
}

/// Returns the ends and points of cells that stand behind the numbers of their points.
fn split_cells(list: &[i64], count: usize) -> Option<(Vec<i64>, Vec<i64>)> {
    let (mut ends, mut points, mut rest) = (Vec::new(), Vec::new(), list);
    for _ in 0..count {
        let (&length, behind) = rest.split_first()?;
        let (cell, behind) = behind.split_at_checked(usize::try_from(length).ok()?)?;
        points.extend(cell);
        ends.push(i64::try_from(points.len()).ok()?);
        rest = behind;
    }
    rest.is_empty().then_some((ends, points))
}
