//! Sequential correction: positions, then velocities, then accelerations, each where a
//! tolerance is exceeded.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2, which finds the three
//! corrections in sequence the most robust in practice, and notes that
//! contacts must be detected again once positions have changed.

use glam::DVec3;
use surface::Contact;

use crate::{
    ContactLaw, ContactRows, ContactSystem, Impulse, ImpulseCache, ResponseError, SolveLevel,
    SolveReport, SolverParams, SweepOrder, check,
};

/// States of all particles, to be corrected.
#[derive(Debug)]
pub struct ParticleStates<'a> {
    /// Positions.
    pub x: &'a mut [DVec3],
    /// Velocities.
    pub v: &'a mut [DVec3],
    /// Accelerations.
    pub a: &'a mut [DVec3],
    /// Inverse masses, 0 where fixed.
    pub inverse_mass: &'a [f64],
}

/// Settings of a sequence of corrections. A tolerance of `None` leaves its correction out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SequenceParams {
    /// Distances kept and friction.
    pub law: ContactLaw,
    /// Depth \[length\] up to which positions are not corrected, `>= 0`.
    pub depth_tolerance: Option<f64>,
    /// Speed of approach \[length / time\] up to which velocities are not corrected,
    /// `>= 0`.
    pub approach_tolerance: Option<f64>,
    /// Acceleration of approach \[length / time²\] up to which accelerations of contacts
    /// that do not separate are not corrected, `>= 0`.
    pub push_tolerance: Option<f64>,
    /// Settings of the solver.
    pub solver: SolverParams,
    /// Order of the rows in a sweep.
    pub order: SweepOrder,
    /// Maximum number of corrections of positions, with contacts refreshed after each.
    pub max_rounds: u32,
}

impl SequenceParams {
    /// Checks that no tolerance is negative or not finite.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] with the first such tolerance.
    pub fn validate(&self) -> Result<(), ResponseError> {
        check::not_negative("depth tolerance", self.depth_tolerance.unwrap_or(0.0))?;
        check::not_negative("approach tolerance", self.approach_tolerance.unwrap_or(0.0))?;
        check::not_negative("push tolerance", self.push_tolerance.unwrap_or(0.0))?;
        check::not_negative("tolerance", self.solver.tolerance)?;
        Ok(())
    }
}

/// Report of a sequence of corrections.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SequenceReport {
    /// Number of corrections of positions.
    pub rounds: u32,
    /// Largest depth of the contacts as refreshed last.
    pub depth: f64,
    /// Last solution for positions, where one was needed.
    pub positions: Option<SolveReport>,
    /// Solution for velocities, where one was needed.
    pub velocities: Option<SolveReport>,
    /// Solution for accelerations, where one was needed.
    pub accelerations: Option<SolveReport>,
}

/// Corrects positions until no depth exceeds its tolerance or the rounds run
/// out, then velocities, then accelerations.
///
/// `refresh` detects the contacts at new positions; its errors end the sequence.
/// `cache` holds the velocities' impulses from step to step.
///
/// ```
/// use glam::DVec3;
/// use response::{
///     ContactLaw, ImpulseCache, Margins, ParticleStates, ResponseError, SequenceParams,
///     SolverParams, SweepOrder, correct_in_sequence,
/// };
/// use surface::{Anchor, Contact, Stencil, Term};
///
/// /// One particle over the floor z = 0.
/// fn detect(x: &[DVec3], contacts: &mut Vec<Contact>) -> Result<(), ResponseError> {
///     contacts.clear();
///     contacts.push(Contact {
///         stencil: Stencil::single(Term { particle: 0, weight: -1.0 }),
///         anchor: Some(Anchor { point: x[0].with_z(0.0), ..Anchor::default() }),
///         normal: DVec3::Z, offset: 0.0, gap: x[0].z, time: None,
///     });
///     Ok(())
/// }
/// let params = SequenceParams {
///     law: ContactLaw::new(Margins::new(0.0, 0.1)?, 0.0)?,
///     depth_tolerance: Some(0.0), approach_tolerance: Some(0.0), push_tolerance: Some(0.0),
///     solver: SolverParams::default(), order: SweepOrder::Colored, max_rounds: 4,
/// };
/// let (mut x, mut v, mut a) = ([DVec3::Z * -0.2], [DVec3::Z * -1.0], [DVec3::Z * -9.81]);
/// let particles = ParticleStates { x: &mut x, v: &mut v, a: &mut a, inverse_mass: &[1.0] };
/// let mut contacts = Vec::new();
/// detect(particles.x, &mut contacts)?;
/// correct_in_sequence(particles, &mut contacts, detect, &params, &mut ImpulseCache::default())?;
/// assert_eq!((x[0].z, v[0].z, a[0].z), (0.0, 0.0, 0.0));
/// # Ok::<(), ResponseError>(())
/// ```
///
/// # Errors
///
/// Those of [`SequenceParams::validate`], [`ContactRows::push`],
/// [`ContactSystem::solve`] and `refresh`. Corrections made before the error stay.
pub fn correct_in_sequence<E: From<ResponseError>>(
    particles: ParticleStates<'_>,
    contacts: &mut Vec<Contact>,
    mut refresh: impl FnMut(&[DVec3], &mut Vec<Contact>) -> Result<(), E>,
    params: &SequenceParams,
    cache: &mut ImpulseCache,
) -> Result<SequenceReport, E> {
    let ParticleStates { x, v, a, inverse_mass } = particles;
    check::count("velocities", x.len(), v.len())?;
    check::count("accelerations", x.len(), a.len())?;
    check::inverse_masses(x.len(), inverse_mass)?;
    params.validate()?;
    let sequence = Sequence { params, inverse_mass };

    // Positions, with contacts detected again after each round.
    let (mut rounds, mut positions) = (0, None);
    while let Some(tolerance) = params.depth_tolerance {
        if sequence.largest_depth(contacts) <= tolerance || rounds == params.max_rounds {
            break;
        }
        positions = Some(sequence.correct_positions(x, contacts)?);
        rounds += 1;
        refresh(x, contacts)?;
    }

    // Velocities and accelerations at the corrected positions.
    let velocities = sequence.correct_velocities(v, contacts, cache)?;
    let accelerations = sequence.correct_accelerations(v, a, contacts)?;
    let depth = sequence.largest_depth(contacts);
    Ok(SequenceReport { rounds, depth, positions, velocities, accelerations })
}

