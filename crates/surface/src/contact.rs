//! Contact between two objects: the record that every detector returns and every
//! response takes.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2: a
//! collision is a linear combination of particle states. P is the colliding
//! point, P̄ its projection on (or entry point in) the other object, and
//! `P_c = P̄ − P = Σ w_i P_i − P`.
//!
//! Here P may itself be a combination (a point of an edge), and P̄ may be
//! carried by a rigid object, whose state at P̄ is then the contact's anchor.

use glam::DVec3;

/// Weight of one particle in a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Term {
    /// Number of the particle in the caller's arrays.
    pub particle: u32,
    /// Its weight β in `P_c = Σ β_k P_k`: negative on the side of P. A zero has the
    /// sign of its side.
    pub weight: f64,
}

impl Term {
    /// Returns the term on the side of P, for its weight in P: with the sign of that side.
    fn of_p(self) -> Self {
        // The sum of both zeros is the positive one.
        Self { weight: -(self.weight + 0.0), ..self }
    }

    /// Returns the term on the side of P̄, for its weight in P̄.
    fn of_on(self) -> Self {
        Self { weight: self.weight + 0.0, ..self }
    }
}

/// Linear combination of one to six particles: at most a face on either side.
///
/// The weights on the side of P sum to −1. Those on the side of P̄ sum to 1
/// where P̄ is carried by particles; where it is rigid there are none, and the
/// contact has an [`Anchor`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stencil {
    terms: [Term; MAX_TERMS],
    len: u8,
}

/// Terms of a stencil between a point of one face and a point of another.
const MAX_TERMS: usize = 6;

/// Padding of a stencil with fewer terms.
const NO_TERM: Term = Term { particle: 0, weight: 0.0 };

/// State of a rigid object at P̄, in the caller's length and time units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Anchor {
    /// P̄ itself.
    pub point: DVec3,
    /// Velocity of the object there.
    pub velocity: DVec3,
    /// Acceleration of the object there.
    pub acceleration: DVec3,
}

/// Carrier of the point of one side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactSide<'a> {
    /// A rigid object, by its state at the point.
    Rigid(Anchor),
    /// Particles, by their weights in the point, which sum to 1.
    Particles(&'a [Term]),
}

impl ContactSide<'_> {
    /// Returns a point of a rigid object at rest.
    #[must_use]
    pub fn at_rest(point: DVec3) -> Self {
        Self::Rigid(Anchor { point, ..Anchor::default() })
    }
}

/// Contact of a point P of one object with its projection P̄ on another one.
///
/// # Identity
///
/// With P_c = [`separation`](Self::separation) at the positions that the contact was
/// detected at,
///
/// ```text
/// gap = −P_c · normal − offset
/// ```
///
/// `−P_c · normal` is the signed height of P over P̄. Every detector asserts
/// this by [`identity_error`](Self::identity_error).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// The particles that P_c combines.
    pub stencil: Stencil,
    /// The rigid object's state at P̄, or none where particles carry P̄.
    pub anchor: Option<Anchor>,
    /// Unit length; points out of the object that holds P̄.
    pub normal: DVec3,
    /// Distance between P and P̄ at which the objects just touch, `>= 0`: the radii
    /// of a medial contact, else 0.
    pub offset: f64,
    /// Signed distance between the objects at the contact; negative inside.
    pub gap: f64,
    /// Time at which a swept contact began, in `0.0..=1.0` of the step.
    pub time: Option<f64>,
}

impl Stencil {
    /// Returns the stencil of a vertex P against a face with weights `b` of its corners.
    #[must_use]
    pub fn vertex_face(vertex: u32, face: [u32; 3], b: [f64; 3]) -> Self {
        let Self { terms: [p, q, r, ..], .. } = Self::face(face, b);
        Self::from_terms([Term { particle: vertex, weight: -1.0 }, p.of_on(), q.of_on(), r.of_on()])
    }

    /// Returns the stencil of the point `(1 − s) a0 + s a1` of an edge as P against the
    /// point `(1 − t) b0 + t b1` of another.
    #[must_use]
    pub fn edge_edge(a: [u32; 2], s: f64, b: [u32; 2], t: f64) -> Self {
        let term = |particle, weight| Term { particle, weight };
        let (p, on) = ([term(a[0], 1.0 - s), term(a[1], s)], [term(b[0], 1.0 - t), term(b[1], t)]);
        Self::from_terms([p[0].of_p(), p[1].of_p(), on[0].of_on(), on[1].of_on()])
    }

