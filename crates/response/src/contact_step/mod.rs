//! Contact step of a simulator: positions, then velocities, then forces, each where a
//! tolerance is exceeded.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2, which finds the three
//! corrections in sequence the most robust in practice, and notes that
//! contacts must be detected again once positions have changed.

mod params;
mod positions;
mod report;
mod row_solver;
mod step_cache;
mod swept;

use std::mem::take;

use glam::DVec3;
use surface::{Anchor, Contact};

pub use self::params::StepParams;
pub use self::report::{StepReport, SweptReport};
use self::row_solver::RowSolver;
use self::step_cache::StepCache;
use crate::contact_set::KnownContact;
use crate::followers::Represented;
use crate::{
    Combinations, ContactSet, Followers, Material, ResponseError, SolveLevel, SolveReport,
    StepLength, check,
};

/// States of all particles, in the caller's slices, to be corrected.
#[derive(Debug)]
pub struct ParticleStates<'a> {
    /// Positions.
    pub x: &'a mut [DVec3],
    /// Velocities.
    pub v: &'a mut [DVec3],
    /// Accelerations or forces of the next move, where the caller's integrator takes these.
    pub loads: ParticleLoads<'a>,
    /// Inverse masses, 0 where fixed.
    pub inverse_mass: &'a [f64],
}

/// Accelerations or forces of all particles.
#[derive(Debug)]
pub enum ParticleLoads<'a> {
    /// Neither: velocities have them.
    None,
    /// Accelerations.
    Accelerations(&'a mut [DVec3]),
    /// Forces. Those of fixed particles are not changed.
    Forces(&'a mut [DVec3]),
}

/// Contact step of a simulator, with the memory that it carries from step to step.
///
/// # Place in the step
///
/// The corrected velocities must be those that move the particles:
///
/// ```text
/// v ← v + h a        forces of the caller
/// contact step       positions, then velocities
/// x ← x + h v
/// ```
///
/// On a slope of angle α that friction holds, nothing moves then. Corrected *after* the move,
/// velocities are zero at the end of each step, but every move still has the tangential gain
/// g sin α h of that step: the particle creeps at that speed, 3.36 mm/s at 20° and 1 ms, and
/// ten times that at 10 ms. Correcting positions does not remove it, since these are pushed
/// along normals only.
///
/// An integrator that takes velocities and forces together (`v ← v + h a; x ← x + h v` in one
/// call) hands over both before that call, with [`StepParams::push_tolerance`]. The
/// [`ParticleLoads`] are then corrected such that v + h a is what the correction of these
/// velocities would give, with the bones' velocities at that time: the same order, before the
/// move.
///
/// # Hard and soft
///
/// Hard contacts are corrected in sequence, with thresholds: positions along normals, detected
/// anew after each round, velocities and loads with friction, which cancels the slip that it
/// can. Soft contacts ([`Material::spring`](crate::Material::spring)) are springs taken
/// implicitly in the same systems, stable at any stiffness: in the velocities, or in the loads
/// where velocities are not corrected.
///
/// # Example
///
/// ```
/// use glam::DVec3;
/// use response::{
///     ContactSet, ContactStep, Margins, Material, ParticleLoads, ParticleStates, ResponseError,
///     RigidMotion, StepLength, StepParams,
/// };
/// use surface::{Contact, ContactSide, Term};
///
/// let material = Material::hard(Margins::new(0.0, 0.1)?);
/// // One particle over the floor z = 0, which rises.
/// let detect = |x: &[DVec3], contacts: &mut ContactSet| -> Result<(), ResponseError> {
///     let particle = [Term { particle: 0, weight: 1.0 }];
///     let floor = ContactSide::at_rest(x[0].with_z(0.0));
///     let contact =
///         Contact::between(ContactSide::Particles(&particle), floor, DVec3::Z, x[0].z);
///     let motion = RigidMotion { velocity: DVec3::Z * 0.5, ..RigidMotion::default() };
///     contacts.add(0, &material, &motion, &[contact]);
///     Ok(())
/// };
/// let (mut x, mut v) = ([DVec3::Z * -0.2], [DVec3::Z * -1.0]);
/// let loads = ParticleLoads::None;
/// let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &[1.0] };
/// let params = StepParams::new(StepLength::new(0.01)?);
/// let report = ContactStep::default().correct(particles, &params, detect)?;
/// assert_eq!((x[0].z, v[0].z), (0.0, 0.5));
/// assert_eq!((report.depth_before, report.depth, report.impulse.z), (0.2, 0.0, 1.5));
/// # Ok::<(), ResponseError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ContactStep {
    contacts: ContactSet,
    velocity_cache: StepCache,
    load_cache: StepCache,
    solver: RowSolver,
    followers: Followers,
    combinations: Combinations,
    /// Per particle, true if it follows others.
    follows: Vec<bool>,
    /// Inverse masses with those of followers.
    lumped: Vec<f64>,
    /// Vertices that each contact stands for.
    represented: Vec<Represented>,
    /// Offset of each follower, at the positions as detected last.
    offsets: Vec<DVec3>,
    /// Offsets of particles that follow, summed per leader.
    offset_sums: Vec<DVec3>,
    /// Displacements, or velocities before a correction.
    displacements: Vec<DVec3>,
    /// Velocities after the move.
    next: Vec<DVec3>,
    /// Velocities before the contacts of the step.
    start: Vec<DVec3>,
    /// Contacts that the last correction of positions has pushed apart.
    pushed: ContactSet,
    /// Primitives and normals of the contacts as detected last.
    normals: Vec<KnownContact>,
    /// Number of the contacts as detected last.
    detected: usize,
    swept: ContactSet,
    /// Primitives and normals of the swept contacts that are added.
    known: Vec<KnownContact>,
}

