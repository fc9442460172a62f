//! Regions of elements that are small beside the spacing, four at a time.
//!
//! The region of such a face, edge or vertex is narrow, and longest along its normal. Across the axis
//! that is nearest to it, a layer of nodes holds one node of the region or a few, or none. Where a
//! region may be wide, its rows are clipped in turn ([`super::rows`]).
//!
//! Sides are compared in single precision, moved out by [`SLACK`]. What is found is measured in
//! double precision: distances from edges and vertices are true ones wherever a node is, and a node
//! that is within the slack of a face's sides is compared with them again.

use glam::DVec3;
use wide::f32x4;

use super::layers::{Candidate, Found, LANES, Regions, SLACK, Vectors};
use super::layers::{add, cross, dot, negated, round, splat, times};
use super::rows::{cone, prism, wedge};
use super::sides::WIDENING;
use super::slab::Slab;
use crate::num::single;
use crate::units::GridSurface;

/// Maximum width of the rectangles \[spacings\]: wider ones have more nodes beyond the sides.
const MAX_WIDTH: f32 = 4.0;

/// Maximum length of an element along the axis across the layers, and of an edge \[spacings\].
const MAX_LENGTH: f32 = 6.0;

/// Maximum band \[spacings\], which keeps coordinates below those that [`SLACK`] allows.
const MAX_BAND: f64 = 12.0;

/// Minimum length of an edge \[spacings\], whose square single precision holds.
const MIN_LENGTH: f32 = 1e-4;

/// Minimum cosine of the angle between the normals of a narrow edge.
const MIN_COSINE: f64 = 0.5;

/// Sine of the angle between two normals from which single precision has its sign.
const MIN_SINE: f32 = 1e-4;

/// Maximum slope of the ends of a cone, in spacings per layer.
const MAX_SLOPE: f64 = 2.0;

/// Doubled area of a face, seen along an axis, from which its normal bounds a cone
/// \[spacings²\].
const MIN_AREA: f64 = 1e-3;

/// The axis after each axis, and the one after that.
const NEXT: [usize; 3] = [1, 2, 0];
const LAST: [usize; 3] = [2, 0, 1];

/// Places of x, y and z among coordinates whose first axis is each of them.
const PLACES: [[usize; 3]; 3] = [[0, 1, 2], [2, 0, 1], [1, 2, 0]];

/// Four elements, each with `V` vectors, in coordinates whose first axis is across the layers.
struct Batch<const V: usize> {
    count: usize,
    element: [u32; LANES],
    /// Face that nodes of the region take.
    face: [u32; LANES],
    /// Node to which coordinates are relative.
    origin: [DVec3; LANES],
    axis: [usize; LANES],
    vectors: [[[f32; LANES]; 3]; V],
}

impl<const V: usize> Batch<V> {
    fn new() -> Self {
        Self {
            count: 0,
            element: [0; LANES],
            face: [0; LANES],
            origin: [DVec3::ZERO; LANES],
            axis: [0; LANES],
            vectors: [[[0.0; LANES]; 3]; V],
        }
    }

    /// Adds an element with its vectors; returns true once the batch is full.
    #[inline(always)]
    fn add(&mut self, element: u32, face: u32, lane: BatchLane<V>) -> bool {
        let (n, axis) = (self.count, lane.axis);
        (self.element[n], self.face[n]) = (element, face);
        (self.origin[n], self.axis[n]) = (lane.origin, axis);
        for (lists, vector) in self.vectors.iter_mut().zip(lane.vectors) {
            let vector = vector.as_vec3().to_array();
            lists[0][n] = vector[axis];
            lists[1][n] = vector[NEXT[axis]];
            lists[2][n] = vector[LAST[axis]];
        }
        self.count += 1;
        self.count == LANES
    }

    /// Fills the lanes that are left with the first element, which then is searched again: the
    /// shorter distance stays.
    fn pad(&mut self) {
        for lane in self.count..LANES {
            self.element[lane] = self.element[0];
            self.face[lane] = self.face[0];
            self.origin[lane] = self.origin[0];
            self.axis[lane] = self.axis[0];
            for list in self.vectors.as_flattened_mut() {
                list[lane] = list[0];
            }
        }
    }

