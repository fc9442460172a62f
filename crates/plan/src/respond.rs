//! Contacts of a plan answered by moving what yields.

use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ContactSystem, Margins, SolveLevel, SolveReport, SolverParams,
    SweepOrder,
};

use super::{Detection, Plan};
use crate::PlanError;
use scene::{BodyKind, Scene};

/// How far apart bodies are moved, and how hard that is tried.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RespondParams {
    /// Gap that contacts are brought to, `>= 0`, in the length unit.
    pub clearance: f64,
    /// How contacts are solved together.
    pub solver: SolverParams,
}

impl Plan {
    /// Moves the vertices of bodies that are not rigid so that the contacts of a
    /// frame part: all contacts at once, each body's vertices yielding alike.
    /// What a reduced surface stands for goes where that goes.
    ///
    /// One call corrects positions once; contacts that this makes are found by
    /// the next detection. Overlap removal repeats both until nothing
    /// overlaps, and keeps shapes and volumes.
    ///
    /// # Errors
    ///
    /// [`PlanError::OtherScene`], and [`PlanError::Response`] for parameters out
    /// of range.
    pub fn respond(
        &self,
        scene: &mut Scene,
        detection: &Detection,
        params: &RespondParams,
    ) -> Result<SolveReport, PlanError> {
        self.check_scene(scene)?;
        let (moved, report) = displacements(scene, detection, params)?;
        for id in scene.ids() {
            let body = scene.body(id);
            if body.kind() == BodyKind::Rigid {
                continue;
            }
            let particles = body.particles();
            let mut own = moved[particles.start as usize..particles.end as usize].to_vec();
            if let Some(level) = &self.structures.levels[id.index()] {
                level.spread(&mut own);
            }
            if own.iter().all(|&by| by == DVec3::ZERO) {
                continue;
            }
            let x: Vec<DVec3> = body.positions().iter().zip(&own).map(|(x, by)| x + by).collect();
            scene.move_body(id, &x)?;
        }
        Ok(report)
    }
}

/// What each particle of the scene must go by.
fn displacements(
    scene: &Scene,
    detection: &Detection,
    params: &RespondParams,
) -> Result<(Vec<DVec3>, SolveReport), response::ResponseError> {
    let yields = |body: &scene::Body| if body.kind() == BodyKind::Rigid { 0.0 } else { 1.0 };
    let of_body = |body| std::iter::repeat_n(yields(body), body.positions().len());
    let inverse_mass: Vec<f64> = scene.bodies().iter().flat_map(of_body).collect();
    // Hard corrections know no proximity; a law must have one.
    let law = ContactLaw::new(Margins::new(params.clearance, 1.0)?, 0.0)?;
    let mut rows = ContactRows::new(inverse_mass.len());
    rows.extend(detection.contacts(), law)?;
    let system = ContactSystem::new(&rows, &inverse_mass, SweepOrder::Given)?;
    let mut moved = vec![DVec3::ZERO; inverse_mass.len()];
    let mut impulses = system.no_impulses();
    let report = system.solve(SolveLevel::Position, &mut moved, &mut impulses, &params.solver)?;
    Ok((moved, report))
}
