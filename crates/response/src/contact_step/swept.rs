//! Contacts that a step meets between its positions and those at the end of the move.

use glam::DVec3;

use super::{ContactStep, StepParams, StepReport, SweptReport, relative_velocity};
use crate::{ContactSet, ResponseError, check};

impl ContactStep {
    /// Corrects velocities again, by contacts that are met between the present positions and those
    /// at the end of the move, x + h v, after [`Self::correct`] of the same step: none tunnels
    /// through another.
    ///
    /// `sweep` adds the contacts of that move at the velocities given, with the
    /// [time](surface::Contact::time) at which each begins and the gap of the *present*
    /// positions along its normal. A velocity may close that gap, and no more. Corrected
    /// velocities may meet other contacts, so that it sweeps again, up to `max_rounds` times.
    /// Where contacts are left then, the move is free up to [`SweptReport::free_share`], and the
    /// caller may stop there. Replaces what `report` has of velocities. Loads are not corrected.
    ///
    /// # Errors
    ///
    /// As [`Self::correct`].
    pub fn correct_swept<E: From<ResponseError>>(
        &mut self,
        v: &mut [DVec3],
        inverse_mass: &[f64],
        params: &StepParams,
        report: &mut StepReport,
        mut sweep: impl FnMut(&[DVec3], &mut ContactSet) -> Result<(), E>,
    ) -> Result<SweptReport, E> {
        check::particles("velocity", self.start.len(), v)?;
        check::inverse_masses(v.len(), inverse_mass)?;
        params.validate()?;
        let mut swept_report = SweptReport::default();
        self.known.clear();
        let allowed = params.approach_tolerance.unwrap_or(0.0) + params.solver.tolerance;
        loop {
            self.swept.clear();
            sweep(v, &mut self.swept)?;
            self.solver.check(v.len(), &self.swept, &self.combinations)?;

            // Those that velocities do not respect yet, and the first of them.
            let found = self.swept.retain_swept(|contact, material| {
                let velocity = relative_velocity(contact, v);
                material.forbidden_speed(contact, velocity, params.h) > allowed
            });
            swept_report.free_share = found.unwrap_or(1.0);
            if found.is_none() || swept_report.rounds == params.max_rounds {
                break;
            }
            swept_report.rounds += 1;
            swept_report.contacts += self.contacts.append_new(&self.swept, &mut self.known);

            // All contacts of the step together, from the velocities before them.
            self.weigh(inverse_mass);
            self.solve_velocities(v, inverse_mass, params, report)?;
        }
        report.contacts = self.contacts.contacts().len();
        Ok(swept_report)
    }
}
