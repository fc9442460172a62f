//! Constraint rows: contacts as the solvers and the soft forces take them.
//!
//! A contact combines at most six particles. A row combines any number: where
//! a contact lies on the fan about the center of a polygon, the center's
//! weight is spread over the polygon's vertices
//! ([`SimplexSurface::spread`](surface::SimplexSurface::spread)). Terms are stored
//! one row after the other, as in a compressed sparse matrix.
//!
//! A row stores the depth at which its contact was detected, and measures changes from
//! there: a center that is lifted off its polygon, or an offset by radii, does not
//! concern the row.
//!
//! Each row imposes a [`Constraint`] on the relative motion Q_c of its contact.

use glam::DVec3;
use surface::{Anchor, Contact, Term};

use crate::distribute::merge_onto;
use crate::{Constraint, Friction, Margins, ResponseError, check};

/// Distances that a response keeps at a contact, its friction and its compliance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactLaw {
    margins: Margins,
    friction: Friction,
    compliance: f64,
}

#[cfg(feature = "serde")]
check::deserialize_checked!(
    ContactLaw { margins: Margins, friction: Friction, compliance: f64 },
    Self { margins, friction, compliance: 0.0 }.with_compliance(compliance)
);

impl ContactLaw {
    /// Returns a hard law with the distances kept and Coulomb's friction coefficient µ
    /// `>= 0`.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] when µ is outside its range.
    pub fn new(margins: Margins, friction: f64) -> Result<Self, ResponseError> {
        Ok(Self { margins, friction: Friction::coulomb(friction)?, compliance: 0.0 })
    }

    /// Returns the same law with another friction law.
    #[must_use]
    pub fn with_friction(self, friction: Friction) -> Self {
        Self { friction, ..self }
    }

    /// Returns the same law with the compliance α `>= 0` of the constraint, in the unit of
    /// the unknowns over that of the impulses; 0 is hard. [`SpringDamper::compliance`]
    /// computes it from a stiffness. Friction remains hard.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the range.
    ///
    /// [`SpringDamper::compliance`]: crate::SpringDamper::compliance
    pub fn with_compliance(self, compliance: f64) -> Result<Self, ResponseError> {
        Ok(Self { compliance: check::not_negative("compliance", compliance)?, ..self })
    }

    /// Returns the distances kept.
    #[must_use]
    pub fn margins(&self) -> Margins {
        self.margins
    }

    /// Returns the friction law.
    #[must_use]
    pub fn friction(&self) -> Friction {
        self.friction
    }

    /// Returns the compliance α.
    #[must_use]
    pub fn compliance(&self) -> f64 {
        self.compliance
    }
}

/// View of one row of [`ContactRows`].
#[derive(Clone, Copy, Debug)]
pub struct ContactRow<'a> {
    /// Particles and weights β, each particle once.
    pub terms: &'a [Term],
    /// n, of unit length.
    pub normal: DVec3,
    /// δ where the contact was detected: clearance minus gap.
    pub depth: f64,
    /// State of the rigid object at P̄, zero where there is none.
    pub anchor: Anchor,
    /// Distances kept, friction and compliance.
    pub law: ContactLaw,
    /// Constraint on Q_c.
    pub constraint: Constraint,
}

impl ContactRow<'_> {
    /// Computes Σ β_k q_k over the terms.
    pub(crate) fn combine(&self, q: &[DVec3]) -> DVec3 {
        self.terms.iter().map(|term| term.weight * q[term.particle as usize]).sum()
    }
}

/// Constraint rows over particles `0..particle_count`, one per contact.
///
/// ```
/// use glam::DVec3;
/// use response::{ContactLaw, ContactRows, Margins};
/// use surface::{Anchor, Contact, Stencil, Term};
///
/// let contact = Contact {
///     stencil: Stencil::single(Term { particle: 0, weight: -1.0 }),
///     anchor: Some(Anchor::default()),
///     normal: DVec3::Z,
///     offset: 0.0,
///     gap: -0.5,
///     time: None,
/// };
/// let law = ContactLaw::new(Margins::new(0.1, 1.0)?, 0.5)?;
/// let mut rows = ContactRows::new(1);
/// rows.extend(&[contact], law)?;
/// assert_eq!(rows.row(0).depth, 0.6);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactRows {
    particle_count: usize,
    records: Vec<Record>,
    terms: Vec<Term>,
}

/// One row as it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Record {
    /// Range of its terms.
    terms: [u32; 2],
    normal: DVec3,
    depth: f64,
    anchor: Anchor,
    law: ContactLaw,
    constraint: Constraint,
}

