//! Positions, then velocities, then accelerations, each where a threshold is
//! passed.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2, which finds the three
//! corrections in sequence the most robust in practice, and notes that
//! contacts must be detected anew once positions have changed.

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

/// What each correction tolerates, `>= 0`; `None` leaves that correction out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Thresholds {
    /// Depth \[length\]: left alone up to this.
    pub depth: Option<f64>,
    /// Speed of approach \[length / time\].
    pub approach: Option<f64>,
    /// Acceleration of approach \[length / time²\], where a contact is not
    /// leaving.
    pub push: Option<f64>,
}

/// How a sequence of corrections goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceParams {
    /// Distances kept and friction.
    pub law: ContactLaw,
    /// What each correction tolerates.
    pub thresholds: Thresholds,
    /// How contacts are solved together.
    pub solver: SolverParams,
    /// Which rows are solved first.
    pub order: SweepOrder,
    /// Corrections of positions at most, with contacts refreshed after each.
    pub max_rounds: u32,
}

/// How it went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceReport {
    /// Corrections of positions done.
    pub rounds: u32,
    /// Largest depth left, of the contacts as refreshed last.
    pub depth: f64,
    /// The last solution for positions, where one was needed.
    pub positions: Option<SolveReport>,
    /// The solution for velocities, where one was needed.
    pub velocities: Option<SolveReport>,
    /// The solution for accelerations, where one was needed.
    pub accelerations: Option<SolveReport>,
}

/// Corrects positions until no depth is above its threshold or the rounds run
/// out, then velocities, then accelerations.
///
/// `refresh` finds the contacts at new positions; its errors end the sequence.
/// `memory` holds the velocities' impulses from step to step.
///
/// ```
/// use glam::DVec3;
/// use response::{
///     ContactLaw, ImpulseCache, Margins, SweepOrder, ParticleStates, ResponseError, SequenceParams,
///     SolverParams, Thresholds, correct_in_sequence,
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
///     thresholds: Thresholds { depth: Some(0.0), approach: Some(0.0), push: Some(0.0) },
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
/// Those of [`ContactRows::push`] and [`ContactSystem::solve`], and those of
/// `refresh`. Corrections made before the error stay.
pub fn correct_in_sequence<E: From<ResponseError>>(
    particles: ParticleStates<'_>,
    contacts: &mut Vec<Contact>,
    mut refresh: impl FnMut(&[DVec3], &mut Vec<Contact>) -> Result<(), E>,
    params: &SequenceParams,
    memory: &mut ImpulseCache,
) -> Result<SequenceReport, E> {
    let ParticleStates { x, v, a, inverse_mass } = particles;
    check_lengths(x.len(), v, a, inverse_mass)?;
    check_thresholds(&params.thresholds)?;
    let (mut rounds, mut positions) = (0, None);
    while let Some(threshold) = params.thresholds.depth {
        if largest_depth(contacts, params) <= threshold || rounds == params.max_rounds {
            break;
        }
        positions = Some(correct_positions(x, inverse_mass, contacts, params)?);
        rounds += 1;
        refresh(x, contacts)?;
    }
    let velocities = correct_velocities(v, inverse_mass, contacts, params, memory)?;
    let accelerations = correct_accelerations(v, a, inverse_mass, contacts, params)?;
    let depth = largest_depth(contacts, params);
    Ok(SequenceReport { rounds, depth, positions, velocities, accelerations })
}

fn correct_positions(
    x: &mut [DVec3],
    inverse_mass: &[f64],
    contacts: &[Contact],
    params: &SequenceParams,
) -> Result<SolveReport, ResponseError> {
    let mut moved = vec![DVec3::ZERO; x.len()];
    // Velocities take off the slip; taken back here too, it would count twice.
    let params = &SequenceParams { law: params.law.without_friction(), ..*params };
    let (report, _) =
        solve(SolveLevel::Position, &mut moved, inverse_mass, contacts, params, None)?;
    x.iter_mut().zip(moved).for_each(|(x, moved)| *x += moved);
    Ok(report)
}