    /// Returns the stencil of one particle against a rigid object.
    #[must_use]
    pub fn single(term: Term) -> Self {
        Self::from_terms([term])
    }

    /// Returns the stencil of a face's corners against a rigid object.
    #[must_use]
    pub fn face(face: [u32; 3], weights: [f64; 3]) -> Self {
        Self::from_terms([0, 1, 2].map(|k| Term { particle: face[k], weight: weights[k] }))
    }

    /// Returns the stencil of a number of terms that fits when the program is built: at most six.
    #[expect(clippy::cast_possible_truncation, reason = "at most six")]
    #[must_use]
    pub fn from_terms<const N: usize>(terms: [Term; N]) -> Self {
        const { assert!(N <= MAX_TERMS, "a stencil has at most six terms") };
        let mut padded = [NO_TERM; MAX_TERMS];
        padded[..N].copy_from_slice(&terms);
        Self { terms: padded, len: N as u8 }
    }

    /// Returns the stencil of one to six terms; `None` for another number.
    ///
    /// ```
    /// use surface::{Stencil, Term};
    ///
    /// let vertex_on_bone = Stencil::new(&[Term { particle: 7, weight: -1.0 }]).expect("one term");
    /// assert_eq!(vertex_on_bone.terms().len(), 1);
    /// assert!(Stencil::new(&[]).is_none());
    /// ```
    #[must_use]
    pub fn new(terms: &[Term]) -> Option<Self> {
        if !(1..=MAX_TERMS).contains(&terms.len()) {
            return None;
        }
        let mut padded = [NO_TERM; MAX_TERMS];
        padded[..terms.len()].copy_from_slice(terms);
        Some(Self { terms: padded, len: u8::try_from(terms.len()).ok()? })
    }

    /// Returns the terms of P̄ minus those of P, those of P first; `None` unless they are
    /// one to six.
    fn difference(on: &[Term], p: &[Term]) -> Option<Self> {
        let len = p.len() + on.len();
        let signed = p.iter().map(|term| term.of_p()).chain(on.iter().map(|term| term.of_on()));
        let mut terms = [NO_TERM; MAX_TERMS];
        for (place, term) in terms.iter_mut().zip(signed) {
            *place = term;
        }
        Self::new(terms.get(..len)?)
    }

    /// Returns the terms, those of P first.
    #[must_use]
    pub fn terms(&self) -> &[Term] {
        &self.terms[..usize::from(self.len)]
    }

    /// Computes `Σ β_k x(k)` over the terms.
    #[must_use]
    pub fn combine(&self, mut x: impl FnMut(u32) -> DVec3) -> DVec3 {
        self.terms().iter().map(|term| term.weight * x(term.particle)).sum()
    }
}

impl Contact {
    /// Builds the contact of a point P of one side with its projection P̄ on the other;
    /// `normal` points out of the latter. The offset is 0.
    ///
    /// Where only P̄ is carried by particles, these become the point that the contact moves:
    /// the rigid object at P is the anchor, and the normal is reversed.
    ///
    /// ```
    /// use surface::{Contact, ContactSide, Term, glam::DVec3};
    ///
    /// let bone = ContactSide::at_rest(DVec3::ZERO);
    /// let tissue = [Term { particle: 7, weight: 1.0 }];
    /// let contact = Contact::between(bone, ContactSide::Particles(&tissue), DVec3::Z, -0.5);
    /// assert_eq!(contact.stencil.terms(), [Term { particle: 7, weight: -1.0 }]);
    /// assert_eq!(contact.normal, -DVec3::Z);
    /// ```
    ///
    /// # Panics
    ///
    /// When there are no particles, or more than six.
    #[must_use]
    pub fn between(p: ContactSide<'_>, on: ContactSide<'_>, normal: DVec3, gap: f64) -> Self {
        use ContactSide::{Particles, Rigid};

        let (stencil, anchor, normal) = match (p, on) {
            (Particles(p), Particles(on)) => (Stencil::difference(on, p), None, normal),
            (Particles(p), Rigid(anchor)) => (Stencil::difference(&[], p), Some(anchor), normal),
            (Rigid(anchor), Particles(on)) => (Stencil::difference(&[], on), Some(anchor), -normal),
            (Rigid(_), Rigid(_)) => (None, None, normal),
        };
        let stencil = stencil.expect("one to six particles carry a contact");
        Self { stencil, anchor, normal, offset: 0.0, gap, time: None }
    }

