//! VTK polygonal data (`.vtp`): points and polygons of all pieces as one mesh.

use glam::DVec3;

use super::array::DataArray;
use super::xml::Element;
use super::{Dialect, VtkFile};
use crate::mesh::{Mesh, Polygons};
use crate::{FilePlace, ReadError};

const VTP: Dialect = Dialect {
    format: "VTP",
    dataset: "PolyData",
    remedy: "save it as polygonal data of plain polygons, uncompressed or compressed by zlib",
};

/// Reads the points and polygons of a VTP file.
pub(crate) fn parse_vtp(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let file = VtkFile::parse(bytes, &VTP)?;
    let mut positions = Vec::new();
    let mut polygons = Polygons::default();
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
    let Some(array) = piece.child("Points").and_then(|points| points.child("DataArray")) else {
        return Err(VTP.missing(FilePlace::Array("Points".to_owned())));
    };
    let coordinates = DataArray::new(file, array).floats()?;

    let (points, rest) = coordinates.as_chunks::<3>();
    if points.len() != count || !rest.is_empty() {
        let found = coordinates.len();
        let problem = format!("{count} points need three times as many numbers, not {found}");
        return Err(VTP.malformed(FilePlace::Element("Points".to_owned()), problem));
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
        return Err(VTP.unsupported(format!("{strips} triangle strips")));
    }
    let count = count(piece, "NumberOfPolys")?;
    if count == 0 {
        return Ok(());
    }
    // Polygons one after the other, and where each ends.
    let section = piece.child("Polys");
    let corners = needed(file, section, "connectivity")?.integers()?;
    let ends = needed(file, section, "offsets")?.integers()?;
    let malformed = |problem| VTP.malformed(FilePlace::Element("Polys".to_owned()), problem);
    if ends.len() != count {
        return Err(malformed(format!("{count} polygons, but {} offsets", ends.len())));
    }

    let mut start = 0;
    for (polygon, &end) in ends.iter().enumerate() {
        let end = usize::try_from(end).unwrap_or(usize::MAX);
        let Some(range) = corners.get(start..end) else {
            let problem = format!("offset {polygon} does not lie within the connectivity");
            return Err(malformed(problem));
        };
        // A negative index must stay wrong, however many points precede.
        let shift = |&corner: &i64| if corner < 0 { corner } else { corner.saturating_add(first) };
        polygons.push(range.iter().map(shift));
        start = end;
    }
    Ok(())
}

/// Returns a count among the attributes of a piece, 0 where it is left out.
fn count(piece: &Element, name: &str) -> Result<usize, ReadError> {
    let text = piece.attribute(name).unwrap_or("0");
    match text.trim().parse() {
        Ok(count) => Ok(count),
        Err(_) => Err(VTP.malformed_at(piece, format!("{name}=\"{text}\" is not a count"))),
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
