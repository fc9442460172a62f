//! Cells of volume meshes: nodes, faces and corners in the order of VTK, Abaqus and Gmsh.

/// Cell of a volume mesh, by the numbers of its nodes.
///
/// The order is that of Abaqus (C3D4, C3D6, C3D8) and Gmsh, and but for wedges that of VTK: the fourth
/// node of a tetrahedron lies on the side of the first three from which they turn counterclockwise; wedges
/// and hexahedra have the nodes of their base, counterclockwise seen from above, then those above them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Four nodes.
    Tetrahedron([u32; 4]),
    /// Six nodes.
    Wedge([u32; 6]),
    /// Eight nodes.
    Hexahedron([u32; 8]),
}

/// Faces of a tetrahedron, counterclockwise seen from outside.
const TETRAHEDRON_FACES: [&[usize]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];

/// Faces of a wedge, counterclockwise seen from outside.
const WEDGE_FACES: [&[usize]; 5] =
    [&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];

/// Faces of a hexahedron, counterclockwise seen from outside.
const HEXAHEDRON_FACES: [&[usize]; 6] =
    [&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];

/// Corners of a tetrahedron: a node, and the three at the ends of its edges, as a right-handed frame.
const TETRAHEDRON_CORNERS: [[usize; 4]; 4] =
    [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]];

/// Corners of a wedge, likewise.
const WEDGE_CORNERS: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [1, 2, 0, 4], [2, 0, 1, 5], [3, 5, 4, 0], [4, 3, 5, 1], [5, 4, 3, 2]];

/// Corners of a hexahedron, likewise.
const HEXAHEDRON_CORNERS: [[usize; 4]; 8] = [
    [0, 1, 3, 4],
    [1, 2, 0, 5],
    [2, 3, 1, 6],
    [3, 0, 2, 7],
    [4, 7, 5, 0],
    [5, 4, 6, 1],
    [6, 5, 7, 2],
    [7, 6, 4, 3],
];

impl Cell {
    /// Returns the numbers of the nodes.
    #[must_use]
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Tetrahedron(nodes) => nodes,
            Self::Wedge(nodes) => nodes,
            Self::Hexahedron(nodes) => nodes,
        }
    }

    /// Returns the nodes of each face, by their places in the cell.
    pub(crate) fn faces(&self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron(_) => &TETRAHEDRON_FACES,
            Self::Wedge(_) => &WEDGE_FACES,
            Self::Hexahedron(_) => &HEXAHEDRON_FACES,
        }
    }

    /// Returns each corner with the ends of its three edges, by their places in the cell.
    pub(crate) fn corners(&self) -> &'static [[usize; 4]] {
        match self {
            Self::Tetrahedron(_) => &TETRAHEDRON_CORNERS,
            Self::Wedge(_) => &WEDGE_CORNERS,
            Self::Hexahedron(_) => &HEXAHEDRON_CORNERS,
        }
    }
}