    /// Computes P_c = P̄ − P for particles at `x`.
    #[must_use]
    pub fn separation(&self, x: impl FnMut(u32) -> DVec3) -> DVec3 {
        self.anchor.map_or(DVec3::ZERO, |anchor| anchor.point) + self.stencil.combine(x)
    }

    /// Computes the residual of the identity between the fields, in the caller's length
    /// unit: rounding only, at the positions `x` that the contact was detected at.
    #[must_use]
    pub fn identity_error(&self, x: impl FnMut(u32) -> DVec3) -> f64 {
        (self.gap + self.offset + self.separation(x).dot(self.normal)).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_satisfy_the_identity() {
        let x = [DVec3::new(0.2, 0.3, -0.5), DVec3::ZERO, DVec3::X, DVec3::Y];
        let at = |k: u32| x[k as usize];
        let contact = Contact {
            stencil: Stencil::vertex_face(0, [1, 2, 3], [0.5, 0.2, 0.3]),
            anchor: None,
            normal: DVec3::Z,
            offset: 0.0,
            gap: -0.5,
            time: None,
        };
        assert!((contact.separation(at) - DVec3::new(0.0, 0.0, 0.5)).length() < 1e-15);
        assert!(contact.identity_error(at) < 1e-15);
        let wrong = Contact { gap: 0.5, ..contact };
        assert!(wrong.identity_error(at) > 0.9, "a sign error must show");
    }

    #[test]
    fn a_rigid_side_is_the_anchor() {
        let term = |particle, weight| Term { particle, weight };
        let (p, on) = ([term(0, 1.0)], [term(1, 0.5), term(2, 0.2), term(3, 0.3)]);
        let (p, on) = (ContactSide::Particles(&p), ContactSide::Particles(&on));
        let rigid = ContactSide::at_rest(DVec3::X);

        let soft = Contact::between(p, on, DVec3::Z, -1.0);
        assert_eq!(soft.stencil, Stencil::vertex_face(0, [1, 2, 3], [0.5, 0.2, 0.3]));
        assert_eq!((soft.anchor, soft.normal, soft.gap), (None, DVec3::Z, -1.0));

        let on_bone = Contact::between(p, rigid, DVec3::Z, -1.0);
        assert_eq!(on_bone.stencil, Stencil::single(term(0, -1.0)));
        assert_eq!(on_bone.anchor.map(|anchor| anchor.point), Some(DVec3::X));

        let by_bone = Contact::between(rigid, on, DVec3::Z, -1.0);
        assert_eq!(by_bone.stencil, Stencil::face([1, 2, 3], [-0.5, -0.2, -0.3]));
        assert_eq!(by_bone.normal, -DVec3::Z);
    }

    /// Zeros have the sign of their side, whatever that of the zero that they were made of.
    #[test]
    fn signs_of_weights_are_those_of_their_sides() {
        let term = |particle, weight| Term { particle, weight };
        for zero in [0.0, -0.0] {
            for (s, t) in [(zero, 1.0), (1.0, zero), (0.5, zero), (zero, 0.5), (zero, zero)] {
                let (p, on) = ([term(0, 1.0 - s), term(1, s)], [term(2, 1.0 - t), term(3, t)]);
                let (p, on) = (ContactSide::Particles(&p), ContactSide::Particles(&on));
                let face = Stencil::vertex_face(0, [1, 2, 3], [1.0 - t, t, zero]);
                let between = Contact::between(p, on, DVec3::Z, 1.0).stencil;
                let reversed = Contact::between(ContactSide::at_rest(DVec3::X), p, DVec3::Z, 1.0);
                for (stencil, of_p) in [
                    (Stencil::edge_edge([0, 1], s, [2, 3], t), 2),
                    (between, 2),
                    (face, 1),
                    (reversed.stencil, 2),
                ] {
                    let signs = stencil.terms().iter().map(|term| term.weight.is_sign_negative());
                    let expected = (0..stencil.terms().len()).map(|k| k < of_p);
                    assert!(signs.eq(expected), "{stencil:?}");
                }
            }
        }
    }

    #[test]
    fn weights_sum_to_zero() {
        let stencils = [
            Stencil::vertex_face(0, [1, 2, 3], [0.1, 0.2, 0.7]),
            Stencil::edge_edge([0, 1], 0.3, [2, 3], 0.9),
        ];
        for stencil in stencils {
            let sum: f64 = stencil.terms().iter().map(|term| term.weight).sum();
            assert!(sum.abs() < 1e-15, "{stencil:?}");
        }
    }
}
