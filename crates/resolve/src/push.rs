//! Displacements of one round after the elastic ones, in which crossing edges come apart.

use glam::DVec3;
use response::{ContactLaw, Margins, SolverMethod, SolverParams};
use scene::{BodyId, PairReport};
use surface::progress::{Interrupted, Progress};
use surface::{Contact, parallel};

use crate::contact_islands::ContactIslands;
use crate::count::as_f64;
use crate::detection::{clearance, detection_margin};
use crate::exit_patches::{PatchSide, direct_patches};
use crate::exit_sides::{ExitSide, PairMemory};
use crate::near_pairs::NearPair;
use crate::near_pieces::near_pieces;
use crate::run::Run;
use crate::self_contacts::SelfSurface;
use crate::tissue::{Tissue, fitted_tree};
use crate::{ResolveError, ResolveParams};

/// Sweeps of the contact solver for the first push of a round. Below, stacked bodies are
/// not separated in one round; above, rounds take longer.
const FIRST_SOLVER_SWEEPS: u32 = 30;

/// Sweeps of the contact solver after shape is restored, which start near a solution.
const NEXT_SOLVER_SWEEPS: u32 = 6;

/// Alternations of shape restoration and separation per round. Below, tissue ends folded or
/// overlapping; above, rounds take longer and later rounds find little left to do.
const SHAPE_PASSES: u32 = 2;

/// Correction at which the contact solver stops \[tolerances\]. Below, sweeps change nothing
/// that is measured; above, the sum of many small remainders exceeds the tolerance.
const SOLVER_TOLERANCE: f64 = 2e-3;

