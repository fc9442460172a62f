//! Packed rows: constraint rows in the order in which solvers sweep them, without the
//! particles that cannot move.

use glam::DVec3;
use surface::Term;

use super::coloring::{Batch, Coloring, Colors, uncolored};
use super::slots::{Slot, cells};
use super::{Impulse, SolveLevel, SweepOrder};
use crate::contact_rows::ContactRow;
use crate::{ContactLaw, ContactRows};

/// Constraint rows and inverse masses, packed for sweeping.
#[derive(Clone, Debug)]
pub(super) struct PackedSystem {
    pub(super) particle_count: usize,
    /// Number of rows given, of which `rows` holds those that can move a particle.
    pub(super) row_count: usize,
    pub(super) rows: Vec<PackedRow>,
    pub(super) terms: Vec<PackedTerm>,
    pub(super) batches: Vec<Batch>,
    /// Inverse mass of each particle.
    pub(super) inverse_mass: Vec<f64>,
    sources: Vec<RowSource>,
    /// Terms of particles that cannot move.
    fixed: Vec<Term>,
}

/// Data of a row that a sweep reads; one cache line.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedRow {
    pub(super) normal: DVec3,
    /// 1 / Σ β² / m.
    pub(super) step: f64,
    pub(super) friction: f64,
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
    anchor_velocity: DVec3,
    anchor_acceleration: DVec3,
    /// Range of its fixed terms.
    fixed: [u32; 2],
}

/// State of a solution, rows in order of batches.
pub(super) struct SolverState {
    pub(super) q: Vec<DVec3>,
    /// b in Q_c = Σ β q + b over the terms that can move.
    pub(super) bias: Vec<DVec3>,
    pub(super) impulses: Vec<Impulse>,
}

