//! Rows as the solvers sweep them: in order of batches, without the particles
//! that cannot move.

use std::ops::Range;

use glam::DVec3;
use surface::Term;

use super::coloring::{Batch, Coloring, color, uncolored};
use super::slots::Slot;
use super::{Impulse, SolveLevel, SweepOrder};
use crate::contact_rows::ContactRow;
use crate::torque_arm::TorqueArmRow;
use crate::{ContactLaw, ContactRows};

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct Packed {
    pub(super) particle_count: usize,
    /// Rows given, of which `rows` holds those that can move a particle.
    pub(super) row_count: usize,
    pub(super) rows: Vec<PackedRow>,
    pub(super) terms: Vec<PackedTerm>,
    pub(super) batches: Vec<Batch>,
    /// Inverse mass of each particle.
    pub(super) inverse_mass: Vec<f64>,
    levers: Vec<PackedTorqueArm>,
    origins: Vec<Origin>,
    /// Terms of particles that cannot move.
    fixed: Vec<Term>,
}

/// What a sweep reads of a row; one cache line.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedRow {
    pub(super) normal: DVec3,
    /// 1 / Σ β² / m.
    pub(super) normal_step: f64,
    /// The same for the tangents; smaller where there is a lever.
    pub(super) tangent_step: f64,
    pub(super) friction: f64,
    pub(super) terms: [u32; 2],
    levers: [u32; 2],
}

/// One particle that can move, and what it does.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedTerm {
    pub(super) particle: u32,
    /// β.
    pub(super) weight: f64,
    /// β / m.
    pub(super) step: f64,
}

#[derive(Clone, Copy, Debug)]
struct PackedTorqueArm {
    lever: TorqueArmRow,
    inverse_mass: [f64; 3],
}

/// What a solution's start needs of a row.
#[derive(Clone, Copy, Debug)]
struct Origin {
    row: u32,
    depth: f64,
    law: ContactLaw,
    /// Velocity and acceleration of the rigid object.
    anchor: [DVec3; 2],
    /// Where its fixed terms are.
    fixed: [u32; 2],
}

/// One solution under way, rows in order of batches.
pub(super) struct Work {
    pub(super) q: Vec<DVec3>,
    /// b in Q_c = Σ β q + b over the terms that can move.
    pub(super) bias: Vec<DVec3>,
    pub(super) impulses: Vec<Impulse>,
    /// Whether friction acts.
    pub(super) has_friction: bool,
}

impl Packed {
    pub(super) fn new(rows: &ContactRows, inverse_mass: &[f64], order: SweepOrder) -> Self {
        let levers = TorqueArmsByRow::new(rows);
        let movable: Vec<u32> = (0..)
            .zip(rows.iter())
            .filter(|(_, row)| row.terms.iter().any(|t| moves(t, inverse_mass)))
            .map(|(number, _)| number)
            .collect();
        let Coloring { order, batches } = arrange(rows, &movable, &levers, inverse_mass, order);
        let mut packed = Self {
            particle_count: rows.particle_count(),
            row_count: rows.len(),
            rows: Vec::with_capacity(order.len()),
            terms: Vec::with_capacity(4 * order.len()),
            batches,
            inverse_mass: inverse_mass.to_vec(),
            levers: Vec::new(),
            origins: Vec::with_capacity(order.len()),
            fixed: Vec::new(),
        };
        for place in order {
            let number = movable[place as usize];
            packed.push(number, &rows.row(number as usize), levers.of(number));
        }
        packed
    }

    pub(super) fn immovable(&self) -> usize {
        self.row_count - self.rows.len()
    }

    pub(super) fn terms_of(&self, row: &PackedRow) -> &[PackedTerm] {
        &self.terms[row.terms[0] as usize..row.terms[1] as usize]
    }

    /// Particles that a row writes to through its levers.
    pub(super) fn lever_particles(&self, row: &PackedRow) -> impl Iterator<Item = u32> {
        self.levers_of(row).iter().flat_map(|lever| lever.lever.particles)
    }

    /// Copies `q` and applies the impulses to start from.
    pub(super) fn start(&self, level: SolveLevel, q: &[DVec3], impulses: &[Impulse]) -> Work {
        let bias = self.bias(level, q);
        let has_friction = self.rows.iter().any(|row| row.friction > 0.0);
        let mut warm: Vec<Impulse> =
            self.origins.iter().map(|origin| impulses[origin.row as usize]).collect();
        let mut q = q.to_vec();
        let slots = super::slots::cells(&mut q);
        for (row, impulse) in self.rows.iter().zip(&mut warm) {
            *impulse = admissible(row, *impulse, has_friction);
            self.give(row, impulse.normal * row.normal, impulse.tangent, slots);
        }
        Work { q, bias, impulses: warm, has_friction }
    }