impl Run<'_> {
    /// Computes displacements that separate all contacts, or as far as one round goes, and
    /// that keep tissue in shape.
    pub(crate) fn push(&mut self) -> Result<(), ResolveError> {
        // Contacts alone, then the tissue around them.
        self.start_round();
        let islands = self.contact_islands()?;
        self.separate(&islands, FIRST_SOLVER_SWEEPS)?;
        let smoothing = self.params.smoothing;
        self.for_each_soft(|tissue, tree, progress| tissue.spread(tree, smoothing, progress))?;

        // Restoring shape and separating contacts alternate: each undoes some of the other.
        let max_strain = round_strain(self.rounds.len(), &self.params);
        for _ in 0..SHAPE_PASSES {
            self.alter_soft(|tissue, x, progress| tissue.limit_strain(max_strain, x, progress))?;
            self.separate(&islands, NEXT_SOLVER_SWEEPS)?;
        }

        // What separation has left is made safe, and volume is given back.
        self.alter_soft(|tissue, x, progress| tissue.stiffen(x, progress))?;
        self.clamp();
        self.alter_soft(|tissue, x, _| {
            tissue.restore_volume(x);
            Ok(())
        })?;
        Ok(())
    }

    /// Changes the positions that this round moves soft tissues to.
    pub(crate) fn alter_soft(
        &mut self,
        change: impl Fn(&Tissue, &mut [DVec3], Progress<'_>) -> Result<(), Interrupted> + Sync + Send,
    ) -> Result<(), Interrupted> {
        self.for_each_soft(|tissue, tree, progress| {
            tissue.alter(tree, |tissue, x| change(tissue, x, progress))
        })
    }

    /// Resets displacements, and updates normals and nearness of all vertices.
    pub(crate) fn start_round(&mut self) {
        let bodies = self.scene.bodies();
        parallel::map_mut_costly_first(&mut self.tissues, Tissue::cost, |tissue| {
            let x = bodies[tissue.id.index()].positions();
            tissue.normals = tissue.outward_normals(x);
            tissue.u.fill(DVec3::ZERO);
            tissue.is_near.fill(false);
        });

        // Vertices near another body are not free to give volume back.
        for (body, report) in self.near.iter().flat_map(NearPair::sides) {
            for near in &report.near {
                self.tissues[body.index()].is_near[near.vertex as usize] = true;
            }
        }
    }

    /// Collects the contacts to solve, cut to corrections of one step.
    fn contact_islands(&mut self) -> Result<ContactIslands, ResolveError> {
        let max_step = self.params.max_step();
        let law = ContactLaw::new(Margins::new(clearance(&self.params), max_step)?, 0.0)?;

        // Deeper overlaps than a step are left to later rounds.
        let mut contacts = self.contacts()?;
        for list in &mut contacts {
            *list = self.ties.seams.contacts(std::mem::take(list));
            for contact in list {
                contact.gap = contact.gap.max(-max_step);
            }
        }
        let all: Vec<&Contact> = contacts.iter().flatten().collect();
        Ok(ContactIslands::new(&all, law, &self.inverse_masses)?)
    }

    /// Collects the contacts of each pair, then those of bodies with themselves and of corners of cells, and updates
    /// exit directions.
    pub(crate) fn contacts(&mut self) -> Result<Vec<Vec<Contact>>, Interrupted> {
        // Memories are taken out, to be changed while the tissues are shared.
        let mut pairs: Vec<(&NearPair, PairMemory)> = Vec::new();
        for pair in self.near.iter() {
            let memory = self.pair_memories.remove(&pair.report.pair);
            pairs.push((pair, memory.unwrap_or_default()));
        }
        let progress = self.round_progress();
        let cost = |(pair, _): &(&NearPair, _)| pair.cost();
        let contacts = parallel::map_mut_costly_first(&mut pairs, cost, |(pair, memory)| {
            progress.report(0.0)?;
            Ok(self.pair_contacts(pair, memory))
        });
        for (pair, memory) in pairs {
            self.pair_memories.insert(pair.report.pair, memory);
        }

        let contacts: Result<Vec<_>, Interrupted> = contacts.into_iter().collect();
        let mut contacts = contacts?;
        contacts.push(self.self_contacts()?);
        contacts.push(self.corner_contacts());
        Ok(contacts)
    }

    /// Makes the contacts of all bodies that are to be uncrossed.
    pub(crate) fn self_contacts(&self) -> Result<Vec<Contact>, Interrupted> {
        let (margin, progress) = (detection_margin(&self.params), self.round_progress());
        let mut contacts = Vec::new();
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            if tissue.crossings_to_resolve.is_some() && !tissue.is_rigid {
                let own = SelfSurface::new(tissue, fitted_tree(body));
                contacts.extend(own.contacts(body, margin, progress)?);
            }
        }
        Ok(contacts)
    }

    /// Makes the contacts of one pair.
    fn pair_contacts(
        &self,
        NearPair { report, edges }: &NearPair,
        memory: &mut PairMemory,
    ) -> Vec<Contact> {
        let [a, b] = report.pair.bodies();
        let mut contacts = self.exit_contacts(report, memory);

        // Edges come free with deep vertices, and until then mean little.
        if self.uses_edges(report) {
            contacts.extend_from_slice(edges);
            // Elastic rounds take all pushes anew, and give up some of them.
            if self.rounds.len() > self.elastic_rounds() {
                let bodies = [a, b].map(|id| self.scene.body(id));
                memory.pushes.direct(bodies, &report.crossing_faces, &mut contacts);
            }
        }

        // Where bodies are tied they touch: they are not pushed farther apart than that.
        if self.is_tied(report.pair) {
            for contact in &mut contacts {
                if self.is_of_tie(contact) {
                    contact.gap += clearance(&self.params);
                }
            }
        }
        contacts
    }

    /// Makes the contacts of a pair's vertices, piece by piece.
    fn exit_contacts(&self, report: &PairReport, memory: &mut PairMemory) -> Vec<Contact> {
        let ids = report.pair.bodies();
        let mut contacts = Vec::new();
        for (pieces, found) in near_pieces(ids.map(|id| &self.tissues[id.index()]), report) {
            let exits = memory.exits.entry(pieces).or_default();
            let sides = [0, 1].map(|side: usize| PatchSide {
                tissue: &self.tissues[ids[side].index()],
                tree: fitted_tree(self.scene.body(ids[side])),
                near: &found.near[side],
                piece: pieces[side],
                seam_faces: &self.near.seam_faces,
            });
            direct_patches(sides, &found.crossing_faces, exits);
            for (side, other) in [(0, 1), (1, 0)] {
                let exit_side = self.exit_side(ids[side], ids[other], pieces[other]);
                contacts.extend(exit_side.contacts(&found.near[side], &mut exits[side]));
            }
        }
        contacts
    }

    /// Returns true if a pair is so shallow that contacts of its edges are used.
    pub(crate) fn uses_edges(&self, report: &PairReport) -> bool {
        report.max_vertex_depth <= self.params.tuning.shallow_depth * self.params.smoothing
    }

    fn exit_side(&self, body: BodyId, other: BodyId, other_piece: u32) -> ExitSide<'_> {
        ExitSide {
            tissue: &self.tissues[body.index()],
            other_tissue: &self.tissues[other.index()],
            other_piece,
            body: self.scene.body(body),
            other: self.scene.body(other),
            smoothing: self.params.smoothing,
        }
    }

    /// Corrects the displacements of all particles by the contact solver.
    fn separate(
        &mut self,
        islands: &ContactIslands,
        max_iterations: u32,
    ) -> Result<(), ResolveError> {
        self.round_progress().report(0.0)?;

        // The solver takes the displacements of all particles in one list.
        let tolerance = SOLVER_TOLERANCE * self.params.tolerance;
        let params = SolverParams { method: SolverMethod::GaussSeidel, max_iterations, tolerance };
        let mut all = Vec::with_capacity(self.inverse_masses.len());
        for tissue in &self.tissues {
            all.extend_from_slice(&tissue.u);
        }
        self.ties.seams.join(&mut all);
        islands.solve(&mut all, &params)?;
        self.ties.seams.lead(&mut all);

        // Each tissue takes its own part back.
        let mut rest = &all[..];
        for tissue in &mut self.tissues {
            let (part, others) = rest.split_at(tissue.u.len());
            tissue.u.copy_from_slice(part);
            rest = others;
        }
        self.clamp();
        Ok(())
    }

    /// Shortens the displacements to one step.
    pub(crate) fn clamp(&mut self) {
        let max_step = self.params.max_step();
        for u in self.tissues.iter_mut().flat_map(|tissue| &mut tissue.u) {
            *u = u.clamp_length_max(max_step);
        }
        self.follow_ties();
    }
}

