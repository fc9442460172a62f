//! Relaxation of an elastic problem: block Gauss–Seidel, one vertex at a time with all its rows.
//!
//! Bodies without a row or a bond in common do not change each other. Each body has a level, above those of
//! all bodies before it that it has one in common with. The bodies of a level are relaxed side by
//! side, level by level up or down ([`super::turns`]): to the bit as one body after the other.

use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::{DMat3, DVec3};

use crate::elastic::{Bond, ElasticProblem, GapRow, VolumeRow};
use crate::shared_number::SharedNumber;
use crate::turns::Turns;

/// Part of an accuracy that rows may be missing from a solution: a quarter, so that what is solved for is left
/// where all that is computed from it is rounded.
pub(crate) const SOLVED_SHARE: f64 = 0.25;

/// Sweeps of the elastic solver in a step that others follow. Below, displacements are rough, and more
/// steps are needed; above, steps take longer.
pub(crate) const STEP_SWEEPS: usize = 20;

/// Smallest number of sweeps, in which displacements spread over that many edges.
const MIN_SWEEPS: usize = 8;

/// Number of particles below which all bodies are relaxed on one thread: to wake others takes longer.
const MIN_SHARED_PARTICLES: usize = 1000;

impl ElasticProblem {
    /// Computes the steps of all particles from their displacements `u` to those of least energy;
    /// 0 for those that are not active.
    ///
    /// Ends after `max_sweeps`, or when no row is missing more than `tolerance`. The `penalty` is the
    /// stiffness of each row's augmented term, relative to what it moves.
    pub(crate) fn minimize(
        self,
        u: &[DVec3],
        max_sweeps: usize,
        tolerance: f64,
        penalty: f64,
    ) -> Vec<DVec3> {
        let relaxation = Relaxation::new(self, u, penalty);
        let run = |body: usize, is_forward| relaxation.sweep_body(body, is_forward);
        let sweep_all = || {
            // Multipliers follow the rows after every sweep: inexact, but each sweep counts.
            for sweep in 1..=max_sweeps {
                relaxation.turns.sweep(&run);
                let most_missing = relaxation.update_multipliers();
                if sweep >= MIN_SWEEPS && most_missing <= tolerance {
                    break;
                }
            }
        };
        if relaxation.is_worth_sharing() {
            relaxation.turns.share(&run, sweep_all);
        } else {
            sweep_all();
        }
        relaxation.steps_from(u)
    }
}

/// Occurrence of a particle in a row or a bond.
#[derive(Clone, Copy, Debug, Default)]
struct Occurrence {
    number: u32,
    weight: f64,
}

/// Marks particles that are not active.
const INACTIVE: u32 = u32::MAX;

/// Problem with its particles numbered without gaps, and the state of its solution.
struct Relaxation {
    particles: Vec<RelaxedParticle>,
    /// Links to active particles of the same body, by their numbers.
    links: Vec<(u32, f64)>,
    rows: Vec<GapRow>,
    /// Force of each row that its multiplier adds.
    multipliers: Vec<SharedNumber>,
    /// Opening of each row by the present displacements.
    openings: Vec<SharedNumber>,
    in_rows: Vec<Occurrence>,
    bonds: Vec<RelaxedBond>,
    in_bonds: Vec<Occurrence>,
    bodies: Vec<Mutex<RelaxedBody>>,
    turns: Turns,
}

/// Body with the displacements of its active particles, which are numbered from `first` on.
struct RelaxedBody {
    first: usize,
    u: Vec<DVec3>,
    volume: VolumeRow,
}

/// Active particle with the ends of its parts of all lists, which begin where those of the particle
/// before end.
#[derive(Clone, Copy, Debug, Default)]
struct RelaxedParticle {
    particle: u32,
    body: usize,
    area: DVec3,
    /// Force of links to particles that are not active.
    pull: DVec3,
    /// Stiffness of links and foundation, and that of bonds too.
    own: f64,
    diagonal: f64,
    links_end: usize,
    rows_end: usize,
    bonds_end: usize,
}

/// Stiffness of a bond, and its stretch at the present displacements.
struct RelaxedBond {
    stiffness: f64,
    stretch: [SharedNumber; 3],
}

impl RelaxedBond {
    fn stretch(&self) -> DVec3 {
        DVec3::from(self.stretch.each_ref().map(SharedNumber::get))
    }

    fn add_stretch(&self, change: DVec3) {
        for (component, change) in self.stretch.iter().zip(change.to_array()) {
            component.add(change);
        }
    }
}

