//! Where the rows of a grid cross a surface.
//!
//! Which triangles a row crosses is decided exactly: the row is thought to be
//! shifted by an endless small amount along y, and a far smaller one along z, so
//! that it meets no vertex and no edge. A row thus crosses a closed surface as
//! often inwards as outwards.
//!
//! Source: H. Edelsbrunner and E. P. Mücke, "Simulation of Simplicity", ACM TOG
//! 9(1), 1990; J. R. Shewchuk, "Adaptive precision floating-point arithmetic and
//! fast robust geometric predicates", Discrete & Computational Geometry 18, 1997.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::grid::FieldGrid;
use crate::num::{floor_index, nodes_within};
use crate::par;

/// A row passes through a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Crossing {
    /// Row `j + ny · k`.
    pub(crate) row: usize,
    /// First node beyond or on the triangle.
    pub(crate) node: usize,
    /// 1 for each time that the row goes in, −1 out.
    pub(crate) turn: i32,
}

/// Appends the crossings of all rows with one triangle, counted `times`.
pub(crate) fn cross(grid: &FieldGrid, triangle: [DVec3; 3], times: i32, out: &mut Vec<Crossing>) {
    let [nx, ny, nz] = grid.dims();
    let [a, b, c] = triangle.map(|p| grid.to_units(p));
    let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
    // Rounding of the units may not lose a row that only touches the box.
    let slack = f64::EPSILON * 4.0 * (lo.abs().max(hi.abs()).max_element() + 1.0);
    for k in nodes_within(lo.z - slack, hi.z + slack, nz) {
        for j in nodes_within(lo.y - slack, hi.y + slack, ny) {
            let Some((out_of, x)) = meets(grid.position([0, j, k]), triangle) else {
                continue;
            };
            let guess = ((x - grid.origin().x) / grid.spacing()).ceil();
            let is_beyond = |i: usize| beyond(grid.position([i, j, k]), triangle, out_of);
            let node = settle(floor_index(guess.max(0.0)).min(nx), nx, is_beyond);
            let turn = if out_of { -times } else { times };
            if node < nx {
                out.push(Crossing { row: j + ny * k, node, turn });
            }
        }
    }
}

/// First node that is beyond, near the guess.
fn settle(guess: usize, count: usize, is_beyond: impl Fn(usize) -> bool) -> usize {
    let mut node = guess;
    while node > 0 && is_beyond(node - 1) {
        node -= 1;
    }
    while node < count && !is_beyond(node) {
        node += 1;
    }
    node
}

/// Whether the row through `p` leaves by the triangle (its normal points along
/// the row), and where; none when it misses.
fn meets(p: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(bool, f64)> {
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
    // Seen edge on, down to a line: all three sides are none.
    (area != 0.0).then(|| (side_u, (u * a.x + v * b.x + w * c.x) / area))
}

/// Twice the area of `p`, `a`, `b` seen along x, and whether they turn left
/// once `p` has been shifted.
#[expect(clippy::float_cmp, reason = "ties are decided, not tolerated")]
fn turn(p: DVec3, a: DVec3, b: DVec3) -> (f64, bool) {
    let flat = |p: DVec3| Coord { x: p.y, y: p.z };
    let area = orient2d(flat(p), flat(a), flat(b));
    let shifted = if a.z == b.z { a.y < b.y } else { a.z > b.z };
    (area, area > 0.0 || (area == 0.0 && shifted))
}

/// Whether node `p` is on the far side of the triangle along x, or on it.
fn beyond(p: DVec3, triangle: [DVec3; 3], out_of: bool) -> bool {
    let side = side(p, triangle);
    if out_of { side <= 0.0 } else { side >= 0.0 }
}

/// Positive below a triangle, where its corners turn right as seen.
pub(crate) fn side(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let point = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    orient3d(point(a), point(b), point(c), point(p))
}

/// Crossings sorted by row and node.
pub(crate) fn sorted(mut crossings: Vec<Crossing>) -> Vec<Crossing> {
    par::sort(&mut crossings);
    crossings
}

/// The parts of sorted crossings that belong to each of `rows` rows in turn.
pub(crate) fn by_row(
    crossings: &[Crossing],
    rows: usize,
) -> impl Iterator<Item = &[Crossing]> + Clone {
    let mut rest = crossings;
    (0..rows).map(move |row| {
        let count = rest.iter().take_while(|crossing| crossing.row == row).count();
        let (these, others) = rest.split_at(count);
        rest = others;
        these
    })
}
