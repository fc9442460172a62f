//! Nodes of a region of any size, by clipping rows of nodes against its sides.

use glam::DVec3;
use surface::Aabb;

use super::sides::{ROWS, Sides, WIDENING};
use super::slab::Slab;
use crate::num::{coordinate, floor, nodes_within, single};
use crate::units::GridSurface;

/// Minimum cosine of half a wedge's angle for which its box is narrowed.
const MIN_COSINE: f64 = 0.3;

/// Visits the nodes straight above or below a face.
pub(super) fn prism(surface: &GridSurface<'_>, face: u32, slab: &mut Slab<'_>) {
    let normal = surface.normals[face as usize];
    if normal == DVec3::ZERO {
        return;
    }

    // The box of the face, moved both ways along its normal.
    let band = slab.band;
    let [a, b, c] = surface.corners(face);
    let reach = normal.abs() * band + WIDENING;
    let region = Aabb { min: a.min(b).min(c) - reach, max: a.max(b).max(c) + reach };

    let sides = |sides: &mut Sides| {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            sides.add(normal.cross(to - from), from);
        }
        sides.add_shifted(normal, a, band);
        sides.add_shifted(-normal, a, band);
    };
    slab.visit(region, sides, face, |p| {
        let height = normal.dot(p - a);
        height * height
    });
}

/// Visits the nodes outside of both faces of an edge, between its ends.
pub(super) fn wedge(surface: &GridSurface<'_>, edge: u32, slab: &mut Slab<'_>) {
    let faces = surface.surface.edge_faces(edge);
    let ends = surface.surface.edges()[edge as usize];
    let [a, b] = ends.map(|end| surface.x[end as usize]);
    let length = (b - a).length();
    if length <= WIDENING {
        return; // its ends are vertices
    }

    // On the outer side of the first two faces, as far as there are two.
    let along = (b - a) / length;
    let m = into_face(surface, faces.first(), ends, along);
    let n = into_face(surface, faces.get(1), ends, along);
    let Some(extent) = wedge_extent(surface, faces, [m, n], slab.band) else {
        return;
    };
    let (min, max) = (a.min(b) + extent.min - WIDENING, a.max(b) + extent.max + WIDENING);

    let sides = |sides: &mut Sides| {
        sides.add(along, a);
        sides.add(-along, b);
        sides.add(-m, a);
        sides.add(-n, a);
    };
    slab.visit(Aabb { min, max }, sides, faces[0], |p| {
        let to = p - a;
        let t = to.dot(along).clamp(0.0, length);
        (to - t * along).length_squared()
    });
}

/// Returns the unit vector in a face's plane, at right angles to its edge, which runs `along` between
/// its ends, that leads into the face; zero for slivers and without a face.
#[inline]
fn into_face(surface: &GridSurface<'_>, face: Option<&u32>, ends: [u32; 2], along: DVec3) -> DVec3 {
    let Some(&face) = face else {
        return DVec3::ZERO;
    };
    // A face is to the left of its edges, seen from where its normal points to.
    let across = surface.normals[face as usize].cross(along);
    let [i, j, k] = surface.surface.faces()[face as usize];
    if [[i, j], [j, k], [k, i]].contains(&ends) { across } else { -across }
}

/// Computes a box around the wedge of an edge, relative to the edge; `None` where the wedge
/// is so thin that the prisms at its sides cover it.
fn wedge_extent(
    surface: &GridSurface<'_>,
    faces: &[u32],
    [m, n]: [DVec3; 2],
    band: f64,
) -> Option<Aabb> {
    let ball = Some(Aabb { min: DVec3::splat(-band), max: DVec3::splat(band) });
    let &[first, second] = faces else {
        return ball;
    };
    let normals = [surface.normals[first as usize], surface.normals[second as usize]];
    if normals.contains(&DVec3::ZERO) {
        return ball;
    }

    // How far each normal leans over the other face: nothing where the edge is flat.
    let bend = [normals[0].dot(n), normals[1].dot(m)];
    if bend[0].abs().max(bend[1].abs()) * band < WIDENING {
        // Flat, or folded back on itself.
        return if m.dot(n) < 0.0 { None } else { ball };
    }

    // The two directions at which the wedge meets its prisms.
    let [g, h] = [-bend[0].signum() * normals[0], -bend[1].signum() * normals[1]];
    let cosine = (g + h).length() / 2.0;
    if cosine < MIN_COSINE {
        return ball;
    }
    // A unit vector between g and h is a sum of at most 1 / cosine of them.
    let (g, h) = (g * (band / cosine), h * (band / cosine));
    Some(Aabb { min: g.min(h).min(DVec3::ZERO), max: g.max(h).max(DVec3::ZERO) })
}

