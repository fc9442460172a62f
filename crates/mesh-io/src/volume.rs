//! Volume meshes of files, behind their boundary surfaces.

use std::ops::Range;

use glam::DVec3;
use volume_mesh::{Boundary, VolumeMesh};

/// Volume mesh of a file, whose boundary is the surface of the [`Mesh`](crate::Mesh).
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Tetrahedra, wedges and hexahedra, in the order of the file, those of quadratic elements by their corners, and
    /// linear hexahedra and wedges with repeated nodes as the wedges and tetrahedra that they are.
    pub mesh: VolumeMesh,
    /// Positions of all nodes, in the order of the file; of a part with nodes of its own, of these.
    pub nodes: Vec<DVec3>,
    /// Index of the first of them among all nodes of the file.
    pub first_node: u32,
    /// Triangles around the cells; a vertex of the surface is a node of theirs.
    pub boundary: Boundary,
    /// Number of each node in the file: counted from 0 in VTK files, given by the file in others.
    pub node_numbers: Vec<u64>,
    /// Number of each cell in the file, likewise.
    pub cell_numbers: Vec<u64>,
}

/// Elements that are the mesh of a file: those of a surface beside cells are skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum MeshElements {
    #[default]
    Cells,
    Polygons,
}

/// Nodes of a file with their numbers there.
#[derive(Clone, Debug, Default)]
pub(crate) struct NumberedNodes {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) numbers: Vec<u64>,
}

impl NumberedNodes {
    /// Returns the nodes of a range.
    pub(crate) fn within(&self, range: Range<usize>) -> Self {
        let positions = self.positions.get(range.clone()).unwrap_or_default().to_vec();
        Self { positions, numbers: self.numbers.get(range).unwrap_or_default().to_vec() }
    }

    /// Returns some of the nodes, by their indices.
    pub(crate) fn of(&self, indices: &[u32]) -> Self {
        let (mut positions, mut numbers) = (Vec::new(), Vec::new());
        for &index in indices {
            positions.push(self.positions[index as usize]);
            numbers.push(self.numbers[index as usize]);
        }
        Self { positions, numbers }
    }
}