impl ContactRows {
    /// Returns an empty list of rows.
    #[must_use]
    pub fn new(particle_count: usize) -> Self {
        Self { particle_count, records: Vec::new(), terms: Vec::new() }
    }

    /// Removes all rows, for particles `0..particle_count`; the memory is kept.
    pub fn clear(&mut self, particle_count: usize) {
        self.particle_count = particle_count;
        self.records.clear();
        self.terms.clear();
    }

    /// Adds a row for each contact.
    ///
    /// # Errors
    ///
    /// As [`Self::push`], for the first contact refused; the rows before it remain.
    pub fn extend(&mut self, contacts: &[Contact], law: ContactLaw) -> Result<(), ResponseError> {
        self.records.reserve(contacts.len());
        self.terms.reserve(contacts.iter().map(|contact| contact.stencil.terms().len()).sum());
        contacts.iter().try_for_each(|contact| self.push(contact, law))
    }

    /// Adds a row that keeps its contact free: [`Constraint::Contact`].
    ///
    /// # Errors
    ///
    /// As [`Self::push_terms`].
    pub fn push(&mut self, contact: &Contact, law: ContactLaw) -> Result<(), ResponseError> {
        self.push_constraint(contact, law, Constraint::Contact)
    }

    /// Adds a row with another constraint.
    ///
    /// # Errors
    ///
    /// As [`Self::push_terms`].
    pub fn push_constraint(
        &mut self,
        contact: &Contact,
        law: ContactLaw,
        constraint: Constraint,
    ) -> Result<(), ResponseError> {
        self.push_terms(contact, contact.stencil.terms(), law, constraint)
    }

    /// Adds a row for a contact with `terms` instead of its stencil: more than six
    /// particles, for instance.
    ///
    /// # Errors
    ///
    /// With the number the row would have had:
    /// - [`ResponseError::ContactNotFinite`] or [`ResponseError::Normal`];
    /// - [`ResponseError::ParticleOutOfRange`];
    /// - [`ResponseError::Weights`] when they do not sum to 0, or to −1 where
    ///   P̄ is carried by a rigid object;
    /// - [`ResponseError::TooMany`] beyond the range of 32-bit indices.
    pub fn push_terms(
        &mut self,
        contact: &Contact,
        terms: &[Term],
        law: ContactLaw,
        constraint: Constraint,
    ) -> Result<(), ResponseError> {
        // Check everything before the lists change.
        let row = self.len();
        let anchor = contact.anchor.unwrap_or_default();
        let normal = check::normal(row, contact.normal)?;
        let depth = law.margins.clearance() - check::contact_number(row, "gap", contact.gap)?;
        check::contact_vector(row, "anchor velocity", anchor.velocity)?;
        check::contact_vector(row, "anchor acceleration", anchor.acceleration)?;
        constraint.check(row)?;
        check_weights(row, terms, if contact.anchor.is_some() { -1.0 } else { 0.0 })?;
        check::particle_range(row, terms.iter().map(|t| t.particle), self.particle_count)?;
        check::index("contacts", row + 1)?;
        check::index("terms", self.terms.len() + terms.len())?;

        let start = check::index("terms", self.terms.len())?;
        merge_onto(&mut self.terms, terms);
        let terms = [start, check::index("terms", self.terms.len())?];
        self.records.push(Record { terms, normal, depth, anchor, law, constraint });
        Ok(())
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Returns true if there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Returns the number of particles that rows may refer to.
    #[must_use]
    pub fn particle_count(&self) -> usize {
        self.particle_count
    }

    /// Returns one row.
    ///
    /// # Panics
    ///
    /// When there is no such row.
    #[must_use]
    pub fn row(&self, row: usize) -> ContactRow<'_> {
        self.view(&self.records[row])
    }

    /// Returns all rows, in order.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = ContactRow<'_>> {
        self.records.iter().map(|record| self.view(record))
    }

    fn view(&self, record: &Record) -> ContactRow<'_> {
        let Record { terms: [start, end], normal, depth, anchor, law, constraint } = *record;
        let terms = &self.terms[start as usize..end as usize];
        ContactRow { terms, normal, depth, anchor, law, constraint }
    }
}

fn check_weights(contact: usize, terms: &[Term], expected: f64) -> Result<(), ResponseError> {
    let (mut sum, mut scale) = (0.0, 0.0);
    for term in terms {
        sum += check::contact_number(contact, "weight", term.weight)?;
        scale += term.weight.abs();
    }
    check::weight_sum(contact, sum, scale, expected)
}
