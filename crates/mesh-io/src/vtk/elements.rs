//! Cells of unstructured grids: tetrahedra, wedges and hexahedra, or else polygons.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use volume_mesh::Cell;

use crate::ReadError;
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::solid::{NumberedCells, Solid};
use crate::volume::NumberedNodes;

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

/// VTK's numbers of cells without volume: points, lines and surfaces of any order.
const WITHOUT_VOLUME: [i64; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35, 36];

/// Cells of a grid, as they are read.
#[derive(Debug, Default)]
pub(super) struct GridElements {
    cells: NumberedCells,
    polygons: Polygons,
    /// Cells of surfaces that cannot be read, per type.
    unread_surfaces: BTreeMap<i64, Polygons>,
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

        let Some(solid) = solid(kind) else {
            if !WITHOUT_VOLUME.contains(&kind) {
                return Err(unsupported(format, kind));
            }
            if SURFACES.contains(&kind) {
                self.unread_surfaces.entry(kind).or_default().push(points.iter().copied());
            }
            return Ok(());
        };
        let nodes: Vec<u32> =
            points.iter().map(|&point| u32::try_from(point).unwrap_or(u32::MAX)).collect();
        if !self.cells.push(number, solid, &nodes) {
            let problem = format!("cell {number} of type {kind} has {} points", nodes.len());
            return Err(malformed(problem));
        }
        Ok(())
    }

    /// Returns the mesh of the cells with volume, or else of the polygons. Other surfaces beside cells are
    /// counted.
    pub(super) fn into_mesh(
        mut self,
        format: &Format,
        nodes: NumberedNodes,
    ) -> Result<Mesh, ReadError> {
        if let (true, Some(&kind)) = (self.cells.is_empty(), self.unread_surfaces.keys().next()) {
            return Err(unsupported(format, kind));
        }
        let mut others = BTreeMap::new();
        for (kind, polygons) in self.unread_surfaces {
            others.insert(format!("VTK's type {kind}"), polygons);
        }
        turn_wedges(&mut self.cells.cells, &nodes.positions);
        Mesh::of_elements(nodes, self.cells, &self.polygons, &others)
    }
}

/// Returns the solid of a type of VTK; wedges in the order of [`Cell`].
fn solid(kind: i64) -> Option<Solid> {
    match kind {
        10 => Some(Solid::TETRAHEDRON),
        12 => Some(Solid::HEXAHEDRON),
        13 => Some(Solid::WEDGE),
        24 => Some(Solid::QUADRATIC_TETRAHEDRON),
        25 => Some(Solid::QUADRATIC_HEXAHEDRON),
        26 => Some(Solid::QUADRATIC_WEDGE),
        _ => None,
    }
}

/// Returns VTK's number of a cell, and its nodes in the order of VTK: seen from above, the base of a wedge
/// turns clockwise there.
pub(super) fn vtk_cell(cell: &Cell) -> (u8, Vec<u32>) {
    match cell {
        Cell::Tetrahedron(nodes) => (10, nodes.to_vec()),
        Cell::Wedge(nodes) => (13, turned(*nodes).to_vec()),
        Cell::Hexahedron(nodes) => (12, nodes.to_vec()),
    }
}

/// Turns all wedges where most of their volume is negative: files have them in the order of VTK, or, by
/// other writers, in that of [`Cell`].
fn turn_wedges(cells: &mut [Cell], positions: &[DVec3]) {
    let mut total = 0.0;
    for cell in &*cells {
        // Nodes out of range are refused afterwards.
        let place = |node: u32| positions.get(node as usize).copied().unwrap_or_default();
        if let Cell::Wedge(nodes) = cell {
            let [a, b, c, d, e, f] = nodes.map(place);
            // Three tetrahedra: with repeated nodes, some are flat.
            for [p, q, r] in [[b, c, f], [b, f, e], [e, f, d]] {
                total += DMat3::from_cols(p - a, q - a, r - a).determinant();
            }
        }
    }
    if total < 0.0 {
        for cell in cells {
            if let Cell::Wedge(nodes) = cell {
                *nodes = turned(*nodes);
            }
        }
    }
}

/// Returns the nodes of a wedge whose base turns the other way.
fn turned([a, b, c, d, e, f]: [u32; 6]) -> [u32; 6] {
    [a, c, b, d, f, e]
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
