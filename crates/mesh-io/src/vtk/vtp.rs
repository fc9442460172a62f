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
    let array = piece.child("Points").and_then(|points| points.child("DataArray"));
    let coordinates = needed(file, array, "Points")?.floats()?;

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
    let array = |name: &'static str| {
        needed(file, piece.child("Polys").and_then(|polygons| polygons.array(name)), name)
    };
    let corners = array("connectivity")?.integers()?;
    let ends = array("offsets")?.integers()?;
    let malformed =
        |problem: String| VTP.malformed(FilePlace::Element("Polys".to_owned()), problem);
    if ends.len() != count {
        return Err(malformed(format!("{count} polygons, but {} offsets", ends.len())));
    }

    let mut start = 0;
    for (polygon, &end) in ends.iter().enumerate() {
        let end = usize::try_from(end).ok().filter(|end| (start..=corners.len()).contains(end));
        let Some(end) = end else {
            let problem = format!("offset {polygon} does not lie within the connectivity");
            return Err(malformed(problem));
        };
        // A negative index must stay wrong, however many points precede.
        let shifted =
            |&corner: &i64| if corner < 0 { corner } else { corner.saturating_add(first) };
        polygons.push(corners[start..end].iter().map(shifted));
        start = end;
    }
    Ok(())
}

/// Returns a count among the attributes of a piece, 0 where it is left out.
fn count(piece: &Element, name: &str) -> Result<usize, ReadError> {
    let text = piece.attribute(name).unwrap_or("0");
    text.trim()
        .parse()
        .map_err(|_| VTP.malformed_at(piece, format!("{name}=\"{text}\" is not a count")))
}

fn needed<'a>(
    file: &'a VtkFile<'a>,
    array: Option<&'a Element>,
    name: &str,
) -> Result<DataArray<'a>, ReadError> {
    let array = array
        .ok_or_else(|| VTP.malformed(FilePlace::Array(name.to_owned()), "is missing".to_owned()))?;
    Ok(DataArray::new(file, array))
}
