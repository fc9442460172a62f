//! VTK XML files written again with other points.
//!
//! Raw appended points change in their place. Others are written inline, in the number type, byte
//! order and compression of the file; appended data of other arrays stay where their offsets point.

use std::fmt::Write as _;
use std::io::Write as _;
use std::ops::Range;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec3;

use super::piece::Piece;
use super::vtp::VTP;
use super::vtu::VTU;
use super::xml::Element;
use super::{Appended, Dialect, VtkFile};
use crate::ReadError;
use crate::copy::{Copy, Precision, check_count, check_range};
use crate::stored_values::single;
use crate::text::quoted;

/// VTK file with points.
#[derive(Clone, Copy, Debug)]
pub(crate) enum VtkPoints {
    PolyData,
    UnstructuredGrid,
}

impl VtkPoints {
    fn dialect(self) -> &'static Dialect {
        match self {
            Self::PolyData => &VTP,
            Self::UnstructuredGrid => &VTU,
        }
    }

    /// Returns the number type of the points; single precision if any piece has it.
    pub(crate) fn precision(self, bytes: &[u8]) -> Result<Precision, ReadError> {
        let file = VtkFile::parse(bytes, self.dialect())?;
        for piece in Piece::all(&file) {
            let Some(array) = piece.points()? else { continue };
            if precision(&file, array)? == Precision::Single {
                return Ok(Precision::Single);
            }
        }
        Ok(Precision::Double)
    }
}

/// Writes a file with other points.
pub(crate) fn replace_points(
    bytes: &[u8],
    kind: VtkPoints,
    positions: &[DVec3],
) -> Result<Vec<u8>, ReadError> {
    let file = VtkFile::parse(bytes, kind.dialect())?;
    let (mut edits, mut first) = (Vec::new(), 0_usize);
    for piece in Piece::all(&file) {
        let Some(array) = piece.points()? else { continue };
        let count = piece.count("NumberOfPoints")?;
        let Some(x) = positions.get(first..first.saturating_add(count)) else {
            let (expected, found) = (first.saturating_add(count), positions.len());
            return Err(ReadError::PositionCount { expected, found });
        };
        check_range(precision(&file, array)?, x, first)?;
        first += count;
        edits.push(edit(bytes, &file, array, x)?);
    }
    check_count(first, positions)?;

    // Appended data stand behind all elements.
    edits.sort_by_key(|edit| edit.0.start);
    for pair in edits.windows(2) {
        if pair[0].0.end > pair[1].0.start {
            let feature = "pieces whose points share appended data";
            return Err(file.dialect.format.unsupported(feature));
        }
    }
    let mut copy = Copy::new(bytes);
    for (place, content) in edits {
        copy.put(place, &content);
    }
    Ok(copy.finish())
}

/// Returns the place of an array and its new content.
fn edit(
    bytes: &[u8],
    file: &VtkFile<'_>,
    array: &Element,
    x: &[DVec3],
) -> Result<(Range<usize>, Vec<u8>), ReadError> {
    let precision = precision(file, array)?;
    let encoding = array.attribute("format").unwrap_or("ascii");

    if let (Some(Appended::Raw(data)), None, "appended") =
        (file.appended, &file.compressor, encoding)
    {
        let offset = array.attribute("offset").unwrap_or_default().trim().parse::<usize>();
        let content = numbers(file, precision, x);
        let start = offset.unwrap_or(usize::MAX).saturating_add(file.header_bytes);
        let place = start..start.saturating_add(content.len());
        if data.get(place.clone()).is_none() {
            return Err(file.dialect.malformed_at(array, "its appended data are missing"));
        }
        let before = bytes.len() - data.len();
        return Ok((before + place.start..before + place.end, content));
    }

    // The whole element anew, without its range of values and whatever else it holds.
    let is_text = encoding == "ascii";
    let mut element = "<DataArray".to_owned();
    for (name, value) in array.attributes() {
        if !["format", "offset", "RangeMin", "RangeMax"].contains(&name) {
            // Escaped already, but for the quotation marks that single ones may hold.
            let _ = write!(element, " {name}=\"{}\"", value.replace('"', "&quot;"));
        }
    }
    let format = if is_text { "ascii" } else { "binary" };
    let content = if is_text { text(precision, x) } else { base64(file, precision, x)? };
    let _ = write!(element, " format=\"{format}\">{content}</DataArray>");
    let place = [array.at, array.end].map(|byte| usize::try_from(byte).unwrap_or(usize::MAX));
    Ok((place[0]..place[1], element.into_bytes()))
}