fn correct_velocities(
    v: &mut [DVec3],
    inverse_mass: &[f64],
    contacts: &[Contact],
    params: &SequenceParams,
    memory: &mut ImpulseCache,
) -> Result<Option<SolveReport>, ResponseError> {
    let Some(threshold) = params.thresholds.approach else { return Ok(None) };
    let approach = |contact: &Contact| approach(contact, params, v, |anchor| anchor.velocity);
    if !exceeds(contacts.iter().map(approach), threshold) {
        memory.remember(contacts, vec![Impulse::default(); contacts.len()])?;
        return Ok(None);
    }
    let start = memory.recall(contacts)?;
    let (report, impulses) =
        solve(SolveLevel::Velocity, v, inverse_mass, contacts, params, Some(start))?;
    memory.remember(contacts, impulses)?;
    Ok(Some(report))
}

fn correct_accelerations(
    v: &[DVec3],
    a: &mut [DVec3],
    inverse_mass: &[f64],
    contacts: &[Contact],
    params: &SequenceParams,
) -> Result<Option<SolveReport>, ResponseError> {
    let Some(threshold) = params.thresholds.push else { return Ok(None) };
    let leaving_at = params.thresholds.approach.unwrap_or(0.0);
    let stays = |contact: &Contact| {
        let anchor = contact.anchor.unwrap_or_default().velocity;
        (anchor + combine(contact, v)).dot(contact.normal) >= -leaving_at
    };
    let staying: Vec<Contact> = contacts.iter().filter(|c| stays(c)).copied().collect();
    let push = |contact: &Contact| approach(contact, params, a, |anchor| anchor.acceleration);
    if !exceeds(staying.iter().map(push), threshold) {
        return Ok(None);
    }
    let (report, _) = solve(SolveLevel::Acceleration, a, inverse_mass, &staying, params, None)?;
    Ok(Some(report))
}

fn solve(
    level: SolveLevel,
    q: &mut [DVec3],
    inverse_mass: &[f64],
    contacts: &[Contact],
    params: &SequenceParams,
    start: Option<Vec<Impulse>>,
) -> Result<(SolveReport, Vec<Impulse>), ResponseError> {
    let mut rows = ContactRows::new(q.len());
    rows.extend(contacts, params.law)?;
    let system = ContactSystem::new(&rows, inverse_mass, params.order)?;
    let mut impulses = start.unwrap_or_else(|| system.no_impulses());
    let report = system.solve(level, q, &mut impulses, &params.solver)?;
    Ok((report, impulses))
}

/// Largest depth over the distance kept; a depth that is not a number counts
/// as infinite, so that the solver is asked and names it.
fn largest_depth(contacts: &[Contact], params: &SequenceParams) -> f64 {
    let clearance = params.law.margins().clearance();
    let depths = contacts.iter().map(|contact| clearance - contact.gap);
    depths
        .fold(0.0, |largest, depth| if depth.is_nan() { f64::INFINITY } else { depth.max(largest) })
}

/// λ (Q_c · n) of a contact.
fn approach(
    contact: &Contact,
    params: &SequenceParams,
    q: &[DVec3],
    of: impl Fn(surface::Anchor) -> DVec3,
) -> f64 {
    let margins = params.law.margins();
    let depth = margins.clearance() - contact.gap;
    let factor = (1.0 + depth / margins.proximity()).clamp(0.0, 1.0);
    let given = contact.anchor.map_or(DVec3::ZERO, of);
    factor * (given + combine(contact, q)).dot(contact.normal)
}

/// Σ β q, not a number where a particle does not exist: the rows name it.
fn combine(contact: &Contact, q: &[DVec3]) -> DVec3 {
    contact.stencil.combine(|k| q.get(k as usize).copied().unwrap_or(DVec3::NAN))
}

/// Whether one is above the threshold, or not a number.
fn exceeds(mut values: impl Iterator<Item = f64>, threshold: f64) -> bool {
    values.any(|value| value.is_nan() || value > threshold)
}

fn check_lengths(
    expected: usize,
    v: &[DVec3],
    a: &[DVec3],
    inverse_mass: &[f64],
) -> Result<(), ResponseError> {
    check::count("velocities", expected, v.len())?;
    check::count("accelerations", expected, a.len())?;
    check::inverse_masses(expected, inverse_mass)
}

fn check_thresholds(thresholds: &Thresholds) -> Result<(), ResponseError> {
    let Thresholds { depth, approach, push } = *thresholds;
    let named =
        [("depth threshold", depth), ("approach threshold", approach), ("push threshold", push)];
    for (name, threshold) in named {
        check::not_negative(name, threshold.unwrap_or(0.0))?;
    }
    Ok(())
}