impl ContactStep {
    /// Corrects positions until no depth exceeds its tolerance or the rounds run
    /// out, then velocities, then accelerations or forces.
    ///
    /// `detect` adds the contacts at given positions to an empty set; its errors end the step.
    /// Nothing is allocated after the first steps, as long as contacts become no more, but for
    /// rows that are swept in parallel.
    ///
    /// # Errors
    ///
    /// Those of [`StepParams::validate`], [`Material::validate`](crate::Material::validate),
    /// [`ContactRows::push`], [`ContactSystem::solve`] and `detect`. Corrections made before
    /// the error stay.
    ///
    /// [`ContactRows::push`]: crate::ContactRows::push
    /// [`ContactSystem::solve`]: crate::ContactSystem::solve
    pub fn correct<E: From<ResponseError>>(
        &mut self,
        particles: ParticleStates<'_>,
        params: &StepParams,
        mut detect: impl FnMut(&[DVec3], &mut ContactSet) -> Result<(), E>,
    ) -> Result<StepReport, E> {
        let ParticleStates { x, v, loads, inverse_mass } = particles;
        check::particles("position", x.len(), x)?;
        check::particles("velocity", x.len(), v)?;
        check::inverse_masses(x.len(), inverse_mass)?;
        params.validate()?;
        self.followers.check(x.len())?;
        self.combinations.check(inverse_mass)?;
        self.combinations.apply(x);
        self.combinations.apply(v);

        // Positions, with contacts detected again after each round.
        let mut report = StepReport::default();
        self.detect(x, inverse_mass, &mut detect)?;
        report.depth_before = self.largest_depth();
        while let Some(tolerance) = params.depth_tolerance {
            if self.largest_depth() <= tolerance || report.rounds == params.max_rounds {
                break;
            }
            if report.rounds > 0 {
                self.hold_pushed(x, inverse_mass);
            }
            self.correct_positions(x, inverse_mass, params, &mut report)?;
            self.remember_pushed(tolerance);
            self.detect(x, inverse_mass, &mut detect)?;
        }
        report.contacts = self.contacts.contacts().len();
        report.depth = self.largest_depth();
        report.contact_energy = self.contact_energy();

        // Velocities and accelerations at the corrected positions.
        self.correct_velocities(v, inverse_mass, params, &mut report)?;
        self.correct_loads(v, loads, inverse_mass, params, &mut report)?;
        Ok(report)
    }

    /// Sets the particles that follow others: those that the detector's surfaces have left
    /// out. Contacts act on the masses of both.
    pub fn set_followers(&mut self, followers: Followers) {
        self.followers = followers;
    }

    /// Sets the particles that are combinations of others: centers of fanned polygons. Each step
    /// computes their positions and velocities.
    pub fn set_combinations(&mut self, combinations: Combinations) {
        self.combinations = combinations;
    }

    /// Returns the contacts as detected last.
    #[must_use]
    pub fn contacts(&self) -> &ContactSet {
        &self.contacts
    }

    fn detect<E: From<ResponseError>>(
        &mut self,
        x: &[DVec3],
        inverse_mass: &[f64],
        detect: &mut impl FnMut(&[DVec3], &mut ContactSet) -> Result<(), E>,
    ) -> Result<(), E> {
        self.contacts.clear();
        detect(x, &mut self.contacts)?;
        self.detected = self.contacts.contacts().len();
        self.solver.check(x.len(), &self.contacts, &self.combinations)?;
        self.followers.compute_offsets(x, &mut self.offsets);
        self.weigh(inverse_mass);
        Ok(())
    }

