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
//! h, and the proof holds with the same weights: η is then the largest of the same distances at
//! the new positions.

use glam::DVec3;

use crate::mesh_point::MeshPoint;

/// Map from a full surface onto a coarse one on some of its vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct CoarseMap {
    /// Per vertex of the full surface, its image, as a mean of kept vertices.
    pub(crate) images: Vec<MeshPoint>,
    /// Shifts of the points inside edges and faces.
    pub(crate) shifts: Vec<Shift>,
}

/// Difference between a point and its image, as a sum over vertices of the full surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    vertices: [u32; 4],
    weights: [f64; 4],
}

/// Roundings of a coordinate that a distance between weighted means may be off by.
const ROUNDINGS: f64 = 32.0;

impl CoarseMap {
    /// Returns the map of a surface onto itself.
    pub(crate) fn identity(vertices: &[u32]) -> Self {
        let images = vertices.iter().map(|&vertex| MeshPoint::vertex(vertex)).collect();
        Self { images, shifts: Vec::new() }
    }

    /// Computes η at positions of the full surface, rounded outward. Allocates nothing.
    ///
    /// # Panics
    ///
    /// When there are fewer positions than the full surface has vertices.
    pub(crate) fn max_shift(&self, x: &[DVec3]) -> f64 {
        // Vertices of the full surface, and the largest of their coordinates.
        let (mut max_squared, mut size) = (0.0_f64, DVec3::ZERO);
        for (&p, image) in x.iter().zip(&self.images) {
            max_squared = max_squared.max(p.distance_squared(image.mean(x)));
            size = size.max(p.abs());
        }

        // Points inside edges and faces.
        for shift in &self.shifts {
            max_squared = max_squared.max(shift.at(x).length_squared());
        }
        max_squared.sqrt() + ROUNDINGS * f64::EPSILON * size.max_element()
    }

    /// Returns its memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.images[..]) + size_of_val(&self.shifts[..])
    }
}

impl Shift {
    /// Returns the shift of a point to its image: an edge's to an edge's, or a face's to a
    /// vertex, so that they have four vertices.
    pub(crate) fn new(point: &MeshPoint, image: &MeshPoint) -> Self {
        let mut shift = Self { vertices: [point.carrier()[0]; 4], weights: [0.0; 4] };
        let vertices = point.carrier().iter().chain(image.carrier());
        for (k, &vertex) in vertices.enumerate() {
            let is_of_point = k < point.carrier().len();
            shift.vertices[k] = vertex;
            shift.weights[k] =
                if is_of_point { point.weight(vertex) } else { -image.weight(vertex) };
        }
        shift
    }

    /// Returns the shift at positions of the full surface.
    pub(crate) fn at(&self, x: &[DVec3]) -> DVec3 {
        let [a, b, c, d] = self.vertices.map(|vertex| x[vertex as usize]);
        let [s, t, u, v] = self.weights;
        s * a + t * b + u * c + v * d
    }
}
