//! PLY, ascii and binary of either byte order, through the crate `ply-rs-bw`.
//!
//! Read are the properties `x`, `y`, `z` of the element `vertex` and the list
//! `vertex_indices` (or `vertex_index`) of the element `face`; whatever else a
//! file holds is skipped.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    BeginList, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult,
};

use super::MeshError;
use super::mesh::{Mesh, Polygons, assemble};

/// Reads a PLY file's vertices and faces.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(|error| malformed("header", &error))?;
    check_header(&header, bytes.len())?;
    let (mut positions, mut polygons) = (Vec::new(), Polygons::default());
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                let vertices: Vec<Vertex> = payload(&mut reader, element, &header)?;
                positions = vertices.into_iter().map(|vertex| vertex.0).collect();
            }
            "face" => polygons = faces(payload(&mut reader, element, &header)?),
            _ => drop(payload::<Skipped>(&mut reader, element, &header)?),
        }
    }
    assemble(positions, &polygons)
}

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
        match number(&value) {
            Some(value) => {
                *coordinate = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

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

/// A face's corners, in whichever list the file's type of index fills.
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

fn is_corner_list(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// An element nobody asked for: read past, kept nowhere.
#[derive(Debug)]
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// Refuses what would be read as nonsense, or would make the parser build more
/// elements than the file has bytes.
fn check_header(header: &Header, bytes: usize) -> Result<(), MeshError> {
    for element in header.elements.values() {
        if element.count > bytes {
            let (name, count) = (&element.name, element.count);
            return Err(in_header(format!("{count} of '{name}' do not fit in {bytes} bytes")));
        }
    }
    let vertex = element(header, "vertex")?;
    let face = element(header, "face")?;
    for coordinate in ["x", "y", "z"] {
        if !vertex.properties.contains_key(coordinate) {
            return Err(in_header(format!("element 'vertex' lacks the property '{coordinate}'")));
        }
    }
    if !face.properties.keys().any(|name| is_corner_list(name)) {
        return Err(in_header("element 'face' lacks the list 'vertex_indices'".to_owned()));
    }
    Ok(())
}

fn element<'a>(header: &'a Header, name: &str) -> Result<&'a ElementDef, MeshError> {
    header.elements.get(name).ok_or_else(|| in_header(format!("there is no element '{name}'")))
}

fn in_header(problem: String) -> MeshError {
    MeshError::Malformed { format: "PLY", place: "header".to_owned(), problem }
}

fn payload<E: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, MeshError> {
    Parser::new().read_payload_for_element(reader, element, header).map_err(|error| {
        // The parser counts lines, which a binary payload has not.
        match error.line().filter(|_| header.encoding == Encoding::Ascii) {
            Some(line) => malformed(&format!("line {line}"), &error),
            None => malformed(&format!("element '{}'", element.name), &error),
        }
    })
}

/// The parser's message in short: its first line without the line number, and
/// the text it stumbled over.
fn malformed(place: &str, error: &ParseError) -> MeshError {
    let message = error.to_string();
    let prefix = error.line().map(|line| format!("Line {line}: "));
    let message = prefix.and_then(|prefix| message.strip_prefix(&prefix)).unwrap_or(&message);
    let mut lines = message.lines().map(str::trim);
    let first = lines.next().unwrap_or_default().trim_end_matches('.').to_owned();
    let problem = match lines.find_map(|line| line.strip_prefix("String: '")) {
        Some(text) => format!("{first}: '{}'", text.trim_end_matches('\'').trim()),
        None => first,
    };
    MeshError::Malformed { format: "PLY", place: place.to_owned(), problem }
}

fn faces(faces: Vec<Face>) -> Polygons {
    let mut polygons = Polygons::with_capacity(faces.len());
    for Face { signed, unsigned } in faces {
        polygons.push(signed.into_iter().map(i64::from).chain(unsigned.into_iter().map(i64::from)));
    }
    polygons
}