    /// Computes the masses of particles with those that follow them, and the vertices that contacts
    /// stand for.
    fn weigh(&mut self, inverse_mass: &[f64]) {
        let Self { followers, contacts, follows, lumped, offsets, offset_sums, .. } = self;
        followers.mark(inverse_mass, contacts, follows);
        followers.lump(inverse_mass, follows, lumped);
        followers.sum_offsets(inverse_mass, follows, offsets, offset_sums);
        self.represented.clear();
        for contact in contacts.contacts() {
            self.represented.push(Represented::of(contact, inverse_mass, lumped, offset_sums));
        }
    }

    fn correct_velocities(
        &mut self,
        v: &mut [DVec3],
        inverse_mass: &[f64],
        params: &StepParams,
        report: &mut StepReport,
    ) -> Result<(), ResponseError> {
        report.approach_before = largest_approach(&self.contacts, v, params.h);
        report.approach = report.approach_before;
        self.start.clear();
        self.start.extend_from_slice(v);
        let Some(tolerance) = params.approach_tolerance else { return Ok(()) };
        let has_soft = self.contacts.groups().iter().any(|group| !group.material.is_hard());
        if report.approach <= tolerance && !has_soft {
            self.velocity_cache.clear();
            return Ok(());
        }
        self.solve_velocities(v, inverse_mass, params, report)
    }

    /// Solves for velocities, from those before contacts and the impulses that are cached.
    fn solve_velocities(
        &mut self,
        v: &mut [DVec3],
        inverse_mass: &[f64],
        params: &StepParams,
        report: &mut StepReport,
    ) -> Result<(), ResponseError> {
        let (mut cache, start) = (take(&mut self.velocity_cache), take(&mut self.start));
        v.copy_from_slice(&start);
        let solved = self.solve(&start, v, params, &mut cache, |contact, _| Some(*contact));
        (self.velocity_cache, self.start) = (cache, start);
        report.velocities = Some(solved?);

        // Momentum and energy that the correction has given.
        report.approach = largest_approach(&self.contacts, v, params.h);
        report.rigid_work = self.solver.prescribed_work(v, inverse_mass);
        (report.impulse, report.kinetic_energy) = (DVec3::ZERO, 0.0);
        for ((v, before), w) in v.iter().zip(&self.start).zip(inverse_mass) {
            if *w > 0.0 {
                report.impulse += (*v - *before) / *w;
                report.kinetic_energy += 0.5 * (*v - *before).dot(*v + *before) / *w;
            }
        }
        Ok(())
    }

    fn correct_loads(
        &mut self,
        v: &[DVec3],
        loads: ParticleLoads<'_>,
        inverse_mass: &[f64],
        params: &StepParams,
        report: &mut StepReport,
    ) -> Result<(), ResponseError> {
        // Velocities after the move.
        let Some(tolerance) = params.push_tolerance else { return Ok(()) };
        let h = params.h.get();
        self.next.clear();
        match &loads {
            ParticleLoads::None => return Ok(()),
            ParticleLoads::Accelerations(a) => {
                check::particles("acceleration", v.len(), a)?;
                self.next.extend(v.iter().zip(&**a).map(|(v, a)| *v + h * *a));
            }
            ParticleLoads::Forces(force) => {
                check::particles("force", v.len(), force)?;
                let gains = force.iter().zip(inverse_mass).map(|(force, w)| h * *w * *force);
                self.next.extend(v.iter().zip(gains).map(|(v, gain)| *v + gain));
            }
        }

        self.combinations.apply(&mut self.next);

        // Bones have their velocity at that time, too. Soft contacts act once.
        let has_soft = params.approach_tolerance.is_none()
            && self.contacts.groups().iter().any(|group| !group.material.is_hard());
        let largest = largest_approach_at(&self.contacts, &self.next, params.h, |contact| {
            advanced(contact, h)
        });
        let tolerated = params.approach_tolerance.unwrap_or(0.0) + tolerance * h;
        if largest <= tolerated && !has_soft {
            self.load_cache.clear();
            return Ok(());
        }

        // The change of these velocities belongs to one of the loads.
        let (mut cache, mut next) = (take(&mut self.load_cache), take(&mut self.next));
        let mut changes = take(&mut self.displacements);
        changes.clear();
        changes.extend_from_slice(&next);
        let solved = self.solve(&changes, &mut next, params, &mut cache, |contact, material| {
            (material.is_hard() || has_soft).then(|| advanced(contact, h))
        });
        for (change, next) in changes.iter_mut().zip(&next) {
            *change = (*next - *change) / h;
        }
        (self.load_cache, self.next, self.displacements) = (cache, next, changes);
        report.loads = Some(solved?);
        report.force = add_to_loads(loads, &self.displacements, inverse_mass);
        Ok(())
    }

