//! Packed rows: constraint rows in the order in which solvers sweep them, without the
//! particles that cannot move.

use std::ops::RangeInclusive;

use glam::DVec3;
use surface::Term;

use super::coloring::{Batch, Coloring};
use super::slots::{Slot, cells};
use super::{Impulse, Residual, SweepOrder};
use crate::contact_rows::ContactRow;
use crate::{Constraint, ContactLaw, ContactRows, SolveLevel};

/// Constraint rows and inverse masses, packed for sweeping.
#[derive(Clone, Debug, Default)]
pub(super) struct PackedSystem {
    pub(super) particle_count: usize,
    /// Number of rows given, of which `rows` holds those that can move a particle.
    pub(super) row_count: usize,
    pub(super) rows: Vec<PackedRow>,
    pub(super) terms: Vec<PackedTerm>,
    /// Inverse mass of each particle.
    pub(super) inverse_mass: Vec<f64>,
    coloring: Coloring,
    sources: Vec<RowSource>,
    /// Terms of particles that cannot move.
    fixed: Vec<Term>,
    /// Numbers of the rows that can move a particle.
    movable: Vec<u32>,
}

/// Data of a row that a sweep reads; one cache line.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedRow {
    pub(super) normal: DVec3,
    /// 1 / D with D = Σ β² / m.
    pub(super) step: f64,
    /// D / (D + α): 1 for a hard row.
    pub(super) hardness: f64,
    /// Coulomb's coefficients.
    static_friction: f64,
    dynamic_friction: f64,
    terms: [u32; 2],
}

/// Term of a particle that can move.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedTerm {
    pub(super) particle: u32,
    /// β.
    pub(super) weight: f64,
    /// β / m.
    pub(super) step: f64,
}

/// Data of a row that a solution reads once, at its start.
#[derive(Clone, Copy, Debug)]
struct RowSource {
    row: u32,
    depth: f64,
    law: ContactLaw,
    constraint: Constraint,
    anchor_velocity: DVec3,
    anchor_acceleration: DVec3,
    /// Range of its fixed terms.
    fixed: [u32; 2],
}

/// Goal of a row in one solution.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowGoal {
    /// b in Q_c − t = Σ β q + b over the terms that can move, with t the target.
    pub(super) bias: DVec3,
    /// True if the normal impulse must not pull.
    pub(super) is_one_sided: bool,
    pub(super) tangent: Tangent,
    pub(super) share: ShareLimits,
}

/// Limits of a tangential impulse that removes a share of the slip: none, unless the goal is
/// [`Tangent::Share`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShareLimits {
    /// Unit vector along the slip at the start.
    pub(super) direction: DVec3,
    /// Largest impulse over the normal one; infinite where it is not limited by that.
    ratio: f64,
}

impl ShareLimits {
    /// Returns the largest impulse along the slip.
    #[inline]
    fn largest(&self, normal: f64) -> f64 {
        if self.ratio.is_infinite() { f64::INFINITY } else { self.ratio * normal.max(0.0) }
    }

    /// Returns the nearest impulse that opposes the slip and is not too large.
    #[inline]
    fn within(&self, along: f64, normal: f64) -> DVec3 {
        along.max(0.0).min(self.largest(normal)) * self.direction
    }
}

/// Projection of a row's tangential impulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tangent {
    /// No tangential impulse.
    Free,
    /// Coulomb's disc.
    Disc,
    /// One along the slip at the start, never against it, within the share's limits; hard.
    Share,
    /// Any impulse, with the compliance of the normal.
    Compliant,
}

/// State of a solution, rows in order of batches.
#[derive(Clone, Debug, Default)]
pub(super) struct SolverState {
    pub(super) q: Vec<DVec3>,
    pub(super) goals: Vec<RowGoal>,
    pub(super) impulses: Vec<Impulse>,
}

