//! Rows of a contact step at one level, and their solution.

use glam::DVec3;
use surface::{Contact, Term};

use super::StepParams;
use crate::{
    Combinations, Constraint, ContactLaw, ContactRows, ContactSet, ContactSystem, Impulse,
    Material, ResponseError, SolveLevel, SolveReport, SolverMemory,
};

/// Solver of the rows of one level, in memory that all levels share.
#[derive(Clone, Debug, Default)]
pub(super) struct RowSolver {
    rows: ContactRows,
    system: ContactSystem,
    memory: SolverMemory,
    /// Contact of each row.
    of_rows: Vec<usize>,
    row_impulses: Vec<Impulse>,
    /// Terms of a row without combined particles.
    terms: Vec<Term>,
    /// Impulses of all contacts: to start from, then the result.
    pub(super) impulses: Vec<Impulse>,
}

/// Row of a contact, in the state that it is solved in.
pub(super) type Row = (Contact, (ContactLaw, Constraint));

impl RowSolver {
    /// Replaces the rows by those that `row` makes of the contacts and their numbers; `None` for
    /// contacts that do not act.
    pub(super) fn set_rows(
        &mut self,
        particle_count: usize,
        contacts: &ContactSet,
        combinations: &Combinations,
        row: impl Fn(usize, &Contact, &Material) -> Result<Option<Row>, ResponseError>,
    ) -> Result<(), ResponseError> {
        // Rows keep the order of contacts, and say which one they are of.
        self.rows.clear(particle_count);
        self.of_rows.clear();
        for (number, (contact, material)) in contacts.iter().enumerate() {
            if let Some((contact, (law, constraint))) = row(number, contact, material)? {
                combinations.expand(contact.stencil.terms(), &mut self.terms);
                self.rows.push_terms(&contact, &self.terms, law, constraint)?;
                self.of_rows.push(number);
            }
        }
        Ok(())
    }

    /// Checks materials and contacts, all of them, so that errors name these by their place.
    pub(super) fn check(
        &mut self,
        particle_count: usize,
        contacts: &ContactSet,
        combinations: &Combinations,
    ) -> Result<(), ResponseError> {
        for group in contacts.groups() {
            group.material.validate()?;
        }
        self.set_rows(particle_count, contacts, combinations, |_, contact, material| {
            Ok(Some((*contact, material.position_row(contact)?)))
        })
    }

    /// Corrects `q` by the rows.
    pub(super) fn solve(
        &mut self,
        level: SolveLevel,
        q: &mut [DVec3],
        inverse_mass: &[f64],
        params: &StepParams,
    ) -> Result<SolveReport, ResponseError> {
        // Impulses to start from, of the contacts that have a row.
        self.row_impulses.clear();
        for &number in &self.of_rows {
            self.row_impulses.push(self.impulses[number]);
        }
        self.system.rebuild(&self.rows, inverse_mass, params.order)?;
        let (memory, impulses) = (&mut self.memory, &mut self.row_impulses);
        let report = self.system.solve_in(memory, level, q, impulses, &params.solver)?;

        // Contacts without a row end without an impulse.
        self.impulses.fill(Impulse::default());
        for (&number, &impulse) in self.of_rows.iter().zip(&self.row_impulses) {
            self.impulses[number] = impulse;
        }
        Ok(report)
    }

    /// Computes the work of all that moves as prescribed, rigid objects and fixed particles: the
    /// impulses that they give times their velocities.
    pub(super) fn prescribed_work(&self, v: &[DVec3], inverse_mass: &[f64]) -> f64 {
        let mut work = 0.0;
        for (row, impulse) in self.rows.iter().zip(&self.row_impulses) {
            let mut velocity = row.anchor.velocity;
            for &Term { particle, weight } in row.terms {
                if inverse_mass[particle as usize] <= 0.0 {
                    velocity += weight * v[particle as usize];
                }
            }
            work += (impulse.normal * row.normal + impulse.tangent).dot(velocity);
        }
        work
    }
}