    pub(super) fn finish(&self, work: &Work, q: &mut [DVec3], impulses: &mut [Impulse]) {
        q.copy_from_slice(&work.q);
        impulses.fill(Impulse::default());
        for (origin, impulse) in self.origins.iter().zip(&work.impulses) {
            impulses[origin.row as usize] = *impulse;
        }
    }

    /// Q_c of a row; at the surface point for the tangents.
    #[inline]
    pub(super) fn relative<S: Slot>(&self, row: &PackedRow, bias: DVec3, q: &[S]) -> [DVec3; 2] {
        let mut at = bias;
        for term in self.terms_of(row) {
            at += term.weight * q[term.particle as usize].load();
        }
        let mut at_surface = at;
        for lever in self.levers_of(row) {
            at_surface += lever.lever.gather(|k| q[k as usize].load());
        }
        [at, at_surface]
    }

    /// Gives P the impulse `normal + tangent`, and P̄ the opposite one.
    #[inline]
    pub(super) fn give<S: Slot>(&self, row: &PackedRow, normal: DVec3, tangent: DVec3, q: &[S]) {
        let impulse = normal + tangent;
        for term in self.terms_of(row) {
            let slot = &q[term.particle as usize];
            slot.store(slot.load() - term.step * impulse);
        }
        for PackedTorqueArm { lever, inverse_mass } in self.levers_of(row) {
            let turns = lever.impulses(tangent);
            for ((k, turn), w) in lever.particles.into_iter().zip(turns).zip(inverse_mass) {
                if *w > 0.0 {
                    let slot = &q[k as usize];
                    slot.store(slot.load() - *w * turn);
                }
            }
        }
    }

    /// Largest change any row alone would still ask for.
    pub(super) fn residual<S: Slot>(
        &self,
        bias: &[DVec3],
        impulses: &[Impulse],
        has_friction: bool,
        q: &[S],
    ) -> f64 {
        let rows = self.rows.iter().zip(bias).zip(impulses);
        rows.map(|((row, bias), impulse)| {
            change(row, *impulse, self.relax(row, *bias, *impulse, has_friction, 1.0, q))
        })
        .fold(0.0, f64::max)
    }

    /// The impulse that a row alone would have, with `share` of its steps.
    #[inline]
    pub(super) fn relax<S: Slot>(
        &self,
        row: &PackedRow,
        bias: DVec3,
        impulse: Impulse,
        has_friction: bool,
        share: f64,
        q: &[S],
    ) -> Impulse {
        let [at, at_surface] = self.relative(row, bias, q);
        let approach = at.dot(row.normal);
        let normal = (impulse.normal + share * row.normal_step * approach).max(0.0);
        if !has_friction || row.friction <= 0.0 {
            return Impulse { normal, tangent: DVec3::ZERO };
        }
        let slip = at_surface - at_surface.dot(row.normal) * row.normal;
        let sticking = impulse.tangent + share * row.tangent_step * slip;
        Impulse { normal, tangent: within_disc(sticking, row.friction * normal) }
    }

    fn levers_of(&self, row: &PackedRow) -> &[PackedTorqueArm] {
        &self.levers[row.levers[0] as usize..row.levers[1] as usize]
    }

    fn bias(&self, level: SolveLevel, q: &[DVec3]) -> Vec<DVec3> {
        let each = self.rows.iter().zip(&self.origins);
        each.map(|(row, origin)| self.bias_of(level, row, origin, q)).collect()
    }

    /// b: the part of Q_c that the solution does not change, less the approach
    /// that the proximity factor leaves.
    fn bias_of(&self, level: SolveLevel, row: &PackedRow, origin: &Origin, q: &[DVec3]) -> DVec3 {
        let terms = &self.fixed[origin.fixed[0] as usize..origin.fixed[1] as usize];
        let fixed: DVec3 = terms.iter().map(|t| t.weight * q[t.particle as usize]).sum();
        let given = match level {
            SolveLevel::Position => return fixed + origin.depth * row.normal,
            SolveLevel::Velocity => fixed + origin.anchor[0],
            SolveLevel::Acceleration => fixed + origin.anchor[1],
        };
        let moving: DVec3 =
            self.terms_of(row).iter().map(|t| t.weight * q[t.particle as usize]).sum();
        let approach = (given + moving).dot(row.normal).max(0.0);
        let factor = (1.0 + origin.depth / origin.law.margins().proximity()).clamp(0.0, 1.0);
        given - (1.0 - factor) * approach * row.normal
    }

