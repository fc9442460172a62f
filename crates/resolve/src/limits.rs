//! Limits on the change of bodies: only states within them are accepted, and none is kept that is deeper than the
//! start.

use scene::{BodyId, PairReport};
use surface::progress::Interrupted;

use crate::ResolveError;
use crate::detection::{check, detection_margin};
use crate::resolution::{BrokenLimit, total_depth};
use crate::run::{AcceptedState, DEPTH_BRACKET, Run};
use crate::soft_positions::soft_positions;
use crate::tissue::{Damage, Tissue, fitted_tree};

/// Accepted states that are kept, to return to where rounding breaks a limit. Below, the start is
/// returned to; above, memory grows.
const MAX_ACCEPTED_STATES: usize = 8;

/// Limits on the change of one body.
#[derive(Clone, Copy, Debug)]
struct Limits {
    volume_change: f64,
    strain: f64,
    displacement: f64,
}

impl Limits {
    /// Returns true if a change is within all limits; self-crossings are not regarded.
    fn hold(&self, damage: &Damage) -> bool {
        damage.flipped_faces + damage.flat_corners == 0
            && damage.volume_change <= self.volume_change
            && damage.strain <= self.strain
            && damage.max_displacement <= self.displacement
    }
}

impl Tissue {
    /// Returns the number of self-crossings that are within limits: none are new.
    fn allowed_crossings(&self) -> usize {
        self.crossings_to_resolve.unwrap_or(0)
    }
}

