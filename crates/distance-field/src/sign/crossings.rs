//! Crossings of the rows of a grid with a surface.
//!
//! Which triangles a row crosses is decided exactly, by simulation of simplicity: the row is
//! taken to be shifted by an infinitesimal amount along y, and a far smaller one along z, so
//! that it meets no vertex and no edge. A row thus crosses a closed surface as often inward
//! as outward.
//!
//! Source: H. Edelsbrunner and E. P. Mücke, "Simulation of Simplicity", ACM TOG 9(1), 1990;
//! J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates", Discrete & Computational Geometry 18, 1997.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};
use surface::Aabb;

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
    // Rounding of the units may not lose a row that only touches the box.
    let slack = f64::EPSILON * 4.0 * (min.abs().max(max.abs()).max_element() + 1.0);

    for k in nodes_within(min.z - slack, max.z + slack, nz) {
        for j in nodes_within(min.y - slack, max.y + slack, ny) {
            let Some((leaves, x)) = meet(grid.position([0, j, k]), triangle) else {
                continue;
            };
            let guess = ((x - grid.origin().x) / grid.spacing()).ceil();
            let is_beyond = |i: usize| is_beyond(grid.position([i, j, k]), triangle, leaves);
            let node = first_beyond(floor_index(guess.max(0.0)).min(nx), nx, is_beyond);
            let turn = if leaves { -times } else { times };
            if node < nx {
                crossings.push(Crossing { row: j + ny * k, node, turn });
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

/// Intersects the row through `p` with a triangle: true where it leaves by the triangle,
/// whose normal then points along the row, and the x of the intersection. `None` where they
/// do not meet.
fn meet(p: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(bool, f64)> {
    let (u, side_u) = turn(p, b, c);
    let (v, side_v) = turn(p, c, a);
    if side_u != side_v {
        return None;
    }
    let (w, side_w) = turn(p, a, b);
    if side_w != side_u {
        return None;
    }
    let area = u + v + w;
    // A triangle parallel to the row is a line along it: all three areas are 0.
    (area != 0.0).then(|| (side_u, (u * a.x + v * b.x + w * c.x) / area))
}

/// Computes twice the area of `p`, `a`, `b` along x; true where they turn left once `p` is
/// shifted.
#[expect(clippy::float_cmp, reason = "ties are decided, not tolerated")]
fn turn(p: DVec3, a: DVec3, b: DVec3) -> (f64, bool) {
    let flat = |p: DVec3| Coord { x: p.y, y: p.z };
    let area = orient2d(flat(p), flat(a), flat(b));
    let shifted = if a.z == b.z { a.y < b.y } else { a.z > b.z };
    (area, area > 0.0 || (area == 0.0 && shifted))
}

/// Returns true if `p` is on the far side of the triangle along x, or on it.
fn is_beyond(p: DVec3, triangle: [DVec3; 3], leaves: bool) -> bool {
    let side = side(p, triangle);
    if leaves { side <= 0.0 } else { side >= 0.0 }
}

/// Returns a number that is positive below a triangle, where its corners turn right, and 0
/// exactly on its plane.
pub(super) fn side(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let point = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    orient3d(point(a), point(b), point(c), point(p))
}

/// Splits sorted crossings into those of each of `rows` rows.
pub(super) fn by_row(crossings: &[Crossing], rows: usize) -> impl Iterator<Item = &[Crossing]> {
    let mut rest = crossings;
    (0..rows).map(move |row| {
        let count = rest.iter().take_while(|crossing| crossing.row == row).count();
        let (these, others) = rest.split_at(count);
        rest = others;
        these
    })
}