impl Relaxation {
    fn new(problem: ElasticProblem, u: &[DVec3], penalty: f64) -> Self {
        let ElasticProblem { particles: active, mut rows, bonds, volumes } = problem;
        let mut numbers = vec![INACTIVE; u.len()];
        for (number, active) in (0..).zip(&active) {
            numbers[active.particle as usize] = number;
        }

        // Links between active particles; all others pull with a constant force.
        let mut particles = Vec::with_capacity(active.len());
        let mut links = Vec::new();
        for active in &active {
            let mut particle = RelaxedParticle {
                particle: active.particle,
                body: active.body,
                area: active.area,
                own: active.foundation,
                ..RelaxedParticle::default()
            };
            for &(next, stiffness) in &active.links {
                particle.own += stiffness;
                match numbers[next as usize] {
                    INACTIVE => particle.pull += stiffness * u[next as usize],
                    number => links.push((number, stiffness)),
                }
            }
            particle.diagonal = particle.own;
            particle.links_end = links.len();
            particles.push(particle);
        }

        // Particles that are not active do not change an opening.
        for row in &mut rows {
            row.keep_active(|particle| numbers[particle as usize] != INACTIVE, u);
        }
        let in_rows = occurrences(rows.iter().map(|row| &row.terms), &numbers, active.len());
        let in_bonds = occurrences(bonds.iter().map(|bond| &bond.terms), &numbers, active.len());
        let mut relaxed = Vec::with_capacity(bonds.len());
        for Bond { terms, stiffness } in &bonds {
            let mut stretch = DVec3::ZERO;
            for &(particle, weight) in terms {
                stretch += weight * u[particle as usize];
            }
            let bond = RelaxedBond { stiffness: *stiffness, stretch: Default::default() };
            bond.add_stretch(stretch);
            relaxed.push(bond);
        }
        for (i, particle) in particles.iter_mut().enumerate() {
            (particle.rows_end, particle.bonds_end) = (in_rows.ends[i], in_bonds.ends[i]);
            for bond in in_bonds.of(i) {
                let stiffness = relaxed[bond.number as usize].stiffness;
                particle.diagonal += stiffness * bond.weight * bond.weight;
            }
        }
        let terms = rows.iter().map(|row| &row.terms).chain(bonds.iter().map(|bond| &bond.terms));
        let levels = levels(terms, &numbers, &particles, volumes.len());
        let (bodies, levels) = relaxed_bodies(&particles, u, &volumes, &levels);
        let turns = Turns::new(&levels);
        let mut relaxation = Self {
            bodies,
            turns,
            particles,
            links,
            openings: rows.iter().map(|_| SharedNumber::default()).collect(),
            multipliers: rows.iter().map(|_| SharedNumber::default()).collect(),
            rows,
            in_rows: in_rows.all,
            bonds: relaxed,
            in_bonds: in_bonds.all,
        };
        relaxation.set_penalties(&numbers, penalty);
        relaxation
    }

    /// Returns the steps of all particles from their displacements `u` to the present ones.
    fn steps_from(&self, u: &[DVec3]) -> Vec<DVec3> {
        let mut steps = vec![DVec3::ZERO; u.len()];
        for body in &self.bodies {
            let body = lock(body);
            for (active, displaced) in self.particles[body.first..].iter().zip(&body.u) {
                steps[active.particle as usize] = *displaced - u[active.particle as usize];
            }
        }
        steps
    }

    /// Relaxes the particles of a body once.
    fn sweep_body(&self, body: usize, is_forward: bool) {
        let body = &mut *lock(&self.bodies[body]);
        let count = body.u.len();
        for step in 0..count {
            self.relax(body, if is_forward { step } else { count - 1 - step });
        }
    }

    /// Returns true if there is enough to do for several threads.
    fn is_worth_sharing(&self) -> bool {
        self.bodies.len() > 1 && self.particles.len() >= MIN_SHARED_PARTICLES
    }

