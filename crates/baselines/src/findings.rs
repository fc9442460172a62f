//! What goes into every method, and what comes out.

use glam::DVec3;
use surface::{Positions, TriangleSurface};

/// A surface and where its vertices are.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSurface<'a> {
    /// Its faces.
    pub surface: &'a TriangleSurface,
    /// Its vertices \[length unit\].
    pub x: Positions<'a>,
}

impl PlacedSurface<'_> {
    /// Corners of a face.
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.x.corners(self.surface.faces()[face as usize])
    }

    /// How many faces it has, which 32 bits can number.
    pub(crate) fn face_count(&self) -> u32 {
        index(self.surface.faces().len())
    }
}

/// A vertex found inside the other body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexInside {
    /// The vertex.
    pub vertex: u32,
    /// How deep it is estimated to be \[length unit\], `>= 0`.
    pub depth: f64,
}

/// What a method says of two bodies; `None` stands for what it does not look for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairFindings {
    /// Whether the bodies overlap, as far as the method can tell.
    pub overlap: bool,
    /// How likely it takes that to be, in `0.0..=1.0`, where it goes by chance.
    pub probability: Option<f64>,
    /// Faces that cross, one of the first and one of the second body, ascending.
    pub crossing_faces: Option<Vec<[u32; 2]>>,
    /// Vertices of the first body in the second, and of the second in the
    /// first, ascending.
    pub inside: Option<[Vec<VertexInside>; 2]>,
    /// Volume that the bodies share \[cube of the length unit\].
    pub volume: Option<f64>,
    /// Elementary tests done: pairs of boxes, pairs of triangles, a ray
    /// against a face, a point against a tetrahedron.
    pub tests: u64,
}

impl PairFindings {
    /// The greatest depth of a vertex; `None` where no vertex is found inside.
    #[must_use]
    pub fn depth(&self) -> Option<f64> {
        let all = self.inside.as_ref()?.iter().flatten();
        all.map(|vertex| vertex.depth).max_by(f64::total_cmp)
    }
}

/// A place in a list of a surface, which numbers them with 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "a surface has fewer than 2^32 of each")]
pub(crate) fn index(place: usize) -> u32 {
    place as u32
}
