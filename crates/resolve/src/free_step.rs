//! Steps that are certainly free of contact.
//!
//! Continuous detection finds the first contacts on the way. Particles that meet are held back to
//! before their contact, by themselves: all others go on. Since that changes the way of their
//! neighbors, the step is swept again until nothing meets.

use ccd::CcdParams;
use glam::DVec3;
use kdop::Workspace;
use scene::{BodyMove, PairId, PairSweep};
use surface::progress::Interrupted;
use surface::{Contact, Meeting, parallel, triangles_meet};

use crate::ResolveError;
use crate::run::{Run, TOUCHING};
use crate::tissue::fitted_tree;

/// Share of the way to a contact that is taken. Far below, steps are many; near 1, the directions in which gaps
/// are opened next are those of points that nearly coincide.
pub(crate) const FREE_SHARE: f64 = 0.8;

/// Sweeps of a step in which single particles are held back, after which whole bodies are.
pub(crate) const MAX_HOLD_PASSES: usize = 8;

/// Displacements of a step, and what of them is taken.
struct FreeStep<'a> {
    displacements: &'a [DVec3],
    /// Part of its displacement that each particle takes.
    shares: Vec<f64>,
    /// Bodies whose way has changed since the last sweep.
    changed: Vec<bool>,
    /// Pairs that touch at the start and do not approach there.
    touching: Vec<PairId>,
    /// Outward normals of all particles at the start, once they are needed.
    outward: Option<Vec<DVec3>>,
}

