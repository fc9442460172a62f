//! Map from a surface onto a coarser one, which bounds the deviation of both.
//!
//! The map h is continuous and piecewise linear. Vertices of the full surface S are taken to
//! near points of the coarse surface S′, and so is a point of each edge where the image of the
//! edge passes from one coarse face to the next. These points cut the faces of S into triangles
//! whose corners have images in one coarse face, and h is linear on each.
//!
//! # What it proves
//!
//! Let η be the largest distance from such a point to its image. From x to h(x) it is no
//! farther anywhere, since that distance is convex on each triangle. So:
//!
//! - Every point of S is within η of S′.
//! - Every point of S′ is within η of S, since each is an image. Two faces of S share the image
//!   of their edge, in opposite directions; so the images of all triangles, with their signs,
//!   cover each component of S′ equally often. That number is whole, and the signed areas of
//!   the images in every face of S′ add up to once the face.
//! - Both surfaces have the same winding number about every point that is farther than η from
//!   one of them. S is moved onto S′ along the segments from x to h(x), and winding numbers
//!   change only about points that the moving surface passes. Those are on such a segment, and
//!   so within η of both ends. No crack or plate opens or closes unseen.
//!
//! All points and images are weighted means of vertices of S. Where these move, so do S, S′ and
//! h, and the proof holds with the same weights.
//!
//! It holds with other weights, too, as long as points stay in their edges and faces of S, and images
//! in theirs of S′. Take the triangles as a surface of their own, with one map to S and one to S′. Each
//! corner may move in a convex set, and every triangle stays in one face: to new weights both maps
//! change continuously, within S and within S′. So they cover both as often as before, and the
//! triangles move from S onto S′ along segments no longer than those of their corners. η is therefore
//! the largest of the least distances: a surface that stretches or slides along itself, as where
//! muscles bend, deviates by no more than before.

use glam::DVec3;
use surface::{closest_between_segments, closest_on_triangle};

use crate::mesh_point::MeshPoint;

/// Map from a full surface onto a coarse one on some of its vertices.
///
/// Shifts are computed in every frame, of more points than caches hold: each takes 24 bytes.
#[derive(Clone, Debug, Default)]
pub(crate) struct CoarseMap {
    /// Shifts of the vertices that were not kept to points of coarse faces, ascending.
    of_vertices: Vec<VertexShift>,
    /// Shifts of points inside faces to coarse vertices, seen from these.
    of_faces: Vec<VertexShift>,
    /// Shifts of points inside edges to points of coarse edges.
    of_edges: Vec<EdgeShift>,
}

/// Difference between a vertex of one surface and a point `a + s (b − a) + t (c − a)` of a face of
/// the other.
#[derive(Clone, Copy, Debug)]
struct VertexShift {
    vertex: u32,
    corners: [u32; 3],
    weights: [f32; 2],
}

/// Difference between a point `a + s (b − a)` of an edge and such a point of a coarse edge.
#[derive(Clone, Copy, Debug)]
struct EdgeShift {
    ends: [u32; 2],
    coarse_ends: [u32; 2],
    weights: [f32; 2],
}

/// Shifts between two looks at the limit: a test for each would double the time.
const CHUNK: usize = 1024;

/// Difference between a point of one surface and a point of a simplex of the other.
trait Shift {
    /// Returns the difference with the same weights as ever.
    fn at(&self, x: &[DVec3], of_simplex: &[DVec3]) -> DVec3;

    /// Returns the least squared distance that other weights have.
    fn least_squared(&self, x: &[DVec3], of_simplex: &[DVec3]) -> f64;
}

/// Roundings of a coordinate that a distance between weighted means may be off by.
const ROUNDINGS: f64 = 32.0;

/// Squared distance that no two points have whose coordinates are in range, up to 1e30.
const OUT_OF_RANGE: f64 = 2e61;

impl CoarseMap {
    /// Adds a vertex of the full surface that was not kept, after those of smaller numbers, and its
    /// image in numbers of the coarse surface.
    pub(crate) fn add_vertex(&mut self, vertex: u32, image: &MeshPoint) {
        self.of_vertices.push(VertexShift::new(vertex, image));
    }

    /// Adds a point inside an edge or a face and its image in numbers of the coarse surface: a vertex
    /// or, for a point of an edge, a point of an edge.
    pub(crate) fn add_point(&mut self, point: &MeshPoint, image: &MeshPoint) {
        match image.carrier() {
            &[vertex] => self.of_faces.push(VertexShift::new(vertex, point)),
            _ => self.of_edges.push(EdgeShift::new(point, image)),
        }
    }

    /// Returns the corners of the coarse face that a vertex is mapped to, in numbers of the coarse
    /// surface, and their weights; `None` for a vertex that stays where it is.
    pub(crate) fn image(&self, vertex: u32) -> Option<[(u32, f64); 3]> {
        let place = self.of_vertices.binary_search_by_key(&vertex, |shift| shift.vertex).ok()?;
        Some(self.of_vertices[place].image())
    }

    /// Replaces the value of each vertex that was not kept by that of its image.
    pub(crate) fn spread(&self, values: &mut [DVec3], kept: &[u32]) {
        for shift in &self.of_vertices {
            let [p, q, r] = shift
                .image()
                .map(|(corner, weight)| weight * values[kept[corner as usize] as usize]);
            values[shift.vertex as usize] = p + q + r;
        }
    }

    /// Computes η at positions of the full surface and of its kept vertices, rounded outward;
    /// infinite where one is out of range. Allocates nothing.
    ///
    /// # Panics
    ///
    /// When there are fewer positions than the surfaces have vertices.
    pub(crate) fn max_shift(&self, x: &[DVec3], kept: &[DVec3]) -> f64 {
        self.max_shift_within(x, kept, f64::INFINITY).unwrap_or(f64::INFINITY)
    }

