//! Crossings of the rows of a grid with a surface.
//!
//! Which triangles a row crosses, and between which nodes, is decided exactly: by the rays of
//! [`ray_crosses_triangle`], which are taken to be shifted by an infinitesimal amount, so that
//! they meet no vertex and no edge. A row thus crosses a closed surface as often inward as
//! outward.

use glam::DVec3;
use surface::{Aabb, ray_crosses_triangle, triangle};

use crate::FieldGrid;
use crate::num::{floor_index, nodes_within};

/// Crossing of a row with a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Crossing {
    /// Row `j + ny · k`.
    pub(super) row: usize,
    /// First node beyond or on the triangle.
    pub(super) node: usize,
    /// Change of the number of times that the surface encloses the row: positive where it
    /// enters.
    pub(super) turn: i32,
}

/// Appends the crossings of all rows with one triangle, counted `times`.
pub(super) fn cross(
    grid: &FieldGrid,
    triangle: [DVec3; 3],
    times: i32,
    crossings: &mut Vec<Crossing>,
) {
    let [nx, ny, nz] = grid.dims();
    let Aabb { min, max } = Aabb::of_points(triangle.map(|p| grid.to_spacings(p)));
    // Rounding, of the units and of the positions of rows, may not lose a row that only touches the box.
    let largest = min.abs().max(max.abs()) + (grid.origin() / grid.spacing()).abs();
    let slack = f64::EPSILON * 4.0 * (largest.max_element() + 1.0);
    let before = Aabb::of_points(triangle).min.x - grid.spacing();

    for k in nodes_within(min.z - slack, max.z + slack, nz) {
        for j in nodes_within(min.y - slack, max.y + slack, ny) {
            let start = DVec3 { x: before, ..grid.position([0, j, k]) };
            let Some(outward) = ray_crosses_triangle(start, triangle) else {
                continue;
            };

            // A rounded intersection is at most a node off; exact rays find the node.
            let x = grid.to_spacings(intersection(start, triangle)).x;
            let guess = floor_index(x.max(min.x).min(max.x).ceil()).min(nx);
            let is_beyond =
                |i: usize| ray_crosses_triangle(grid.position([i, j, k]), triangle).is_none();
            let node = first_beyond(guess, nx, is_beyond);
            if node < nx {
                crossings.push(Crossing { row: j + ny * k, node, turn: -outward * times });
            }
        }
    }
}

/// Returns the first node that is beyond, searching from a guess.
fn first_beyond(guess: usize, count: usize, is_beyond: impl Fn(usize) -> bool) -> usize {
    let mut node = guess;
    while node > 0 && is_beyond(node - 1) {
        node -= 1;
    }
    while node < count && !is_beyond(node) {
        node += 1;
    }
    node
}

/// Intersects the row through `p` with the plane of a triangle; not finite where they are
/// parallel.
fn intersection(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = triangle::normal([a, b, c]);
    DVec3 { x: p.x + normal.dot(a - p) / normal.x, ..p }
}