impl PackedSystem {
    /// Replaces all rows; the memory is kept.
    pub(super) fn rebuild(&mut self, rows: &ContactRows, inverse_mass: &[f64], order: SweepOrder) {
        self.particle_count = rows.particle_count();
        self.row_count = rows.len();
        self.inverse_mass.clear();
        self.inverse_mass.extend_from_slice(inverse_mass);
        self.rows.clear();
        self.terms.clear();
        self.sources.clear();
        self.fixed.clear();

        // Rows that can move a particle, in the order in which they are swept.
        self.movable.clear();
        self.movable.reserve(rows.len());
        for (number, row) in (0..).zip(rows.iter()) {
            if is_movable(&row, inverse_mass) {
                self.movable.push(number);
            }
        }
        match order {
            SweepOrder::Given => self.coloring.keep_order(index(self.movable.len())),
            SweepOrder::Colored => self.color(rows),
        }

        // Rows next to each other in a sweep are next to each other in memory.
        let count = self.coloring.order.len();
        self.rows.reserve(count);
        self.terms.reserve(4 * count);
        self.sources.reserve(count);
        for place in 0..count {
            let number = self.movable[self.coloring.order[place] as usize];
            self.push(number, &rows.row(number as usize));
        }
    }

    /// Colors the movable rows such that rows of one color write to different particles.
    fn color(&mut self, rows: &ContactRows) {
        self.coloring.clear(self.movable.len(), rows.particle_count());
        for &number in &self.movable {
            let particles = rows.row(number as usize).terms.iter().map(|term| term.particle);
            let free = particles.filter(|particle| self.inverse_mass[*particle as usize] > 0.0);
            self.coloring.add_row(free);
        }
        self.coloring.sort();
    }

    pub(super) fn batches(&self) -> &[Batch] {
        &self.coloring.batches
    }

    pub(super) fn immovable(&self) -> usize {
        self.row_count - self.rows.len()
    }

    pub(super) fn terms_of(&self, row: &PackedRow) -> &[PackedTerm] {
        &self.terms[row.terms[0] as usize..row.terms[1] as usize]
    }

    /// Copies `q` and applies the impulses to start from.
    pub(super) fn start(
        &self,
        level: SolveLevel,
        q: &[DVec3],
        impulses: &[Impulse],
        state: &mut SolverState,
    ) {
        // Goals need the state before impulses act.
        state.goals.clear();
        state.goals.reserve(self.rows.len());
        for (row, source) in self.rows.iter().zip(&self.sources) {
            state.goals.push(self.goal(level, row, source, q));
        }

        state.q.clear();
        state.q.extend_from_slice(q);
        state.impulses.clear();
        state.impulses.reserve(self.rows.len());
        let slots = cells(&mut state.q);
        for ((row, source), goal) in self.rows.iter().zip(&self.sources).zip(&state.goals) {
            let impulse = admissible(row, goal, impulses[source.row as usize]);
            self.apply(row, impulse.normal * row.normal, impulse.tangent, slots);
            state.impulses.push(impulse);
        }
    }

    /// Copies a solution to the caller's lists.
    pub(super) fn finish(&self, state: &SolverState, q: &mut [DVec3], impulses: &mut [Impulse]) {
        q.copy_from_slice(&state.q);
        impulses.fill(Impulse::default());
        for (source, impulse) in self.sources.iter().zip(&state.impulses) {
            impulses[source.row as usize] = *impulse;
        }
    }

    /// Computes Q_c of a row.
    #[inline]
    pub(super) fn relative<S: Slot>(&self, row: &PackedRow, bias: DVec3, q: &[S]) -> DVec3 {
        let mut at = bias;
        for term in self.terms_of(row) {
            at += term.weight * q[term.particle as usize].load();
        }
        at
    }

    /// Applies the impulse `normal + tangent` to P, and the opposite one to P̄.
    #[inline]
    pub(super) fn apply<S: Slot>(&self, row: &PackedRow, normal: DVec3, tangent: DVec3, q: &[S]) {
        let impulse = normal + tangent;
        for term in self.terms_of(row) {
            let slot = &q[term.particle as usize];
            slot.store(slot.load() - term.step * impulse);
        }
    }

    /// Computes the largest changes that any row alone still requires.
    pub(super) fn residual<S: Slot>(
        &self,
        goals: &[RowGoal],
        impulses: &[Impulse],
        q: &[S],
    ) -> Residual {
        let mut largest = Residual::default();
        for ((row, goal), impulse) in self.rows.iter().zip(goals).zip(impulses) {
            let relaxed = self.relax(row, goal, *impulse, 1.0, q);
            largest.include(&changes(row, goal, *impulse, relaxed));
        }
        largest
    }