    fn vectors(&self) -> [Vectors; V] {
        let mut vectors = [[splat(0.0); 3]; V];
        for (vectors, lists) in vectors.iter_mut().zip(self.vectors) {
            for (vector, list) in vectors.iter_mut().zip(lists) {
                *vector = f32x4::new(list);
            }
        }
        vectors
    }

    /// Returns the first layer of the slab between two ends, and the number of layers.
    #[inline(always)]
    fn layers(&self, slab: &Slab<'_>, lower: f32x4, upper: f32x4) -> [f32x4; 2] {
        let (mut lowest, mut highest) = ([0.0; LANES], [0.0; LANES]);
        for (lane, &axis) in self.axis.iter().enumerate() {
            lowest[lane] = single((slab.lowest - self.origin[lane]).to_array()[axis]);
            highest[lane] = single((slab.highest - self.origin[lane]).to_array()[axis]);
        }
        let first = round(lower + splat(0.5)).fast_max(f32x4::new(lowest));
        let last = round(upper - splat(0.5)).fast_min(f32x4::new(highest));
        [first, last - first + splat(1.0)]
    }

    /// Returns the position of a node.
    #[inline(always)]
    fn position(&self, candidate: &Candidate<'_>) -> DVec3 {
        self.origin[candidate.lane] + candidate.node(PLACES[self.axis[candidate.lane]])
    }
}

/// Element as a batch holds it.
struct BatchLane<const V: usize> {
    origin: DVec3,
    axis: usize,
    vectors: [DVec3; V],
}

/// Visits the nodes straight above or below faces.
pub(super) fn prisms(surface: &GridSurface<'_>, faces: &[u32], slab: &mut Slab<'_>) {
    let (mut batch, mut found) = (Batch::new(), Found::default());
    for &face in faces {
        let normal = surface.normals[face as usize];
        if normal == DVec3::ZERO {
            continue;
        }
        if slab.band > MAX_BAND {
            prism(surface, face, slab);
            continue;
        }

        // Edges as differences in double precision, so that short ones keep their directions.
        let [a, b, c] = surface.corners(face);
        let (origin, axis) = (nearest_node(a), longest_axis(normal));
        let vectors = [normal, a - origin, b - a, c - b, a - c];
        if batch.add(face, face, BatchLane { origin, axis, vectors }) {
            search_prisms(surface, &batch, &mut found, slab);
            batch.count = 0;
        }
    }
    if batch.count > 0 {
        batch.pad();
        search_prisms(surface, &batch, &mut found, slab);
    }
}

/// Visits the nodes straight above or below four faces.
#[inline(never)]
fn search_prisms(
    surface: &GridSurface<'_>,
    batch: &Batch<5>,
    found: &mut Found,
    slab: &mut Slab<'_>,
) {
    let (slack, band) = (splat(SLACK), splat(single(slab.band)));
    let [normal, a, e, f, g] = batch.vectors();
    let b = add(a, e);
    let c = add(b, f);

    // A layer cuts the prism in a triangle that moves along the normal.
    let slopes = [normal[1] / normal[0], normal[2] / normal[0]];
    let (mut at, mut widths) = ([slack; 2], [slack; 2]);
    for i in 0..2 {
        let [a, b, c] = [a, b, c].map(|p| p[i + 1] - slopes[i] * p[0]);
        at[i] = a.fast_min(b).fast_min(c) - slack;
        widths[i] = a.fast_max(b).fast_max(c) + slack - at[i];
    }
    let lowest = a[0].fast_min(b[0]).fast_min(c[0]);
    let highest = a[0].fast_max(b[0]).fast_max(c[0]);
    let reach = band * normal[0].abs() + slack;
    let [first, mut layers] = batch.layers(slab, lowest - reach, highest + reach);

    // Unit normals of the sides, across which distances compare with the slack.
    let (mut normals, mut offsets) = ([normal; 3], [slack; 3]);
    let mut shortest = splat(f32::INFINITY);
    for (side, (from, edge)) in [(a, e), (b, f), (c, g)].into_iter().enumerate() {
        let across = cross(normal, edge);
        let length = dot(across, across).sqrt().fast_max(splat(f32::MIN_POSITIVE));
        shortest = shortest.fast_min(length);
        normals[side] = times(across, splat(1.0) / length);
        offsets[side] = slack - dot(normals[side], from);
    }

    // Faces that are too large, or whose edges are too short, leave their lanes empty.
    let is_wide = widths[0].fast_max(widths[1]).simd_gt(splat(MAX_WIDTH));
    let is_long = (highest - lowest).simd_gt(splat(MAX_LENGTH));
    let excluded = is_wide | is_long | shortest.simd_lt(splat(MIN_LENGTH));
    if excluded.any() {
        let lanes = excluded.to_bitmask();
        for lane in 0..LANES {
            if lanes >> lane & 1 == 1 {
                prism(surface, batch.element[lane], slab);
            }
        }
        offsets[0] = excluded.select(splat(f32::NEG_INFINITY), offsets[0]);
        layers = excluded.select(splat(0.0), layers);
        widths = widths.map(|width| excluded.select(splat(0.0), width));
    }

    let regions = Regions { first, layers, at, slopes, widths, normals, offsets };
    regions.search(found, |candidate| {
        let (p, face) = (batch.position(&candidate), batch.element[candidate.lane]);
        let normal = surface.normals[face as usize];
        let corners = surface.corners(face);
        let is_sure = candidate.distance() > 2.0 * SLACK;
        if is_sure || is_in_prism(p, corners, normal) {
            let height = normal.dot(p - corners[0]);
            slab.keep(p, height * height, face);
        }
    });
}