    /// Sets the stiffness of each row's augmented term in proportion to what it moves.
    fn set_penalties(&mut self, numbers: &[u32], penalty: f64) {
        for row in &mut self.rows {
            let mut compliance = 0.0;
            for &(particle, weight) in &row.terms {
                let stiffness = self.particles[numbers[particle as usize] as usize].diagonal;
                if stiffness > 0.0 {
                    compliance += weight * weight / stiffness;
                }
            }
            row.penalty = if compliance > 0.0 { penalty / compliance } else { 0.0 };
        }

        for body in &self.bodies {
            let mut body = lock(body);
            let mut compliance = 0.0;
            for active in &self.particles[body.first..body.first + body.u.len()] {
                if active.diagonal > 0.0 {
                    compliance += active.area.length_squared() / active.diagonal;
                }
            }
            body.volume.penalty = if compliance > 0.0 { compliance.recip() } else { 0.0 };
        }
    }

    /// Moves one particle of a body to where the energy is least while all others rest.
    fn relax(&self, body: &mut RelaxedBody, own: usize) {
        let i = body.first + own;
        let active = self.particles[i];
        let before = if i == 0 { RelaxedParticle::default() } else { self.particles[i - 1] };
        if active.diagonal <= 0.0 {
            return;
        }

        // Elastic forces.
        let mut force = active.pull - active.own * body.u[own];
        for &(next, stiffness) in &self.links[before.links_end..active.links_end] {
            force += stiffness * body.u[next as usize - body.first];
        }
        let bonds = before.bonds_end..active.bonds_end;
        for occurrence in &self.in_bonds[bonds.clone()] {
            let bond = &self.bonds[occurrence.number as usize];
            force -= bond.stiffness * occurrence.weight * bond.stretch();
        }

        // The volume, then rows in force.
        force += body.volume.force() * active.area;
        let mut hessian = DMat3::from_diagonal(DVec3::splat(active.diagonal));
        hessian += outer(active.area, body.volume.penalty);
        let rows = before.rows_end..active.rows_end;
        for occurrence in &self.in_rows[rows.clone()] {
            let number = occurrence.number as usize;
            let row = &self.rows[number];
            let push = row.force(self.multipliers[number].get(), self.openings[number].get());
            if push > 0.0 {
                force += push * occurrence.weight * row.normal;
                hessian += outer(row.normal, row.penalty * occurrence.weight * occurrence.weight);
            }
        }

        // All that depends on the particle follows it.
        let step = hessian.inverse() * force;
        body.u[own] += step;
        body.volume.gained += active.area.dot(step);
        for occurrence in &self.in_bonds[bonds] {
            self.bonds[occurrence.number as usize].add_stretch(occurrence.weight * step);
        }
        for occurrence in &self.in_rows[rows] {
            let row = &self.rows[occurrence.number as usize];
            let opening = occurrence.weight * row.normal.dot(step);
            self.openings[occurrence.number as usize].add(opening);
        }
    }

    /// Adds what rows and volumes are missing to their forces; returns the largest part of a gap
    /// that is missing.
    fn update_multipliers(&self) -> f64 {
        let mut most: f64 = 0.0;
        for ((row, multiplier), opening) in
            self.rows.iter().zip(&self.multipliers).zip(&self.openings)
        {
            multiplier.set(row.force(multiplier.get(), opening.get()));
            if row.penalty > 0.0 {
                most = most.max(row.missing - opening.get());
            }
        }
        for body in &self.bodies {
            let volume = &mut lock(body).volume;
            volume.multiplier = volume.force();
        }
        most
    }
}

/// Computes the level of each body: 0, or one more than the highest of the bodies before it that it has a
/// row or a bond in common with. Each has terms of two bodies at most.
fn levels<'t>(
    terms: impl Iterator<Item = &'t Vec<(u32, f64)>>,
    numbers: &[u32],
    particles: &[RelaxedParticle],
    count: usize,
) -> Vec<usize> {
    let mut meets = vec![false; count * count];
    for terms in terms {
        let (mut lowest, mut highest) = (count, 0);
        for &(particle, _) in terms {
            let number = numbers[particle as usize];
            if number != INACTIVE {
                let body = particles[number as usize].body;
                (lowest, highest) = (lowest.min(body), highest.max(body));
            }
        }
        if lowest < highest {
            meets[highest * count + lowest] = true;
        }
    }

    let mut levels = vec![0; count];
    for body in 0..count {
        for before in 0..body {
            if meets[body * count + before] {
                levels[body] = levels[body].max(levels[before] + 1);
            }
        }
    }
    levels
}

