//! Corrections of positions, round after round.

use glam::DVec3;

use super::{ContactStep, StepParams, StepReport};
use crate::{Impulse, ResponseError, SolveLevel};

impl ContactStep {
    /// Adds the contacts that the last correction has pushed apart, unless they were detected
    /// again.
    ///
    /// At a crease, each detection finds one of two sides. If the correction for one could undo
    /// that for the other, they would take turns without an end.
    pub(super) fn hold_pushed(&mut self, x: &[DVec3], inverse_mass: &[f64]) {
        self.pushed.follow(x);
        self.contacts.append_unlike(&self.pushed, &mut self.normals);
        self.weigh(inverse_mass);
    }

    /// Stores the contacts that a correction has pushed apart from depths beyond a tolerance.
    pub(super) fn remember_pushed(&mut self, tolerance: f64) {
        let Self { pushed, contacts, solver, detected, .. } = self;
        pushed.copy_chosen(contacts, |number, contact, material| {
            let was_deep = number >= *detected || material.depth(contact) > tolerance;
            let is_pushed = solver.impulses[number].normal > 0.0;
            was_deep && is_pushed && material.permanent.is_none()
        });
    }

    /// Corrects positions once, by all hard contacts.
    pub(super) fn correct_positions(
        &mut self,
        x: &mut [DVec3],
        inverse_mass: &[f64],
        params: &StepParams,
        report: &mut StepReport,
    ) -> Result<(), ResponseError> {
        self.displacements.clear();
        self.displacements.resize(x.len(), DVec3::ZERO);
        self.solver.impulses.clear();
        self.solver.impulses.resize(self.contacts.contacts().len(), Impulse::default());
        self.solver.set_rows(
            x.len(),
            &self.contacts,
            &self.combinations,
            |_, contact, material| {
                let row = material.position_row(contact)?;
                Ok(material.is_hard().then_some((*contact, row)))
            },
        )?;
        let (level, moved) = (SolveLevel::Position, &mut self.displacements);
        report.positions = Some(self.solver.solve(level, moved, &self.lumped, params)?);
        self.next.clear();
        self.next.resize(x.len(), DVec3::ZERO);
        self.followers.follow(&self.follows, &self.next, moved);
        self.combinations.apply(moved);
        report.rounds += 1;

        // What positions gain in potential energy is reported by the mass moved.
        for ((x, moved), w) in x.iter_mut().zip(&self.displacements).zip(inverse_mass) {
            *x += *moved;
            if *w > 0.0 {
                report.mass_moved += *moved / *w;
            }
        }
        Ok(())
    }
}