/// Settings and masses that all corrections of a sequence share.
struct Sequence<'a> {
    params: &'a SequenceParams,
    inverse_mass: &'a [f64],
}

impl Sequence<'_> {
    fn correct_positions(
        &self,
        x: &mut [DVec3],
        contacts: &[Contact],
    ) -> Result<SolveReport, ResponseError> {
        // Velocities take off the slip; taken back here too, it would count twice.
        let system = self.system(contacts, self.params.law.without_friction())?;
        let mut moved = vec![DVec3::ZERO; x.len()];
        let impulses = &mut system.no_impulses();
        let report =
            system.solve(SolveLevel::Position, &mut moved, impulses, &self.params.solver)?;
        for (x, moved) in x.iter_mut().zip(moved) {
            *x += moved;
        }
        Ok(report)
    }

    fn correct_velocities(
        &self,
        v: &mut [DVec3],
        contacts: &[Contact],
        cache: &mut ImpulseCache,
    ) -> Result<Option<SolveReport>, ResponseError> {
        let Some(tolerance) = self.params.approach_tolerance else { return Ok(None) };
        let approach =
            |c: &Contact| self.approach(c, c.anchor.unwrap_or_default().velocity + combine(c, v));
        if !exceeds(contacts.iter().map(approach), tolerance) {
            cache.store(contacts, vec![Impulse::default(); contacts.len()])?;
            return Ok(None);
        }

        // From the impulses of the last step, which are replaced by these.
        let system = self.system(contacts, self.params.law)?;
        let mut impulses = cache.warm_start(contacts);
        let report = system.solve(SolveLevel::Velocity, v, &mut impulses, &self.params.solver)?;
        cache.store(contacts, impulses)?;
        Ok(Some(report))
    }

    fn correct_accelerations(
        &self,
        v: &[DVec3],
        a: &mut [DVec3],
        contacts: &[Contact],
    ) -> Result<Option<SolveReport>, ResponseError> {
        let Some(tolerance) = self.params.push_tolerance else { return Ok(None) };

        // Contacts that separate need no support.
        let separating = self.params.approach_tolerance.unwrap_or(0.0);
        let mut staying = contacts.to_vec();
        staying.retain(|c| {
            let velocity = c.anchor.unwrap_or_default().velocity + combine(c, v);
            velocity.dot(c.normal) >= -separating
        });

        // The rest is supported where one is pushed.
        let push = |c: &Contact| {
            self.approach(c, c.anchor.unwrap_or_default().acceleration + combine(c, a))
        };
        if !exceeds(staying.iter().map(push), tolerance) {
            return Ok(None);
        }

        let system = self.system(&staying, self.params.law)?;
        let impulses = &mut system.no_impulses();
        Ok(Some(system.solve(SolveLevel::Acceleration, a, impulses, &self.params.solver)?))
    }

    fn system(
        &self,
        contacts: &[Contact],
        law: ContactLaw,
    ) -> Result<ContactSystem, ResponseError> {
        let mut rows = ContactRows::new(self.inverse_mass.len());
        rows.extend(contacts, law)?;
        ContactSystem::new(&rows, self.inverse_mass, self.params.order)
    }

    /// Computes the largest depth over the distance kept; a depth that is not a number
    /// counts as infinite, so that the solver runs and names it.
    fn largest_depth(&self, contacts: &[Contact]) -> f64 {
        let clearance = self.params.law.margins().clearance();
        let mut largest = 0.0_f64;
        for contact in contacts {
            let depth = clearance - contact.gap;
            largest = if depth.is_nan() { f64::INFINITY } else { depth.max(largest) };
        }
        largest
    }

    /// Computes λ (Q_c · n) of a contact.
    fn approach(&self, contact: &Contact, relative: DVec3) -> f64 {
        let margins = self.params.law.margins();
        let factor = margins.proximity_factor(margins.clearance() - contact.gap);
        factor * relative.dot(contact.normal)
    }
}

/// Computes Σ β q; not a number where a particle does not exist, so that the rows name it.
fn combine(contact: &Contact, q: &[DVec3]) -> DVec3 {
    contact.stencil.combine(|k| q.get(k as usize).copied().unwrap_or(DVec3::NAN))
}

/// Returns true if one value exceeds the tolerance or is not a number.
fn exceeds(mut values: impl Iterator<Item = f64>, tolerance: f64) -> bool {
    values.any(|value| value.is_nan() || value > tolerance)
}
