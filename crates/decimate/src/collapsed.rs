//! Surface after some collapses.

use crate::order::Collapse;

/// Remaining part of a surface after the first collapses of a sequence.
pub(crate) struct Collapsed {
    /// Per vertex of the full surface, the one that it has moved into, in the full surface's
    /// numbers.
    pub(crate) moved_into: Vec<u32>,
    /// Per remaining vertex, its number in the full surface, ascending.
    pub(crate) kept: Vec<u32>,
    /// Corners of the remaining faces, in numbers of `kept`.
    pub(crate) faces: Vec<[u32; 3]>,
}

impl Collapsed {
    pub(crate) fn new(vertices: usize, faces: &[[u32; 3]], collapses: &[Collapse]) -> Self {
        // Faces with two corners in one vertex have vanished.
        let moved_into = moved_into(vertices, collapses);
        let mut remaining = Vec::new();
        for corners in faces {
            let [a, b, c] = corners.map(|v| moved_into[v as usize]);
            if a != b && b != c && c != a {
                remaining.push([a, b, c]);
            }
        }
        let kept = renumber(&mut remaining, vertices);
        Self { moved_into, kept, faces: remaining }
    }
}

/// Numbers the vertices that faces use in ascending order, and returns them.
fn renumber(faces: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut kept: Vec<u32> = faces.as_flattened().to_vec();
    kept.sort_unstable();
    kept.dedup();

    // The number of a vertex is its position in the list.
    let mut numbers = vec![u32::MAX; vertices];
    for (number, &vertex) in (0_u32..).zip(&kept) {
        numbers[vertex as usize] = number;
    }
    for corner in faces.as_flattened_mut() {
        *corner = numbers[*corner as usize];
    }
    kept
}

/// Follows every vertex through the collapses, from the last to the first: the vertex that one
/// moves into has then been followed before.
fn moved_into(vertices: usize, collapses: &[Collapse]) -> Vec<u32> {
    let mut moved_into: Vec<u32> = (0_u32..).take(vertices).collect();
    for collapse in collapses.iter().rev() {
        moved_into[collapse.vertex as usize] = moved_into[collapse.into as usize];
    }
    moved_into
}