/// Returns true if a point is straight above or below a face, or beside by [`WIDENING`].
fn is_in_prism(p: DVec3, [a, b, c]: [DVec3; 3], normal: DVec3) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let side = normal.cross(to - from);
        side.dot(p - from) >= -WIDENING * side.abs().element_sum()
    })
}

/// Visits the nodes outside of both faces of edges, between their ends.
pub(super) fn wedges(surface: &GridSurface<'_>, edges: &[u32], slab: &mut Slab<'_>) {
    let (mut batch, mut found) = (Batch::new(), Found::default());
    let [shortest, longest] = [MIN_LENGTH, MAX_LENGTH].map(|length| f64::from(length * length));
    for &edge in edges {
        let &[first, second] = surface.surface.edge_faces(edge) else {
            wedge(surface, edge, slab);
            continue;
        };
        let ends = surface.surface.edges()[edge as usize];
        let [a, b] = ends.map(|end| surface.x[end as usize]);
        let (length, n) = ((b - a).length_squared(), surface.normals[first as usize]);
        let m = surface.normals[second as usize];
        let is_left = runs_along(surface, first, ends);

        // Faces that run the same way along their edge, or bend sharply, are not narrow.
        let is_oriented = is_left != runs_along(surface, second, ends);
        let is_narrow = length > shortest && length < longest && n.dot(m) > MIN_COSINE;
        if !(is_oriented && is_narrow && slab.band <= MAX_BAND) {
            wedge(surface, edge, slab);
            continue;
        }
        let (left, right) = if is_left { (n, m) } else { (m, n) };
        let (origin, axis) = (nearest_node(a), longest_axis(n + m));
        let vectors = [a - origin, b - a, left, right];
        if batch.add(edge, first, BatchLane { origin, axis, vectors }) {
            search_wedges(surface, &batch, &mut found, slab);
            batch.count = 0;
        }
    }
    if batch.count > 0 {
        batch.pad();
        search_wedges(surface, &batch, &mut found, slab);
    }
}

/// Returns true if a face runs along an edge from its first end to its second.
#[inline(always)]
fn runs_along(surface: &GridSurface<'_>, face: u32, [a, b]: [u32; 2]) -> bool {
    let [i, j, k] = surface.surface.faces()[face as usize];
    ((i == a) & (j == b)) | ((j == a) & (k == b)) | ((k == a) & (i == b))
}