/// Returns the limit on strain in a round: it widens where the rounds before have found no gentler way.
fn round_strain(rounds: usize, params: &ResolveParams) -> f64 {
    (params.tuning.strain_growth * as_f64(rounds)).min(1.0) * params.max_strain
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::{BodyKind, Scene};

    use super::*;

    use crate::{Conditions, Tie};

    #[test]
    fn the_limit_on_strain_widens_from_round_to_round_up_to_the_maximum() {
        let params = ResolveParams { max_strain: 2.0, ..ResolveParams::with_smoothing(6.0) };
        for (rounds, limit) in [(0, 0.0), (1, 0.2), (5, 1.0), (10, 2.0), (60, 2.0)] {
            assert!((round_strain(rounds, &params) - limit).abs() < 1e-12, "{rounds} rounds");
        }
    }

    /// Two soft cubes that share a face, with a bone in one of them.
    #[test]
    fn the_contact_solver_moves_particles_at_one_place_as_one() {
        let mut scene = Scene::new();
        let mut ids = Vec::new();
        for (name, kind, size, place) in [
            ("left", BodyKind::Deformable, 2.0, DVec3::new(-1.0, 0.0, 0.0)),
            ("right", BodyKind::Deformable, 2.0, DVec3::new(1.0, 0.0, 0.0)),
            ("bone", BodyKind::Rigid, 0.5, DVec3::new(0.9, 0.1, -1.1)),
        ] {
            let cube = shapes::cube(size).translated(place);
            ids.push(scene.add(name, kind, cube.surface(), cube.positions).expect("a body"));
        }
        let ties = vec![Tie { bodies: [ids[0], ids[1]], distance: f64::MIN_POSITIVE }];
        let conditions = Conditions { ties, ..Conditions::default() };
        let params = ResolveParams::with_smoothing(6.0);
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        run.start_round();
        let islands = run.contact_islands().expect("contacts");
        run.separate(&islands, FIRST_SOLVER_SWEEPS).expect("displacements");

        let u: Vec<DVec3> = run.tissues.iter().flat_map(|tissue| tissue.u.clone()).collect();
        assert_eq!(run.ties.seams.points().len(), 4);
        let mut pushed = 0;
        for point in run.ties.seams.points() {
            let [first, second] = [point[0], point[1]].map(|particle| u[particle as usize]);
            assert_eq!(first, second);
            pushed += usize::from(first != DVec3::ZERO);
        }
        assert!(pushed > 0, "the seam is pushed");
    }
}