/// Visits the nodes that are behind a vertex along each of its edges.
pub(super) fn cone(surface: &GridSurface<'_>, vertex: u32, slab: &mut Slab<'_>) {
    let faces = surface.surface.vertex_faces(vertex);
    let Some(&face) = faces.first() else {
        return;
    };

    let at = surface.x[vertex as usize];
    let mut edges = std::mem::take(&mut slab.edges);
    edges.clear();
    for &f in faces {
        let corners = surface.surface.faces()[f as usize];
        let next = corners[(1 + corners.iter().position(|&v| v == vertex).unwrap_or(0)) % 3];
        edges.push(surface.x[next as usize] - at);
    }

    // Behind the vertex along an edge: not nearer to a point within it.
    let sides = |sides: &mut Sides| {
        for &edge in &edges {
            sides.add(-edge, at);
        }
    };
    let region = cone_box(at, &edges, slab.band);
    slab.visit(region, sides, face, |p| p.distance_squared(at));
    slab.edges = edges;
}

/// Computes a box around what is behind a vertex along all of its edges, within the band.
///
/// A vector that does not lead forward along an edge leads along an axis by at most the sine of the
/// angle between both, where that is acute: the part of the axis along the edge adds nothing.
fn cone_box(at: DVec3, edges: &[DVec3], band: f64) -> Aabb {
    // Squared sines of the smallest angles from either end of each axis.
    let (mut lower, mut upper) = (DVec3::ONE, DVec3::ONE);
    for &edge in edges {
        let squares = edge * edge;
        let length_squared = squares.element_sum();
        if length_squared > WIDENING * WIDENING {
            let across =
                DVec3::new(squares.y + squares.z, squares.z + squares.x, squares.x + squares.y);
            let sines = across / length_squared;
            for axis in 0..3 {
                let end = if edge[axis] > 0.0 { &mut upper } else { &mut lower };
                end[axis] = if sines[axis] < end[axis] { sines[axis] } else { end[axis] };
            }
        }
    }

    // Sides are moved out by at most twice the widening; the rest is for rounding.
    let reach = |squared: DVec3| squared.map(f64::sqrt) * band + 3.0 * WIDENING;
    Aabb { min: at - reach(lower), max: at + reach(upper) }
}

impl Slab<'_> {
    /// Visits the nodes of a region, a box less what is beyond its sides: keeps the shorter
    /// of their distance and `squared_distance`, which is that of `face`.
    #[inline]
    fn visit(
        &mut self,
        region: Aabb,
        sides: impl FnOnce(&mut Sides),
        face: u32,
        squared_distance: impl Fn(DVec3) -> f64,
    ) {
        let (first, last) = (coordinate(self.planes.start), coordinate(self.planes.end - 1));
        let mut sides = Some(sides);
        let Aabb { min, max } = region;
        for k in nodes_within(min.z.max(first), max.z.min(last), self.dims[2]) {
            let rows = nodes_within(min.y, max.y, self.dims[1]);
            for first in rows.clone().step_by(ROWS) {
                // Many regions lie between rows and never need their sides.
                if let Some(sides) = sides.take() {
                    self.sides.clear();
                    sides(&mut self.sides);
                }

                let (y, z) = (coordinate(first), coordinate(k));
                let [from, to] = self.sides.clip([min.x, max.x], y, z);
                if !are_any_nodes(from, to) {
                    continue;
                }
                for (j, ends) in (first..rows.end).zip(from.into_iter().zip(to)) {
                    self.visit_row(ends, [j, k], face, &squared_distance);
                }
            }
        }
    }

    /// Visits the nodes between the ends of row `j` of plane `k`.
    #[inline]
    fn visit_row(
        &mut self,
        (from, to): (f64, f64),
        [j, k]: [usize; 2],
        face: u32,
        squared_distance: impl Fn(DVec3) -> f64,
    ) {
        // Of a region beyond the grid, the ends may lie there too.
        let nodes = nodes_within(from, to, self.dims[0]);
        if nodes.is_empty() {
            return;
        }

        let (y, z) = (coordinate(j), coordinate(k));
        let row = self.dims[0] * (j + self.dims[1] * (k - self.planes.start));
        let run = row + nodes.start..row + nodes.end;
        for (i, index) in nodes.zip(run) {
            let squared = squared_distance(DVec3::new(coordinate(i), y, z));
            if squared <= self.band * self.band {
                self.nodes.keep_nearer(index, single(squared), face + 1);
            }
        }
    }
}

/// Returns true if some node is between the ends of some row. Most regions pass between the nodes
/// of most rows.
#[inline]
fn are_any_nodes(from: [f64; ROWS], to: [f64; ROWS]) -> bool {
    let mut are_any = false;
    for (from, to) in from.into_iter().zip(to) {
        are_any |= from <= floor(to);
    }
    are_any
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_behind_all_edges_are_within_the_box_of_a_vertex() {
        let mut random = fixtures::random::Random(7);
        let mut draw = || DVec3::from_array([0; 3].map(|_| 2.0 * random.unit() - 1.0));
        for _ in 0..5000 {
            let (edges, at) = ([draw(), draw(), draw()], draw());
            let Aabb { min, max } = cone_box(at, &edges, 2.0);
            let p = at + 2.0 * draw().normalize();
            let is_behind = edges.iter().all(|edge| edge.dot(p - at) <= 0.0);
            assert!(!is_behind || (min.cmple(p) & p.cmple(max)).all(), "{p} behind {edges:?}");
        }
    }
}
