//! VTK unstructured grids (`.vtu`): points, and tetrahedra and hexahedra, or else polygons, of all pieces
//! as one mesh.
//!
//! Cells without volume are skipped where others have some; other cells with volume are refused. The writer takes values
//! per node, as that of surfaces does.

use glam::DVec3;
use volume_mesh::{Cell, VolumeMesh};

use super::piece::{Piece, shifted};
use super::write::{array, field_data, point_arrays};
use super::{Dialect, PointValues, VtkFile};
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::volume::{NumberedCells, NumberedNodes};
use crate::{ReadError, Space};

pub(super) const VTU: Dialect = Dialect {
    format: Format {
        name: "VTU",
        remedy: "save it as an unstructured grid of linear tetrahedra and hexahedra, or of polygons, \
                 uncompressed or compressed by zlib",
    },
    dataset: "UnstructuredGrid",
};

/// VTK's number of triangles.
const TRIANGLE: i64 = 5;

/// VTK's number of polygons of any number of corners.
const POLYGON: i64 = 7;

/// VTK's number of rectangles whose corners stand row by row.
const PIXEL: i64 = 8;

/// VTK's number of quadrilaterals.
const QUADRILATERAL: i64 = 9;

/// VTK's numbers of cells of surfaces: strips and those of higher order among them, which cannot be read.
const SURFACES: [i64; 11] = [TRIANGLE, 6, POLYGON, PIXEL, QUADRILATERAL, 22, 23, 28, 30, 34, 36];

/// VTK's number of linear tetrahedra.
const TETRAHEDRON: u8 = 10;

/// VTK's number of linear hexahedra.
const HEXAHEDRON: u8 = 12;

/// VTK's numbers of cells without volume: points, lines and surfaces of any order.
const WITHOUT_VOLUME: [i64; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35, 36];

/// Reads the points and cells of a VTU file.
pub(crate) fn parse_vtu(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let file = VtkFile::parse(bytes, &VTU)?;
    let (mut nodes, mut cells, mut number) = (Vec::new(), NumberedCells::default(), 0);
    let (mut polygons, mut unread_surface) = (Polygons::default(), None);

    for piece in Piece::all(&file) {
        // Cells of a piece count its own points from 0.
        let first = i64::try_from(nodes.len()).unwrap_or(i64::MAX);
        piece.read_points(&mut nodes)?;
        let count = piece.count("NumberOfCells")?;
        if count == 0 {
            continue;
        }
        let points = piece.cells("Cells", count)?;
        let types = piece.array("Cells", "types")?.integers(count)?;
        if types.len() != count {
            let problem = format!("{count} cells, but {} types", types.len());
            return Err(piece.malformed("Cells", problem));
        }

        // A cell without volume is left out, but keeps its number in the file.
        for (points, kind) in points.iter().zip(types) {
            if let Some(corners) = polygon(kind, points) {
                polygons.push(corners.into_iter().map(|corner| shifted(corner, first)));
            } else if let Some(cell) = cell(&piece, kind, points, first, number)? {
                cells.push(number, cell);
            } else if SURFACES.contains(&kind) {
                unread_surface = Some(kind);
            }
            number += 1;
        }
    }

    let numbers = (0..nodes.len() as u64).collect();
    let nodes = NumberedNodes { positions: nodes, numbers };
    if let (true, Some(kind)) = (cells.is_empty(), unread_surface) {
        return Err(unsupported_type(kind));
    }
    let mesh = Mesh::of_elements(nodes, cells, &polygons)?;
    Ok(Mesh { space: file.space(), ..mesh })
}

/// Returns the corners of a polygon in their order around it; `None` for other cells.
fn polygon(kind: i64, points: &[i64]) -> Option<Vec<i64>> {
    match (kind, points) {
        (TRIANGLE, [_, _, _]) | (QUADRILATERAL, [_, _, _, _]) | (POLYGON, _) => {
            Some(points.to_vec())
        }
        (PIXEL, &[a, b, c, d]) => Some(vec![a, b, d, c]),
        _ => None,
    }
}

/// Returns a cell of a type; `None` for those without volume.
fn cell(
    piece: &Piece<'_>,
    kind: i64,
    points: &[i64],
    first: i64,
    number: u64,
) -> Result<Option<Cell>, ReadError> {
    let node = |&point: &i64| u32::try_from(shifted(point, first)).unwrap_or(u32::MAX);
    let nodes: Vec<u32> = points.iter().map(node).collect();
    let cell = if kind == i64::from(TETRAHEDRON) {
        <[u32; 4]>::try_from(nodes).map(Cell::Tetrahedron)
    } else if kind == i64::from(HEXAHEDRON) {
        <[u32; 8]>::try_from(nodes).map(Cell::Hexahedron)
    } else if WITHOUT_VOLUME.contains(&kind) {
        return Ok(None);
    } else {
        return Err(unsupported_type(kind));
    };
    let wrong = |nodes: Vec<u32>| {
        let problem = format!("cell {number} of type {kind} has {} points", nodes.len());
        piece.malformed("Cells", problem)
    };
    cell.map(Some).map_err(wrong)
}

fn unsupported_type(kind: i64) -> ReadError {
    VTU.format.unsupported(format!("cells of VTK's type {kind}"))
}

/// Returns a volume mesh with values per node as a `.vtu` file, which states the space of its nodes
/// where there is one.
#[must_use]
pub fn write_vtu(
    nodes: &[DVec3],
    mesh: &VolumeMesh,
    values: &[PointValues<'_>],
    space: Option<Space>,
) -> String {
    let (mut connectivity, mut ends, mut types) = (Vec::new(), Vec::new(), Vec::new());
    for cell in mesh.cells() {
        connectivity.extend(cell.nodes());
        ends.push(connectivity.len() as u64);
        let is_tetrahedron = matches!(cell, Cell::Tetrahedron(_));
        types.push(if is_tetrahedron { TETRAHEDRON } else { HEXAHEDRON });
    }

    // Arrays stand inline, as those of surfaces do.
    let connectivity =
        array("UInt32", "connectivity", 1, connectivity.into_iter().map(u32::to_le_bytes));
    let offsets = array("UInt64", "offsets", 1, ends.into_iter().map(u64::to_le_bytes));
    let types = array("UInt8", "types", 1, types.into_iter().map(u8::to_le_bytes));
    let (point_data, points) = point_arrays(nodes, values);
    let field_data = field_data(space);
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid>
{field_data}<Piece NumberOfPoints="{}" NumberOfCells="{}">
{point_data}{points}<Cells>
{connectivity}{offsets}{types}</Cells>
</Piece>
</UnstructuredGrid>
</VTKFile>
"#,
        nodes.len(),
        mesh.cells().len(),
    )
}
