//! Exact distances in a band around the surface, by its characteristics.
//!
//! A node's closest point lies in a face, on an edge or at a vertex, and then
//! the node lies in the prism over that face, in the wedge between the normals
//! of the edge's faces or in the cone between those of the vertex's. These
//! regions hardly overlap: visiting the nodes of each costs little more than
//! visiting the band once, where splatting the box of each face visits most
//! nodes dozens of times.
//!
//! The regions need no closed or oriented surface. Whatever its faces, a node
//! whose closest point is inside an edge is on the outer side of every face at
//! that edge; leaving out a condition, or widening one against rounding, only
//! makes a region larger, and every region measures true distances to its own
//! element. So no node in the band is missed, and none is given too short a
//! distance by more than twice [`WIDEN`].
//!
//! Source: S. Mauch, "Efficient Algorithms for Solving Static Hamilton–Jacobi
//! Equations", PhD thesis, California Institute of Technology, 2003, chapter on
//! the closest point transform. Differs in taking any list of faces, and in
//! clipping rows of nodes against the sides of a region instead of scan
//! converting polyhedra.

use std::cmp::Reverse;
use std::ops::Range;

use glam::DVec3;

use crate::num::{coordinate, nodes_within, single};
use crate::par;
use crate::units::Units;

/// How far a region is widened so that rounding loses no node \[spacings\].
///
/// Above the rounding of a plane through a sliver (1e-8 times a few spacings),
/// far below storage precision at the size of a bone (3e-5).
const WIDEN: f64 = 1e-6;

/// Planes of nodes that are worked on together.
const SLAB: usize = 32;

/// Cosine of half a wedge's angle below which its box is not narrowed.
const NARROW_COSINE: f64 = 0.3;

/// Squared distances and faces, one a node.
#[derive(Debug)]
pub(crate) struct Nearest {
    /// Squared distance in spacings; means nothing where there is no face.
    pub(crate) squared: Vec<f32>,
    /// One more than the nearest face; 0 where none is known.
    pub(crate) face: Vec<u32>,
}

/// Fills in every node within `band` spacings of the surface.
///
/// Among faces at the same distance the first wins, whatever the order of work.
pub(crate) fn fill(units: &Units<'_>, dims: [usize; 3], band: f64, nearest: &mut Nearest) {
    let plane = dims[0] * dims[1];
    let bins = Bins::new(units, dims[2], band);
    let slabs = nearest.squared.chunks_mut(plane * SLAB).zip(nearest.face.chunks_mut(plane * SLAB));
    let mut slabs: Vec<_> = slabs.enumerate().collect();
    // The most work first, so that no thread is left with it at the end.
    slabs.sort_by_key(|(s, _)| Reverse(bins.load(*s)));
    par::for_each(slabs, |_, (s, (squared, face))| {
        let planes = s * SLAB..s * SLAB + squared.len() / plane;
        let mut slab = Slab { dims, planes, band, squared, face, sides: Sides::default() };
        for &f in &bins.faces[s] {
            prism(units, f, band, &mut slab);
        }
        for &e in &bins.edges[s] {
            wedge(units, e, band, &mut slab);
        }
        for &v in &bins.vertices[s] {
            cone(units, v, band, &mut slab);
        }
    });
}

/// Which elements come near each slab.
struct Bins {
    faces: Vec<Vec<u32>>,
    edges: Vec<Vec<u32>>,
    vertices: Vec<Vec<u32>>,
}

impl Bins {
    fn new(units: &Units<'_>, planes: usize, band: f64) -> Self {
        let mut kinds = par::map(3, |kind| match kind {
            0 => bin(units.surface.faces().iter().map(|face| span(units, face)), planes, band),
            1 => bin(units.surface.edges().iter().map(|edge| span(units, edge)), planes, band),
            _ => bin(units.x.iter().map(|p| [p.z, p.z]), planes, band),
        })
        .into_iter();
        let mut next = || kinds.next().unwrap_or_default();
        Self { faces: next(), edges: next(), vertices: next() }
    }

    /// Elements near a slab.
    fn load(&self, slab: usize) -> usize {
        self.faces[slab].len() + self.edges[slab].len() + self.vertices[slab].len()
    }
}

/// Least and greatest height of some vertices.
fn span(units: &Units<'_>, vertices: &[u32]) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    vertices.iter().fold(none, |[lo, hi], &v| {
        let z = units.x[v as usize].z;
        [lo.min(z), hi.max(z)]
    })
}

