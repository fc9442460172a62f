//! Relaxation of an elastic problem: block Gauss–Seidel, one vertex at a time with all its rows.
//!
//! Bodies are cut into [parts](super::parts), and parts without a link, a row or a bond in common have one color.
//! Those of one color are relaxed side by side, color by color forward or backward ([`super::turns`]): to the bit as one part
//! after the other. What a part gains of its body's volume is known to those of later colors, and to others of its own
//! color in the next sweep.

mod setup;

use glam::{DMat3, DVec3};
use surface::vectors::outer;

use crate::elastic::ElasticProblem;
use crate::occurrences::Occurrence;
use crate::parts::Part;
use crate::shared_number::{SharedNumber, SharedVector};
use crate::turns::Turns;
use crate::volume_row::{RelaxedArea, SharedGain, VolumeRow};

/// Part of an accuracy that rows may be missing from a solution: a quarter, so that what is solved for is left
/// where all that is computed from it is rounded.
pub(crate) const SOLVED_SHARE: f64 = 0.25;

/// Sweeps of the elastic solver in a step that others follow. Below, displacements are rough, and more
/// steps are needed; above, steps take longer.
pub(crate) const STEP_SWEEPS: usize = 20;

/// Smallest number of sweeps, in which displacements spread over that many edges.
const MIN_SWEEPS: usize = 8;

/// Number of particles below which all parts are relaxed on one thread: to wake others takes longer.
const MIN_SHARED_PARTICLES: usize = 1000;

/// Force against a step at its end that is left to the next sweep \[force at its start\]. Below, multipliers of single rows
/// take more sweeps to their values; above, rows that contradict each other throw particles far.
const MAX_OVERSHOOT: f64 = 2.5;

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
        let run = |part: usize, is_forward| relaxation.sweep_part(part, is_forward);
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

/// Problem with its particles numbered without gaps, and the state of its solution.
struct Relaxation {
    particles: Vec<RelaxedParticle>,
    /// Displacements of all particles.
    u: Vec<SharedVector>,
    /// Links to other active particles, by their numbers.
    links: Vec<(u32, f64)>,
    rows: Vec<RelaxedRow>,
    in_rows: Vec<Occurrence>,
    bonds: Vec<RelaxedBond>,
    in_bonds: Vec<Occurrence>,
    /// Per body.
    volumes: Vec<VolumeRow>,
    parts: Vec<Part>,
    colors: Vec<usize>,
    /// Volume that each part has gained in the present sweep.
    gained: Vec<SharedNumber>,
    /// Areas of particles in bodies other than their own, and what parts gain of these, part by part.
    shared_areas: Vec<RelaxedArea>,
    shared_gains: Vec<SharedGain>,
    turns: Turns,
}

/// Active particle with the ends of its parts of all lists, which begin where those of the particle
/// before end.
#[derive(Clone, Copy, Debug, Default)]
struct RelaxedParticle {
    particle: u32,
    shared_areas_end: u32,
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

/// Row of a gap with its state.
struct RelaxedRow {
    /// Unit direction in which the gap opens.
    normal: DVec3,
    /// Opening that is missing; negative where the gap is wider than asked.
    missing: f64,
    /// Stiffness of the augmented term.
    penalty: f64,
    /// Force that the multiplier adds.
    multiplier: SharedNumber,
    /// Opening by the present displacements.
    opening: SharedNumber,
}

/// Stiffness of a bond, and its stretch at the present displacements.
struct RelaxedBond {
    stiffness: f64,
    stretch: SharedVector,
}

impl RelaxedRow {
    /// Returns the force at an opening.
    #[inline(always)]
    fn force(&self, opening: f64) -> f64 {
        (self.multiplier.get() + self.penalty * (self.missing - opening)).max(0.0)
    }
}

impl Relaxation {
    /// Returns the steps of all particles from their displacements `u` to the present ones.
    fn steps_from(&self, u: &[DVec3]) -> Vec<DVec3> {
        let mut steps = vec![DVec3::ZERO; u.len()];
        for (active, displaced) in self.particles.iter().zip(&self.u) {
            steps[active.particle as usize] = displaced.get() - u[active.particle as usize];
        }
        steps
    }

    /// Relaxes the particles of a part once.
    fn sweep_part(&self, number: usize, is_forward: bool) {
        let Part { body, particles } = &self.parts[number];
        let volume = &self.volumes[*body];
        let color = self.colors[number];
        let before = self.gained_before(volume, color, is_forward);
        for gain in self.gains_of(number) {
            let volume = &self.volumes[gain.body];
            gain.before.set(self.gained_before(volume, color, is_forward));
            gain.gained.set(0.0);
        }
        let mut gained = before;
        for step in 0..particles.len() {
            let i = if is_forward { particles.start + step } else { particles.end - 1 - step };
            self.relax(i, volume, &mut gained);
        }
        self.gained[number].set(gained - before);
    }

