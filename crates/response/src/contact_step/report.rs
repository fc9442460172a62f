//! Report of a contact step.

use glam::DVec3;

use crate::SolveReport;

/// Report of a contact step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StepReport {
    /// Number of contacts as detected last.
    pub contacts: usize,
    /// Number of corrections of positions.
    pub rounds: u32,
    /// Largest depth of hard contacts at the start.
    pub depth_before: f64,
    /// Largest depth of hard contacts as detected last.
    pub depth: f64,
    /// Largest speed of approach of hard contacts, times λ, before velocities are corrected.
    pub approach_before: f64,
    /// The same after.
    pub approach: f64,
    /// Last solution for positions, where one was needed.
    pub positions: Option<SolveReport>,
    /// Solution for velocities, where one was needed.
    pub velocities: Option<SolveReport>,
    /// Solution for the velocities after the move, where accelerations or forces were to be
    /// corrected.
    pub loads: Option<SolveReport>,
    /// Σ m Δx of the corrections of positions over the particles that can move: times
    /// gravity, the energy that they add.
    pub mass_moved: DVec3,
    /// Σ m Δv of the correction of velocities: the momentum given by rigid objects and fixed
    /// particles.
    pub impulse: DVec3,
    /// Σ m Δa of the correction of accelerations or forces: the force of rigid objects and
    /// fixed particles.
    pub force: DVec3,
    /// Change of the kinetic energy by the correction of velocities.
    pub kinetic_energy: f64,
    /// Work of rigid objects and fixed particles that move, in the correction of velocities. Hard
    /// contacts that are solved only dissipate: the kinetic energy grows by at most this work.
    pub rigid_work: f64,
    /// Energy k δ² / 2 of soft contacts at the start of the move.
    pub contact_energy: f64,
}

/// Report of the contacts that are met during the move of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SweptReport {
    /// Number of corrections of velocities.
    pub rounds: u32,
    /// Number of contacts that were added to those of the step.
    pub contacts: usize,
    /// Share of the move, in `0.0..=1.0`, before which no contact begins that the corrected
    /// velocities do not respect: 1 where all are respected.
    pub free_share: f64,
}
