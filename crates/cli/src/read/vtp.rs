//! VTK XML polygonal data (`.vtp`): points and polygons of all pieces as one
//! mesh.
//!
//! The XML goes through the crate `quick-xml`; what its arrays hold is decoded
//! in `vtk_array`. Appended raw data is not XML, so the file is cut where it
//! begins.

use glam::DVec3;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::MeshError;
use super::mesh::{Mesh, Polygons, assemble};
use super::vtk_array::{Appended, Array, Conventions};

/// Reads a VTP file's points and polygons.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let (xml, appended) = cut_appended(bytes)?;
    let document = Document::read(xml, appended.is_some())?;
    let mut positions = Vec::new();
    let mut polygons = Polygons::default();
    for piece in &document.pieces {
        read_piece(piece, &document.conventions, appended, &mut positions, &mut polygons)?;
    }
    assemble(positions, &polygons)
}

const APPENDED: &[u8] = b"<AppendedData";

/// Splits the file at its appended data, which follow an underscore.
pub(crate) fn cut_appended(bytes: &[u8]) -> Result<(&[u8], Option<Appended<'_>>), MeshError> {
    let Some(at) = bytes.windows(APPENDED.len()).position(|window| window == APPENDED) else {
        return Ok((bytes, None));
    };
    let (xml, rest) = bytes.split_at(at);
    let tag_end = rest.iter().position(|&byte| byte == b'>');
    let tag = tag_end.and_then(|end| std::str::from_utf8(&rest[..end]).ok());
    let data = tag_end.and_then(|end| {
        let underscore = rest[end..].iter().position(|&byte| byte == b'_')?;
        Some(&rest[end + underscore + 1..])
    });
    match (tag, data) {
        (Some(tag), Some(data)) if tag.contains("raw") => Ok((xml, Some(Appended::Raw(data)))),
        (Some(_), Some(data)) => {
            let end = data.iter().position(|&byte| byte == b'<').unwrap_or(data.len());
            Ok((xml, Some(Appended::Base64(&data[..end]))))
        }
        _ => Err(malformed("AppendedData", "the file ends within the tag".to_owned())),
    }
}

/// What a file says of itself, with the arrays that make the mesh.
#[derive(Debug)]
struct Document {
    conventions: Conventions,
    pieces: Vec<Piece>,
}

#[derive(Debug, Default)]
struct Piece {
    points: usize,
    polygons: usize,
    strips: usize,
    coordinates: Option<Array>,
    connectivity: Option<Array>,
    offsets: Option<Array>,
}

/// Which array the next one found belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Points,
    Polygons,
    Other,
}

impl Document {
    fn read(xml: &[u8], has_appended: bool) -> Result<Self, MeshError> {
        let mut reader = Reader::from_reader(xml);
        let mut document = Self { conventions: Conventions::default(), pieces: Vec::new() };
        let mut section = Section::Other;
        let mut is_whole = has_appended;
        loop {
            let place = format!("byte {}", reader.buffer_position());
            let event = reader.read_event().map_err(|e| malformed(&place, e.to_string()))?;
            match &event {
                Event::Start(tag) | Event::Empty(tag) => {
                    let text = match event {
                        Event::Start(_) if tag.name().as_ref() == "DataArray" => {
                            text_of(&mut reader, tag, &place)?
                        }
                        _ => Vec::new(),
                    };
                    document.open(tag, text, &mut section, &place)?;
                }
                Event::End(tag) => match tag.name().as_ref() {
                    "Points" | "Polys" => section = Section::Other,
                    "VTKFile" => is_whole = true,
                    _ => {}
                },
                Event::Eof if is_whole => return Ok(document),
                Event::Eof => {
                    return Err(malformed(&place, "the file ends before </VTKFile>".to_owned()));
                }
                _ => {}
            }
        }
    }

