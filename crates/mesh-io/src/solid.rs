//! Types of solid elements: the cell of their corners, and the edges that have a node in their middle.

use volume_mesh::{Cell, MiddleNode};

/// Type of a solid element, by the order of its nodes: corners, then those in the middle of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Solid {
    shape: Shape,
    /// Ends of the edges with a node in their middle, by their places among the corners.
    edges: &'static [[usize; 2]],
}

/// Shape of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Tetrahedron,
    Wedge,
    Hexahedron,
}

/// Edges of a quadratic tetrahedron in the order of VTK and Abaqus.
const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Edges of a quadratic wedge, likewise.
const WEDGE_EDGES: [[usize; 2]; 9] =
    [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];

/// Edges of a quadratic hexahedron, likewise.
const HEXAHEDRON_EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

impl Solid {
    pub(crate) const TETRAHEDRON: Self = Self { shape: Shape::Tetrahedron, edges: &[] };
    pub(crate) const WEDGE: Self = Self { shape: Shape::Wedge, edges: &[] };
    pub(crate) const HEXAHEDRON: Self = Self { shape: Shape::Hexahedron, edges: &[] };
    pub(crate) const QUADRATIC_TETRAHEDRON: Self = Self::TETRAHEDRON.with_edges(&TETRAHEDRON_EDGES);
    pub(crate) const QUADRATIC_WEDGE: Self = Self::WEDGE.with_edges(&WEDGE_EDGES);
    pub(crate) const QUADRATIC_HEXAHEDRON: Self = Self::HEXAHEDRON.with_edges(&HEXAHEDRON_EDGES);

    /// Returns the type with nodes in the middle of edges in another order.
    pub(crate) const fn with_edges(self, edges: &'static [[usize; 2]]) -> Self {
        Self { shape: self.shape, edges }
    }

    /// Returns the number of nodes of an element.
    pub(crate) fn node_count(self) -> usize {
        let corners = match self.shape {
            Shape::Tetrahedron => 4,
            Shape::Wedge => 6,
            Shape::Hexahedron => 8,
        };
        corners + self.edges.len()
    }
}

/// Solid elements of a file with their numbers there.
#[derive(Debug, Default)]
pub(crate) struct NumberedCells {
    pub(crate) cells: Vec<Cell>,
    pub(crate) numbers: Vec<u64>,
    pub(crate) middle_nodes: Vec<MiddleNode>,
    /// True for each cell whose element has no nodes but corners.
    are_linear: Vec<bool>,
}

impl NumberedCells {
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Adds all elements of others behind its own, with `shift` added to the indices of their nodes.
    pub(crate) fn append(&mut self, others: &Self, shift: u32) {
        let shifted = |node: u32| node + shift;
        self.cells.extend(others.cells.iter().map(|cell| match *cell {
            Cell::Tetrahedron(nodes) => Cell::Tetrahedron(nodes.map(shifted)),
            Cell::Wedge(nodes) => Cell::Wedge(nodes.map(shifted)),
            Cell::Hexahedron(nodes) => Cell::Hexahedron(nodes.map(shifted)),
        }));
        self.numbers.extend(&others.numbers);
        self.are_linear.extend(&others.are_linear);
        for &MiddleNode { node, ends } in &others.middle_nodes {
            self.middle_nodes.push(MiddleNode::new(node + shift, ends.map(shifted)));
        }
    }

    /// Returns the elements at some places, with all nodes in the middle of edges.
    pub(crate) fn filtered(&self, is_wanted: impl Fn(usize) -> bool) -> Self {
        let mut filtered = Self { middle_nodes: self.middle_nodes.clone(), ..Self::default() };
        for place in (0..self.cells.len()).filter(|&place| is_wanted(place)) {
            filtered.cells.push(self.cells[place]);
            filtered.numbers.push(self.numbers[place]);
            filtered.are_linear.push(self.are_linear[place]);
        }
        filtered
    }

    /// Takes linear elements with repeated nodes for the wedges and tetrahedra that they are. Others stay as they
    /// are, and are refused for these nodes.
    pub(crate) fn collapse(&mut self) {
        for (cell, &is_linear) in self.cells.iter_mut().zip(&self.are_linear) {
            if let Some(collapsed) = cell.collapsed().filter(|_| is_linear) {
                *cell = collapsed;
            }
        }
    }

    /// Adds an element. Returns false where it has another number of nodes than its type.
    pub(crate) fn push(&mut self, number: u64, solid: Solid, nodes: &[u32]) -> bool {
        if nodes.len() != solid.node_count() {
            return false;
        }
        let (corners, middle) = nodes.split_at(nodes.len() - solid.edges.len());
        let cell = match solid.shape {
            Shape::Tetrahedron => corners.try_into().map(Cell::Tetrahedron),
            Shape::Wedge => corners.try_into().map(Cell::Wedge),
            Shape::Hexahedron => corners.try_into().map(Cell::Hexahedron),
        };
        let Ok(cell) = cell else { return false };
        self.cells.push(cell);
        self.numbers.push(number);
        self.are_linear.push(solid.edges.is_empty());
        for (&node, edge) in middle.iter().zip(solid.edges) {
            self.middle_nodes.push(MiddleNode::new(node, edge.map(|place| corners[place])));
        }
        true
    }
}