    /// Computes the impulse that a row alone would have, with `factor` of its steps.
    #[inline]
    pub(super) fn relax<S: Slot>(
        &self,
        row: &PackedRow,
        goal: &RowGoal,
        impulse: Impulse,
        factor: f64,
        q: &[S],
    ) -> Impulse {
        let at = self.relative(row, goal.bias, q);
        let approach = at.dot(row.normal);
        let toward = row.hardness * row.step * approach - (1.0 - row.hardness) * impulse.normal;
        let wanted = impulse.normal + factor * toward;
        let normal = if goal.is_one_sided { wanted.max(0.0) } else { wanted };
        if goal.tangent == Tangent::Free {
            return Impulse { normal, tangent: DVec3::ZERO };
        }

        // The impulse that stops the slip: Coulomb's law limits it to the friction disc.
        let slip = at - approach * row.normal;
        let tangent = impulse.tangent + factor * row.step * slip;
        let tangent = match goal.tangent {
            Tangent::Free => DVec3::ZERO,
            Tangent::Disc => within_disc(row, tangent, normal),
            Tangent::Share => goal.share.within(tangent.dot(goal.share.direction), normal),
            Tangent::Compliant => {
                let toward = row.hardness * row.step * slip;
                impulse.tangent + factor * (toward - (1.0 - row.hardness) * impulse.tangent)
            }
        };
        Impulse { normal, tangent }
    }

    /// Computes the goal of a row from the state before impulses act.
    fn goal(&self, level: SolveLevel, row: &PackedRow, source: &RowSource, q: &[DVec3]) -> RowGoal {
        // Q_c: the part that the solution does not change, and the rest.
        let terms = &self.fixed[source.fixed[0] as usize..source.fixed[1] as usize];
        let fixed: DVec3 = terms.iter().map(|t| t.weight * q[t.particle as usize]).sum();
        let given = match level {
            SolveLevel::Position => fixed,
            SolveLevel::Velocity => fixed + source.anchor_velocity,
            SolveLevel::Acceleration => fixed + source.anchor_acceleration,
        };
        let terms = self.terms_of(row);
        let moving: DVec3 = terms.iter().map(|t| t.weight * q[t.particle as usize]).sum();
        let start = given + moving;
        let lambda = source.law.margins().proximity_factor(source.depth);

        // Targets enter with the part that does not change.
        let left = (1.0 - lambda) * start.dot(row.normal).max(0.0);
        let target = match source.constraint {
            Constraint::Contact | Constraint::Approach(_) if level == SolveLevel::Position => {
                -source.depth * row.normal
            }
            // Outside of collision only λ of the approach is canceled.
            Constraint::Contact => left * row.normal,
            Constraint::Approach(largest) => left.min(largest) * row.normal,
            Constraint::OneSided(target) | Constraint::TwoSided(target) => target * row.normal,
            Constraint::Vector(target) => target,
        };
        let is_one_sided = source.constraint.is_one_sided();
        let (bias, share) = (given - target, ShareLimits::default());
        let goal = RowGoal { bias, is_one_sided, tangent: Tangent::Free, share };
        if let Constraint::Vector(_) = source.constraint {
            return RowGoal { tangent: Tangent::Compliant, ..goal };
        }

        // Coulomb's law projects, and needs no target.
        let Some(share) = source.law.friction().as_share() else {
            let has_friction = row.static_friction > 0.0;
            return if has_friction { RowGoal { tangent: Tangent::Disc, ..goal } } else { goal };
        };

        // The source's friction leaves a share of the slip, where the contact approaches.
        let approach = start.dot(row.normal);
        let slip = start - approach * row.normal;
        let (removed, speed) = (share * lambda, slip.length());
        let direction = slip / speed;
        if removed * speed <= 0.0 || !direction.is_finite() {
            return goal;
        }
        let mut ratio = f64::INFINITY;
        if is_one_sided && level != SolveLevel::Position {
            // Impulses of the row alone, over D: friction is in this ratio to the push.
            let push = row.hardness * (approach - target.dot(row.normal));
            if approach <= 0.0 || push <= 0.0 {
                return goal;
            }
            ratio = (removed * speed / push).min(f64::MAX);
        }
        let bias = goal.bias - (1.0 - removed) * slip;
        let share = ShareLimits { direction, ratio };
        RowGoal { bias, tangent: Tangent::Share, share, ..goal }
    }

