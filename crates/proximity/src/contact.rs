//! Contact records from vertices and their closest points.

use surface::{Contact, ContactSide, Positions, Term, TriangleSurface};

use crate::NearVertex;

/// Numbers of a surface's vertices among all particles of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParticleNumbers<'a> {
    /// Number of the first vertex.
    pub first: u32,
    /// For a surface that represents a finer one: the vertices of that one which it has kept,
    /// ascending. Those are numbered from `first`.
    pub kept: Option<&'a [u32]>,
}

/// Surface as one side of a contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactSurface<'a> {
    /// The surface.
    pub surface: &'a TriangleSurface,
    /// Positions of its vertices.
    pub positions: Positions<'a>,
    /// Numbers of its vertices.
    pub particles: ParticleNumbers<'a>,
    /// True if it does not yield: it is then an anchor, at rest, and none of its vertices is in
    /// a stencil.
    pub is_rigid: bool,
}

impl ParticleNumbers<'_> {
    /// Numbers vertices from `first`.
    #[must_use]
    pub fn from(first: u32) -> Self {
        Self { first, kept: None }
    }

    /// Returns the particle that a vertex is.
    ///
    /// # Panics
    ///
    /// When the surface has kept fewer vertices.
    #[must_use]
    #[inline]
    pub fn particle(&self, vertex: u32) -> u32 {
        self.first + self.kept.map_or(vertex, |kept| kept[vertex as usize])
    }
}

/// Makes the contact of a vertex of `p` with the face of `q` that holds its closest point.
///
/// A rigid side is the anchor. Where `p` is rigid, the closest point becomes the colliding one
/// and the normal is reversed.
///
/// # Panics
///
/// When `near` is of other surfaces.
#[must_use]
pub fn contact(p: &ContactSurface<'_>, q: &ContactSurface<'_>, near: &NearVertex) -> Contact {
    let vertex = [Term { particle: p.particles.particle(near.vertex), weight: 1.0 }];
    let corners = q.surface.faces()[near.face as usize];
    let face: [Term; 3] = std::array::from_fn(|k| Term {
        particle: q.particles.particle(corners[k]),
        weight: near.barycentric[k],
    });

    // Of two rigid surfaces, the second is the anchor.
    let of_p = if p.is_rigid && !q.is_rigid {
        ContactSide::at_rest(p.positions.at(near.vertex))
    } else {
        ContactSide::Particles(&vertex)
    };
    let of_q =
        if q.is_rigid { ContactSide::at_rest(near.foot) } else { ContactSide::Particles(&face) };
    let contact = Contact::between(of_p, of_q, near.normal, near.gap);
    debug_assert!(satisfies_identity(&contact, p, q, near), "{contact:?}");
    contact
}

/// Returns true if a contact's fields fit each other, up to rounding.
fn satisfies_identity(
    contact: &Contact,
    p: &ContactSurface<'_>,
    q: &ContactSurface<'_>,
    near: &NearVertex,
) -> bool {
    let corners = q.surface.faces()[near.face as usize];
    let position = |particle: u32| {
        for corner in corners {
            if q.particles.particle(corner) == particle {
                return q.positions.at(corner);
            }
        }
        p.positions.at(near.vertex)
    };

    // Rounding is relative to the coordinates: that of closest points on triangles.
    let mut scale = contact.gap.abs();
    for term in contact.stencil.terms() {
        scale = scale.max(position(term.particle).abs().max_element());
    }
    contact.identity_error(position) <= 512.0 * f64::EPSILON * scale
}
