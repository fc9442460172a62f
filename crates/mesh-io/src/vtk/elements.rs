//! Cells of unstructured grids: tetrahedra and hexahedra, or else polygons.

use std::collections::BTreeMap;

use volume_mesh::Cell;

use crate::ReadError;
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::volume::{NumberedCells, NumberedNodes};

/// VTK's number of triangles.
const TRIANGLE: i64 = 5;

/// VTK's number of polygons of any number of corners.
const POLYGON: i64 = 7;

/// VTK's number of rectangles whose corners stand row by row.
const PIXEL: i64 = 8;

/// VTK's number of quadrilaterals.
const QUADRILATERAL: i64 = 9;

/// VTK's number of linear tetrahedra.
pub(super) const TETRAHEDRON: u8 = 10;

/// VTK's number of linear hexahedra.
pub(super) const HEXAHEDRON: u8 = 12;

/// VTK's numbers of cells of surfaces: strips and those of higher order among them, which cannot be read.
const SURFACES: [i64; 11] = [TRIANGLE, 6, POLYGON, PIXEL, QUADRILATERAL, 22, 23, 28, 30, 34, 36];

/// VTK's numbers of cells without volume: points, lines and surfaces of any order.
const WITHOUT_VOLUME: [i64; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35, 36];

/// Cells of a grid, as they are read.
#[derive(Debug, Default)]
pub(super) struct GridElements {
    cells: NumberedCells,
    polygons: Polygons,
    /// Number of cells of surfaces that cannot be read, per type.
    unread_surfaces: BTreeMap<i64, usize>,
    /// Number of cells so far: one without volume keeps its number.
    count: u64,
}

impl GridElements {
    /// Adds a cell of a type, by its points in the grid. A refusal of its number of points is built by
    /// `malformed`.
    pub(super) fn push(
        &mut self,
        format: &Format,
        kind: i64,
        points: &[i64],
        malformed: impl Fn(String) -> ReadError,
    ) -> Result<(), ReadError> {
        let number = self.count;
        self.count += 1;
        if let Some(corners) = polygon(kind, points) {
            self.polygons.push(corners);
            return Ok(());
        }

        let nodes: Vec<u32> =
            points.iter().map(|&point| u32::try_from(point).unwrap_or(u32::MAX)).collect();
        let cell = if kind == i64::from(TETRAHEDRON) {
            <[u32; 4]>::try_from(nodes).map(Cell::Tetrahedron)
        } else if kind == i64::from(HEXAHEDRON) {
            <[u32; 8]>::try_from(nodes).map(Cell::Hexahedron)
        } else if WITHOUT_VOLUME.contains(&kind) {
            if SURFACES.contains(&kind) {
                *self.unread_surfaces.entry(kind).or_default() += 1;
            }
            return Ok(());
        } else {
            return Err(unsupported(format, kind));
        };
        let wrong = |nodes: Vec<u32>| {
            malformed(format!("cell {number} of type {kind} has {} points", nodes.len()))
        };
        self.cells.push(number, cell.map_err(wrong)?);
        Ok(())
    }

    /// Returns the mesh of the cells with volume, or else of the polygons. Other surfaces beside cells are
    /// counted.
    pub(super) fn into_mesh(
        self,
        format: &Format,
        nodes: NumberedNodes,
    ) -> Result<Mesh, ReadError> {
        if let (true, Some(&kind)) = (self.cells.is_empty(), self.unread_surfaces.keys().next()) {
            return Err(unsupported(format, kind));
        }
        let mesh = Mesh::of_elements(nodes, self.cells, &self.polygons)?;
        let mut skipped = mesh.skipped.unwrap_or_default();
        for (kind, count) in self.unread_surfaces {
            skipped.add_all(format!("VTK's type {kind}"), count);
        }
        Ok(Mesh { skipped: skipped.if_any(), ..mesh })
    }
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

fn unsupported(format: &Format, kind: i64) -> ReadError {
    format.unsupported(format!("cells of VTK's type {kind}"))
}
