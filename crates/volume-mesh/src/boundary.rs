//! Boundary surface of a volume mesh.

use glam::DVec3;

use crate::{VolumeError, VolumeMesh};

/// Triangles around a volume mesh, over the nodes that they use.
///
/// Quadrilaterals are split by the diagonal at their smallest node number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Boundary {
    /// Corners of the triangles, as places in [`nodes`](Self::nodes), counterclockwise seen from
    /// outside.
    pub faces: Vec<[u32; 3]>,
    /// Numbers of the nodes on the boundary, ascending.
    pub nodes: Vec<u32>,
}

/// Face of a cell. Equal faces of two cells differ in all but the key.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct CellFace {
    /// Nodes, ascending; the last is [`u32::MAX`] for a triangle.
    key: [u32; 4],
    cell: usize,
    /// Number of the face in its cell.
    face: usize,
}

impl VolumeMesh {
    /// Finds the faces that belong to one cell alone.
    ///
    /// # Errors
    ///
    /// [`VolumeError::SharedFace`] where three cells or more have a face in common,
    /// [`VolumeError::RepeatedCell`] where two cells have all nodes in common, and
    /// [`VolumeError::NoBoundary`] where no face belongs to one cell alone.
    pub fn boundary(&self) -> Result<Boundary, VolumeError> {
        // Faces with the same nodes stand together.
        let mut faces = self.cell_faces();
        faces.sort_unstable();
        let mut outer = Vec::new();
        for group in faces.chunk_by(|p, q| p.key == q.key) {
            match group {
                [face] => outer.push((face.cell, face.face)),
                [a, b] if self.have_same_nodes(a.cell, b.cell) => {
                    return Err(VolumeError::RepeatedCell { cells: [a.cell, b.cell] });
                }
                [_, _] => {}
                [a, b, c, ..] => {
                    return Err(VolumeError::SharedFace { cells: [a.cell, b.cell, c.cell] });
                }
                [] => {}
            }
        }
        if outer.is_empty() {
            return Err(VolumeError::NoBoundary { cells: self.cells().len() });
        }
        outer.sort_unstable();

        // Triangles by node numbers first, in the order of the cells.
        let mut triangles = Vec::with_capacity(2 * outer.len());
        for (cell, face) in outer {
            let cell = &self.cells()[cell];
            let corners = cell.faces()[face].iter().map(|&place| cell.nodes()[place]);
            push_triangles(&corners.collect::<Vec<u32>>(), &mut triangles);
        }
        Ok(Boundary::over_used_nodes(triangles, self.node_count()))
    }

    /// Returns true if the cells have the same nodes in any order.
    fn have_same_nodes(&self, a: usize, b: usize) -> bool {
        let [a, b] = [a, b].map(|cell| self.cells()[cell].nodes());
        a.len() == b.len() && a.iter().all(|node| b.contains(node))
    }

    fn cell_faces(&self) -> Vec<CellFace> {
        let mut faces = Vec::new();
        for (number, cell) in self.cells().iter().enumerate() {
            for (face, places) in cell.faces().iter().enumerate() {
                let mut key = [u32::MAX; 4];
                for (key, &place) in key.iter_mut().zip(*places) {
                    *key = cell.nodes()[place];
                }
                key.sort_unstable();
                faces.push(CellFace { key, cell: number, face });
            }
        }
        faces
    }
}

/// Adds a triangle, or a quadrilateral split by the diagonal at its smallest node.
fn push_triangles(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let smallest = (0..corners.len()).min_by_key(|&place| corners[place]).unwrap_or(0);
    let corner = |k: usize| corners[(smallest + k) % corners.len()];
    for k in 1..corners.len() - 1 {
        triangles.push([corner(0), corner(k), corner(k + 1)]);
    }
}

impl Boundary {
    /// Numbers the nodes of triangles anew, in ascending order.
    fn over_used_nodes(triangles: Vec<[u32; 3]>, node_count: usize) -> Self {
        let mut places = vec![u32::MAX; node_count];
        for &node in triangles.iter().flatten() {
            places[node as usize] = 0;
        }
        // Marked nodes take their places in ascending order.
        let mut nodes = Vec::new();
        for (node, place) in (0_u32..).zip(&mut places) {
            if *place == 0 {
                *place = u32::try_from(nodes.len()).unwrap_or(u32::MAX);
                nodes.push(node);
            }
        }
        let faces = triangles.into_iter().map(|nodes| nodes.map(|node| places[node as usize]));
        Self { faces: faces.collect(), nodes }
    }

    /// Lists the corners of cells of which all four nodes are on the boundary, as places in [`nodes`](Self::nodes): a
    /// corner, and the ends of its three edges.
    #[must_use]
    pub fn corners(&self, mesh: &VolumeMesh) -> Vec<[u32; 4]> {
        let place = |node: u32| {
            self.nodes.binary_search(&node).ok().and_then(|place| u32::try_from(place).ok())
        };
        let mut corners = Vec::new();
        for cell in mesh.cells() {
            for corner in cell.corners() {
                let places = corner.map(|of_cell| place(cell.nodes()[of_cell]));
                if let [Some(p), Some(a), Some(b), Some(c)] = places {
                    corners.push([p, a, b, c]);
                }
            }
        }
        corners
    }

    /// Returns the positions of the boundary's nodes.
    #[must_use]
    pub fn positions(&self, nodes: &[DVec3]) -> Vec<DVec3> {
        self.nodes.iter().map(|&node| nodes[node as usize]).collect()
    }
}
