//! PLY, ASCII and binary in either byte order.
//!
//! Headers and binary files go through the crate `ply-rs-bw`, but for binary files of the usual
//! layout ([`crate::ply_binary`]); lines of text files are read by [`crate::ply_text`]. The reader
//! uses the properties `x`, `y`, `z` of the element `vertex` and the list `vertex_indices` (or
//! `vertex_index`) of the element `face`; other elements and properties are skipped.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    BeginList, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult,
};

use crate::mesh::{Mesh, Polygons, Unread};
use crate::ply_binary::{read_faces, read_vertices};
use crate::ply_header::{PLY, is_corner_list, with_plain_names};
use crate::text::{line_number, quoted};
use crate::{FilePlace, ReadError, Space, ply_text};

/// Returns a surface as a binary file.
///
/// Coordinates are doubles: in single precision, surfaces at a small distance could
/// overlap.
pub(crate) fn encode(positions: &[DVec3], faces: &[[u32; 3]], space: Option<Space>) -> Vec<u8> {
    let comment =
        space.map_or_else(String::new, |space| format!("comment {}\n", space.statement()));
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\n{comment}element vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        positions.len(),
        faces.len()
    )
    .into_bytes();

    // Each vertex as three doubles, each face as the number of its corners and these.
    file.extend(positions.iter().flat_map(DVec3::to_array).flat_map(f64::to_le_bytes));
    for face in faces {
        file.push(3);
        file.extend(face.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    file
}

/// Reads the vertices and faces of a PLY file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let bytes = &*with_plain_names(bytes)?;
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader);
    let header = header.map_err(|error| malformed(FilePlace::Header, &error))?;
    check_header(&header, bytes.len())?;
    let space = header.comments.iter().find_map(|text| Space::in_text(text.as_bytes()));

    if header.encoding == Encoding::Ascii {
        let start = bytes.len() - reader.get_ref().len();
        let text = ply_text::read(bytes, &header, start)?;
        let unread = unread(bytes, &bytes[text.end..], header.encoding);
        return Ok(Mesh { unread, space, ..Mesh::assemble(text.positions, &text.polygons)? });
    }

    // Elements stand in the order of the header.
    let (mut positions, mut polygons) = (Vec::new(), Polygons::default());
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => match read_vertices(reader.get_mut(), element, &header) {
                Some(vertices) => positions = vertices,
                None => positions = parse_vertices(&mut reader, element, &header)?,
            },
            "face" => match read_faces(reader.get_mut(), element, &header) {
                Some(faces) => polygons = faces,
                None => polygons = parse_faces(&mut reader, element, &header)?,
            },
            _ => drop(payload::<Skipped>(&mut reader, element, &header)?),
        }
    }

    let unread = unread(bytes, reader.get_ref(), header.encoding);
    Ok(Mesh { unread, space, ..Mesh::assemble(positions, &polygons)? })
}

