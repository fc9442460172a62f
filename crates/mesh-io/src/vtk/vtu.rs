//! VTK unstructured grids (`.vtu`): points, and tetrahedra, wedges and hexahedra, or else polygons, of all
//! pieces as one mesh.
//!
//! Cells without volume are skipped where others have some, and counted where they are surfaces apart from
//! these; other cells with volume are refused. The writer takes values per node, as that of surfaces does,
//! and leaves quadratic elements without the nodes in the middle of their edges.

use glam::DVec3;
use volume_mesh::VolumeMesh;

use super::elements::{GridElements, vtk_cell};
use super::piece::{Piece, shifted};
use super::write::{array, field_data, point_arrays};
use super::{Dialect, PointValues, VtkFile};
use crate::error::Format;
use crate::mesh::Mesh;
use crate::volume::NumberedNodes;
use crate::{ReadError, Space};

pub(super) const VTU: Dialect = Dialect {
    format: Format {
        name: "VTU",
        remedy: "save it as an unstructured grid of tetrahedra, wedges and hexahedra, or of polygons, \
                 uncompressed or compressed by zlib",
    },
    dataset: "UnstructuredGrid",
};

/// Reads the points and cells of a VTU file.
pub(crate) fn parse_vtu(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let file = VtkFile::parse(bytes, &VTU)?;
    let (mut nodes, mut elements) = (Vec::new(), GridElements::default());

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

        let malformed = |problem| piece.malformed("Cells", problem);
        for (points, kind) in points.iter().zip(types) {
            let points: Vec<i64> = points.iter().map(|&point| shifted(point, first)).collect();
            elements.push(&VTU.format, kind, &points, malformed)?;
        }
    }

    let numbers = (0..nodes.len() as u64).collect();
    let nodes = NumberedNodes { positions: nodes, numbers };
    let mesh = elements.into_mesh(&VTU.format, nodes)?;
    Ok(Mesh { space: file.space(), ..mesh })
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
        let (kind, nodes) = vtk_cell(cell);
        connectivity.extend(nodes);
        ends.push(connectivity.len() as u64);
        types.push(kind);
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