fn bin(heights: impl Iterator<Item = [f64; 2]>, planes: usize, band: f64) -> Vec<Vec<u32>> {
    let mut bins = vec![Vec::new(); planes.div_ceil(SLAB)];
    for (element, [lo, hi]) in (0_u32..).zip(heights) {
        let near = nodes_within(lo - band, hi + band, planes);
        if !near.is_empty() {
            for bin in &mut bins[near.start / SLAB..=(near.end - 1) / SLAB] {
                bin.push(element);
            }
        }
    }
    bins
}

/// Some planes of nodes, and what is known of them.
struct Slab<'a> {
    dims: [usize; 3],
    planes: Range<usize>,
    band: f64,
    squared: &'a mut [f32],
    face: &'a mut [u32],
    /// Scratch of the region that is visited.
    sides: Sides,
}

/// One end of a row: where it meets a side, `x = at + per_y · y + per_z · z`.
struct End {
    at: f64,
    per_y: f64,
    per_z: f64,
}

/// Sides of a region, by the end of a row that they cut off.
#[derive(Default)]
struct Sides {
    lower: Vec<End>,
    upper: Vec<End>,
}

/// What stands for 1 / 0: takes a row that is on the wrong side of a plane
/// along x out of the grid, and leaves one that is not alone.
const VERTICAL: f64 = 1e30;

impl Sides {
    fn clear(&mut self) {
        self.lower.clear();
        self.upper.clear();
    }

    /// The side through `at` with the given inward normal, of any length, moved
    /// out by [`WIDEN`] to twice that. A zero normal cuts nothing off.
    #[inline]
    fn add(&mut self, normal: DVec3, at: DVec3) {
        self.add_shifted(normal, at, WIDEN * normal.abs().element_sum());
    }

    #[inline]
    fn add_shifted(&mut self, normal: DVec3, at: DVec3, out: f64) {
        let slope = if normal.x == 0.0 { -VERTICAL } else { -1.0 / normal.x };
        let offset = out - normal.dot(at);
        let end = End { at: offset * slope, per_y: normal.y * slope, per_z: normal.z * slope };
        if normal.x < 0.0 { self.upper.push(end) } else { self.lower.push(end) }
    }

    /// Part of a row from `from` to `to` that no side cuts off; empty when the
    /// first end is after the second.
    #[inline]
    fn clip(&self, [mut from, mut to]: [f64; 2], y: f64, z: f64) -> [f64; 2] {
        // Compared so that an end that is not a number cuts nothing off.
        for end in &self.lower {
            let x = end.x(y, z);
            from = if x > from { x } else { from };
        }
        for end in &self.upper {
            let x = end.x(y, z);
            to = if x < to { x } else { to };
        }
        [from, to]
    }
}

impl End {
    #[inline]
    fn x(&self, y: f64, z: f64) -> f64 {
        self.at + self.per_y * y + self.per_z * z
    }
}

/// A box that holds a region.
struct Region {
    lo: DVec3,
    hi: DVec3,
}

/// Nodes straight above or below a face.
fn prism(units: &Units<'_>, face: u32, band: f64, slab: &mut Slab<'_>) {
    let normal = units.normals[face as usize];
    if normal == DVec3::ZERO {
        return;
    }
    let [a, b, c] = units.corners(face);
    let reach = normal.abs() * band + WIDEN;
    let region = Region { lo: a.min(b).min(c) - reach, hi: a.max(b).max(c) + reach };
    let sides = |sides: &mut Sides| {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            sides.add(normal.cross(to - from), from);
        }
        sides.add_shifted(normal, a, band);
        sides.add_shifted(-normal, a, band);
    };
    slab.visit(&region, sides, face, |p| {
        let height = normal.dot(p - a);
        height * height
    });
}

/// Nodes outside of both faces of an edge, between its ends.
fn wedge(units: &Units<'_>, edge: u32, band: f64, slab: &mut Slab<'_>) {
    let faces = units.surface.edge_faces(edge);
    let [a, b] = units.surface.edges()[edge as usize].map(|v| units.x[v as usize]);
    let length = (b - a).length();
    if length <= WIDEN {
        return; // its ends are vertices
    }
    let along = (b - a) / length;
    let inward = |i: usize| match faces.get(i) {
        Some(&face) => into(units, face, a, along),
        None => DVec3::ZERO,
    };
    let (m, n) = (inward(0), inward(1));
    let Some([lo, hi]) = wedge_reach(units, faces, [m, n], band) else {
        return;
    };
    let region = Region { lo: a.min(b) + lo - WIDEN, hi: a.max(b) + hi + WIDEN };
    let sides = |sides: &mut Sides| {
        sides.add(along, a);
        sides.add(-along, b);
        sides.add(-m, a);
        sides.add(-n, a);
    };
    slab.visit(&region, sides, faces[0], |p| {
        let to = p - a;
        let t = to.dot(along).clamp(0.0, length);
        (to - t * along).length_squared()
    });
}

