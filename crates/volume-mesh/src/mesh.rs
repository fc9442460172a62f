//! Cells with checked nodes.

use glam::DVec3;

use crate::{Cell, VolumeError};

/// Cells over numbered nodes, every number checked.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeMesh {
    node_count: usize,
    cells: Vec<Cell>,
    middle_nodes: Vec<MiddleNode>,
}

/// Node in the middle of a straight edge: of quadratic elements, whose corners are a [`Cell`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MiddleNode {
    /// Number of the node.
    pub node: u32,
    /// Numbers of the nodes at the ends of the edge, ascending.
    pub ends: [u32; 2],
}

impl MiddleNode {
    /// Returns the node of an edge whose ends are in any order.
    #[must_use]
    pub fn new(node: u32, mut ends: [u32; 2]) -> Self {
        ends.sort_unstable();
        Self { node, ends }
    }

    /// Returns the middle between the ends.
    pub(crate) fn middle(self, positions: &[DVec3]) -> DVec3 {
        let [a, b] = self.ends.map(|end| positions[end as usize]);
        a.midpoint(b)
    }
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
            let out_of_range = cell.nodes().iter().find(|&&node| node as usize >= node_count);
            if let Some(&node) = out_of_range {
                return Err(VolumeError::NodeOutOfRange { cell: number, node, node_count });
            }
            if let Some(node) = cell.repeated_node() {
                return Err(VolumeError::RepeatedNode { cell: number, node });
            }
        }
        Ok(Self { node_count, cells, middle_nodes: Vec::new() })
    }

    /// Adds the nodes in the middle of edges, each once or several times.
    ///
    /// # Errors
    ///
    /// The first node out of range, on two edges, or at a corner of a cell: [`VolumeError::MiddleNode`].
    pub fn with_middle_nodes(mut self, mut nodes: Vec<MiddleNode>) -> Result<Self, VolumeError> {
        // Cells share edges, of which each has one node.
        nodes.sort_unstable();
        nodes.dedup();
        let mut is_corner = vec![false; self.node_count];
        for &node in self.cells.iter().flat_map(Cell::nodes) {
            is_corner[node as usize] = true;
        }

        let corner = |node: u32| is_corner.get(node as usize).copied();
        for (place, &MiddleNode { node, ends }) in nodes.iter().enumerate() {
            let is_repeated = place > 0 && nodes[place - 1].node == node;
            let stands_apart = corner(node) == Some(false) && !is_repeated;
            if !stands_apart || ends.map(corner) != [Some(true); 2] {
                return Err(VolumeError::MiddleNode { node, ends });
            }
        }
        self.middle_nodes = nodes;
        Ok(self)
    }

    /// Returns the number of nodes, those without a cell included.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.node_count
    }

    /// Returns the nodes of cells and those in the middle of their edges, ascending.
    #[must_use]
    pub fn used_nodes(&self) -> Vec<u32> {
        let corners = self.cells.iter().flat_map(Cell::nodes);
        let mut nodes: Vec<u32> =
            corners.copied().chain(self.middle_nodes.iter().map(|middle| middle.node)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns the nodes in the middle of edges, ascending.
    #[must_use]
    pub fn middle_nodes(&self) -> &[MiddleNode] {
        &self.middle_nodes
    }

    /// Returns the cells.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }
}