/// Visits the nodes outside of both faces of four edges, between their ends.
#[inline(never)]
fn search_wedges(
    surface: &GridSurface<'_>,
    batch: &Batch<4>,
    found: &mut Found,
    slab: &mut Slab<'_>,
) {
    let (slack, zero) = (splat(SLACK), splat(0.0));
    let [a, edge, n, m] = batch.vectors();
    let length = dot(edge, edge).sqrt();
    let along = times(edge, splat(1.0) / length);

    // A node is at a sum of both normals from the edge, of at most the band over the cosine of half
    // their angle. A layer cuts that in a parallelogram that moves along their middle.
    let middle = add(n, m);
    let reach = splat(2.0 * single(slab.band)) / dot(middle, middle).sqrt();
    let slopes = [middle[1] / middle[0], middle[2] / middle[0]];
    let (mut at, mut widths) = ([slack; 2], [slack; 2]);
    for i in 0..2 {
        let start = a[i + 1] - slopes[i] * a[0];
        let length = edge[i + 1] - slopes[i] * edge[0];
        let beside = (n[i + 1] - slopes[i] * n[0]).abs() * reach + slack;
        at[i] = start + length.fast_min(zero) - beside;
        widths[i] = length.abs() + beside + beside;
    }

    // The wedge is above a convex edge and below a concave one, and next to nothing on both sides of
    // a flat one.
    let sine = dot(along, cross(n, m));
    let height = n[0].abs().fast_max(m[0].abs()) * reach;
    let above = sine.simd_gt(splat(-MIN_SINE)).select(height, zero);
    let below = sine.simd_lt(splat(MIN_SINE)).select(height, zero);
    let is_up = middle[0].simd_gt(zero);
    let (up, down) = (is_up.select(above, below), is_up.select(below, above));
    let lower = a[0] + edge[0].fast_min(zero) - down - slack;
    let upper = a[0] + edge[0].fast_max(zero) + up + slack;
    let [first, layers] = batch.layers(slab, lower, upper);

    // Between the ends, and away from either face, of which that of `n` is on the left.
    let (from_left, from_right) = (cross(along, n), cross(m, along));
    let start = dot(along, a);
    let normals = [along, negated(along), from_left, from_right];
    let offsets = [
        slack - start,
        slack + start + length,
        slack - dot(from_left, a),
        slack - dot(from_right, a),
    ];
    let regions = Regions { first, layers, at, slopes, widths, normals, offsets };
    regions.search(found, |candidate| {
        let edge = batch.element[candidate.lane];
        let [a, b] = surface.surface.edges()[edge as usize].map(|end| surface.x[end as usize]);
        let (p, length) = (batch.position(&candidate), (b - a).length());
        let along = (b - a) / length;
        let t = (p - a).dot(along).clamp(0.0, length);
        let squared = (p - a - t * along).length_squared();
        slab.keep(p, squared, batch.face[candidate.lane]);
    });
}

/// Visits the nodes that are behind vertices along each of their edges.
pub(super) fn cones(surface: &GridSurface<'_>, vertices: &[u32], slab: &mut Slab<'_>) {
    let (mut batch, mut found) = (Batch::new(), Found::default());
    for &vertex in vertices {
        let Some(&face) = surface.surface.vertex_faces(vertex).first() else {
            continue;
        };
        let axis = longest_axis(surface.normals[face as usize]);
        let slopes = cone_slopes(surface, vertex, axis).filter(|[lower, upper]| {
            let width = (*upper - *lower).abs().max_element() * slab.band;
            width < f64::from(MAX_WIDTH) && slab.band <= MAX_BAND
        });
        let Some(slopes) = slopes else {
            cone(surface, vertex, slab);
            continue;
        };
        let at = surface.x[vertex as usize];
        let origin = nearest_node(at);
        let vectors = [at - origin, slopes[0], slopes[1]];
        if batch.add(vertex, face, BatchLane { origin, axis, vectors }) {
            search_cones(surface, &batch, &mut found, slab);
            batch.count = 0;
        }
    }
    if batch.count > 0 {
        batch.pad();
        search_cones(surface, &batch, &mut found, slab);
    }
}