    /// Corrects velocities `v`, which are `before` still, by the contacts in the states that `state`
    /// returns, `None` for those that do not act; from the impulses that are cached, which are
    /// replaced by these.
    fn solve(
        &mut self,
        before: &[DVec3],
        v: &mut [DVec3],
        params: &StepParams,
        cache: &mut StepCache,
        state: impl Fn(&Contact, &Material) -> Option<Contact>,
    ) -> Result<SolveReport, ResponseError> {
        let Self { contacts, combinations, solver, represented, .. } = self;
        cache.warm_start(contacts, params.h, &mut solver.impulses);
        solver.set_rows(v.len(), contacts, combinations, |number, contact, material| {
            let (soft, law) = represented[number].of_soft(contact, material);
            let row = law.velocity_row(&soft, params.h)?;
            Ok(state(contact, material).map(|contact| (contact, row)))
        })?;
        let report = solver.solve(SolveLevel::Velocity, v, &self.lumped, params)?;

        self.followers.follow(&self.follows, before, v);
        self.combinations.apply(v);
        cache.store(contacts, params.h, &solver.impulses)?;
        Ok(report)
    }

    /// Computes the largest depth of hard contacts.
    fn largest_depth(&self) -> f64 {
        let depths = self.contacts.iter().map(|(contact, material)| material.hard_depth(contact));
        depths.fold(0.0, f64::max)
    }

    fn contact_energy(&self) -> f64 {
        let mut energy = 0.0;
        for ((contact, material), represented) in self.contacts.iter().zip(&self.represented) {
            let (contact, material) = represented.of_soft(contact, material);
            let Some(spring) = material.spring else { continue };
            let depth = material.depth(&contact);
            if depth > 0.0 || material.permanent.is_some() {
                energy += 0.5 * spring.stiffness() * depth * depth;
            }
        }
        energy
    }
}

/// Adds accelerations to loads; returns the force of all that can move.
fn add_to_loads(loads: ParticleLoads<'_>, changes: &[DVec3], inverse_mass: &[f64]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (change, w) in changes.iter().zip(inverse_mass).filter(|(_, w)| **w > 0.0) {
        sum += *change / *w;
    }

    // In the unit of the caller's list.
    match loads {
        ParticleLoads::None => {}
        ParticleLoads::Accelerations(a) => {
            for (a, change) in a.iter_mut().zip(changes) {
                *a += *change;
            }
        }
        ParticleLoads::Forces(force) => {
            for ((force, change), w) in force.iter_mut().zip(changes).zip(inverse_mass) {
                if *w > 0.0 {
                    *force += *change / *w;
                }
            }
        }
    }
    sum
}

/// Computes the largest speed that hard contacts forbid.
fn largest_approach(contacts: &ContactSet, v: &[DVec3], h: StepLength) -> f64 {
    largest_approach_at(contacts, v, h, |contact| *contact)
}

/// As [`largest_approach`], for contacts in another state.
fn largest_approach_at(
    contacts: &ContactSet,
    v: &[DVec3],
    h: StepLength,
    state: impl Fn(&Contact) -> Contact,
) -> f64 {
    let mut largest = 0.0_f64;
    for (contact, material) in contacts.iter().filter(|(_, material)| material.is_hard()) {
        let contact = state(contact);
        let velocity = relative_velocity(&contact, v);
        largest = largest.max(material.forbidden_speed(&contact, velocity, h));
    }
    largest
}

/// Computes V_c of a contact.
fn relative_velocity(contact: &Contact, v: &[DVec3]) -> DVec3 {
    let of_anchor = contact.anchor.unwrap_or_default().velocity;
    of_anchor + contact.stencil.combine(|k| v[k as usize])
}

/// Returns the contact with its anchor's velocity after `h`.
fn advanced(contact: &Contact, h: f64) -> Contact {
    let later =
        |anchor: Anchor| Anchor { velocity: anchor.velocity + h * anchor.acceleration, ..anchor };
    Contact { anchor: contact.anchor.map(later), ..*contact }
}