    fn open(
        &mut self,
        tag: &BytesStart<'_>,
        text: Vec<u8>,
        section: &mut Section,
        place: &str,
    ) -> Result<(), MeshError> {
        let attribute = |name: &str| attribute(tag, name, place);
        match tag.name().as_ref() {
            "VTKFile" => {
                let kind = attribute("type")?.unwrap_or_default();
                if kind != "PolyData" {
                    return Err(unsupported(format!("data of type '{kind}'")));
                }
                self.conventions = Conventions::new(
                    attribute("byte_order")?.as_deref(),
                    attribute("header_type")?.as_deref(),
                    attribute("compressor")?,
                );
            }
            "Piece" => {
                let count = |name: &str| -> Result<usize, MeshError> {
                    attribute(name)?.map_or(Ok(0), |text| number(&text, name, place))
                };
                self.pieces.push(Piece {
                    points: count("NumberOfPoints")?,
                    polygons: count("NumberOfPolys")?,
                    strips: count("NumberOfStrips")?,
                    ..Piece::default()
                });
            }
            "Points" => *section = Section::Points,
            "Polys" => *section = Section::Polygons,
            "Verts" | "Lines" | "Strips" | "PointData" | "CellData" => {
                *section = Section::Other;
            }
            "DataArray" if *section != Section::Other => {
                let offset = attribute("offset")?;
                let array = Array {
                    name: attribute("Name")?.unwrap_or_else(|| "Points".to_owned()),
                    number_type: attribute("type")?.unwrap_or_default(),
                    format: attribute("format")?.unwrap_or_else(|| "ascii".to_owned()),
                    offset: offset.map(|text| number(&text, "offset", place)).transpose()?,
                    text,
                };
                self.keep(array, *section, place)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn keep(&mut self, array: Array, section: Section, place: &str) -> Result<(), MeshError> {
        let piece = self
            .pieces
            .last_mut()
            .ok_or_else(|| malformed(place, "an array stands outside of a piece".to_owned()))?;
        match (section, array.name.as_str()) {
            (Section::Points, _) => piece.coordinates = Some(array),
            (Section::Polygons, "connectivity") => piece.connectivity = Some(array),
            (Section::Polygons, "offsets") => piece.offsets = Some(array),
            _ => {}
        }
        Ok(())
    }
}

/// The text up to the end of a data array, which may hold nested tags.
pub(crate) fn text_of(
    reader: &mut Reader<&[u8]>,
    tag: &BytesStart<'_>,
    place: &str,
) -> Result<Vec<u8>, MeshError> {
    let mut text = Vec::new();
    loop {
        match reader.read_event().map_err(|e| malformed(place, e.to_string()))? {
            Event::Text(part) => text.extend_from_slice(part.as_bytes()),
            Event::End(end) if end.name() == tag.name() => return Ok(text),
            Event::Eof => {
                return Err(malformed(place, "the file ends within this array".to_owned()));
            }
            // Some writers nest what is known of the array, such as its range.
            Event::Start(nested) => {
                let nested = nested.to_owned();
                text_of(reader, &nested, place)?;
            }
            _ => {}
        }
    }
}

pub(crate) fn attribute(
    tag: &BytesStart<'_>,
    name: &str,
    place: &str,
) -> Result<Option<String>, MeshError> {
    let attribute =
        tag.try_get_attribute(name).map_err(|error| malformed(place, error.to_string()))?;
    Ok(attribute.map(|attribute| attribute.value.into_owned()))
}

fn number(text: &str, what: &str, place: &str) -> Result<usize, MeshError> {
    text.trim().parse().map_err(|_| malformed(place, format!("{what}=\"{text}\" is not a count")))
}

fn read_piece(
    piece: &Piece,
    conventions: &Conventions,
    appended: Option<Appended<'_>>,
    positions: &mut Vec<DVec3>,
    polygons: &mut Polygons,
) -> Result<(), MeshError> {
    if piece.strips > 0 {
        return Err(unsupported(format!("{} triangle strips", piece.strips)));
    }
    let first = i64::try_from(positions.len()).unwrap_or(i64::MAX);
    if piece.points > 0 {
        let coordinates = needed(piece.coordinates.as_ref(), "Points")?;
        let coordinates = coordinates.floats(conventions, appended)?;
        let (points, rest) = coordinates.as_chunks::<3>();
        if points.len() != piece.points || !rest.is_empty() {
            let found = coordinates.len();
            let problem =
                format!("{} points need three times as many numbers, not {found}", piece.points);
            return Err(malformed("Points", problem));
        }
        positions.extend(points.iter().map(|&point| DVec3::from_array(point)));
    }
    if piece.polygons > 0 {
        let corners = needed(piece.connectivity.as_ref(), "connectivity")?;
        let corners = corners.integers(conventions, appended)?;
        let ends = needed(piece.offsets.as_ref(), "offsets")?.integers(conventions, appended)?;
        if ends.len() != piece.polygons {
            let problem = format!("{} polygons, but {} offsets", piece.polygons, ends.len());
            return Err(malformed("Polys", problem));
        }
        push_polygons(&corners, &ends, first, polygons)?;
    }
    Ok(())
}

fn needed<'a>(array: Option<&'a Array>, name: &str) -> Result<&'a Array, MeshError> {
    array.ok_or_else(|| malformed("Piece", format!("the array '{name}' is missing")))
}

fn push_polygons(
    corners: &[i64],
    ends: &[i64],
    first: i64,
    polygons: &mut Polygons,
) -> Result<(), MeshError> {
    let mut start = 0;
    for (polygon, &end) in ends.iter().enumerate() {
        let end = usize::try_from(end).ok().filter(|end| (start..=corners.len()).contains(end));
        let Some(end) = end else {
            let problem = format!("offset {polygon} does not lie within the connectivity");
            return Err(malformed("Polys", problem));
        };
        // A negative index must stay wrong, however many points precede.
        polygons.push(
            corners[start..end].iter().map(|&v| if v < 0 { v } else { v.saturating_add(first) }),
        );
        start = end;
    }
    Ok(())
}

pub(super) fn malformed(place: &str, problem: String) -> MeshError {
    MeshError::Malformed { format: "VTP", place: place.to_owned(), problem }
}

pub(super) fn unsupported(feature: String) -> MeshError {
    MeshError::Unsupported {
        format: "VTP",
        feature,
        advice: "save it as polygonal data of plain polygons, uncompressed or compressed by zlib",
    }
}
