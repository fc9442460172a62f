//! Constraint rows: contacts as the solvers and the soft forces take them.
//!
//! A contact combines at most four particles. A row combines any number: where
//! a contact lies on the fan about the center of a polygon, the center's
//! weight is spread over the polygon's vertices ([`Spread`]). Rows are stored
//! one after the other, as in a compressed sparse matrix.
//!
//! A row remembers how deep its contact was when found, and measures from
//! there: a center that is lifted off its polygon, or an offset by radii, is
//! then no concern of the row's.

use glam::DVec3;
use surface::{Anchor, Contact, Term};

use crate::distribute::merge_onto;
use crate::torque_arm::{TorqueArm, TorqueArmRow};
use crate::{Margins, ResponseError, check};

/// Deviation of a sum of weights that is taken for rounding, a plain number.
/// Barycentric weights are good to 1e-12 even on slivers; a forgotten term is
/// off by 1e-2 and more, and would break the momentum by its share.
const WEIGHT_TOLERANCE: f64 = 1e-9;

/// What a response keeps at a contact, and how it rubs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactLaw {
    margins: Margins,
    friction: f64,
}

impl ContactLaw {
    /// Distances kept, and Coulomb's friction coefficient µ `>= 0`.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] when µ is outside its range.
    pub fn new(margins: Margins, friction: f64) -> Result<Self, ResponseError> {
        Ok(Self { margins, friction: check::not_negative("friction coefficient", friction)? })
    }

    /// The same distances kept, without friction.
    #[must_use]
    pub fn without_friction(self) -> Self {
        Self { friction: 0.0, ..self }
    }

    /// Distances kept.
    #[must_use]
    pub fn margins(&self) -> Margins {
        self.margins
    }

    /// Coulomb's µ.
    #[must_use]
    pub fn friction(&self) -> f64 {
        self.friction
    }
}

/// Points that stand for weighted sums of particles, numbered after them: the
/// center of a polygon for the mean of its vertices.
///
/// ```
/// use surface::Term;
///
/// // Particles 0..4; point 4 is the center of the square that they form.
/// let corners: Vec<Term> = (0..4).map(|particle| Term { particle, weight: 0.25 }).collect();
/// let mut spread = response::Spread::new(4);
/// assert_eq!(spread.push(&corners)?, 4);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    particle_count: usize,
    starts: Vec<u32>,
    terms: Vec<Term>,
}

impl Spread {
    /// No points yet, over particles `0..particle_count`.
    #[must_use]
    pub fn new(particle_count: usize) -> Self {
        Self { particle_count, starts: vec![0], terms: Vec::new() }
    }

    /// Adds a point, and returns the number that contacts refer to it by. The
    /// weights must sum to 1.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Weights`] with the point's place in `contact`, or
    /// [`ResponseError::ParticleOutOfRange`] likewise.
    pub fn push(&mut self, terms: &[Term]) -> Result<u32, ResponseError> {
        let point = self.starts.len() - 1;
        check_weights(point, terms, 1.0)?;
        check_particles(point, terms, self.particle_count)?;
        let name = number("spread points", self.particle_count + point)?;
        self.starts.push(number("terms", self.terms.len() + terms.len())?);
        self.terms.extend_from_slice(terms);
        Ok(name)
    }

    fn terms_of(&self, particle: u32) -> Option<&[Term]> {
        let point = (particle as usize).checked_sub(self.particle_count)?;
        let end = *self.starts.get(point + 1)?;
        Some(&self.terms[self.starts[point] as usize..end as usize])
    }
}

/// One row, as [`ContactRows::row`] shows it.
#[derive(Clone, Copy, Debug)]
pub struct ContactRow<'a> {
    /// Particles and weights β, each particle once.
    pub terms: &'a [Term],
    /// n, of unit length.
    pub normal: DVec3,
    /// δ where the contact was found: clearance less gap.
    pub depth: f64,
    /// State of the rigid object at P̄, zero where there is none.
    pub anchor: Anchor,
    /// Distances kept and friction.
    pub law: ContactLaw,
}

/// Constraint rows over particles `0..particle_count`, one a contact.
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
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRows {
    particle_count: usize,
    starts: Vec<u32>,
    terms: Vec<Term>,
    normals: Vec<DVec3>,
    depths: Vec<f64>,
    anchors: Vec<Anchor>,
    laws: Vec<ContactLaw>,
    levers: Vec<TorqueArmRow>,
}

impl ContactRows {
    /// No rows yet.
    #[must_use]
    pub fn new(particle_count: usize) -> Self {
        Self {
            particle_count,
            starts: vec![0],
            terms: Vec::new(),
            normals: Vec::new(),
            depths: Vec::new(),
            anchors: Vec::new(),
            laws: Vec::new(),
            levers: Vec::new(),
        }
    }

    /// Adds a row for each contact.
    ///
    /// # Errors
    ///
    /// As [`Self::push`], for the first contact refused; those before it stay.
    pub fn extend(&mut self, contacts: &[Contact], law: ContactLaw) -> Result<(), ResponseError> {
        self.starts.reserve(contacts.len());
        self.terms.reserve(contacts.iter().map(|contact| contact.stencil.terms().len()).sum());
        self.normals.reserve(contacts.len());
        self.depths.reserve(contacts.len());
        self.anchors.reserve(contacts.len());
        self.laws.reserve(contacts.len());
        contacts.iter().try_for_each(|contact| self.push(contact, law))
    }

