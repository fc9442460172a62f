//! VTK polygonal data (`.vtp`): points and polygons of all pieces as one mesh.

use glam::DVec3;

use super::array::DataArray;
use super::xml::Element;
use super::{Dialect, VtkFile};
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::text::quoted;
use crate::{FilePlace, ReadError};

const VTP: Dialect = Dialect {
    format: Format {
        name: "VTP",
        remedy: "save it as polygonal data of plain polygons, uncompressed or compressed by zlib",
    },
    dataset: "PolyData",
};

/// Reads the points and polygons of a VTP file.
pub(crate) fn parse_vtp(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let file = VtkFile::parse(bytes, &VTP)?;
    let (mut positions, mut polygons) = (Vec::new(), Polygons::default());

    // Each piece counts its own points from 0.
    for piece in file.dataset.children("Piece") {
        let first = i64::try_from(positions.len()).unwrap_or(i64::MAX);
        read_points(&file, piece, &mut positions)?;
        read_polygons(&file, piece, first, &mut polygons)?;
    }

    Mesh::assemble(positions, &polygons)
}

fn read_points(
    file: &VtkFile<'_>,
    piece: &Element,
    positions: &mut Vec<DVec3>,
) -> Result<(), ReadError> {
    let count = count(piece, "NumberOfPoints")?;
    if count == 0 {
        return Ok(());
    }
    let points = piece.child("Points");
    let Some(array) = points.and_then(|points| points.child("DataArray")) else {
        return Err(VTP.missing(FilePlace::Array("Points".to_owned())));
    };
    let coordinates = DataArray::new(file, array).floats(count.saturating_mul(3))?;

    let (points, rest) = coordinates.as_chunks::<3>();
    if points.len() != count || !rest.is_empty() {
        let found = coordinates.len();
        let problem = format!("{count} points need three times as many numbers, not {found}");
        return Err(VTP.format.malformed(FilePlace::Element("Points".to_owned()), problem));
    }
    positions.extend(points.iter().map(|&point| DVec3::from_array(point)));
    Ok(())
}

/// Reads the polygons of a piece whose points are numbered from `first`.
fn read_polygons(
    file: &VtkFile<'_>,
    piece: &Element,
    first: i64,
    polygons: &mut Polygons,
) -> Result<(), ReadError> {
    let strips = count(piece, "NumberOfStrips")?;
    if strips > 0 {
        return Err(VTP.format.unsupported(format!("{strips} triangle strips")));
    }
    let count = count(piece, "NumberOfPolys")?;
    if count == 0 {
        return Ok(());
    }

    // Where each polygon ends, and their corners one after the other.
    let section = piece.child("Polys");
    let ends = needed(file, section, "offsets")?.integers(count)?;
    let corner_count = ends.last().map_or(0, |&end| usize::try_from(end).unwrap_or(usize::MAX));
    let corners = needed(file, section, "connectivity")?.integers(corner_count)?;
    if ends.len() != count {
        let problem = format!("{count} polygons, but {} offsets", ends.len());
        return Err(in_polygons(problem));
    }

    let mut start = 0;
    for (polygon, &end) in ends.iter().enumerate() {
        let end = usize::try_from(end).unwrap_or(usize::MAX);
        let Some(range) = corners.get(start..end) else {
            let problem = format!("offset {polygon} does not lie within the connectivity");
            return Err(in_polygons(problem));
        };
        polygons.push(range.iter().map(|&corner| shifted(corner, first)));
        start = end;
    }
    Ok(())
}

fn in_polygons(problem: String) -> ReadError {
    VTP.format.malformed(FilePlace::Element("Polys".to_owned()), problem)
}

/// Returns the number among all points of a piece's point. A negative one must stay
/// wrong, however many points precede.
fn shifted(corner: i64, first: i64) -> i64 {
    if corner < 0 { corner } else { corner.saturating_add(first) }
}

/// Returns a count among the attributes of a piece, 0 where it is left out.
fn count(piece: &Element, name: &str) -> Result<usize, ReadError> {
    let text = piece.attribute(name).unwrap_or("0");
    match text.trim().parse() {
        Ok(count) => Ok(count),
        Err(_) => Err(VTP.malformed_at(piece, format!("{name}={} is not a count", quoted(text)))),
    }
}

/// Returns the array of a name in a section of a piece.
fn needed<'a>(
    file: &'a VtkFile<'a>,
    section: Option<&'a Element>,
    name: &str,
) -> Result<DataArray<'a>, ReadError> {
    match section.and_then(|section| section.array(name)) {
        Some(array) => Ok(DataArray::new(file, array)),
        None => Err(VTP.missing(FilePlace::Array(name.to_owned()))),
    }
}