/// Computes the change per layer of the ends between which nodes behind a vertex lie, along the two
/// axes that are not `axis`; `None` where an end is not known or steep.
///
/// Seen along the axis, a face at the vertex spans an angle. Where that holds an axis, being behind
/// both of its edges bounds the node along that axis: by the face's own normal at the vertex.
fn cone_slopes(surface: &GridSurface<'_>, vertex: u32, axis: usize) -> Option<[DVec3; 2]> {
    let axes = [axis, NEXT[axis], LAST[axis]];
    let at: &[f64; 3] = surface.x[vertex as usize].as_ref();
    let [mut lower, mut upper] = [[f64::NAN; 2]; 2];
    for &face in surface.surface.vertex_faces(vertex) {
        // Without a branch: which of its corners the vertex is has no pattern.
        let corners = surface.surface.faces()[face as usize];
        let first = usize::from(corners[1] == vertex) + 2 * usize::from(corners[2] == vertex);
        let [e, f] = [NEXT[first % 3], LAST[first % 3]].map(|corner| {
            let end: &[f64; 3] = surface.x[corners[corner] as usize].as_ref();
            axes.map(|axis| end[axis] - at[axis])
        });

        // Edges that are nearly in line hold no angle.
        let area = e[1] * f[2] - e[2] * f[1];
        let inverse = if area.abs() > MIN_AREA { 1.0 / area } else { f64::NAN };
        let slopes = [e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]].map(|s| s * inverse);

        // Either axis as a sum of both edges: none of its terms may be negative.
        for (i, [s, t]) in [[f[2], -e[2]], [-f[1], e[1]]].into_iter().enumerate() {
            let (s, t) = (s * inverse, t * inverse);
            upper[i] = if (s >= 0.0) & (t >= 0.0) { slopes[i] } else { upper[i] };
            lower[i] = if (s <= 0.0) & (t <= 0.0) { slopes[i] } else { lower[i] };
        }
    }

    // The axis itself has no slope.
    let is_flat = lower.iter().chain(&upper).all(|slope| slope.abs() <= MAX_SLOPE);
    is_flat.then(|| {
        [lower, upper].map(|[next, last]| {
            let mut slopes = DVec3::ZERO;
            (slopes[axes[1]], slopes[axes[2]]) = (next, last);
            slopes
        })
    })
}

/// Visits the nodes that are behind four vertices along each of their edges.
#[inline(never)]
fn search_cones(
    surface: &GridSurface<'_>,
    batch: &Batch<3>,
    found: &mut Found,
    slab: &mut Slab<'_>,
) {
    let (slack, band) = (splat(SLACK), splat(single(slab.band)));
    let [p, lower, upper] = batch.vectors();
    let (mut at, mut widths, mut offsets) = ([slack; 2], [slack; 2], [slack; 2]);
    let (mut up, mut down) = (band, band);
    for i in 0..2 {
        at[i] = p[i + 1] - lower[i + 1] * p[0] - slack;
        offsets[i] = p[i + 1] - upper[i + 1] * p[0] + slack;
        let width = upper[i + 1] - lower[i + 1];
        widths[i] = width.abs() * band + slack + slack;

        // On the side on which the lower end is beyond the upper one, no more than the slack of both.
        let short = splat(4.0 * SLACK) / width.abs().fast_max(splat(f32::MIN_POSITIVE));
        let short = short.fast_min(band);
        up = width.simd_lt(splat(0.0)).select(up.fast_min(short), up);
        down = width.simd_gt(splat(0.0)).select(down.fast_min(short), down);
    }
    let [first, layers] = batch.layers(slab, p[0] - down - slack, p[0] + up + slack);

    // Rectangles begin at their lower ends, so that the upper ones are the sides.
    let (zero, minus) = (splat(0.0), splat(-1.0));
    let normals = [[upper[1], minus, zero], [upper[2], zero, minus]];
    let slopes = [lower[1], lower[2]];
    let regions = Regions { first, layers, at, slopes, widths, normals, offsets };
    regions.search(found, |candidate| {
        let p = batch.position(&candidate);
        let vertex = surface.x[batch.element[candidate.lane] as usize];
        slab.keep(p, p.distance_squared(vertex), batch.face[candidate.lane]);
    });
}

/// Returns the node that is nearest to a point, of those in a grid without end.
#[inline(always)]
fn nearest_node(p: DVec3) -> DVec3 {
    // At this magnitude neighboring numbers are 1 apart.
    const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 · 2^52
    (p + WHOLE) - WHOLE
}

/// Returns the axis along which a vector is longest.
#[inline(always)]
fn longest_axis(v: DVec3) -> usize {
    let v = v.abs();
    if v.x >= v.y && v.x >= v.z {
        0
    } else if v.y >= v.z {
        1
    } else {
        2
    }
}
