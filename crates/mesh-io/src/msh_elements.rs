//! Elements of MSH files, by the numbers of their types.

use crate::error::Format;
use crate::solid::Solid;
use crate::text_nodes::TextNodes;
use crate::{FilePlace, ReadError};

pub(crate) const MSH: Format = Format {
    name: "MSH",
    remedy: "save it as text in version 4.1 or 2.2, with tetrahedra, wedges and hexahedra, or linear \
             triangles and quadrilaterals",
};

/// Numbers of element types without volume: points, lines and surfaces of any order.
pub(crate) const WITHOUT_VOLUME: [u64; 18] =
    [1, 2, 3, 8, 9, 10, 15, 16, 20, 21, 22, 23, 24, 25, 26, 27, 28, 36];

/// Numbers of element types of surfaces that are not linear.
pub(crate) const CURVED_SURFACES: [u64; 10] = [9, 10, 16, 20, 21, 22, 23, 24, 25, 36];

/// Number of the element type of linear triangles.
pub(crate) const TRIANGLE: u64 = 2;

/// Number of the element type of linear quadrilaterals.
pub(crate) const QUADRILATERAL: u64 = 3;

/// Edges of a quadratic tetrahedron in the order of Gmsh.
const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [3, 0], [2, 3], [1, 3]];

/// Edges of a quadratic wedge, likewise.
const WEDGE_EDGES: [[usize; 2]; 9] =
    [[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]];

/// Edges of a quadratic hexahedron, likewise.
const HEXAHEDRON_EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [0, 3],
    [0, 4],
    [1, 2],
    [1, 5],
    [2, 3],
    [2, 6],
    [3, 7],
    [4, 5],
    [4, 7],
    [5, 6],
    [6, 7],
];

/// Element of a file.
#[derive(Debug)]
pub(crate) struct MshElement<'a> {
    pub(crate) at: FilePlace,
    /// Number of the element, of the first copy where the file has it once per group.
    pub(crate) number: u64,
    /// True if it is the same element as one before, in another group.
    pub(crate) is_copy: bool,
    pub(crate) kind: u64,
    /// Numbers of the physical groups that it is in.
    pub(crate) groups: &'a [u64],
    pub(crate) nodes: &'a [u64],
}

/// Returns the solid of an element type.
pub(crate) fn solid(kind: u64) -> Option<Solid> {
    match kind {
        4 => Some(Solid::TETRAHEDRON),
        5 => Some(Solid::HEXAHEDRON),
        6 => Some(Solid::WEDGE),
        11 => Some(Solid::TETRAHEDRON.with_edges(&TETRAHEDRON_EDGES)),
        17 => Some(Solid::HEXAHEDRON.with_edges(&HEXAHEDRON_EDGES)),
        18 => Some(Solid::WEDGE.with_edges(&WEDGE_EDGES)),
        _ => None,
    }
}

impl MshElement<'_> {
    /// Returns the indices of its nodes, where there are `count`.
    pub(crate) fn indices(&self, known: &TextNodes, count: usize) -> Result<Vec<u32>, ReadError> {
        known.indices(&MSH, &self.at, self.nodes, count)
    }
}