/// Unit vector in a face's plane that leaves its edge, which runs `along` from
/// `a`, into the face; zero for slivers.
#[inline]
fn into(units: &Units<'_>, face: u32, a: DVec3, along: DVec3) -> DVec3 {
    let across = units.normals[face as usize].cross(along);
    let [p, q, r] = units.corners(face);
    let inward = across.dot(p + q + r - 3.0 * a);
    if inward < 0.0 { -across } else { across }
}

/// How far a wedge extends from its edge, as corners of a box; none when it is
/// so thin that the prisms at its sides cover it.
fn wedge_reach(
    units: &Units<'_>,
    faces: &[u32],
    [m, n]: [DVec3; 2],
    band: f64,
) -> Option<[DVec3; 2]> {
    let everywhere = Some([DVec3::splat(-band), DVec3::splat(band)]);
    let &[first, second] = faces else {
        return everywhere;
    };
    let normals = [units.normals[first as usize], units.normals[second as usize]];
    if normals.contains(&DVec3::ZERO) {
        return everywhere;
    }
    let bend = [normals[0].dot(n), normals[1].dot(m)];
    if bend[0].abs().max(bend[1].abs()) * band < WIDEN {
        // Flat, or folded back on itself.
        return if m.dot(n) < 0.0 { None } else { everywhere };
    }
    // The two directions at which the wedge meets its prisms.
    let [g, h] = [-bend[0].signum() * normals[0], -bend[1].signum() * normals[1]];
    let cosine = (g + h).length() / 2.0;
    if cosine < NARROW_COSINE {
        return everywhere;
    }
    // A unit vector between g and h is a sum of at most 1 / cosine of them.
    let (g, h) = (g * (band / cosine), h * (band / cosine));
    Some([g.min(h).min(DVec3::ZERO), g.max(h).max(DVec3::ZERO)])
}

/// Nodes behind a vertex as seen along each of its edges.
fn cone(units: &Units<'_>, vertex: u32, band: f64, slab: &mut Slab<'_>) {
    let faces = units.surface.vertex_faces(vertex);
    let Some(&face) = faces.first() else {
        return;
    };
    let at = units.x[vertex as usize];
    let region = Region { lo: at - band, hi: at + band };
    let sides = |sides: &mut Sides| {
        for &f in faces {
            let corners = units.surface.faces()[f as usize];
            let next = corners[(1 + corners.iter().position(|&v| v == vertex).unwrap_or(0)) % 3];
            sides.add(at - units.x[next as usize], at);
        }
    };
    slab.visit(&region, sides, face, |p| p.distance_squared(at));
}

impl Slab<'_> {
    /// Keeps, for every node of a region less what is beyond its sides, the shorter
    /// of what it has and `squared_distance` to `face`.
    #[inline]
    fn visit(
        &mut self,
        region: &Region,
        sides: impl FnOnce(&mut Sides),
        face: u32,
        squared_distance: impl Fn(DVec3) -> f64,
    ) {
        let farthest = self.band * self.band;
        let (first, last) = (coordinate(self.planes.start), coordinate(self.planes.end - 1));
        let mut sides = Some(sides);
        let Region { lo, hi } = region;
        for k in nodes_within(lo.z.max(first), hi.z.min(last), self.dims[2]) {
            for j in nodes_within(lo.y, hi.y, self.dims[1]) {
                // Many regions lie between rows and never need their sides.
                if let Some(sides) = sides.take() {
                    self.sides.clear();
                    sides(&mut self.sides);
                }
                let (y, z) = (coordinate(j), coordinate(k));
                let [from, to] = self.sides.clip([lo.x, hi.x], y, z);
                let row = self.dims[0] * (j + self.dims[1] * (k - self.planes.start));
                let nodes = nodes_within(from, to, self.dims[0]);
                // Of a region beyond the grid, the ends may lie there too.
                if nodes.is_empty() {
                    continue;
                }
                let here = row + nodes.start..row + nodes.end;
                let known = self.squared[here.clone()].iter_mut().zip(&mut self.face[here]);
                for (i, (best, id)) in nodes.zip(known) {
                    let squared = squared_distance(DVec3::new(coordinate(i), y, z));
                    if squared <= farthest {
                        keep((best, id), single(squared), face + 1);
                    }
                }
            }
        }
    }
}

/// Keeps the nearer, or of two as near the first.
#[inline]
fn keep((best, id): (&mut f32, &mut u32), squared: f32, face: u32) {
    if *id == 0 || (squared, face) < (*best, *id) {
        (*best, *id) = (squared, face);
    }
}