impl Run<'_> {
    /// Moves soft bodies by the displacements of all particles, as far as nothing meets and no
    /// body leaves its limits; returns which bodies moved. Pairs that cross already, or are exempt, are not regarded.
    pub(crate) fn move_freely(
        &mut self,
        displacements: &[DVec3],
        crossing: &[PairId],
    ) -> Result<Vec<bool>, ResolveError> {
        let mut step = FreeStep {
            displacements,
            shares: vec![1.0; displacements.len()],
            changed: vec![true; self.tissues.len()],
            touching: Vec::new(),
            outward: None,
        };
        self.turning_faces.clear();

        // Whoever is held back changes the way of its neighbors: swept again.
        let mut pass = 0;
        loop {
            self.limit_shapes(displacements, &mut step.shares, &mut step.changed)?;
            let ends = self.ends_of_step(displacements, &step.shares);
            let meetings = self.meetings(&ends, &step.changed, crossing)?;
            step.changed.fill(false);
            let is_free = self.hold_back(&mut step, &meetings, pass);
            self.joints.lower(self.scene, &mut step.shares, &mut step.changed);
            if is_free {
                step.touching.sort_unstable();
                step.touching.dedup();
                self.take_step(&ends, &step.touching)?;
                return Ok(ends.iter().map(Option::is_some).collect());
            }
            pass += 1;
        }
    }

    /// Holds particles that meet back to before their contact; returns true if none is held.
    fn hold_back(&self, step: &mut FreeStep<'_>, meetings: &[PairSweep], pass: usize) -> bool {
        // What meets several others is held by the earliest one.
        let mut held_shares = step.shares.clone();
        let mut is_free = true;
        for PairSweep { pair, contacts } in meetings {
            let mut is_held = false;
            let first_of_b = self.scene.body(pair.b).particles().start;
            for swept in contacts {
                if self.ties.seams.joins(&swept.contact, first_of_b) {
                    continue;
                }

                // What touches and does not approach may go on: exact detection decides after.
                if swept.at_start && !self.approaches(&swept.contact, step) {
                    step.touching.push(*pair);
                    continue;
                }
                is_held = true;
                let time = swept.contact.time.unwrap_or(0.0);
                let factor = if swept.at_start { 0.0 } else { FREE_SHARE * time };
                for term in swept.contact.stencil.terms() {
                    let particle = term.particle as usize;
                    let held = factor * step.shares[particle];
                    held_shares[particle] = held_shares[particle].min(held);
                }
            }
            if is_held {
                is_free = false;
                self.mark_held(*pair, pass, &mut step.changed, &mut held_shares);
            }
        }
        step.shares = held_shares;
        is_free
    }

    /// Returns true if the two sides of a contact that touch at the start come nearer in the step.
    fn approaches(&self, contact: &Contact, step: &mut FreeStep<'_>) -> bool {
        let outward = step.outward.get_or_insert_with(|| self.outward_normals());
        let approach =
            contact.stencil.combine(|p| step.shares[p as usize] * step.displacements[p as usize]);
        approach.dot(self.normal_at_start(contact, outward)) > 0.0
    }

    /// Returns the outward normals of all particles.
    fn outward_normals(&self) -> Vec<DVec3> {
        let mut normals = Vec::with_capacity(self.inverse_masses.len());
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            normals.extend(tissue.outward_normals(body.positions()));
        }
        normals
    }

    /// Returns the normal of a contact at the start of a step. Points that coincide have none of their own,
    /// and part along the normals of both surfaces.
    fn normal_at_start(&self, contact: &Contact, outward: &[DVec3]) -> DVec3 {
        let bodies = self.scene.bodies();
        let apart = contact.stencil.combine(|p| {
            let body = &bodies[bodies.partition_point(|body| body.particles().end <= p)];
            body.positions()[(p - body.particles().start) as usize]
        });
        if apart.length() > TOUCHING * self.params.gap {
            return contact.normal;
        }
        contact.stencil.combine(|p| outward[p as usize])
    }

    /// Finds what meets on the way, among pairs of which a way has changed.
    pub(crate) fn meetings(
        &mut self,
        ends: &[Option<Vec<DVec3>>],
        changed: &[bool],
        crossing: &[PairId],
    ) -> Result<Vec<PairSweep>, ResolveError> {
        let mut moves = Vec::new();
        for (tissue, end) in self.tissues.iter().zip(ends) {
            if let Some(positions) = end {
                moves.push(BodyMove { body: tissue.id, positions });
            }
        }
        let is_wanted = |pair: PairId| {
            let has_changed = changed[pair.a.index()] || changed[pair.b.index()];
            let moves = ends[pair.a.index()].is_some() || ends[pair.b.index()].is_some();
            let is_left = crossing.contains(&pair) || self.exempt_pairs.contains(&pair);
            has_changed && moves && !is_left
        };
        let progress = self.round_progress();
        let report = self.scene.sweep_among(&moves, &CcdParams::DEFAULT, is_wanted, progress)?;
        Ok(report.pairs)
    }

    /// Marks the bodies of a pair as held back. Where holding back single particles does not end,
    /// both bodies rest.
    fn mark_held(&self, pair: PairId, pass: usize, changed: &mut [bool], shares: &mut [f64]) {
        for id in pair.bodies() {
            changed[id.index()] = true;
            if pass >= MAX_HOLD_PASSES {
                self.rest_body(id.index(), shares);
            }
        }
    }

    /// Shortens the steps of vertices of changed bodies until no face turns over, and no body crosses itself anew,
    /// and those at one point of a seam to the shortest of them. Bodies that change by that are changed, too.
    fn limit_shapes(
        &mut self,
        displacements: &[DVec3],
        shares: &mut [f64],
        changed: &mut [bool],
    ) -> Result<(), Interrupted> {
        let mut to_limit = changed.to_vec();
        for pass in 0.. {
            self.limit_shape(displacements, shares, &to_limit)?;
            to_limit.fill(false);
            if !self.joints.lower(self.scene, shares, &mut to_limit) {
                break;
            }
            for (number, lowered) in to_limit.iter().enumerate() {
                changed[number] |= lowered;
                if *lowered && pass >= MAX_HOLD_PASSES {
                    self.rest_body(number, shares);
                }
            }
        }
        Ok(())
    }

    /// Lets a body rest in a step.
    fn rest_body(&self, number: usize, shares: &mut [f64]) {
        let range = self.scene.bodies()[number].particles();
        shares[range.start as usize..range.end as usize].fill(0.0);
    }

    /// Shortens the steps of vertices of changed bodies until no face turns over, and no body crosses
    /// itself anew.
    fn limit_shape(
        &mut self,
        displacements: &[DVec3],
        shares: &mut [f64],
        changed: &[bool],
    ) -> Result<(), Interrupted> {
        let mut parts = Vec::new();
        let (mut displacements, mut shares) = (displacements, shares);
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            let (d, others) = displacements.split_at(tissue.rest.len());
            let (own, rest) = shares.split_at_mut(tissue.rest.len());
            (displacements, shares) = (others, rest);
            let is_changed = changed[tissue.id.index()];
            if is_changed && !tissue.is_rigid && d.iter().any(|d| *d != DVec3::ZERO) {
                parts.push((tissue, fitted_tree(body), d, own, Vec::new()));
            }
        }

        let progress = self.round_progress();
        parallel::try_for_each_mut(&mut parts, |_, (tissue, tree, d, shares, turning)| {
            progress.report(0.0)?;
            *turning = tissue.limit_step(tree, d, shares, progress)?;
            Ok(())
        })?;
        for (tissue, _, _, _, turning) in parts {
            self.turning_faces.extend(turning.into_iter().map(|face| (tissue.id, face)));
        }
        Ok(())
    }

    /// Returns the end positions of each body; `None` where it rests.
    pub(crate) fn ends_of_step(
        &self,
        displacements: &[DVec3],
        shares: &[f64],
    ) -> Vec<Option<Vec<DVec3>>> {
        let mut ends = Vec::new();
        for body in self.scene.bodies() {
            let range = body.particles().start as usize..body.particles().end as usize;
            let (d, shares) = (&displacements[range.clone()], &shares[range]);
            let mut x = body.positions().to_vec();
            let mut moves = false;
            for ((x, d), share) in x.iter_mut().zip(d).zip(shares) {
                let step = *share * *d;
                if step != DVec3::ZERO {
                    *x += step;
                    moves = true;
                }
            }
            ends.push(moves.then_some(x));
        }
        ends
    }

    /// Moves all bodies to the end of the step, unless surfaces that touched then cross.
    fn take_step(
        &mut self,
        ends: &[Option<Vec<DVec3>>],
        touching: &[PairId],
    ) -> Result<(), ResolveError> {
        let mut starts = Vec::new();
        for (number, end) in ends.iter().enumerate() {
            if let Some(x) = end {
                starts.push((number, self.scene.bodies()[number].positions().to_vec()));
                self.move_tissue(number, x)?;
            }
        }
        if touching.is_empty() {
            return Ok(());
        }

        self.scene.fit_all()?;
        if touching.iter().any(|pair| self.crosses(*pair)) {
            for (number, x) in starts {
                self.move_tissue(number, &x)?;
            }
        }
        Ok(())
    }

    /// Returns true if faces of two bodies cross.
    fn crosses(&self, pair: PairId) -> bool {
        let [a, b] = pair.bodies().map(|id| fitted_tree(self.scene.body(id)));
        let mut crosses = false;
        a.tree().pairs(b.tree(), 0.0, &mut Workspace::default(), |face_a, face_b| {
            let (corners_a, corners_b) = (a.corners(face_a), b.corners(face_b));
            crosses = crosses || triangles_meet(corners_a, corners_b) == Meeting::Crossing;
        });
        crosses
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::Scene;
    use surface::progress::Progress;

    use super::*;

    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams};

    /// Builds a block that rests on a plate, shifted along it.
    fn resting_block(shift: DVec3) -> Scene {
        let plate = shapes::plate(DVec3::new(8.0, 8.0, 2.0), [4, 4]).translated(-DVec3::Z);
        let block = shapes::plate(DVec3::splat(2.0), [4, 4]).translated(DVec3::Z + shift);
        bone_and_muscle(plate, block)
    }

    #[test]
    fn a_block_that_rests_on_a_plate_moves_off_and_not_into_it() {
        let (mut scene, conditions) = (resting_block(DVec3::ZERO), Conditions::default());
        let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        for (step, lowest) in [(-0.05, 0.0), (0.25, 0.25)] {
            let first = run.scene.bodies()[1].particles().start as usize;
            let mut displacements = vec![DVec3::ZERO; run.inverse_masses.len()];
            displacements[first..].fill(step * DVec3::Z);
            run.move_freely(&displacements, &[]).expect("a step");
            let height = |x: &DVec3| x.z;
            let heights = run.scene.bodies()[1].positions().iter().map(height);
            assert!((heights.fold(9.0, f64::min) - lowest).abs() < 1e-12, "{step}");
        }
    }

    #[test]
    fn what_meets_is_held_back_by_itself() {
        // A block with a tip below its lower side, that comes down on a plate.
        let plate = shapes::plate(DVec3::new(8.0, 8.0, 2.0), [4, 4]).translated(-DVec3::Z);
        let mut block = shapes::plate(DVec3::new(6.0, 6.0, 2.0), [6, 6]);
        block = block.translated(DVec3::new(0.3, 0.2, 3.0));
        let is_tip = |x: &DVec3| x.distance(DVec3::new(0.3, 0.2, 2.0)) < 1e-9;
        let tip = block.positions.iter().position(is_tip).expect("a tip");
        block.positions[tip].z = 1.0;
        let at_first = block.positions.clone();
        let mut scene = bone_and_muscle(plate, block);
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");

        // The tip meets several faces and edges after two thirds of the step; what is far from it meets nothing.
        let first = run.scene.bodies()[1].particles().start as usize;
        let mut displacements = vec![DVec3::ZERO; run.inverse_masses.len()];
        displacements[first..].fill(-1.5 * DVec3::Z);
        run.move_freely(&displacements, &[]).expect("a step");
        let x = run.scene.bodies()[1].positions();
        let way = |number: usize| at_first[number].z - x[number].z;
        assert!((way(tip) - FREE_SHARE).abs() < 1e-6, "{}", way(tip));
        let far = (0..x.len()).filter(|number| x[*number].distance(x[tip]) > 2.9);
        assert!(far.clone().count() > 9);
        for number in far {
            assert!((way(number) - 1.5).abs() < 1e-12, "{number} by {}", way(number));
        }
    }

    #[test]
    fn the_gap_of_a_block_that_rests_on_a_plate_is_opened() {
        for shift in [DVec3::ZERO, DVec3::new(0.3, 0.2, 0.0)] {
            let mut scene = resting_block(shift);
            let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
            let resolution = crate::resolve(&mut scene, &params, Progress::none());
            let gap = resolution.expect("a resolution").gap;
            assert!(gap.holds(), "{shift}: {:?}", gap.short);
        }
    }
}