    fn push(&mut self, number: u32, row: &ContactRow<'_>, levers: &[TorqueArmRow]) {
        let starts = [self.terms.len(), self.levers.len(), self.fixed.len()].map(index);
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
        self.levers.extend(levers.iter().map(|&lever| PackedTorqueArm {
            lever,
            inverse_mass: lever.particles.map(|k| self.inverse_mass[k as usize]),
        }));
        let mut packed = PackedRow {
            normal: row.normal,
            normal_step: compliance.recip(),
            tangent_step: compliance.recip(),
            friction: row.law.friction(),
            terms: [starts[0], index(self.terms.len())],
            levers: [starts[1], index(self.levers.len())],
        };
        if !levers.is_empty() {
            packed.tangent_step = self.tangent_compliance(&packed).recip();
        }
        self.rows.push(packed);
        self.origins.push(Origin {
            row: number,
            depth: row.depth,
            law: row.law,
            anchor: [row.anchor.velocity, row.anchor.acceleration],
            fixed: [starts[2], index(self.fixed.len())],
        });
    }

    /// Largest slip that a unit impulse in the tangent plane gives, along
    /// itself.
    fn tangent_compliance(&self, row: &PackedRow) -> f64 {
        let tangents = row.normal.any_orthonormal_pair();
        let [along, across] = [tangents.0, tangents.1].map(|tangent| self.response(row, tangent));
        let (a, d) = (along.dot(tangents.0), across.dot(tangents.1));
        let b = along.dot(tangents.1);
        0.5 * (a + d) + (0.25 * (a - d) * (a - d) + b * b).sqrt()
    }

    /// Q_c at the surface point when P̄ is given a unit impulse along `tangent`.
    fn response(&self, row: &PackedRow, tangent: DVec3) -> DVec3 {
        let mut local: Vec<(u32, DVec3)> = Vec::new();
        let mut add = |k: u32, by: DVec3| match local.iter_mut().find(|(other, _)| *other == k) {
            Some((_, q)) => *q += by,
            None => local.push((k, by)),
        };
        for term in self.terms_of(row) {
            add(term.particle, term.step * tangent);
        }
        for PackedTorqueArm { lever, inverse_mass } in self.levers_of(row) {
            let turns = lever.impulses(tangent);
            for ((k, turn), w) in lever.particles.into_iter().zip(turns).zip(inverse_mass) {
                add(k, *w * turn);
            }
        }
        let q = |k: u32| local.iter().find(|(other, _)| *other == k).map_or(DVec3::ZERO, |e| e.1);
        let at: DVec3 = self.terms_of(row).iter().map(|t| t.weight * q(t.particle)).sum();
        self.levers_of(row).iter().fold(at, |at, lever| at + lever.lever.gather(q))
    }
}

/// Change of Q_c that goes with a change of impulse.
#[inline]
pub(super) fn change(row: &PackedRow, from: Impulse, to: Impulse) -> f64 {
    let normal = (to.normal - from.normal).abs() / row.normal_step;
    let tangent = (to.tangent - from.tangent).length() / row.tangent_step;
    normal.max(tangent)
}

/// Levers in order of rows, found by row.
struct TorqueArmsByRow<'a>(&'a [TorqueArmRow]);

impl<'a> TorqueArmsByRow<'a> {
    fn new(rows: &'a ContactRows) -> Self {
        Self(rows.levers())
    }

    fn of(&self, row: u32) -> &'a [TorqueArmRow] {
        let Range { start, end } =
            self.0.partition_point(|l| l.row < row)..self.0.partition_point(|l| l.row <= row);
        &self.0[start..end]
    }
}

fn arrange(
    rows: &ContactRows,
    movable: &[u32],
    levers: &TorqueArmsByRow<'_>,
    inverse_mass: &[f64],
    order: SweepOrder,
) -> Coloring {
    let count = index(movable.len());
    if order == SweepOrder::Given {
        return uncolored(count);
    }
    color(count, rows.particle_count(), |place, visit| {
        let number = movable[place as usize];
        let terms = rows.row(number as usize).terms;
        let of_levers = levers.of(number).iter().flat_map(|lever| lever.particles);
        let all = terms.iter().map(|term| term.particle).chain(of_levers);
        all.filter(|&k| inverse_mass[k as usize] > 0.0).for_each(visit);
    })
}

fn moves(term: &Term, inverse_mass: &[f64]) -> bool {
    term.weight * term.weight * inverse_mass[term.particle as usize] > 0.0
}

/// The nearest impulse that does not pull and is within the disc.
fn admissible(row: &PackedRow, impulse: Impulse, has_friction: bool) -> Impulse {
    let normal = impulse.normal.max(0.0);
    if !has_friction {
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