    /// Returns the volume that parts of colors before have gained of a body in the present sweep.
    fn gained_before(&self, volume: &VolumeRow, color: usize, is_forward: bool) -> f64 {
        let is_before = |part: usize| match is_forward {
            true => self.colors[part] < color,
            false => self.colors[part] > color,
        };
        let mut before = 0.0;
        for part in volume.parts.clone() {
            if is_before(part) {
                before += self.gained[part].get();
            }
        }
        for &number in &volume.shared {
            let gain = &self.shared_gains[number];
            if is_before(gain.part) {
                before += gain.gained.get();
            }
        }
        before
    }

    /// Returns what a part gains of bodies other than its own.
    fn gains_of(&self, part: usize) -> &[SharedGain] {
        let first = self.shared_gains.partition_point(|gain| gain.part < part);
        let end = self.shared_gains.partition_point(|gain| gain.part <= part);
        &self.shared_gains[first..end]
    }

    /// Returns true if there is enough to do for several threads.
    fn is_worth_sharing(&self) -> bool {
        self.parts.len() > 1 && self.particles.len() >= MIN_SHARED_PARTICLES
    }

    /// Moves one particle to where the energy is least while all others rest, or nearer. In this sweep its body has
    /// `gained` volume by then.
    fn relax(&self, i: usize, volume: &VolumeRow, gained: &mut f64) {
        let active = self.particles[i];
        let before = if i == 0 { RelaxedParticle::default() } else { self.particles[i - 1] };
        if active.diagonal <= 0.0 {
            return;
        }

        // Elastic forces.
        let mut force = active.pull - active.own * self.u[i].get();
        for &(next, stiffness) in &self.links[before.links_end..active.links_end] {
            force += stiffness * self.u[next as usize].get();
        }
        let bonds = before.bonds_end..active.bonds_end;
        for occurrence in &self.in_bonds[bonds.clone()] {
            let bond = &self.bonds[occurrence.number as usize];
            force -= bond.stiffness * occurrence.weight * bond.stretch.get();
        }

        // The volume, then rows in force.
        force += volume.force(*gained) * active.area;
        let mut stiffness = DMat3::from_diagonal(DVec3::splat(active.diagonal));
        stiffness += outer(volume.penalty * active.area, active.area);
        let shared = before.shared_areas_end as usize..active.shared_areas_end as usize;
        for &RelaxedArea { area, body, gain } in &self.shared_areas[shared.clone()] {
            let (volume, gain) = (&self.volumes[body], &self.shared_gains[gain]);
            force += volume.force(gain.before.get() + gain.gained.get()) * area;
            stiffness += outer(volume.penalty * area, area);
        }
        let in_rows = &self.in_rows[before.rows_end..active.rows_end];
        let (pushed, hessian) = self.add_rows(in_rows, force, stiffness);
        let mut step = hessian.inverse() * pushed;

        // Where many rows come into force on the way, they would throw the particle back and forth: as far as the
        // energy falls, by Newton's method along the step, no farther back than by its secant.
        if self.open_rows(in_rows, step) {
            let (ahead, hessian) = self.add_rows(in_rows, force - stiffness * step, stiffness);
            let (from, to) = (pushed.dot(step), ahead.dot(step));
            if to < -MAX_OVERSHOOT * from {
                let newton = 1.0 + to / step.dot(hessian * step);
                let share = newton.max(from / (from - to));
                self.open_rows(in_rows, (share - 1.0) * step);
                step *= share;
            }
        }

        // All that depends on the particle follows it.
        self.u[i].add(step);
        *gained += active.area.dot(step);
        for shared in &self.shared_areas[shared] {
            self.shared_gains[shared.gain].gained.add(shared.area.dot(step));
        }
        for occurrence in &self.in_bonds[bonds] {
            self.bonds[occurrence.number as usize].stretch.add(occurrence.weight * step);
        }
    }

    /// Adds to a force and a stiffness those of the rows of their particle.
    #[inline(always)]
    fn add_rows(
        &self,
        in_rows: &[Occurrence],
        mut force: DVec3,
        mut stiffness: DMat3,
    ) -> (DVec3, DMat3) {
        for &Occurrence { number, weight } in in_rows {
            let row = &self.rows[number as usize];
            let push = row.force(row.opening.get());
            if push > 0.0 {
                force += push * weight * row.normal;
                stiffness += outer(row.penalty * weight * weight * row.normal, row.normal);
            }
        }
        (force, stiffness)
    }

    /// Opens rows by a step of their particle; returns true if one comes into force by it.
    #[inline(always)]
    fn open_rows(&self, in_rows: &[Occurrence], step: DVec3) -> bool {
        let mut comes_into_force = false;
        for &Occurrence { number, weight } in in_rows {
            let row = &self.rows[number as usize];
            let before = row.opening.get();
            let opening = before + weight * row.normal.dot(step);
            row.opening.set(opening);
            let [was, is] = [before, opening].map(|opening| row.force(opening) > 0.0);
            comes_into_force |= is & !was;
        }
        comes_into_force
    }