impl PackedSystem {
    pub(super) fn new(rows: &ContactRows, inverse_mass: &[f64], order: SweepOrder) -> Self {
        // Rows that can move a particle, in the order in which they are swept.
        let mut movable: Vec<u32> = Vec::with_capacity(rows.len());
        for (number, row) in (0..).zip(rows.iter()) {
            if row.terms.iter().any(|term| moves(term, inverse_mass)) {
                movable.push(number);
            }
        }
        let Coloring { order, batches } = match order {
            SweepOrder::Given => uncolored(index(movable.len())),
            SweepOrder::Colored => color(rows, &movable, inverse_mass),
        };

        // Rows next to each other in a sweep are next to each other in memory.
        let mut packed = Self {
            particle_count: rows.particle_count(),
            row_count: rows.len(),
            rows: Vec::with_capacity(order.len()),
            terms: Vec::with_capacity(4 * order.len()),
            batches,
            inverse_mass: inverse_mass.to_vec(),
            sources: Vec::with_capacity(order.len()),
            fixed: Vec::new(),
        };
        for place in order {
            let number = movable[place as usize];
            packed.push(number, &rows.row(number as usize));
        }
        packed
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
    ) -> SolverState {
        // The bias needs the state before impulses act.
        let rows = self.rows.iter().zip(&self.sources);
        let bias = rows.map(|(row, source)| self.bias(level, row, source, q)).collect();

        let mut q = q.to_vec();
        let slots = cells(&mut q);
        let mut warm = Vec::with_capacity(self.rows.len());
        for (row, source) in self.rows.iter().zip(&self.sources) {
            let impulse = admissible(row, impulses[source.row as usize]);
            self.apply(row, impulse.normal * row.normal, impulse.tangent, slots);
            warm.push(impulse);
        }
        SolverState { q, bias, impulses: warm }
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

    /// Computes the largest change that any row alone still requires.
    pub(super) fn residual(&self, state: &mut SolverState) -> f64 {
        let SolverState { q, bias, impulses } = state;
        self.largest_change(bias, impulses, cells(q))
    }

    /// Computes the largest change that any row alone still requires.
    pub(super) fn largest_change<S: Slot>(
        &self,
        bias: &[DVec3],
        impulses: &[Impulse],
        q: &[S],
    ) -> f64 {
        let mut largest = 0.0_f64;
        for ((row, bias), impulse) in self.rows.iter().zip(bias).zip(impulses) {
            let relaxed = self.relax(row, *bias, *impulse, 1.0, q);
            largest = largest.max(change(row, *impulse, relaxed));
        }
        largest
    }

    /// Computes the impulse that a row alone would have, with `factor` of its steps.
    #[inline]
    pub(super) fn relax<S: Slot>(
        &self,
        row: &PackedRow,
        bias: DVec3,
        impulse: Impulse,
        factor: f64,
        q: &[S],
    ) -> Impulse {
        let at = self.relative(row, bias, q);
        let approach = at.dot(row.normal);
        let normal = (impulse.normal + factor * row.step * approach).max(0.0);
        if row.friction <= 0.0 {
            return Impulse { normal, tangent: DVec3::ZERO };
        }

        // Coulomb's law: the impulse that stops the slip, within the friction disc.
        let slip = at - approach * row.normal;
        let sticking = impulse.tangent + factor * row.step * slip;
        Impulse { normal, tangent: within_disc(sticking, row.friction * normal) }
    }

    /// Computes b: the part of Q_c that the solution does not change, minus the approach
    /// that the proximity factor permits.
    fn bias(&self, level: SolveLevel, row: &PackedRow, source: &RowSource, q: &[DVec3]) -> DVec3 {
        let terms = &self.fixed[source.fixed[0] as usize..source.fixed[1] as usize];
        let fixed: DVec3 = terms.iter().map(|t| t.weight * q[t.particle as usize]).sum();
        let given = match level {
            SolveLevel::Position => return fixed + source.depth * row.normal,
            SolveLevel::Velocity => fixed + source.anchor_velocity,
            SolveLevel::Acceleration => fixed + source.anchor_acceleration,
        };

        // Outside of collision only λ of the approach is canceled.
        let terms = self.terms_of(row);
        let moving: DVec3 = terms.iter().map(|t| t.weight * q[t.particle as usize]).sum();
        let approach = (given + moving).dot(row.normal).max(0.0);
        let factor = source.law.margins().proximity_factor(source.depth);
        given - (1.0 - factor) * approach * row.normal
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
        self.rows.push(PackedRow {
            normal: row.normal,
            step: compliance.recip(),
            friction: row.law.friction(),
            terms: [starts[0], index(self.terms.len())],
        });
        self.sources.push(RowSource {
            row: number,
            depth: row.depth,
            law: row.law,
            anchor_velocity: row.anchor.velocity,
            anchor_acceleration: row.anchor.acceleration,
            fixed: [starts[1], index(self.fixed.len())],
        });
    }
}

/// Computes the change of Q_c that belongs to a change of impulse.
#[inline]
pub(super) fn change(row: &PackedRow, from: Impulse, to: Impulse) -> f64 {
    let normal = (to.normal - from.normal).abs() / row.step;
    let tangent = (to.tangent - from.tangent).length() / row.step;
    normal.max(tangent)
}

/// Colors the movable rows such that rows of one color write to different particles.
fn color(rows: &ContactRows, movable: &[u32], inverse_mass: &[f64]) -> Coloring {
    let mut colors = Colors::new(movable.len(), rows.particle_count());
    let mut particles = Vec::new();
    for &number in movable {
        particles.clear();
        particles.extend(rows.row(number as usize).terms.iter().map(|term| term.particle));
        particles.retain(|particle| inverse_mass[*particle as usize] > 0.0);
        colors.add_row(&particles);
    }
    colors.sort()
}

fn moves(term: &Term, inverse_mass: &[f64]) -> bool {
    term.weight * term.weight * inverse_mass[term.particle as usize] > 0.0
}

/// Returns the nearest impulse that does not pull and is within the friction disc.
fn admissible(row: &PackedRow, impulse: Impulse) -> Impulse {
    let normal = impulse.normal.max(0.0);
    if row.friction <= 0.0 {
        return Impulse { normal, tangent: DVec3::ZERO };
    }
    let in_plane = impulse.tangent - impulse.tangent.dot(row.normal) * row.normal;
    Impulse { normal, tangent: within_disc(in_plane, row.friction * normal) }
}

#[inline]
fn within_disc(j: DVec3, radius: f64) -> DVec3 {
    let length_squared = j.length_squared();
    if length_squared <= radius * radius { j } else { j * (radius / length_squared.sqrt()) }
}

#[expect(clippy::cast_possible_truncation, reason = "rows and terms are numbered in 32 bits")]
fn index(count: usize) -> u32 {
    debug_assert!(u32::try_from(count).is_ok(), "contact rows keep to 32 bits");
    count as u32
}