/// Reads vertices of any binary layout.
fn parse_vertices(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<DVec3>, ReadError> {
    let vertices: Vec<Vertex> = payload(reader, element, header)?;
    Ok(vertices.into_iter().map(|vertex| vertex.0).collect())
}

/// Reads faces of any binary layout.
fn parse_faces(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Polygons, ReadError> {
    let mut polygons = Polygons::default();
    for Face { signed, unsigned } in payload(reader, element, header)? {
        // Only the list of the file's type of index has entries.
        let unsigned = unsigned.into_iter().map(i64::from);
        polygons.push(signed.into_iter().map(i64::from).chain(unsigned));
    }
    Ok(polygons)
}

/// Describes the `rest` of a file behind its last element, if there is any. Blank lines
/// at the end of a text file are none.
fn unread(file: &[u8], rest: &[u8], encoding: Encoding) -> Option<Unread> {
    let end = file.len() - rest.len();
    if encoding != Encoding::Ascii {
        let place = FilePlace::Byte(end as u64);
        return (!rest.is_empty()).then_some(Unread { place, bytes: rest.len() });
    }

    // The first line with content, behind blank ones.
    let content = rest.trim_ascii_start();
    let start = file.len() - content.len();
    let place = FilePlace::Line(line_number(file, start));
    let unread = Unread { place, bytes: content.len() };
    (!content.is_empty()).then_some(unread)
}

/// Position of a vertex, with the other properties left out.
#[derive(Debug)]
struct Vertex(DVec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(DVec3::NAN)
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let coordinate = match name {
            "x" => &mut self.0.x,
            "y" => &mut self.0.y,
            "z" => &mut self.0.z,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(value) = number(&value) else {
            return PropertyAccessResult::UnsupportedType;
        };
        *coordinate = value;
        PropertyAccessResult::Set
    }
}

/// Returns a scalar property as a double.
fn number(value: &Property) -> Option<f64> {
    match *value {
        Property::Char(v) => Some(v.into()),
        Property::UChar(v) => Some(v.into()),
        Property::Short(v) => Some(v.into()),
        Property::UShort(v) => Some(v.into()),
        Property::Int(v) => Some(v.into()),
        Property::UInt(v) => Some(v.into()),
        Property::Float(v) => Some(v.into()),
        Property::Double(v) => Some(v),
        _ => None,
    }
}

/// Corners of a face, in the list that the file's type of index fills.
#[derive(Debug)]
struct Face {
    signed: Vec<i32>,
    unsigned: Vec<u32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { signed: Vec::new(), unsigned: Vec::new() }
    }

    fn begin_list_int(&mut self, name: &str, _: usize) -> BeginList<'_, i32> {
        if is_corner_list(name) { BeginList::Fill(&mut self.signed) } else { BeginList::UseSetter }
    }

    fn begin_list_uint(&mut self, name: &str, _: usize) -> BeginList<'_, u32> {
        if is_corner_list(name) {
            BeginList::Fill(&mut self.unsigned)
        } else {
            BeginList::UseSetter
        }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !is_corner_list(name) {
            return PropertyAccessResult::Ignored;
        }
        self.signed = match value {
            Property::ListChar(list) => list.into_iter().map(i32::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i32::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i32::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i32::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Element without use here, read past.
#[derive(Debug)]
pub(crate) struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// Refuses headers without a mesh, and those that would make the parser build more
/// elements than the file has bytes.
pub(crate) fn check_header(header: &Header, bytes: usize) -> Result<(), ReadError> {
    for ElementDef { name, count, .. } in header.elements.values() {
        if *count > bytes {
            let problem = format!("{count} of {} do not fit in {bytes} bytes", quoted(name));
            return Err(PLY.in_header(problem));
        }
    }

    let (vertex, face) = (element(header, "vertex")?, element(header, "face")?);
    for coordinate in ["x", "y", "z"] {
        if !vertex.properties.contains_key(coordinate) {
            let problem = format!("element 'vertex' lacks the property '{coordinate}'");
            return Err(PLY.in_header(problem));
        }
    }
    match face.properties.keys().filter(|name| is_corner_list(name)).count() {
        0 => Err(PLY.in_header("element 'face' lacks the list 'vertex_indices'")),
        1 => Ok(()),
        _ => Err(PLY.in_header("element 'face' has two lists of corners")),
    }
}

pub(crate) fn element<'a>(header: &'a Header, name: &str) -> Result<&'a ElementDef, ReadError> {
    match header.elements.get(name) {
        Some(element) => Ok(element),
        None => Err(PLY.in_header(format!("there is no element '{name}'"))),
    }
}

fn payload<E: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, ReadError> {
    let payload = Parser::new().read_payload_for_element(reader, element, header);
    payload.map_err(|error| malformed(FilePlace::Element(element.name.clone()), &error))
}

/// Shortens the parser's message to its first line, without the line number, and the
/// offending text.
pub(crate) fn malformed(place: FilePlace, error: &ParseError) -> ReadError {
    let message = error.to_string();
    let prefix = format!("Line {}: ", error.line().unwrap_or_default());
    let message = message.strip_prefix(&prefix).unwrap_or(&message);

    // A line of its own quotes the text, if there is any.
    let mut lines = message.lines().map(str::trim);
    let mut problem = lines.next().unwrap_or_default().trim_end_matches('.').to_owned();
    if let Some(text) = lines.find_map(|line| line.strip_prefix("String: '")) {
        problem += &format!(": {}", quoted(text.trim_end_matches('\'').trim()));
    }
    PLY.malformed(place, problem)
}