    /// Computes η as [`max_shift`](Self::max_shift) does; `None` as soon as it exceeds a limit, unless
    /// it is infinite.
    pub(crate) fn max_shift_within(&self, x: &[DVec3], kept: &[DVec3], limit: f64) -> Option<f64> {
        let limit_squared = limit * limit;
        let max_squared = max_least_squared(&self.of_faces, [kept, x], limit_squared, 0.0);
        let max_squared =
            max_least_squared(&self.of_vertices, [x, kept], limit_squared, max_squared);
        let max_squared = max_least_squared(&self.of_edges, [x, kept], limit_squared, max_squared);

        // Other vertices are no farther out than the kept ones and η.
        let shift = max_squared.sqrt();
        let bound = shift + rounding(kept.iter()) + ROUNDINGS * f64::EPSILON * shift;
        if bound > limit && bound.is_finite() { None } else { Some(bound) }
    }

    /// Returns true for the map of a surface onto itself.
    pub(crate) fn is_empty(&self) -> bool {
        self.of_vertices.is_empty() && self.of_faces.is_empty() && self.of_edges.is_empty()
    }

    /// Returns its memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.of_vertices[..])
            + size_of_val(&self.of_faces[..])
            + size_of_val(&self.of_edges[..])
    }
}

/// Computes the largest of some least squared distances, at least `max_squared`; any above the limit
/// where it exceeds that, and infinity where a position is out of range.
fn max_least_squared<S: Shift>(
    shifts: &[S],
    [x, of_simplex]: [&[DVec3]; 2],
    limit_squared: f64,
    mut max_squared: f64,
) -> f64 {
    for chunk in shifts.chunks(CHUNK) {
        // The least distances matter of those alone that would be the largest with the same weights.
        for shift in chunk {
            let squared = shift.at(x, of_simplex).length_squared();
            if squared <= max_squared {
                continue;
            }
            // Numbers that are none are out of range, too.
            let is_in_range = squared < OUT_OF_RANGE;
            let least =
                if is_in_range { shift.least_squared(x, of_simplex) } else { f64::INFINITY };
            max_squared = max_squared.max(least);
        }
        if max_squared > limit_squared {
            break;
        }
    }
    max_squared
}

/// Returns a bound on the rounding of shifts between points no farther out than some vertices.
pub(crate) fn rounding<'a>(vertices: impl Iterator<Item = &'a DVec3>) -> f64 {
    let mut size = DVec3::ZERO;
    for p in vertices {
        size = size.max(p.abs());
    }
    ROUNDINGS * f64::EPSILON * size.max_element()
}

/// Rounds a weight toward zero, so that a point stays in its face; any weights prove the same.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
fn rounded_down(weight: f64) -> f32 {
    let nearest = weight as f32;
    if f64::from(nearest) > weight { nearest.next_down() } else { nearest }
}

impl VertexShift {
    fn new(vertex: u32, point: &MeshPoint) -> Self {
        let [(a, _), (b, s), (c, t)] = point.terms();
        Self { vertex, corners: [a, b, c], weights: [s, t].map(rounded_down) }
    }

    /// Returns the corners of the face, with their weights.
    fn image(&self) -> [(u32, f64); 3] {
        let ([a, b, c], [s, t]) = (self.corners, self.weights.map(f64::from));
        [(a, 1.0 - s - t), (b, s), (c, t)]
    }
}

impl Shift for VertexShift {
    #[inline(always)]
    fn at(&self, x: &[DVec3], of_face: &[DVec3]) -> DVec3 {
        let Self { vertex, corners: [a, b, c], weights } = *self;
        let [s, t] = weights.map(f64::from);
        let [a, b, c] = [of_face[a as usize], of_face[b as usize], of_face[c as usize]];
        (x[vertex as usize] - a) - s * (b - a) - t * (c - a)
    }

    /// Returns the squared distance of the vertex from the face, edge or vertex that holds the point.
    fn least_squared(&self, x: &[DVec3], of_face: &[DVec3]) -> f64 {
        let p = x[self.vertex as usize];
        let corners = self.corners.map(|corner| of_face[corner as usize]);
        closest_on_triangle(p, corners).point.distance_squared(p)
    }
}

impl EdgeShift {
    fn new(point: &MeshPoint, image: &MeshPoint) -> Self {
        let [[(a, _), (b, s), _], [(c, _), (d, t), _]] = [point, image].map(MeshPoint::terms);
        Self { ends: [a, b], coarse_ends: [c, d], weights: [s, t].map(rounded_down) }
    }
}

impl Shift for EdgeShift {
    #[inline(always)]
    fn at(&self, x: &[DVec3], kept: &[DVec3]) -> DVec3 {
        let Self { ends: [a, b], coarse_ends: [c, d], weights } = *self;
        let [s, t] = weights.map(f64::from);
        let [a, b] = [x[a as usize], x[b as usize]];
        let [c, d] = [kept[c as usize], kept[d as usize]];
        (a - c) + s * (b - a) - t * (d - c)
    }

    /// Returns the squared distance between both edges.
    fn least_squared(&self, x: &[DVec3], kept: &[DVec3]) -> f64 {
        let (ends, coarse_ends) = (self.ends, self.coarse_ends);
        let ends = ends.map(|end| x[end as usize]);
        let [p, q] =
            closest_between_segments(ends, coarse_ends.map(|end| kept[end as usize])).points;
        p.distance_squared(q)
    }
}
