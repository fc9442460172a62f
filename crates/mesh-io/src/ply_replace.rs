//! PLY files written again with other positions.
//!
//! Goes through the elements in the order of the header, in any encoding, and replaces `x`, `y` and
//! `z` of each vertex. All else stays, colors and normals included.

use std::ops::Range;

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType};

use crate::ReadError;
use crate::copy::{Copy, Precision, check_count, check_range};
use crate::ply::{Skipped, check_header, malformed};
use crate::ply_binary::size_of_scalar;
use crate::ply_header::{PLY, with_plain_names};
use crate::stored_values::single;
use crate::text::{Lines, PlacedWord, number, placed_words};
use crate::{FilePlace, ply};

/// Returns the number type of the coordinates.
pub(crate) fn precision(file: &[u8]) -> Result<Precision, ReadError> {
    let (header, _) = read_header(file)?;
    for name in ["x", "y", "z"] {
        let vertex = ply::element(&header, "vertex")?;
        match vertex.properties.get(name).map(|property| &property.data_type) {
            Some(PropertyType::Scalar(ScalarType::Double)) => {}
            Some(PropertyType::Scalar(ScalarType::Float)) => return Ok(Precision::Single),
            _ => return Err(PLY.unsupported("positions that are no floats")),
        }
    }
    Ok(Precision::Double)
}

/// Writes a file with other positions.
pub(crate) fn replace(file: &[u8], positions: &[DVec3]) -> Result<Vec<u8>, ReadError> {
    let (header, start) = read_header(file)?;
    check_range(precision(file)?, positions, 0)?;
    check_count(ply::element(&header, "vertex")?.count, positions)?;

    let mut copy = Copy::new(file);
    if header.encoding == Encoding::Ascii {
        replace_text(file, &header, start, positions, &mut copy)?;
    } else {
        replace_binary(file, &header, start, positions, &mut copy)?;
    }
    Ok(copy.finish())
}

/// Reads the header, and returns the byte behind it.
fn read_header(file: &[u8]) -> Result<(Header, usize), ReadError> {
    let file = &*with_plain_names(file)?;
    let mut reader = Reader::new(file);
    let header = Parser::<Skipped>::new().read_header(&mut reader);
    let header = header.map_err(|error| malformed(FilePlace::Header, &error))?;
    check_header(&header, file.len())?;
    Ok((header, file.len() - reader.get_ref().len()))
}

/// Replaces coordinates in the lines of the vertices; nothing behind them changes.
fn replace_text(
    file: &[u8],
    header: &Header,
    start: usize,
    positions: &[DVec3],
    copy: &mut Copy<'_>,
) -> Result<(), ReadError> {
    let mut lines = Lines::new(&file[start..]).filter(|line| !line.text.trim_ascii().is_empty());
    for element in header.elements.values() {
        // Each entry of an element is a line, whatever its properties are.
        if element.name != "vertex" {
            lines.by_ref().take(element.count).for_each(drop);
            continue;
        }
        for x in positions {
            let line = lines.next().ok_or_else(|| ends_in(element))?;
            replace_line(placed_words(line.text, start + line.start), element, *x, copy)?;
        }
        break;
    }
    Ok(())
}

/// Replaces the coordinates of a vertex in its line.
fn replace_line<'a>(
    mut words: impl Iterator<Item = PlacedWord<'a>>,
    element: &ElementDef,
    x: DVec3,
    copy: &mut Copy<'_>,
) -> Result<(), ReadError> {
    for property in element.properties.values() {
        let word = words.next().ok_or_else(|| ends_in(element))?;
        match &property.data_type {
            PropertyType::Scalar(scalar) => {
                let is_single = *scalar == ScalarType::Float;
                let precision = if is_single { Precision::Single } else { Precision::Double };
                if let Some(axis) = axis(&property.name) {
                    copy.put_number(word.place, x[axis], precision);
                }
            }
            // A list has as many words behind it as it says.
            PropertyType::List(..) => {
                words.by_ref().take(number(word.text).unwrap_or(0)).for_each(drop);
            }
        }
    }
    Ok(())
}

/// Replaces coordinates in the records of the vertices; nothing behind them changes.
fn replace_binary(
    file: &[u8],
    header: &Header,
    start: usize,
    positions: &[DVec3],
    copy: &mut Copy<'_>,
) -> Result<(), ReadError> {
    // Records may have lists, so that each is passed to find the next.
    let is_big_endian = header.encoding == Encoding::BinaryBigEndian;
    let mut records = Records { file, at: start, is_big_endian };
    for element in header.elements.values() {
        if element.name != "vertex" {
            for _ in 0..element.count {
                records.pass(element, |_, _| {})?;
            }
            continue;
        }
        for x in positions {
            records.pass(element, |property, place| {
                if let Some(axis) = axis(&property.name) {
                    let bytes = scalar_bytes(x[axis], place.len(), is_big_endian);
                    copy.put(place, &bytes);
                }
            })?;
        }
        break;
    }
    Ok(())
}

/// Records of a binary file, one after the other.
struct Records<'a> {
    file: &'a [u8],
    /// Byte at which the next record begins.
    at: usize,
    is_big_endian: bool,
}

impl Records<'_> {
    /// Passes a record, and calls `visit` with the place of each property.
    fn pass(
        &mut self,
        element: &ElementDef,
        mut visit: impl FnMut(&PropertyDef, Range<usize>),
    ) -> Result<(), ReadError> {
        for property in element.properties.values() {
            // A list begins with its count. Products and sums saturate: a count that the file
            // cannot hold ends behind its end, and is refused below.
            let length = match &property.data_type {
                PropertyType::Scalar(scalar) => size_of_scalar(scalar),
                PropertyType::List(count, item) => {
                    let bytes = self.file.get(self.at..self.at + size_of_scalar(count));
                    let bytes = bytes.ok_or_else(|| ends_in(element))?;
                    let items = whole_number(bytes, self.is_big_endian);
                    bytes.len().saturating_add(items.saturating_mul(size_of_scalar(item)))
                }
            };
            let end = self.at.saturating_add(length);
            if end > self.file.len() {
                return Err(ends_in(element));
            }
            visit(property, self.at..end);
            self.at = end;
        }
        Ok(())
    }
}

/// Returns a number in single or double precision, by its length.
fn scalar_bytes(value: f64, length: usize, is_big_endian: bool) -> Vec<u8> {
    let mut bytes = if length == 4 {
        single(value).to_le_bytes().to_vec()
    } else {
        value.to_le_bytes().to_vec()
    };
    if is_big_endian {
        bytes.reverse();
    }
    bytes
}

fn whole_number(bytes: &[u8], is_big_endian: bool) -> usize {
    let mut digits = [0; 8];
    digits[..bytes.len()].copy_from_slice(bytes);
    if is_big_endian {
        digits[..bytes.len()].reverse();
    }
    usize::try_from(u64::from_le_bytes(digits)).unwrap_or(usize::MAX)
}

fn axis(name: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|axis| *axis == name)
}

fn ends_in(element: &ElementDef) -> ReadError {
    PLY.malformed(FilePlace::Element(element.name.clone()), "the file ends here")
}
