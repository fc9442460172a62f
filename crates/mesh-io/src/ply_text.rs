//! ASCII PLY, one line per entry of an element.
//!
//! Numbers may be spelled as C writes them, `1.` and `.5` too, and values without use here need not be
//! finite. The parser of `ply-rs-bw` knows neither.

use glam::DVec3;
use ply_rs_bw::ply::{ElementDef, Header, PropertyType, ScalarType};

use crate::ReadError;
use crate::mesh::Polygons;
use crate::ply_header::{PLY, is_corner_list};
use crate::text::{Line, Lines, number, quoted, words};

/// Vertices and faces of a text file.
#[derive(Debug, Default)]
pub(crate) struct PlyText {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) polygons: Polygons,
    /// Byte of the file behind the last element.
    pub(crate) end: usize,
}

/// Values of an entry, as far as they are used.
#[derive(Debug)]
struct Entry {
    position: DVec3,
    corners: Vec<i64>,
}

/// Reads the elements of a text file whose header ends before byte `start`.
///
/// # Errors
///
/// The first line that does not have the values of its entry.
pub(crate) fn read(file: &[u8], header: &Header, start: usize) -> Result<PlyText, ReadError> {
    let mut text = PlyText { end: start, ..PlyText::default() };
    let mut entry = Entry { position: DVec3::ZERO, corners: Vec::new() };
    let mut lines = Lines::new(file).skip_while(|line| line.start < start);
    let mut last = file[..start].iter().filter(|&&byte| byte == b'\n').count();
    for element in header.elements.values() {
        for number in 0..element.count {
            last += 1;
            let Some(line) = lines.next() else { return Err(ends_early(last, element, number)) };
            entry.read(line.text, element).ok_or_else(|| refused(&line))?;
            text.end = file.len().min(line.start + line.text.len() + 1);

            match element.name.as_str() {
                "vertex" => text.positions.push(entry.position),
                "face" => text.polygons.push(entry.corners.iter().copied()),
                _ => {}
            }
        }
    }
    Ok(text)
}

fn refused(line: &Line<'_>) -> ReadError {
    let text = quoted(line.text.trim_ascii());
    PLY.on_line(line.number, format!("Couldn't read element line: {text}"))
}

fn ends_early(line: usize, element: &ElementDef, found: usize) -> ReadError {
    let (name, expected) = (quoted(&element.name), element.count);
    let place = format!("while reading element {name} (expected {expected}, got {found})");
    PLY.on_line(line, format!("Unexpected end of file {place}"))
}

impl Entry {
    /// Reads a line with a value, or a list of values, per property.
    fn read(&mut self, line: &[u8], element: &ElementDef) -> Option<()> {
        let mut words = words(line);
        for property in element.properties.values() {
            match &property.data_type {
                PropertyType::Scalar(scalar) => {
                    let value = value(words.next()?, scalar)?;
                    if let Some(axis) = ["x", "y", "z"].iter().position(|x| *x == property.name) {
                        self.position[axis] = Some(value).filter(|value| value.is_finite())?;
                    }
                }
                PropertyType::List(count, item) if is_corner_list(&property.name) => {
                    self.corners.clear();
                    for _ in 0..length(words.next()?, count)? {
                        self.corners.push(corner(words.next()?, item)?);
                    }
                }
                PropertyType::List(count, item) => {
                    for _ in 0..length(words.next()?, count)? {
                        value(words.next()?, item)?;
                    }
                }
            }
        }

        // Numbers behind the declared ones are passed over.
        words.all(|word| number::<f64>(word).is_some()).then_some(())
    }
}

/// Returns a value in the type of its property.
fn value(word: &[u8], scalar: &ScalarType) -> Option<f64> {
    match scalar {
        ScalarType::Char => number::<i8>(word).map(f64::from),
        ScalarType::UChar => number::<u8>(word).map(f64::from),
        ScalarType::Short => number::<i16>(word).map(f64::from),
        ScalarType::UShort => number::<u16>(word).map(f64::from),
        ScalarType::Int => number::<i32>(word).map(f64::from),
        ScalarType::UInt => number::<u32>(word).map(f64::from),
        ScalarType::Float => number::<f32>(word).map(f64::from),
        ScalarType::Double => number(word),
    }
}

/// Returns the corner of a face in its type.
fn corner(word: &[u8], scalar: &ScalarType) -> Option<i64> {
    match scalar {
        ScalarType::Char => number::<i8>(word).map(i64::from),
        ScalarType::UChar => number::<u8>(word).map(i64::from),
        ScalarType::Short => number::<i16>(word).map(i64::from),
        ScalarType::UShort => number::<u16>(word).map(i64::from),
        ScalarType::Int => number::<i32>(word).map(i64::from),
        ScalarType::UInt => number::<u32>(word).map(i64::from),
        ScalarType::Float | ScalarType::Double => None,
    }
}

/// Returns the length of a list.
fn length(word: &[u8], scalar: &ScalarType) -> Option<usize> {
    corner(word, scalar).and_then(|length| usize::try_from(length).ok())
}