    /// Adds what rows and volumes are missing to their forces; returns the largest part of a gap
    /// that is missing.
    fn update_multipliers(&self) -> f64 {
        let mut most: f64 = 0.0;
        for row in &self.rows {
            let opening = row.opening.get();
            row.multiplier.set(row.force(opening));
            if row.penalty > 0.0 {
                most = most.max(row.missing - opening);
            }
        }
        for (part, gained) in self.parts.iter().zip(&self.gained) {
            self.volumes[part.body].gained.add(gained.get());
        }
        for gain in &self.shared_gains {
            self.volumes[gain.body].gained.add(gain.gained.get());
        }
        for volume in &self.volumes {
            volume.multiplier.set(volume.force(0.0));
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::{ActiveParticle, Bond, GapRow};

    /// Builds six bodies of particles on foundations, with rows that are missing between every second of
    /// them, by number.
    fn six_bodies() -> (ElasticProblem, u32) {
        let own: u32 = 2000;
        let mut problem = ElasticProblem { missing_volumes: vec![0.1; 6], ..Default::default() };
        for particle in 0..6 * own {
            let mut active = ActiveParticle { particle, foundation: 1.0, ..Default::default() };
            (active.area, active.body) = (DVec3::Y, (particle / own) as usize);
            let link = (particle.wrapping_sub(1), 0.5 + f64::from(particle % 7));
            problem.push(active, (particle % own > 0).then_some(link));
        }
        for k in 0..3000 {
            let [p, q] = [(7919 * k) % (6 * own), (104_729 * k + 11) % (6 * own)];
            if (p / own).abs_diff(q / own) == 2 {
                let normal = DVec3::new(1.0, f64::from(k % 5), f64::from(k % 3)).normalize();
                let terms = [(p, 1.0), (q, -1.0)].into_iter().collect();
                problem.rows.push(GapRow::new(terms, normal, 0.2));
            }
        }
        (problem, 6 * own)
    }

    #[test]
    fn side_by_side_is_as_one_part_after_the_other() {
        let at_rest = |count| vec![DVec3::ZERO; count as usize];
        let [shared, in_order] = [(); 2].map(|()| {
            let (problem, count) = six_bodies();
            Relaxation::new(problem, &at_rest(count), 0.5)
        });
        assert!(shared.is_worth_sharing());
        let run = |part: usize, is_forward: bool| shared.sweep_part(part, is_forward);
        shared.turns.share(&run, || {
            for _ in 0..4 {
                shared.turns.sweep(&run);
                shared.update_multipliers();
            }
        });

        let run = |part: usize, is_forward: bool| in_order.sweep_part(part, is_forward);
        for _ in 0..4 {
            in_order.turns.sweep(&run);
            in_order.update_multipliers();
        }
        let at_rest = at_rest(six_bodies().1);
        let steps = shared.steps_from(&at_rest);
        assert!(steps.iter().any(|step| step.x.abs() > 0.01));
        assert_eq!(steps, in_order.steps_from(&at_rest));
    }

    #[test]
    fn what_has_something_in_common_is_never_relaxed_side_by_side() {
        let (mut problem, count) = six_bodies();
        for k in 0..40 {
            let terms = [0, 31, 577, 4003].map(|by| ((293 * k + by) % count, 0.5));
            let terms = terms.into_iter().collect();
            problem.bonds.push(Bond { terms, stiffness: 1.0 });
        }
        let mut together = Vec::new();
        let mut first = 0;
        for active in &problem.particles {
            let links = &problem.links[first..active.links_end];
            together.extend(links.iter().map(|(next, _)| vec![active.particle, *next]));
            first = active.links_end;
        }
        let particles = |terms: &[(u32, f64)]| terms.iter().map(|(p, _)| *p).collect();
        together.extend(problem.rows.iter().map(|row| particles(&row.terms)));
        together.extend(problem.bonds.iter().map(|bond| particles(&bond.terms)));

        let relaxation = Relaxation::new(problem, &vec![DVec3::ZERO; count as usize], 0.5);
        let part_of = |particle: u32| {
            relaxation.parts.partition_point(|part| part.particles.end <= particle as usize)
        };
        for particles in together {
            for (p, q) in particles.iter().zip(&particles[1..]) {
                let [a, b] = [part_of(*p), part_of(*q)];
                let differs = relaxation.colors[a] != relaxation.colors[b];
                assert!(a == b || differs, "{particles:?} in {a} and {b}");
            }
        }
        assert!(relaxation.colors.iter().any(|color| *color > 1));
    }
}
