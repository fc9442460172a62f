//! Cells with checked nodes.

use crate::{Cell, VolumeError};

/// Cells over numbered nodes, every number checked.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeMesh {
    node_count: usize,
    cells: Vec<Cell>,
}

impl VolumeMesh {
    /// Builds a mesh of cells over nodes that are numbered from 0.
    ///
    /// # Errors
    ///
    /// The first cell with a node out of range or twice, and [`VolumeError::NoCells`].
    pub fn new(node_count: usize, cells: Vec<Cell>) -> Result<Self, VolumeError> {
        if cells.is_empty() {
            return Err(VolumeError::NoCells { nodes: node_count });
        }
        // Later loops index by these numbers without a check.
        for (number, cell) in cells.iter().enumerate() {
            let nodes = cell.nodes();
            for (place, &node) in nodes.iter().enumerate() {
                if node as usize >= node_count {
                    return Err(VolumeError::NodeOutOfRange { cell: number, node, node_count });
                }
                if nodes[..place].contains(&node) {
                    return Err(VolumeError::RepeatedNode { cell: number, node });
                }
            }
        }
        Ok(Self { node_count, cells })
    }

    /// Returns the number of nodes, those without a cell included.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.node_count
    }

    /// Returns the cells.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }
}
