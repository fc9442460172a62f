//! Input and output of all methods.

use glam::DVec3;
use surface::{Aabb, Positions, TriangleSurface};

/// A surface with the positions of its vertices.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSurface<'a> {
    /// Faces.
    pub surface: &'a TriangleSurface,
    /// Positions of the vertices \[length unit\].
    pub x: Positions<'a>,
}

impl PlacedSurface<'_> {
    /// Returns the corners of a face.
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.x.corners(self.surface.faces()[face as usize])
    }

    /// Returns the number of faces.
    pub(crate) fn face_count(&self) -> u32 {
        index(self.surface.faces().len())
    }

    /// Returns the bounding box of all vertices.
    pub(crate) fn bounds(&self) -> Aabb {
        Aabb::of_points(self.x.as_slice().iter().copied())
    }

    /// Returns the bounding box of a face.
    pub(crate) fn face_bounds(&self, face: u32) -> Aabb {
        Aabb::of_points(self.corners(face))
    }
}

/// A vertex inside the other surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexInside {
    /// The vertex.
    pub vertex: u32,
    /// Estimated depth \[length unit\], `>= 0`.
    pub depth: f64,
}

/// Findings about a pair of surfaces; `None` for anything that the method does not compute.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairFindings {
    /// True if the surfaces overlap, by the rule of the method.
    pub overlap: bool,
    /// Probability of an overlap, in `0.0..=1.0`.
    pub probability: Option<f64>,
    /// Faces that cross, one of the first and one of the second surface, ascending.
    pub crossing_faces: Option<Vec<[u32; 2]>>,
    /// Vertices of the first surface in the second, and of the second in the first, ascending.
    pub inside: Option<[Vec<VertexInside>; 2]>,
    /// Volume of the intersection \[cube of the length unit\].
    pub volume: Option<f64>,
    /// Number of elementary tests: of two boxes, of two triangles, of a ray and a face.
    pub tests: u64,
}

/// Converts a list index of a surface, which numbers items with 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "a surface has fewer than 2^32 of each")]
pub(crate) fn index(place: usize) -> u32 {
    place as u32
}

/// Converts a whole number to an integer in `1..=max`; NaN becomes 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range")]
pub(crate) fn clamp_count(x: f64, max: u32) -> u32 {
    x.max(1.0).min(f64::from(max)) as u32
}

/// Returns the cell, in `0..count`, that holds a coordinate in cells.
pub(crate) fn clamp_cell(x: f64, count: u32) -> u32 {
    clamp_count(x.floor() + 1.0, count) - 1
}