/// Returns the number type of an array.
fn precision(file: &VtkFile<'_>, array: &Element) -> Result<Precision, ReadError> {
    match array.attribute("type").unwrap_or_default() {
        "Float32" => Ok(Precision::Single),
        "Float64" => Ok(Precision::Double),
        other => Err(file.dialect.format.unsupported(format!("points of type {}", quoted(other)))),
    }
}

/// Writes a line per point.
fn text(precision: Precision, x: &[DVec3]) -> String {
    let mut text = "\n".to_owned();
    for x in x {
        let [x, y, z] = x.to_array().map(|value| precision.text(value));
        let _ = writeln!(text, "{x} {y} {z}");
    }
    text
}

/// Returns the bytes of all coordinates, in the order of the file.
fn numbers(file: &VtkFile<'_>, precision: Precision, x: &[DVec3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for value in x.iter().flat_map(DVec3::to_array) {
        match precision {
            Precision::Single => push(file, &mut bytes, single(value).to_le_bytes()),
            _ => push(file, &mut bytes, value.to_le_bytes()),
        }
    }
    bytes
}

/// Writes an inline array: its length and its bytes, or the lengths of its one block and the block.
fn base64(file: &VtkFile<'_>, precision: Precision, x: &[DVec3]) -> Result<String, ReadError> {
    let content = numbers(file, precision, x);
    if file.compressor.is_none() {
        let mut bytes = header(file, &[content.len()]);
        bytes.extend(content);
        return Ok(STANDARD.encode(bytes));
    }

    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&content)?;
    let block = encoder.finish()?;
    let header = header(file, &[1, content.len(), 0, block.len()]);
    Ok(STANDARD.encode(header) + &STANDARD.encode(block))
}

/// Returns the integers before an array, in the width and order of the file.
fn header(file: &VtkFile<'_>, integers: &[usize]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for &integer in integers {
        if file.header_bytes == 8 {
            push(file, &mut bytes, (integer as u64).to_le_bytes());
        } else {
            push(file, &mut bytes, u32::try_from(integer).unwrap_or(u32::MAX).to_le_bytes());
        }
    }
    bytes
}

/// Adds a number, given in little-endian order, in the order of the file.
fn push<const N: usize>(file: &VtkFile<'_>, bytes: &mut Vec<u8>, mut number: [u8; N]) {
    if file.is_big_endian {
        number.reverse();
    }
    bytes.extend(number);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_not_escaped_again() {
        let head = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"1\"><Points>";
        let tail = "</Points></Piece></PolyData></VTKFile>";
        let attributes = "type=\"Float64\" Name=\"left &amp; &lt;right>\"";
        let file = format!(
            "{head}<DataArray {attributes} note='\"' format=\"ascii\">0 0 0</DataArray>{tail}"
        );
        let x = [DVec3::new(0.5, 1.0, 2.0)];
        let written = replace_points(file.as_bytes(), VtkPoints::PolyData, &x).expect("a file");
        let written = String::from_utf8(written).expect("text");
        let expected = format!(
            "{head}<DataArray {attributes} note=\"&quot;\" format=\"ascii\">\n0.5 1.0 2.0\n\
             </DataArray>{tail}"
        );
        assert_eq!(written, expected);
    }

    #[test]
    fn what_an_array_holds_does_not_end_it() {
        let head = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"1\"><Points>";
        let tail = "</Points></Piece></PolyData></VTKFile>";
        let attributes = "type=\"Float64\" format=\"ascii\"";
        for held in ["<!-- </DataArray> -->", "<Note><DataArray>7</DataArray></Note>"] {
            let file = format!("{head}<DataArray {attributes}>0 {held}0 0</DataArray>{tail}");
            let x = [DVec3::new(0.5, 1.0, 2.0)];
            let written = replace_points(file.as_bytes(), VtkPoints::PolyData, &x).expect("a file");
            let expected =
                format!("{head}<DataArray {attributes}>\n0.5 1.0 2.0\n</DataArray>{tail}");
            assert_eq!(String::from_utf8(written).expect("text"), expected);
        }
    }

    #[test]
    fn pieces_that_share_appended_points_are_refused() {
        let points = "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
                      format=\"appended\" offset=\"0\"/></Points>";
        let piece = format!("<Piece NumberOfPoints=\"1\">{points}</Piece>");
        let mut file = format!(
            "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" header_type=\"UInt32\"><PolyData>\
             {piece}{piece}</PolyData><AppendedData encoding=\"raw\">_"
        )
        .into_bytes();
        file.extend(24_u32.to_le_bytes());
        file.extend([0; 24]);
        file.extend(b"</AppendedData></VTKFile>");
        let refused = replace_points(&file, VtkPoints::PolyData, &[DVec3::X, DVec3::Y]);
        let error = refused.expect_err("one place for two points").to_string();
        assert!(error.contains("share appended data"), "{error}");
    }
}