impl Run<'_> {
    /// Keeps the positions of all bodies after a round, to return to.
    pub(crate) fn accept_state(&mut self, round: usize) {
        if self.accepted_states.len() == MAX_ACCEPTED_STATES {
            self.accepted_states.pop_front();
        }
        let positions = soft_positions(self.scene);
        self.accepted_states.push_back(AcceptedState { round, positions });
    }

    /// Goes back to the state that was accepted last, and detects contacts.
    pub(crate) fn return_to_accepted(&mut self) -> Result<(), ResolveError> {
        let state = self.accepted_states.pop_back();
        self.place_all(state.as_ref())?;
        self.accepted_states.extend(state);
        Ok(())
    }

    /// Goes back to the last accepted state that keeps limits in the written precision, unless
    /// the present one does or is to be kept. Returns what the present one breaks, and the round of
    /// the state that is kept.
    pub(crate) fn return_to_limits(
        &mut self,
        present: usize,
    ) -> Result<(Vec<BrokenLimit>, usize), ResolveError> {
        let broken = self.broken_limits(true)?;
        let mut round = present;
        let mut is_within = broken.is_empty() || self.params.keep_going;
        while !is_within {
            // Bodies at the start are within their limits.
            let state = self.accepted_states.pop_back();
            round = state.as_ref().map_or(0, |state| state.round);
            self.place_all(state.as_ref())?;
            self.round_positions()?;
            is_within = state.is_none() || self.broken_limits(true)?.is_empty();
        }
        Ok((broken, round))
    }

    /// Detects the state of a round in full, and goes back to the start where that was better: rounds compare
    /// vertices and edges, and faces may be deeper between these. Returns the overlaps with their round.
    pub(crate) fn detect_end(
        &mut self,
        round: usize,
    ) -> Result<(Vec<PairReport>, usize), ResolveError> {
        let after = self.detect_in_full()?;
        if !is_deeper(&after, &self.before) {
            return Ok((after, round));
        }
        self.place_all(None)?;
        self.round_positions()?;
        Ok((self.detect_in_full()?, 0))
    }

    /// Detects all contacts of the present state, and measures its overlaps.
    fn detect_in_full(&mut self) -> Result<Vec<PairReport>, ResolveError> {
        let margin = detection_margin(&self.params);
        check(self.scene, margin, DEPTH_BRACKET * self.params.tolerance, self.round_progress())
    }

    /// Returns true if no body is beyond its limits after a round that was assessed.
    pub(crate) fn holds_limits(&mut self) -> Result<bool, Interrupted> {
        let limits = self.limits();
        if !self.tissues.iter().all(|tissue| limits.hold(&tissue.damage)) {
            return Ok(false);
        }

        // Self-crossings take longest.
        self.for_each_soft(|tissue, tree, progress| {
            tissue.count_crossings_once(tree, progress).map(|_| ())
        })?;
        let holds = |tissue: &Tissue| tissue.counted_crossings <= Some(tissue.allowed_crossings());
        Ok(self.tissues.iter().all(holds))
    }

    /// Lists the bodies that are beyond their limits at present. Without `counts_crossings`, the
    /// last count of self-crossings stays.
    pub(crate) fn broken_limits(
        &mut self,
        counts_crossings: bool,
    ) -> Result<Vec<BrokenLimit>, ResolveError> {
        self.scene.fit_all()?;
        self.for_each_soft(|tissue, tree, progress| {
            tissue.assess(tree, counts_crossings, progress)
        })?;
        let mut broken = Vec::new();
        let limits = self.limits();
        for tissue in &self.tissues {
            let Tissue { id, damage, .. } = tissue;
            if !limits.hold(damage) || damage.self_crossings > tissue.allowed_crossings() {
                broken.push(BrokenLimit {
                    body: *id,
                    volume_change: damage.volume_change,
                    max_displacement: damage.max_displacement,
                    displacement_limit: limits.displacement,
                    strain: damage.strain,
                    flipped_faces: damage.flipped_faces,
                    flat_corners: damage.flat_corners,
                    self_crossings: damage.self_crossings,
                });
            }
        }
        if !broken.is_empty() {
            let bodies = broken.iter().map(|broken: &BrokenLimit| broken.body);
            self.strained_ties = bodies.flat_map(|body| self.ties_at_turned_faces(body)).collect();
        }
        Ok(broken)
    }

    /// Lists the tied vertices of a body at faces that are turned over, and next to these.
    fn ties_at_turned_faces(&self, id: BodyId) -> Vec<(BodyId, u32)> {
        let (tissue, body) = (&self.tissues[id.index()], self.scene.body(id));
        let mut vertices = Vec::new();
        for face in tissue.turned_faces(body.positions(), 0.0) {
            for corner in tissue.corners(face) {
                vertices.push(corner);
                vertices.extend(tissue.links(corner).iter().map(|link| link.neighbor));
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        let first = body.particles().start;
        let is_tied = |vertex: &u32| {
            self.ties.is_follower.get((first + vertex) as usize).copied().unwrap_or_default()
        };
        vertices.into_iter().filter(is_tied).map(|vertex| (id, vertex)).collect()
    }

    /// Lists the bodies that are to be uncrossed and still cross themselves.
    pub(crate) fn self_overlaps(&self) -> Result<Vec<BodyId>, Interrupted> {
        let (mut left, progress) = (Vec::new(), self.round_progress());
        for tissue in &self.tissues {
            let tree = fitted_tree(self.scene.body(tissue.id));
            let is_wanted = tissue.crossings_to_resolve.is_some();
            if is_wanted && tissue.count_new_self_crossings(tree, progress)? > 0 {
                left.push(tissue.id);
            }
        }
        Ok(left)
    }

    fn limits(&self) -> Limits {
        // Beyond this distance a vertex is displaced rather than freed.
        let depth = self.rounds.first().map_or(0.0, |start| start.max_depth);
        let allowed = (self.params.max_displacement * depth).max(self.allowed_displacement);
        Limits {
            volume_change: self.params.max_volume_change,
            strain: self.params.max_strain,
            displacement: self.params.gap + allowed,
        }
    }

    /// Moves soft bodies to a state, or to where they were at the start, and detects contacts.
    fn place_all(&mut self, state: Option<&AcceptedState>) -> Result<(), ResolveError> {
        self.move_soft(|tissue, _| {
            let x = state.map_or(&tissue.rest, |state| &state.positions[tissue.id.index()]);
            Some(x.clone())
        })
    }
}

/// Returns true if no fewer pairs overlap than before, and certainly deeper in all.
fn is_deeper(after: &[PairReport], before: &[PairReport]) -> bool {
    let overlaps = |reports: &[PairReport]| reports.iter().filter(|it| it.overlaps).count();
    overlaps(after) >= overlaps(before) && total_depth(after).lower > total_depth(before).upper
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;
    use proximity::SurfaceTree;
    use scene::{BodyKind, Scene};
    use surface::progress::Progress;

    use super::*;

    use crate::tissue::Tissue;
    use crate::{Conditions, ResolveParams};

    /// Detects the overlaps of balls of radius 5 in a row, each as deep in the one before as given.
    fn overlaps(depths: [f64; 2]) -> Vec<PairReport> {
        let (mut scene, mut x) = (Scene::new(), 0.0);
        for (number, depth) in [0.0].into_iter().chain(depths).enumerate() {
            x += 10.0 - depth;
            let ball = shapes::icosphere(5.0, 3).translated(x * DVec3::X);
            let added =
                scene.add(number.to_string(), BodyKind::Rigid, ball.surface(), ball.positions);
            added.expect("a ball");
        }
        check(&mut scene, 0.1, 0.01, Progress::none()).expect("reports")
    }

    #[test]
    fn fewer_pairs_are_not_deeper_and_as_many_are_by_their_sum() {
        let before = overlaps([0.5, 1.0]);
        assert_eq!(before.iter().filter(|report| report.overlaps).count(), 2);
        for (depths, expected) in [
            ([0.5, 1.0], false),
            ([1.3, 0.1], false),
            ([1.6, 0.3], true),
            ([0.9, 0.9], true),
            ([2.0, -1.0], false),
        ] {
            assert_eq!(is_deeper(&overlaps(depths), &before), expected, "{depths:?}");
        }
    }

    /// A thin body whose upper side is pressed toward its lower one, and through it: nothing is
    /// broken but that it crosses itself.
    #[test]
    fn a_body_that_crosses_itself_anew_is_beyond_its_limits() {
        let mesh = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
        let rest = mesh.positions.clone();
        let mut scene = Scene::new();
        let surface = mesh.surface();
        scene.add("muscle", BodyKind::Deformable, surface, mesh.positions).expect("a body");
        let params = ResolveParams {
            max_volume_change: 0.5,
            max_strain: 10.0,
            ..ResolveParams::with_smoothing(6.0)
        };
        let conditions = Conditions::default();
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        for (depth, holds) in [(2.0, true), (4.5, false)] {
            let mut x = rest.clone();
            for x in x.iter_mut().filter(|x| x.z > 0.0 && x.truncate().length() < 3.0) {
                x.z -= depth;
            }
            run.move_soft(|_, _| Some(x.clone())).expect("positions");
            run.record().expect("a round");
            assert_eq!(run.holds_limits(), Ok(holds), "pressed by {depth}");
            assert!(run.limits().hold(&run.tissues[0].damage), "by nothing else");
        }
    }

    /// A thin body whose upper side is pressed through its lower one on one side at rest, and on the
    /// other one later: as many faces cross, and none that crossed at rest.
    #[test]
    fn faces_that_cross_elsewhere_cross_anew() {
        let mesh = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
        let pressed = |x: DVec3, side: f64| {
            let is_pressed = x.z > 0.0 && x.distance(DVec3::new(6.0 * side, 0.0, x.z)) < 3.0;
            if is_pressed { x - 4.5 * DVec3::Z } else { x }
        };
        let [rest, other] =
            [1.0, -1.0].map(|side| mesh.positions.iter().map(|x| pressed(*x, side)).collect());
        let (rest, other): (Vec<DVec3>, Vec<DVec3>) = (rest, other);
        let mut scene = Scene::new();
        scene.add("muscle", BodyKind::Deformable, mesh.surface(), rest.clone()).expect("a body");
        scene.fit_all().expect("a tree");
        let params = ResolveParams::with_smoothing(6.0);
        let tissues = Tissue::of_bodies(&scene, &params, Progress::none()).expect("tissues");

        let mut counts = Vec::new();
        for x in [rest, other] {
            let tree = SurfaceTree::new(mesh.surface(), x).expect("finite positions");
            let all = tissues[0].self_crossings(&tree, Progress::none()).expect("no interruption");
            let new = tissues[0].count_new_self_crossings(&tree, Progress::none());
            counts.push((all.len(), new.expect("no interruption")));
        }
        let [(at_rest, none), (elsewhere, new)] = counts[..] else { panic!("{counts:?}") };
        assert!(at_rest > 0 && none == 0, "{counts:?}");
        assert!(elsewhere <= at_rest && new == elsewhere, "{counts:?}");
    }

    /// A block that shares a face with a bone at the start is pressed into it.
    #[test]
    fn a_pair_that_shared_faces_overlaps_anew_beyond_the_tolerance() {
        let block = shapes::cube(10.0);
        let bone =
            shapes::cube(10.0).scaled(DVec3::new(3.0, 3.0, 1.0)).translated(-10.0 * DVec3::Z);
        let mut scene = Scene::new();
        let muscle = scene.add("muscle", BodyKind::Deformable, block.surface(), block.positions);
        scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions).expect("a body");
        let rest = scene.body(muscle.expect("a body")).positions().to_vec();
        let params =
            ResolveParams { gap: 0.05, tolerance: 0.2, ..ResolveParams::with_smoothing(6.0) };
        let conditions = Conditions::default();
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        assert_eq!((run.rounds[0].overlapping_pairs, run.rounds[0].touching_faces > 0), (0, true));
        for (depth, new_pairs) in [(0.1, 0), (0.3, 1)] {
            let x: Vec<DVec3> = rest.iter().map(|x| *x - depth * DVec3::Z).collect();
            run.move_soft(|_, _| Some(x.clone())).expect("positions");
            run.record().expect("a round");
            let round = run.rounds.last().expect("a round");
            assert_eq!((round.overlapping_pairs, round.new_pairs), (1, new_pairs), "{depth}");
        }
    }
}