/// Lists the bodies that have particles, displaced by `u`, with their levels.
fn relaxed_bodies(
    particles: &[RelaxedParticle],
    u: &[DVec3],
    volumes: &[VolumeRow],
    levels: &[usize],
) -> (Vec<Mutex<RelaxedBody>>, Vec<usize>) {
    let (mut bodies, mut own_levels) = (Vec::new(), Vec::new());
    let mut first = 0;
    for own in particles.chunk_by(|p, q| p.body == q.body) {
        let number = own[0].body;
        let u = own.iter().map(|active| u[active.particle as usize]).collect();
        bodies.push(Mutex::new(RelaxedBody { first, u, volume: volumes[number] }));
        own_levels.push(levels[number]);
        first += own.len();
    }
    (bodies, own_levels)
}

/// Locks a body, which one thread at a time relaxes.
fn lock(body: &Mutex<RelaxedBody>) -> MutexGuard<'_, RelaxedBody> {
    body.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Occurrences of all active particles, one after the other (compressed sparse rows).
struct Occurrences {
    all: Vec<Occurrence>,
    ends: Vec<usize>,
}

impl Occurrences {
    fn of(&self, i: usize) -> &[Occurrence] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.all[start..self.ends[i]]
    }
}

/// Lists where each active particle occurs in the terms of rows or bonds.
fn occurrences<'t>(
    terms: impl Iterator<Item = &'t Vec<(u32, f64)>> + Clone,
    numbers: &[u32],
    count: usize,
) -> Occurrences {
    // Counted first, so that each list is filled in place.
    let mut ends = vec![0; count];
    for &(particle, _) in terms.clone().flatten() {
        let number = numbers[particle as usize];
        if number != INACTIVE {
            ends[number as usize] += 1;
        }
    }
    let mut total = 0;
    for end in &mut ends {
        (*end, total) = (total, total + *end);
    }

    // Each start moves to the end of its list.
    let mut all = vec![Occurrence::default(); total];
    for (number, terms) in (0..).zip(terms) {
        for &(particle, weight) in terms {
            let i = numbers[particle as usize];
            if i != INACTIVE {
                let end = &mut ends[i as usize];
                all[*end] = Occurrence { number, weight };
                *end += 1;
            }
        }
    }
    Occurrences { all, ends }
}

/// Returns `scale · v vᵀ`.
fn outer(v: DVec3, scale: f64) -> DMat3 {
    let scaled = scale * v;
    DMat3::from_cols(v.x * scaled, v.y * scaled, v.z * scaled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::ActiveParticle;

    /// Builds six bodies of particles on foundations, with rows that are missing between every second of
    /// them, by number.
    fn six_bodies() -> (ElasticProblem, u32) {
        let own: u32 = 2000;
        let mut problem =
            ElasticProblem { volumes: vec![VolumeRow::new(0.1); 6], ..Default::default() };
        for particle in 0..6 * own {
            let mut active = ActiveParticle { particle, foundation: 1.0, ..Default::default() };
            (active.area, active.body) = (DVec3::Y, (particle / own) as usize);
            if particle % own > 0 {
                active.links.push((particle - 1, 0.5 + f64::from(particle % 7)));
            }
            problem.particles.push(active);
        }
        for k in 0..3000 {
            let [p, q] = [(7919 * k) % (6 * own), (104_729 * k + 11) % (6 * own)];
            if (p / own).abs_diff(q / own) == 2 {
                let normal = DVec3::new(1.0, f64::from(k % 5), f64::from(k % 3)).normalize();
                problem.rows.push(GapRow::new(vec![(p, 1.0), (q, -1.0)], normal, 0.2));
            }
        }
        (problem, 6 * own)
    }

    #[test]
    fn side_by_side_is_as_one_body_after_the_other() {
        let at_rest = |count| vec![DVec3::ZERO; count as usize];
        let (problem, count) = six_bodies();
        let shared = Relaxation::new(problem, &at_rest(count), 0.5);
        assert!(shared.is_worth_sharing());
        let run = |body: usize, is_forward: bool| shared.sweep_body(body, is_forward);
        shared.turns.share(&run, || {
            for _ in 0..4 {
                shared.turns.sweep(&run);
                shared.update_multipliers();
            }
        });

        let in_order = Relaxation::new(six_bodies().0, &at_rest(count), 0.5);
        for is_forward in [true, false, true, false] {
            for number in 0..6 {
                in_order.sweep_body(if is_forward { number } else { 5 - number }, is_forward);
            }
            in_order.update_multipliers();
        }
        let steps = shared.steps_from(&at_rest(count));
        assert!(steps.iter().any(|step| step.x.abs() > 0.01));
        assert_eq!(steps, in_order.steps_from(&at_rest(count)));
    }
}