    /// Adds a row.
    ///
    /// # Errors
    ///
    /// With the number the row would have had:
    /// - [`ResponseError::ContactNotFinite`] or [`ResponseError::Normal`];
    /// - [`ResponseError::ParticleOutOfRange`];
    /// - [`ResponseError::Weights`] when they do not sum to 0, or to −1 where
    ///   P̄ is carried by a rigid object;
    /// - [`ResponseError::TooMany`] beyond what 32-bit indices number.
    pub fn push(&mut self, contact: &Contact, law: ContactLaw) -> Result<(), ResponseError> {
        self.push_terms(contact, contact.stencil.terms(), law)
    }

    /// Adds a row for a contact some of whose particles are points of `spread`.
    ///
    /// # Errors
    ///
    /// As [`Self::push`].
    pub fn push_spread(
        &mut self,
        contact: &Contact,
        spread: &Spread,
        law: ContactLaw,
    ) -> Result<(), ResponseError> {
        let mut terms = Vec::with_capacity(16);
        for term in contact.stencil.terms() {
            match spread.terms_of(term.particle) {
                None => terms.push(*term),
                Some(shares) => terms.extend(shares.iter().map(|share| Term {
                    particle: share.particle,
                    weight: term.weight * share.weight,
                })),
            }
        }
        self.push_terms(contact, &terms, law)
    }

    /// Adds a row whose friction acts at a surface point beside P or P̄, which
    /// three particles on that side carry: see [`TorqueArm`].
    ///
    /// `x` are the positions of all particles.
    ///
    /// # Errors
    ///
    /// As [`Self::push`], and [`ResponseError::Collinear`] when the particles
    /// of a lever cannot carry a torque.
    pub fn push_with_torque_arms(
        &mut self,
        contact: &Contact,
        levers: &[TorqueArm],
        x: &[DVec3],
        law: ContactLaw,
    ) -> Result<(), ResponseError> {
        let row = self.len();
        check::particles("position", self.particle_count, x)?;
        let levers = levers
            .iter()
            .map(|lever| TorqueArmRow::new(row, number("contacts", row)?, lever, x))
            .collect::<Result<Vec<_>, _>>()?;
        self.push(contact, law)?;
        self.levers.extend(levers);
        Ok(())
    }

    /// Rows there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.normals.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.normals.is_empty()
    }

    /// Particles the rows refer to at most.
    #[must_use]
    pub fn particle_count(&self) -> usize {
        self.particle_count
    }

    /// One row.
    ///
    /// # Panics
    ///
    /// When there is no such row.
    #[must_use]
    pub fn row(&self, row: usize) -> ContactRow<'_> {
        ContactRow {
            terms: &self.terms[self.starts[row] as usize..self.starts[row + 1] as usize],
            normal: self.normals[row],
            depth: self.depths[row],
            anchor: self.anchors[row],
            law: self.laws[row],
        }
    }

    /// All rows, in order.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = ContactRow<'_>> {
        (0..self.len()).map(|row| self.row(row))
    }

    /// Levers, in order of their rows.
    pub(crate) fn levers(&self) -> &[TorqueArmRow] {
        &self.levers
    }

    fn push_terms(
        &mut self,
        contact: &Contact,
        terms: &[Term],
        law: ContactLaw,
    ) -> Result<(), ResponseError> {
        let row = self.len();
        let anchor = contact.anchor.unwrap_or_default();
        let normal = check::normal(row, contact.normal)?;
        let depth = law.margins.clearance() - check::contact_number(row, "gap", contact.gap)?;
        check::contact_vector(row, "anchor velocity", anchor.velocity)?;
        check::contact_vector(row, "anchor acceleration", anchor.acceleration)?;
        check_weights(row, terms, if contact.anchor.is_some() { -1.0 } else { 0.0 })?;
        check_particles(row, terms, self.particle_count)?;
        number("contacts", row + 1)?;
        number("terms", self.terms.len() + terms.len())?;
        merge_onto(&mut self.terms, terms);
        self.starts.push(number("terms", self.terms.len())?);
        self.normals.push(normal);
        self.depths.push(depth);
        self.anchors.push(anchor);
        self.laws.push(law);
        Ok(())
    }
}

fn check_weights(contact: usize, terms: &[Term], expected: f64) -> Result<(), ResponseError> {
    for term in terms {
        check::contact_number(contact, "weight", term.weight)?;
    }
    let sum: f64 = terms.iter().map(|term| term.weight).sum();
    let scale: f64 = terms.iter().map(|term| term.weight.abs()).sum();
    if (sum - expected).abs() <= WEIGHT_TOLERANCE * scale.max(1.0) {
        Ok(())
    } else {
        Err(ResponseError::Weights { contact, sum, expected })
    }
}

fn check_particles(
    contact: usize,
    terms: &[Term],
    particle_count: usize,
) -> Result<(), ResponseError> {
    match terms.iter().find(|term| term.particle as usize >= particle_count) {
        None => Ok(()),
        Some(&Term { particle, .. }) => {
            Err(ResponseError::ParticleOutOfRange { contact, particle, particle_count })
        }
    }
}

/// A count as a 32-bit index.
fn number(what: &'static str, count: usize) -> Result<u32, ResponseError> {
    let limit = u32::MAX as usize - 1;
    match u32::try_from(count) {
        Ok(number) if count <= limit => Ok(number),
        _ => Err(ResponseError::TooMany { what, count, limit }),
    }
}
