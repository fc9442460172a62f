//! VTK polygonal data (`.vtp`): points and polygons of all pieces as one mesh.

use super::piece::{Piece, shifted};
use super::{Dialect, VtkFile};
use crate::ReadError;
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};

pub(super) const VTP: Dialect = Dialect {
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

    for piece in Piece::all(&file) {
        // Polygons of a piece count its own points from 0.
        let first = i64::try_from(positions.len()).unwrap_or(i64::MAX);
        piece.read_points(&mut positions)?;
        let strips = piece.count("NumberOfStrips")?;
        if strips > 0 {
            return Err(VTP.format.unsupported(format!("{strips} triangle strips")));
        }

        // An empty piece need not have the arrays of polygons.
        let count = piece.count("NumberOfPolys")?;
        if count == 0 {
            continue;
        }
        for corners in piece.cells("Polys", count)?.iter() {
            polygons.push(corners.iter().map(|&corner| shifted(corner, first)));
        }
    }

    Ok(Mesh { space: file.space(), ..Mesh::assemble(positions, &polygons)? })
}
