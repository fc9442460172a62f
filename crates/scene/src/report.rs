//! Result of static detection between two bodies.

use overlap::AreaBracket;
use proximity::{NearVertex, NoInside, PairProximity, PairSide, contact};
use surface::Contact;

use crate::{Coincidence, DepthBracket, PairId, PairOverlap, Scene};

/// Proximity of two bodies in one state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PairReport {
    /// The two bodies.
    pub pair: PairId,
    /// True if faces cross, a vertex of one is inside the other, or both share
    /// a volume since they coincide. Surfaces that only touch do not overlap.
    pub overlaps: bool,
    /// Way in which both bodies are the same, where they are.
    pub coincidence: Option<Coincidence>,
    /// Depth of the deepest vertex inside the other body, `>= 0`; 0 where none
    /// is, even when faces cross. It depends on the mesh:
    /// [`max_depth`](Self::max_depth) does not.
    pub max_vertex_depth: f64,
    /// Smallest signed distance of a vertex to the other surface, negative
    /// inside; `None` where no vertex is inside or within the margin.
    pub min_gap: Option<f64>,
    /// Distance between the surfaces, their edges and faces included: 0 where
    /// they cross or touch, `None` where they are farther apart than the margin. It may exceed the
    /// margin by no more than rounding, as gaps may.
    pub distance: Option<f64>,
    /// Pairs of faces (of `a`, of `b`) that properly cross, ascending.
    pub crossing_faces: Vec<[u32; 2]>,
    /// Vertices of `a` against the surface of `b`.
    pub a_against_b: VertexReport,
    /// Vertices of `b` against the surface of `a`.
    pub b_against_a: VertexReport,
    /// Area of the surface of `a` within the margin of `b`, and of `b` within that of `a`, for pairs
    /// that do not overlap; `None` without [`CheckParams::measures`](crate::CheckParams::measures).
    pub near_areas: Option<[AreaBracket; 2]>,
    /// Measures of what both share, where they overlap, or touch in an area; `None` without
    /// [`CheckParams::measures`](crate::CheckParams::measures).
    pub overlap: Option<PairOverlap>,
}

/// Vertices of one body against the surface of another.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VertexReport {
    /// Number of vertices inside the other body, or the reason why that has no inside.
    pub inside_count: Result<usize, NoInside>,
    /// Vertices that are inside or within the margin, ascending.
    pub near: Vec<NearVertex>,
}

impl PairReport {
    /// Copies what was computed for two bodies, without distance and measures.
    #[must_use]
    pub fn new(pair: PairId, found: &PairProximity) -> Self {
        let [a_against_b, b_against_a] = found.sides().map(VertexReport::new);
        Self {
            pair,
            overlaps: found.overlaps(),
            coincidence: None,
            max_vertex_depth: found.max_vertex_depth(),
            min_gap: found.min_gap(),
            distance: None,
            crossing_faces: found.crossing_faces().to_vec(),
            a_against_b,
            b_against_a,
            near_areas: None,
            overlap: None,
        }
    }

    /// Brackets the depth of the overlap: the greatest distance of a point of one surface inside
    /// the other body, from the other surface. It is a distance, not a way out: in the middle of a
    /// thin body all ways are short.
    ///
    /// `None` where nothing is inside, where the depth in one of the bodies is undefined (it may be
    /// the larger one: `max_vertex_depth` is a depth that there is at least), and without measures.
    #[must_use]
    pub fn max_depth(&self) -> Option<DepthBracket> {
        if self.a_against_b.is_surrounded() || self.b_against_a.is_surrounded() {
            return None;
        }
        self.overlap.as_ref().and_then(PairOverlap::max_depth)
    }

    /// Makes one contact for each vertex that is inside or within the margin, those of `a` first,
    /// with particles numbered by [`Body::particles`](crate::Body::particles). After them comes
    /// one contact for the deepest point of each measured region that no vertex is inside.
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
        let mut contacts = Vec::new();
        for near in &self.a_against_b.near {
            contacts.push(contact(&a, &b, near));
        }
        for near in &self.b_against_a.near {
            contacts.push(contact(&b, &a, near));
        }

        // Regions that no vertex shows.
        let Some(overlap) = &self.overlap else { return contacts };
        for edge in &overlap.edge_overlaps {
            let (own, other) = if edge.body == self.pair.a { (&a, &b) } else { (&b, &a) };
            contacts.push(edge.contact(own, other));
        }
        contacts
    }
}

impl VertexReport {
    fn new(side: &PairSide) -> Self {
        Self { inside_count: side.inside_count(), near: side.near().to_vec() }
    }

    /// Returns true if the other surface is around vertices, but has no inside.
    fn is_surrounded(&self) -> bool {
        self.inside_count.is_err() && self.near.iter().any(|near| near.gap < 0.0)
    }
}
