//! VTK files: polygonal data (`.vtp`), unstructured grids (`.vtu`) and image data (`.vti`) as XML, and
//! legacy files ([`legacy`]).
//!
//! An XML file is a tree of XML elements ([`xml`]), whose data arrays hold numbers in several
//! encodings ([`array`]). Arrays may stand behind the tree, as appended data. These are
//! not XML where they are raw, so the file is cut where they begin.
//!
//! Source: "VTK XML File Formats", the VTK documentation.

mod array;
mod elements;
mod legacy;
mod legacy_reader;
mod piece;
mod replace;
mod vti;
mod vtp;
mod vtu;
mod write;
pub(crate) mod xml;

use self::array::DataArray;
pub(crate) use self::legacy::{is_legacy, legacy_precision, parse_legacy, replace_legacy};
pub(crate) use self::replace::{VtkPoints, replace_points};
pub(crate) use self::vti::{encode_vti, parse_vti};
pub(crate) use self::vtp::parse_vtp;
pub(crate) use self::vtu::parse_vtu;
pub use self::vtu::write_vtu;
pub use self::write::{CellValues, Cells, PointValues, write_vtp, write_vtp_cells};
use self::xml::Element;
use crate::error::Format;
use crate::text::quoted;
use crate::{FilePlace, ReadError, Space};

/// Kind of VTK XML file.
#[derive(Debug)]
struct Dialect {
    format: Format,
    /// Type of the data, and name of the element that holds them.
    dataset: &'static str,
}

impl Dialect {
    /// Returns a refusal at the place of an element.
    fn malformed_at(&self, element: &Element, problem: impl AsRef<str>) -> ReadError {
        self.format.malformed(FilePlace::Byte(element.at), problem)
    }

    /// Returns a refusal for an element or an array that is absent.
    fn missing(&self, place: FilePlace) -> ReadError {
        self.format.malformed(place, "is missing")
    }

    /// Returns a refusal for an element that is absent.
    fn missing_element(&self, name: &str) -> ReadError {
        self.missing(FilePlace::Element(name.to_owned()))
    }
}

/// Data behind the XML, to which arrays point by offset.
#[derive(Clone, Copy, Debug)]
enum Appended<'a> {
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

/// VTK XML file: the element of its data, and the encoding of its arrays.
#[derive(Debug)]
struct VtkFile<'a> {
    dialect: &'static Dialect,
    dataset: Element,
    is_big_endian: bool,
    /// Size of the integers before the bytes of an array.
    header_bytes: usize,
    /// VTK's name of the compressor; none where arrays are plain.
    compressor: Option<String>,
    appended: Option<Appended<'a>>,
}

impl<'a> VtkFile<'a> {
    fn parse(bytes: &'a [u8], dialect: &'static Dialect) -> Result<Self, ReadError> {
        let (xml, appended) = cut_appended(bytes, dialect)?;
        let mut document = match Element::parse(xml, appended.is_some()) {
            Ok(document) => document,
            Err(error) => {
                return Err(dialect.format.malformed(FilePlace::Byte(error.at), error.problem));
            }
        };

        // The element of the data, in the root.
        let Some(mut root) = document.take("VTKFile") else {
            return Err(dialect.missing_element("VTKFile"));
        };
        let kind = root.attribute("type").unwrap_or_default();
        if kind != dialect.dataset {
            return Err(dialect.format.unsupported(format!("data of type {}", quoted(kind))));
        }
        let Some(dataset) = root.take(dialect.dataset) else {
            return Err(dialect.missing_element(dialect.dataset));
        };

        // Attributes that are left out have VTK's defaults.
        let compressor = root.attribute("compressor").filter(|name| !name.is_empty());
        Ok(Self {
            dialect,
            dataset,
            is_big_endian: root.attribute("byte_order") == Some("BigEndian"),
            header_bytes: if root.attribute("header_type") == Some("UInt64") { 8 } else { 4 },
            compressor: compressor.map(str::to_owned),
            appended,
        })
    }
}

impl VtkFile<'_> {
    /// Returns the space that the field data name, in an array of text.
    fn space(&self) -> Option<Space> {
        let fields = self.dataset.child("FieldData")?;
        let mut arrays = fields.children("Array").chain(fields.children("DataArray"));
        let array = arrays.find(|array| array.attribute("Name") == Some("SPACE"))?;

        // Texts end with a byte of 0.
        let text = DataArray::new(self, array).text()?;
        Space::named(text.split(|&byte| byte == 0).next()?)
    }
}

/// Splits a file at its appended data, which follow an underscore.
fn cut_appended<'a>(
    bytes: &'a [u8],
    dialect: &Dialect,
) -> Result<(&'a [u8], Option<Appended<'a>>), ReadError> {
    let Some(at) = find(bytes, b"<AppendedData") else {
        return Ok((bytes, None));
    };
    let (xml, rest) = bytes.split_at(at);

    // The tag ends at its bracket, the data begin behind the next underscore.
    let (tag, behind) = rest.split_at(find(rest, b">").unwrap_or(rest.len()));
    let Some(underscore) = find(behind, b"_") else {
        let place = FilePlace::Element("AppendedData".to_owned());
        return Err(dialect.format.malformed(place, "the file ends in the tag"));
    };
    let data = &behind[underscore + 1..];

    // Base64 ends at the next tag; raw bytes have no mark at their end.
    if find(tag, b"raw").is_some() {
        return Ok((xml, Some(Appended::Raw(data))));
    }
    let end = find(data, b"<").unwrap_or(data.len());
    Ok((xml, Some(Appended::Base64(&data[..end]))))
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}
