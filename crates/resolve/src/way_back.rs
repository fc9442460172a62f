//! Ways of displaced tissue back to where it is at rest.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use kdop::{Dop18, Workspace};
use scene::{PairSweep, SweptContact};
use surface::{Meeting, TotalF64, segment_meets_triangle};

use crate::ResolveError;
use crate::detection::{clearance, detection_margin};
use crate::elastic::ElasticProblem;
use crate::free_step::FREE_SHARE;
use crate::run::Run;
use crate::tissue::{Tissue, fitted_tree};

/// Largest number of steps in which tissue goes back to where its energy is least. Below, it comes after a bone that is
/// faster; above, frames take longer.
const MAX_STEPS_BACK: usize = 4;

/// Longest displacement of a step after which tissue is back \[clearances\]. Below, steps change nothing that is seen;
/// above, it stays away from a bone that is slow.
const SHORT_STEP: f64 = 0.5;

/// Share of the way straight back below which a body that meets something does not go. Below, bodies that stay pressed
/// somewhere are unevenly displaced, and rounds have to restore their volumes; above, bodies come late after a bone that
/// is fast.
const MIN_WAY: f64 = 0.3;

impl Run<'_> {
    /// Moves tissue that overlaps nothing toward where its elastic energy is least, by steps that let nothing cross.
    pub(crate) fn go_back(&mut self) -> Result<(), ResolveError> {
        let mut has_moved = self.go_straight_back()?;
        let (mut near, mut moved) = (Vec::new(), vec![true; self.tissues.len()]);
        let target = clearance(&self.params) + self.gap_slack();
        for _ in 0..MAX_STEPS_BACK {
            self.update_features(&mut near, &[], detection_margin(&self.params), &moved)?;
            let mut problem = ElasticProblem::default();
            for pair in &near {
                let target = if self.is_tied(pair.id) { 0.0 } else { target };
                let row = |feature| self.gap_row(pair.id, feature, target - feature.distance);
                problem.rows.extend(pair.features.iter().filter_map(row));
            }
            let before = self.displacements();
            self.add_displaced_bodies(BTreeMap::new(), &before, &mut problem)?;
            self.add_tie_bonds(&mut problem);
            moved = self.step_freely(problem, &before, &[])?;

            let mut longest: f64 = 0.0;
            for (before, after) in before.iter().zip(self.displacements()) {
                longest = longest.max(before.distance(after));
            }
            for (has_moved, moved) in has_moved.iter_mut().zip(&moved) {
                *has_moved |= *moved;
            }
            if longest <= SHORT_STEP * clearance(&self.params) {
                break;
            }
        }
        self.detect_moved(&has_moved)
    }

    /// Moves tissue straight toward where it is at rest, around each contact on the way up to that contact; returns
    /// which bodies moved. Bodies that soon meet something stay.
    fn go_straight_back(&mut self) -> Result<Vec<bool>, ResolveError> {
        let mut steps = self.displacements();
        steps.iter_mut().for_each(|step| *step = -*step);

        // Shares of the way at which particles meet something, and those of what is around them.
        let mut shares = vec![1.0; steps.len()];
        let ends = self.ends_of_step(&steps, &shares);
        for PairSweep { contacts, .. } in
            self.meetings(&ends, &vec![true; self.tissues.len()], &[])?
        {
            for SweptContact { contact, at_start, .. } in contacts {
                let time = if at_start { 0.0 } else { contact.time.unwrap_or(0.0) };
                for term in contact.stencil.terms() {
                    let share = &mut shares[term.particle as usize];
                    *share = share.min(FREE_SHARE * time);
                }
            }
        }
        let mut others = &mut shares[..];
        for tissue in &self.tissues {
            let (own, rest) = others.split_at_mut(tissue.rest.len());
            if own.iter().any(|share| *share < MIN_WAY) {
                own.fill(0.0);
            }
            tissue.bound_slope(own, self.params.smoothing.recip());
            others = rest;
        }

        for (step, share) in steps.iter_mut().zip(shares) {
            *step *= share;
        }
        self.move_freely(&steps, &[])
    }

    /// Returns true if a rigid body is between displaced tissue and where that is at rest: a vertex would enter
    /// it and leave it on a straight way.
    pub(crate) fn is_kept_off_rest(&self) -> bool {
        let mut workspace = Workspace::default();
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            if tissue.is_rigid {
                continue;
            }
            for bone in self.scene.bodies().iter().filter(|bone| bone.is_rigid()) {
                let bone = fitted_tree(bone);
                let faces_passed = if bone.has_inside().is_ok() { 2 } else { 1 };
                for (&x, &rest) in body.positions().iter().zip(&tissue.rest) {
                    let mut crossed: usize = 0;
                    if x != rest {
                        let way = Dop18::from_points(&[x, rest]);
                        bone.tree().query(&way, &mut workspace, |face| {
                            let meeting = segment_meets_triangle([x, rest], bone.corners(face));
                            crossed += usize::from(meeting == Meeting::Crossing);
                        });
                    }
                    if crossed >= faces_passed {
                        return true;
                    }
                }
            }
        }
        false
    }
}

impl Tissue {
    /// Lowers values of vertices until none is above that of another by more than `slope` times their distance along
    /// edges at rest.
    fn bound_slope(&self, values: &mut [f64], slope: f64) {
        let mut pending = BinaryHeap::new();
        let highest = values.iter().copied().fold(0.0, f64::max);
        for (vertex, &value) in (0..).zip(&*values) {
            if value < highest {
                pending.push(Reverse((TotalF64(value), vertex)));
            }
        }
        while let Some(Reverse((TotalF64(value), vertex))) = pending.pop() {
            if value > values[vertex as usize] {
                continue;
            }
            for link in self.links(vertex) {
                let neighbor = link.neighbor as usize;
                let length = self.rest[vertex as usize].distance(self.rest[neighbor]);
                let bound = value + slope * length;
                if bound < values[neighbor] {
                    values[neighbor] = bound;
                    pending.push(Reverse((TotalF64(bound), link.neighbor)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;

    use crate::run::Run;
    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams};

    #[test]
    fn values_rise_no_steeper_than_they_may() {
        let plate = shapes::plate(DVec3::new(40.0, 2.0, 2.0), [40, 1]);
        let bone = shapes::icosphere(1.0, 1).translated(9.0 * DVec3::Z);
        let mut scene = bone_and_muscle(bone, plate);
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::start(&mut scene, params, &conditions).expect("a run");
        let tissue = &run.tissues[1];
        let is_low = |x: DVec3| x.x < -19.9;
        let mut values: Vec<f64> =
            tissue.rest.iter().map(|x| if is_low(*x) { 0.2 } else { 1.0 }).collect();
        tissue.bound_slope(&mut values, 0.05);
        for (x, value) in tissue.rest.iter().zip(values) {
            let bound = f64::min(0.2 + 0.05 * (x.x + 20.0), 1.0);
            assert!((value - bound).abs() < 1e-12, "{value} at {x}");
        }
    }
}