    fn push(&mut self, number: u32, row: &ContactRow<'_>) {
        let starts = [self.terms.len(), self.fixed.len()].map(index);

        // Terms that can move, and those that cannot.
        let mut compliance = 0.0;
        for &term in row.terms {
            let Term { particle, weight } = term;
            let step = weight * self.inverse_mass[particle as usize];
            if moves(&term, &self.inverse_mass) {
                compliance += weight * step;
                self.terms.push(PackedTerm { particle, weight, step });
            } else {
                self.fixed.push(term);
            }
        }

        // A step cancels Q_c of this row alone.
        let (static_friction, dynamic_friction) = row.law.friction().coefficients();

        self.rows.push(PackedRow {
            normal: row.normal,
            step: compliance.recip(),
            hardness: compliance / (compliance + row.law.compliance()),
            static_friction,
            dynamic_friction,
            terms: [starts[0], index(self.terms.len())],
        });
        self.sources.push(RowSource {
            row: number,
            depth: row.depth,
            law: row.law,
            constraint: row.constraint,
            anchor_velocity: row.anchor.velocity,
            anchor_acceleration: row.anchor.acceleration,
            fixed: [starts[1], index(self.fixed.len())],
        });
    }
}

/// Computes the largest change of Q_c that belongs to a change of impulse.
#[inline]
pub(super) fn change(row: &PackedRow, from: Impulse, to: Impulse) -> f64 {
    let normal = (to.normal - from.normal).abs() / (row.step * row.hardness);
    let tangent = (to.tangent - from.tangent).length() / (row.step * row.hardness);
    normal.max(tangent)
}

/// Sorts the changes of Q_c that belong to a change of impulse by their conditions.
fn changes(row: &PackedRow, goal: &RowGoal, from: Impulse, to: Impulse) -> Residual {
    let mut residual = Residual::default();
    let normal = (to.normal - from.normal).abs() / (row.step * row.hardness);
    if goal.is_one_sided {
        residual.complementarity = normal;
    } else {
        residual.equality = normal;
    }

    let tangent = (to.tangent - from.tangent).length() / row.step;
    match goal.tangent {
        Tangent::Free => {}
        Tangent::Disc | Tangent::Share => residual.cone = tangent,
        Tangent::Compliant => residual.equality = residual.equality.max(tangent / row.hardness),
    }
    residual
}

/// Range of D and of 1 / (D + α) within which a row can be corrected: what is computed of them are
/// numbers.
const CORRECTABLE: RangeInclusive<f64> = 1e-300..=1e300;

/// Returns true if an impulse of the row can move a particle.
fn is_movable(row: &ContactRow<'_>, inverse_mass: &[f64]) -> bool {
    let mut compliance = 0.0;
    for Term { particle, weight } in row.terms {
        compliance += weight * weight * inverse_mass[*particle as usize];
    }
    let hardness = compliance / (compliance + row.law.compliance());
    CORRECTABLE.contains(&compliance) && CORRECTABLE.contains(&(hardness / compliance))
}

fn moves(term: &Term, inverse_mass: &[f64]) -> bool {
    term.weight * term.weight * inverse_mass[term.particle as usize] > 0.0
}

/// Returns the nearest impulse that fulfills the goal's conditions.
fn admissible(row: &PackedRow, goal: &RowGoal, impulse: Impulse) -> Impulse {
    let normal = if goal.is_one_sided { impulse.normal.max(0.0) } else { impulse.normal };

    // The plane has turned since the impulse was stored.
    let in_plane = impulse.tangent - impulse.tangent.dot(row.normal) * row.normal;
    let tangent = match goal.tangent {
        Tangent::Free => DVec3::ZERO,
        Tangent::Disc => within_disc(row, in_plane, normal),
        Tangent::Share => goal.share.within(in_plane.dot(goal.share.direction), normal),
        Tangent::Compliant => in_plane,
    };
    Impulse { normal, tangent }
}

/// Returns a tangential impulse that Coulomb's law permits: any that the static coefficient
/// can hold, else one of the dynamic coefficient.
#[inline]
fn within_disc(row: &PackedRow, j: DVec3, normal: f64) -> DVec3 {
    let normal = normal.max(0.0);
    let (sticking, sliding) = (row.static_friction * normal, row.dynamic_friction * normal);
    let length_squared = j.length_squared();
    if length_squared <= sticking * sticking { j } else { j * (sliding / length_squared.sqrt()) }
}

#[expect(clippy::cast_possible_truncation, reason = "rows and terms are numbered in 32 bits")]
fn index(count: usize) -> u32 {
    debug_assert!(u32::try_from(count).is_ok(), "contact rows keep to 32 bits");
    count as u32
}
