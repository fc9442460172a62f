//! Response to the contacts of a frame: soft bodies move apart.

use decimate::CoarseSurface;
use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ContactSystem, Margins, ResponseError, SolveLevel, SolveReport,
    SolverParams, SweepOrder,
};
use scene::Scene;

use crate::{Detection, Plan, PlanError};

/// Parameters of a response.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RespondParams {
    /// Gap to which contacts are pushed apart, `>= 0`, in the length unit.
    pub clearance: f64,
    /// Parameters of the contact solver.
    pub solver: SolverParams,
}

impl Plan {
    /// Moves the vertices of soft bodies so that the contacts of a frame separate: all contacts
    /// at once, with equal masses. Vertices that a coarse surface has not kept follow it.
    ///
    /// One call corrects positions once; the next detection finds the contacts that this makes.
    /// Overlap removal (the crate `resolve`) repeats both until nothing overlaps, and keeps
    /// shapes and volumes.
    ///
    /// # Errors
    ///
    /// [`PlanError::OtherScene`], [`PlanError::Polygons`], and [`PlanError::Response`] for parameters out of range.
    pub fn respond(
        &self,
        scene: &mut Scene,
        detection: &Detection,
        params: &RespondParams,
    ) -> Result<SolveReport, PlanError> {
        self.check_scene(scene)?;
        if let Some(body) = scene.bodies().iter().find(|body| body.has_moving_centers()) {
            return Err(PlanError::Polygons { name: body.name().to_owned() });
        }
        let (displacements, report) = displacements(scene, detection, params)?;

        // Each body takes its own part; vertices that were not kept follow those that were.
        for id in scene.ids() {
            let body = scene.body(id);
            let particles = body.particles();
            let mut u = displacements[particles.start as usize..particles.end as usize].to_vec();
            if let Some(coarse) = self.structures.coarse(id) {
                follow_kept(coarse, &mut u);
            }
            if !body.is_rigid() && u.iter().any(|&u| u != DVec3::ZERO) {
                let x: Vec<DVec3> = body.positions().iter().zip(&u).map(|(x, u)| x + u).collect();
                scene.move_body(id, &x)?;
            }
        }
        Ok(report)
    }
}

/// Moves the vertices that a coarse surface has not kept with it, unless contacts of the body's own
/// surface move them.
fn follow_kept(coarse: &CoarseSurface, displacements: &mut [DVec3]) {
    let own = displacements.to_vec();
    coarse.spread(displacements);
    for (displacement, own) in displacements.iter_mut().zip(own) {
        if own != DVec3::ZERO {
            *displacement = own;
        }
    }
}

/// Solves the contacts of a frame for the displacements of all particles.
fn displacements(
    scene: &Scene,
    detection: &Detection,
    params: &RespondParams,
) -> Result<(Vec<DVec3>, SolveReport), ResponseError> {
    // Equal masses, and none that moves for rigid bodies.
    let mut inverse_masses = Vec::new();
    for body in scene.bodies() {
        let inverse_mass = if body.is_rigid() { 0.0 } else { 1.0 };
        inverse_masses.resize(inverse_masses.len() + body.positions().len(), inverse_mass);
    }

    // Hard corrections have no proximity force, but a law must have a margin for one.
    let law = ContactLaw::new(Margins::new(params.clearance, 1.0)?, 0.0)?;
    let mut rows = ContactRows::new(inverse_masses.len());
    rows.extend(detection.contacts(), law)?;

    // All contacts at once, from rest.
    let system = ContactSystem::new(&rows, &inverse_masses, SweepOrder::Given)?;
    let mut displacements = vec![DVec3::ZERO; inverse_masses.len()];
    let mut impulses = system.no_impulses();
    let report =
        system.solve(SolveLevel::Position, &mut displacements, &mut impulses, &params.solver)?;
    Ok((displacements, report))
}
