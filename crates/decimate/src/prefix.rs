//! The surface after some collapses.

use crate::order::Collapse;

/// What is left of a surface after the first collapses of a sequence.
pub(crate) struct Prefix {
    /// For each vertex of the full surface, the one it has moved into, in the full
    /// surface's numbers.
    pub(crate) moved_into: Vec<u32>,
    /// For each vertex that is left, its number in the full surface, ascending.
    pub(crate) kept: Vec<u32>,
    /// Corners of the faces that are left, as places in `kept`.
    pub(crate) faces: Vec<[u32; 3]>,
    /// For each face that is left, its number in the full surface.
    pub(crate) sources: Vec<u32>,
}

impl Prefix {
    pub(crate) fn new(vertices: usize, faces: &[[u32; 3]], collapses: &[Collapse]) -> Self {
        let moved_into = moved_into(vertices, collapses);
        let mut prefix = Self { moved_into, kept: vec![], faces: vec![], sources: vec![] };
        for (source, corners) in (0_u32..).zip(faces) {
            let [a, b, c] = corners.map(|v| prefix.moved_into[v as usize]);
            if a != b && b != c && c != a {
                prefix.faces.push([a, b, c]);
                prefix.sources.push(source);
            }
        }
        prefix.number_kept();
        prefix
    }

    /// Numbers the vertices that faces use in ascending order.
    fn number_kept(&mut self) {
        let mut places = vec![u32::MAX; self.moved_into.len()];
        for &vertex in self.faces.iter().flatten() {
            places[vertex as usize] = 0;
        }
        let used = (0_u32..).zip(&mut places).filter(|(_, place)| **place == 0);
        for ((vertex, place), number) in used.zip(0..) {
            *place = number;
            self.kept.push(vertex);
        }
        for corner in self.faces.iter_mut().flatten() {
            *corner = places[*corner as usize];
        }
    }
}

/// Follows every vertex to where the collapses leave it: from the last to the
/// first, so that what one moves into has been followed before.
fn moved_into(vertices: usize, collapses: &[Collapse]) -> Vec<u32> {
    let mut moved_into: Vec<u32> = (0_u32..).take(vertices).collect();
    for collapse in collapses.iter().rev() {
        moved_into[collapse.vertex as usize] = moved_into[collapse.into as usize];
    }
    moved_into
}
