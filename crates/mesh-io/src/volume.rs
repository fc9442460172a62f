//! Volume meshes of files, behind their boundary surfaces.

use glam::DVec3;
use volume_mesh::{Boundary, Cell, VolumeMesh};

use crate::ReadError;
use crate::mesh::{Mesh, check_positions};

/// Volume mesh of a file, whose boundary is the surface of the [`Mesh`].
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Tetrahedra and hexahedra, in the order of the file.
    pub mesh: VolumeMesh,
    /// Positions of all nodes, in the order of the file.
    pub nodes: Vec<DVec3>,
    /// Triangles around the cells; a vertex of the surface is a node of theirs.
    pub boundary: Boundary,
    /// Number of each node in the file: counted from 0 in VTK files, given by the file in others.
    pub node_numbers: Vec<u64>,
    /// Number of each cell in the file, likewise.
    pub cell_numbers: Vec<u64>,
}

/// Nodes of a file with their numbers there.
#[derive(Debug, Default)]
pub(crate) struct NumberedNodes {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) numbers: Vec<u64>,
}

/// Cells of a file with their numbers there.
#[derive(Debug, Default)]
pub(crate) struct NumberedCells {
    cells: Vec<Cell>,
    numbers: Vec<u64>,
}

impl NumberedCells {
    pub(crate) fn push(&mut self, number: u64, cell: Cell) {
        self.cells.push(cell);
        self.numbers.push(number);
    }
}

impl Mesh {
    /// Checks the nodes and cells of a file, and finds the surface around them.
    pub(crate) fn of_volume(nodes: NumberedNodes, cells: NumberedCells) -> Result<Self, ReadError> {
        let NumberedNodes { positions: nodes, numbers: node_numbers } = nodes;
        check_positions(&nodes)?;
        let mesh = VolumeMesh::new(nodes.len(), cells.cells)?;
        let boundary = mesh.boundary()?;

        let (positions, faces) = (boundary.positions(&nodes), boundary.faces.clone());
        let volume = Volume { mesh, nodes, boundary, node_numbers, cell_numbers: cells.numbers };
        Ok(Self { positions, faces, polygons_fanned: 0, unread: None, volume: Some(volume) })
    }
}
