//! Displacements of one round.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use response::{
    ContactLaw, ContactRows, ContactSystem, Margins, SolveLevel, SolverMethod, SolverParams,
    SweepOrder,
};
use scene::{BodyId, Scene};
use surface::{Contact, parallel};

use crate::exit_sides::{ExitMemory, ExitSides};
use crate::near_pairs::NearPair;
use crate::run::Run;
use crate::tissue::{Tissue, fitted_tree};
use crate::{ResolveError, spread, strain, tuning, volume};

/// Soft body with its part of a vector over all particles.
struct SoftPart<'a, T> {
    id: BodyId,
    tree: &'a SurfaceTree,
    tissue: T,
    u: &'a mut [DVec3],
}

impl Run<'_> {
    /// Computes displacements that separate all contacts, or as far as one round goes, and
    /// that keep tissue in shape.
    pub(crate) fn push(&mut self) -> Result<Vec<DVec3>, ResolveError> {
        let max_step = tuning::MAX_STEP * self.params.smoothing;
        let looseness = looseness(self.rounds.len());
        let rows = self.contact_rows(max_step)?;
        let system = ContactSystem::new(&rows, &self.inverse_masses, SweepOrder::Colored)?;

        let mut u = vec![DVec3::ZERO; self.inverse_masses.len()];
        self.separate(&system, &mut u, tuning::FIRST_SOLVER_SWEEPS)?;
        self.spread(&mut u)?;

        // Restoring shape and separating contacts alternate: each undoes some of the other.
        for pass in 0..tuning::SHAPE_PASSES {
            self.alter(&mut u, |part, x| self.restore_shape(part, x, looseness, pass == 0))?;
            self.separate(&system, &mut u, tuning::NEXT_SOLVER_SWEEPS)?;
        }

        self.alter(&mut u, |part, x| strain::stiffen(part.tissue, x))?;
        clamp(&mut u, max_step);
        self.alter(&mut u, |part, x| volume::restore(part.tissue, x, &self.near, part.id))?;
        Ok(u)
    }

    /// Moves tissue, and returns for each body whether it moved.
    pub(crate) fn move_by(&mut self, u: &[DVec3]) -> Result<Vec<bool>, ResolveError> {
        let mut moved = vec![false; self.tissues.len()];
        for id in self.scene.ids() {
            let body = self.scene.body(id);
            let particles = body.particles();
            let part = &u[particles.start as usize..particles.end as usize];
            if !body.is_rigid() && part.iter().any(|&u| u != DVec3::ZERO) {
                let x: Vec<DVec3> = body.positions().iter().zip(part).map(|(x, u)| x + u).collect();
                self.scene.move_body(id, &x)?;
                moved[id.index()] = true;
            }
        }
        Ok(moved)
    }

    /// Collects the contacts to solve; none asks for more than a step.
    fn contact_rows(&mut self, max_step: f64) -> Result<ContactRows, ResolveError> {
        let law = ContactLaw::new(Margins::new(self.params.clearance, max_step)?, 0.0)?;
        let mut rows = ContactRows::new(self.inverse_masses.len());
        for contact in self.contacts() {
            rows.push(&Contact { gap: contact.gap.max(-max_step), ..contact }, law)?;
        }
        Ok(rows)
    }

    /// Collects the contacts of all pairs, with vertices turned to the sides they entered by.
    fn contacts(&mut self) -> Vec<Contact> {
        let scene = &*self.scene;
        let smoothing = self.params.smoothing;
        let sides = ExitSides::new(scene, &self.tissues, smoothing);
        let mut pairs: Vec<(&NearPair, [ExitMemory; 2])> = Vec::new();
        for pair in self.near.iter() {
            let ids = pair.report.pair;
            pairs.push((pair, self.exit_memories.remove(&ids).unwrap_or_default()));
        }

        let contacts = parallel::map_mut(&mut pairs, |(pair, memory)| {
            let mut contacts = sides.contacts(&pair.report, memory);
            // Edges come free with deep vertices, and until then mean little.
            if pair.report.max_depth <= tuning::MAX_DEPTH_WITH_EDGES * smoothing {
                contacts.extend_from_slice(&pair.edges);
            }
            contacts
        });

        for (pair, memory) in pairs {
            self.exit_memories.insert(pair.report.pair, memory);
        }
        contacts.concat()
    }

    /// Corrects displacements by the solver of contacts.
    fn separate(
        &self,
        system: &ContactSystem,
        u: &mut [DVec3],
        max_iterations: u32,
    ) -> Result<(), ResolveError> {
        self.poll()?;
        let tolerance = tuning::SOLVER_TOLERANCE * self.params.tolerance;
        let params = SolverParams { method: SolverMethod::GaussSeidel, max_iterations, tolerance };
        system.solve(SolveLevel::Position, u, &mut system.no_impulses(), &params)?;
        clamp(u, tuning::MAX_STEP * self.params.smoothing);
        Ok(())
    }

    /// Spreads displacements to the tissue around.
    fn spread(&mut self, u: &mut [DVec3]) -> Result<(), ResolveError> {
        self.poll()?;
        let smoothing = self.params.smoothing;
        let mut parts = soft_parts(self.scene, &mut self.tissues, u);
        parallel::map_mut(&mut parts, |SoftPart { tree, tissue, u, .. }| {
            spread::spread(tree, tissue, u, smoothing, &mut Workspace::default());
        });
        Ok(())
    }

    /// Restores the shape of one body.
    fn restore_shape(
        &self,
        SoftPart { id, tree, tissue, .. }: &SoftPart<'_, &Tissue>,
        x: &mut [DVec3],
        looseness: f64,
        may_uncross: bool,
    ) {
        strain::limit_strain(tissue, looseness, x);
        if may_uncross && self.damage[id.index()].self_crossings > 0 {
            strain::uncross(tree, tissue, x);
        }
    }

    /// Changes the positions to which `u` moves soft bodies. Bodies that are neither moved nor
    /// spoilt are left out.
    fn alter(
        &self,
        u: &mut [DVec3],
        change: impl Fn(&SoftPart<'_, &Tissue>, &mut [DVec3]) + Sync,
    ) -> Result<(), ResolveError> {
        self.poll()?;
        let mut parts = soft_parts(self.scene, &self.tissues, u);
        parts.retain(|part| {
            let is_moved = part.u.iter().any(|&u| u != DVec3::ZERO);
            is_moved || self.damage[part.id.index()].is_spoilt()
        });

        parallel::map_mut(&mut parts, |part| {
            let from = part.tree.positions().as_slice();
            let x: Vec<DVec3> = from.iter().zip(&*part.u).map(|(&x, &u)| x + u).collect();
            let mut changed = x.clone();
            change(part, &mut changed);
            // Vertices that are not changed keep the bits of their displacement.
            for (v, u) in part.u.iter_mut().enumerate() {
                if changed[v] != x[v] {
                    *u = changed[v] - from[v];
                }
            }
        });
        Ok(())
    }
}

/// Returns the factor on the limits on strain: they widen where the first rounds have found
/// no gentler way.
fn looseness(rounds: usize) -> f64 {
    let later = u32::try_from(rounds.saturating_sub(tuning::FIRM_ROUNDS)).unwrap_or(u32::MAX);
    (1.0 + tuning::LOOSENING * f64::from(later)).min(tuning::MAX_LOOSENESS)
}

fn clamp(u: &mut [DVec3], max_length: f64) {
    for u in u {
        *u = u.clamp_length_max(max_length);
    }
}

/// Splits a vector over all particles into the parts of the soft bodies.
fn soft_parts<'a, T>(
    scene: &'a Scene,
    tissues: impl IntoIterator<Item = T>,
    mut u: &'a mut [DVec3],
) -> Vec<SoftPart<'a, T>> {
    let mut parts = Vec::new();
    for (id, tissue) in scene.ids().zip(tissues) {
        let body = scene.body(id);
        let (part, rest) = u.split_at_mut(body.positions().len());
        u = rest;
        if !body.is_rigid() {
            parts.push(SoftPart { id, tree: fitted_tree(body), tissue, u: part });
        }
    }
    parts
}
