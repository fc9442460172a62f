//! Degenerate cells: wedges and tetrahedra that are written as cells of more nodes, some of them repeated.
//!
//! Repeated nodes collapse edges of a cell, and faces to edges or points. What remains of the faces decides: where
//! it is the surface of a wedge or of a tetrahedron, the cell is that one, with the same volume. Faces keep their
//! turn, so that the orientation is that of the cell.

use crate::Cell;

impl Cell {
    /// Returns the first node that is a node of the cell before, by its number.
    #[must_use]
    pub fn repeated_node(&self) -> Option<u32> {
        let nodes = self.nodes();
        let mut places = 0..nodes.len();
        places.find(|&place| nodes[..place].contains(&nodes[place])).map(|place| nodes[place])
    }

    /// Returns the wedge or tetrahedron that a cell with repeated nodes is; `None` where it is none, as pyramids
    /// are. A cell without repeated nodes is returned as it is.
    #[must_use]
    pub fn collapsed(&self) -> Option<Self> {
        if self.repeated_node().is_none() {
            return Some(*self);
        }
        let faces = self.collapsed_faces()?;
        let cell = match faces.len() {
            4 => tetrahedron(&faces),
            5 => wedge(&faces),
            _ => None,
        };
        cell.filter(|cell| has_faces(cell, &faces))
    }

    /// Returns the faces with a node for each collapsed edge, without those that are no area any more; `None` where
    /// a face has a repeated node that is not at the end of a collapsed edge.
    fn collapsed_faces(&self) -> Option<Vec<Vec<u32>>> {
        let mut faces = Vec::new();
        for places in self.faces() {
            let mut face: Vec<u32> = places.iter().map(|&place| self.nodes()[place]).collect();
            face.dedup();
            if face.len() > 1 && face.first() == face.last() {
                face.pop();
            }

            let is_repeated = |place: usize| face[..place].contains(&face[place]);
            if (0..face.len()).any(is_repeated) {
                return None;
            }
            if face.len() > 2 {
                faces.push(face);
            }
        }
        Some(faces)
    }
}

/// Returns the tetrahedron on the first face.
fn tetrahedron(faces: &[Vec<u32>]) -> Option<Cell> {
    let &[a, b, c] = &faces.first()?[..] else { return None };
    let apex = faces.iter().flatten().find(|node| ![a, b, c].contains(node))?;
    // Seen from inside, the base turns the other way.
    Some(Cell::Tetrahedron([a, c, b, *apex]))
}

/// Returns the wedge whose base is the first triangle.
fn wedge(faces: &[Vec<u32>]) -> Option<Cell> {
    let &[a, c, b] = &faces.iter().find(|face| face.len() == 3)?[..] else { return None };
    let [above_b, above_a] = opposite_edge(faces, [a, b])?;
    let [above_c, _] = opposite_edge(faces, [b, c])?;
    Some(Cell::Wedge([a, b, c, above_a, above_b, above_c]))
}

/// Returns the edge of a quadrilateral that follows after an edge and the one next to it.
fn opposite_edge(faces: &[Vec<u32>], edge: [u32; 2]) -> Option<[u32; 2]> {
    faces.iter().filter(|face| face.len() == 4).find_map(|face| {
        let node = |place: usize| face[place % face.len()];
        let start = (0..face.len()).find(|&place| [node(place), node(place + 1)] == edge)?;
        Some([node(start + 2), node(start + 3)])
    })
}

/// Returns true if the faces of a cell are these, as many as it has, each with its turn.
fn has_faces(cell: &Cell, faces: &[Vec<u32>]) -> bool {
    let is_there = |places: &&[usize]| {
        let mut face: Vec<u32> = places.iter().map(|&place| cell.nodes()[place]).collect();
        (0..face.len()).any(|_| {
            face.rotate_left(1);
            faces.contains(&face)
        })
    };
    cell.faces().iter().all(is_there)
}
