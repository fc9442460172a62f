//! Result of static detection between two bodies.

use proximity::{ContactPatch, NearVertex, NoInside, PairProximity, PairSide, contact};
use surface::Contact;

use crate::{PairId, Scene};

/// Proximity of two bodies in one state.
#[derive(Clone, Debug, PartialEq)]
pub struct PairReport {
    /// The two bodies.
    pub pair: PairId,
    /// True if faces cross or a vertex of one is inside the other. Surfaces
    /// that only touch do not overlap.
    pub overlaps: bool,
    /// Depth of the deepest vertex inside the other body, `>= 0`; 0 where none
    /// is, even when faces cross.
    pub max_depth: f64,
    /// Smallest signed distance of a vertex to the other surface, negative
    /// inside; `None` where no vertex is inside or within the margin.
    pub min_gap: Option<f64>,
    /// Distance between the surfaces, their edges and faces included: 0 where
    /// they cross or touch, `None` where they are farther apart than the margin.
    pub distance: Option<f64>,
    /// Pairs of faces (of `a`, of `b`) that properly cross, ascending.
    pub crossing_faces: Vec<[u32; 2]>,
    /// Vertices of `a` against the surface of `b`.
    pub a_against_b: VertexReport,
    /// Vertices of `b` against the surface of `a`.
    pub b_against_a: VertexReport,
    /// Connected patches of `a`'s surface that are in contact with `b`, largest
    /// first.
    pub patches: Vec<ContactPatch>,
}

/// Vertices of one body against the surface of another.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexReport {
    /// Number of vertices inside the other body, or the reason why that has no inside.
    pub inside_count: Result<usize, NoInside>,
    /// Vertices that are inside or within the margin, ascending.
    pub near: Vec<NearVertex>,
}

impl PairReport {
    /// Copies what was computed for two bodies, without distance and patches.
    #[must_use]
    pub fn new(pair: PairId, found: &PairProximity) -> Self {
        let [a_against_b, b_against_a] = found.sides().map(VertexReport::new);
        Self {
            pair,
            overlaps: found.overlaps(),
            max_depth: found.max_depth(),
            min_gap: found.min_gap(),
            distance: None,
            crossing_faces: found.crossing_faces().to_vec(),
            a_against_b,
            b_against_a,
            patches: Vec::new(),
        }
    }

    /// Makes one contact for each vertex that is inside or within the margin, those of `a` first,
    /// with particles numbered by [`Body::particles`](crate::Body::particles).
    ///
    /// A rigid body is the anchor of its contacts, at rest; where it holds the vertex, the point
    /// of the other body's face is the colliding point and the normal is reversed.
    ///
    /// # Panics
    ///
    /// When the report is of another scene.
    #[must_use]
    pub fn contacts(&self, scene: &Scene) -> Vec<Contact> {
        let [a, b] = self.pair.bodies().map(|id| scene.body(id).contact_surface());
        let of_a = self.a_against_b.near.iter().map(|near| contact(&a, &b, near));
        let of_b = self.b_against_a.near.iter().map(|near| contact(&b, &a, near));
        of_a.chain(of_b).collect()
    }
}

impl VertexReport {
    fn new(side: &PairSide) -> Self {
        Self { inside_count: side.inside_count(), near: side.near().to_vec() }
    }
}
