//! Bodies that have come to cross themselves: what crosses is taken apart once bodies are, by steps that let
//! nothing else cross.
//!
//! Two faces that cross were apart at the start, with a plane between them. They are apart again when each is
//! on its side of a plane of this direction, which the displacement of least elastic energy brings about. On
//! the way, faces of a tangle may cross others of it: a fold of several faces opens one after the other.

use std::ops::Range;

use glam::DVec3;
use scene::{Body, BodyId, PairId};
use surface::{Meeting, closest_between_triangles, triangle, triangles_meet};

use crate::ResolveError;
use crate::detection::clearance;
use crate::elastic::{ElasticProblem, GapRow, Terms};
use crate::run::{Run, TOUCHING};
use crate::tissue::{Tissue, corners_at, fitted_tree};

/// Steps per body. Below, folds of several edges remain; above, hopeless ones take longer.
const MAX_STEPS: usize = 12;

/// Steps after which a body is left as it is, where none of them has improved it: some lead through states
/// that are no better.
const MAX_STALLED_STEPS: usize = 3;

/// Part of what was missing at least that may be missing after a step that improves a body.
const IMPROVED: f64 = 0.9;

impl Run<'_> {
    /// Takes apart what crosses in each body that crosses no other, and did not at the start, as far as steps
    /// lead.
    pub(crate) fn uncross_anew(&mut self) -> Result<(), ResolveError> {
        self.scene.fit_all()?;
        let crossing = self.overlapping_pairs();
        let is_crossing = |id: BodyId| crossing.iter().any(|pair| pair.contains(id));
        self.for_each_soft(|tissue, tree, progress| {
            if !is_crossing(tissue.id) {
                tissue.count_crossings_once(tree, progress)?;
            }
            Ok(())
        })?;

        let mut moved = vec![false; self.tissues.len()];
        for number in 0..self.tissues.len() {
            if !is_crossing(self.tissues[number].id) {
                self.take_apart(number, &crossing, &mut moved)?;
                self.tissues[number].tangle.clear();
            }
        }
        self.detect_moved(&moved)
    }

    /// Takes apart what crosses in a body, step by step, and marks the bodies that moved.
    fn take_apart(
        &mut self,
        number: usize,
        crossing: &[PairId],
        moved: &mut [bool],
    ) -> Result<(), ResolveError> {
        let (mut least, mut stalled_steps) = (f64::INFINITY, 0);
        for _ in 0..MAX_STEPS {
            let faces = self.crossing_faces(number)?;
            let rows = self.uncrossing_rows(number, &faces);
            let missing: f64 = rows.iter().map(|row| row.missing).sum();
            stalled_steps = if missing < IMPROVED * least { 0 } else { stalled_steps + 1 };
            least = least.min(missing);
            if rows.is_empty() || stalled_steps == MAX_STALLED_STEPS {
                break;
            }
            self.tissues[number].add_to_tangle(&faces);
            let moves = self.uncross_body(number, rows, crossing)?;
            for (moved, moves) in moved.iter_mut().zip(moves) {
                *moved |= moves;
            }
        }
        Ok(())
    }

    /// Finds the pairs of a body's own faces that cross, if there are any that did not at the start.
    fn crossing_faces(&self, number: usize) -> Result<Vec<[u32; 2]>, ResolveError> {
        let (tissue, body) = (&self.tissues[number], &self.scene.bodies()[number]);
        let has_none = tissue.counted_crossings == Some(0);
        if tissue.is_rigid || has_none || body.positions() == tissue.rest {
            return Ok(Vec::new());
        }
        Ok(tissue.self_crossings(fitted_tree(body), self.round_progress())?)
    }

    /// Makes the rows by which a body's own faces come apart that cross and did not at the start.
    fn uncrossing_rows(&self, number: usize, faces: &[[u32; 2]]) -> Vec<GapRow> {
        let (tissue, body) = (&self.tissues[number], &self.scene.bodies()[number]);
        let opening = self.gap_slack()..clearance(&self.params);
        let mut rows = Vec::new();
        for &pair in faces {
            tissue.add_plane_rows(body, pair, &opening, &mut rows);
        }
        rows
    }

    /// Takes one step of a body in which these rows open, and all other bodies stay but for vertices of its seams;
    /// returns which bodies moved.
    fn uncross_body(
        &mut self,
        number: usize,
        rows: Vec<GapRow>,
        crossing: &[PairId],
    ) -> Result<Vec<bool>, ResolveError> {
        let target = clearance(&self.params) + self.gap_slack();
        let mut problem = ElasticProblem {
            rows: self.holding_rows(number, crossing, target)?,
            ..Default::default()
        };

        // The tissue around what crosses.
        let (progress, length) = (self.round_progress(), self.params.smoothing);
        let (tissue, body) = (&mut self.tissues[number], &self.scene.bodies()[number]);
        let first = body.particles().start;
        let mut seeds = Vec::new();
        for row in &rows {
            seeds.extend(row.terms.iter().map(|(particle, _)| particle - first));
        }
        problem.rows.extend(rows);
        let tree = fitted_tree(body);
        let active = tissue.active_vertices(seeds, &[], tree, length, progress)?;
        problem.extend(vec![tissue.elastic_part(body, &active, length)]);

        // From the state as it is: what other rounds have displaced stays so.
        let resting = vec![DVec3::ZERO; self.inverse_masses.len()];
        let moved = self.step_freely(problem, &resting, crossing)?;
        self.scene.fit_all()?;
        Ok(moved)
    }
}

impl Tissue {
    /// Adds the faces that share a corner with one of these, those themselves included, to what is being taken
    /// apart.
    fn add_to_tangle(&mut self, pairs: &[[u32; 2]]) {
        let mut corners: Vec<u32> =
            pairs.as_flattened().iter().flat_map(|face| self.corners(*face)).collect();
        corners.sort_unstable();
        for (number, face) in (0..).zip(self.surface.faces()) {
            if face.iter().any(|corner| corners.binary_search(corner).is_ok()) {
                self.tangle.push(number);
            }
        }
        self.tangle.sort_unstable();
        self.tangle.dedup();
    }

    /// Returns true if both faces are of what is being taken apart.
    pub(crate) fn is_tangled(&self, faces: &[u32; 2]) -> bool {
        faces.iter().all(|face| self.tangle.binary_search(face).is_ok())
    }

    /// Adds a row for each corner of one face and each of another that are not on their sides of a plane which
    /// was between the faces at the start; none where they crossed then. They open to their distance at the
    /// start, within a range.
    fn add_plane_rows(
        &self,
        body: &Body,
        [a, b]: [u32; 2],
        opening: &Range<f64>,
        rows: &mut Vec<GapRow>,
    ) {
        // The plane at the start, and how far the faces were from each other across it.
        let [face_a, face_b] = [a, b].map(|face| corners_at(self.corners(face), &self.rest));
        if triangles_meet(face_a, face_b) == Meeting::Crossing {
            return;
        }
        let feet = closest_between_triangles(face_a, face_b);
        let normal = if feet.distance() > TOUCHING * opening.end {
            (feet.points[1] - feet.points[0]).try_normalize()
        } else {
            normal_between(face_a, face_b)
        };
        let Some(normal) = normal else { return };
        let target = feet.distance().min(opening.end).max(opening.start);

        let (x, first) = (body.positions(), body.particles().start);
        for i in self.corners(a) {
            for j in self.corners(b) {
                // A common corner stays where both faces end.
                let is_common =
                    |corner| self.corners(a).contains(&corner) && self.corners(b).contains(&corner);
                let target = if is_common(i) || is_common(j) { 0.0 } else { target };
                let missing = target - (x[j as usize] - x[i as usize]).dot(normal);
                let terms = [(i, -1.0), (j, 1.0)].into_iter().filter(|(v, _)| self.is_free(*v));
                let terms: Terms = terms.map(|(v, weight)| (first + v, weight)).collect();
                if missing > 0.0 && !terms.is_empty() {
                    rows.push(GapRow::new(terms, normal, missing));
                }
            }
        }
    }
}

/// Returns the normal, from one to the other, of the plane between two triangles that touch: one of theirs, or
/// of an edge of each.
fn normal_between(a: [DVec3; 3], b: [DVec3; 3]) -> Option<DVec3> {
    let edges = |[a, b, c]: [DVec3; 3]| [b - a, c - b, a - c];
    let mut axes = vec![triangle::normal(a), triangle::normal(b)];
    for edge_a in edges(a) {
        axes.extend(edges(b).map(|edge_b| edge_a.cross(edge_b)));
    }

    // That along which they overlap least.
    let (mut best, mut most) = (None, f64::NEG_INFINITY);
    for axis in axes.into_iter().filter_map(DVec3::try_normalize) {
        for axis in [axis, -axis] {
            let end_of_a = a.map(|p| p.dot(axis)).into_iter().fold(f64::NEG_INFINITY, f64::max);
            let start_of_b = b.map(|p| p.dot(axis)).into_iter().fold(f64::INFINITY, f64::min);
            if start_of_b - end_of_a > most {
                most = start_of_b - end_of_a;
                best = Some(axis);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;
    use fixtures::{Mesh, shapes};
    use scene::{BodyKind, CheckParams, PairReport, Scene};
    use surface::progress::Progress;

    use super::*;

    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams, Tie};

    /// A thin body on a bone, whose upper side is pressed through its lower one.
    #[test]
    fn sides_that_were_pressed_through_each_other_part_and_enter_no_bone() {
        let muscle = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
        let bone = shapes::plate(DVec3::new(16.0, 16.0, 1.0), [4, 4]).translated(DVec3::Z * -3.3);
        let mut x = muscle.positions.clone();
        let mut scene = bone_and_muscle(bone, muscle);
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        for x in x.iter_mut().filter(|x| x.z > 0.0 && x.truncate().length() < 3.0) {
            x.z -= 4.2;
        }
        run.move_soft(|_, _| Some(x.clone())).expect("positions");
        run.scene.fit_all().expect("trees");
        let faces = run.crossing_faces(1).expect("faces");
        assert!(!run.uncrossing_rows(1, &faces).is_empty());

        run.uncross_anew().expect("a state");
        let tree = fitted_tree(&run.scene.bodies()[1]);
        let crossings = run.tissues[1].self_crossings(tree, Progress::none());
        assert_eq!(crossings.expect("crossings"), Vec::<[u32; 2]>::new());
        let reports = scene.check(&CheckParams::without_measures(9.0), Progress::none());
        assert!(!reports.expect("reports")[0].overlaps);
    }

    /// A body of two parts, of which one stands on the other with its tip, and is pressed into it.
    #[test]
    fn what_touched_at_the_start_comes_apart() {
        let plate = shapes::plate(DVec3::new(8.0, 8.0, 2.0), [4, 4]).translated(-DVec3::Z);
        let tip = DVec3::new(0.3, 0.6, 0.0);
        let around =
            [DVec3::new(2.0, 0.0, 3.0), DVec3::new(-2.0, 2.0, 3.0), DVec3::new(-1.0, -2.0, 3.0)];
        let positions = vec![tip, tip + around[0], tip + around[1], tip + around[2]];
        let faces = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
        let standing = Mesh { positions, faces };
        let bone = shapes::cube(1.0).translated(DVec3::Z * -9.0);
        let mut scene = bone_and_muscle(bone, plate.clone().joined(&standing));
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        assert_eq!(run.crossing_faces(1).expect("faces"), Vec::<[u32; 2]>::new());

        let pressed = |(number, x): (usize, &DVec3)| {
            if number < plate.positions.len() { *x } else { *x - 0.3 * DVec3::Z }
        };
        run.move_soft(|_, x| Some(x.iter().enumerate().map(pressed).collect())).expect("positions");
        assert!(!run.crossing_faces(1).expect("faces").is_empty());
        run.uncross_anew().expect("a state");
        assert_eq!(run.crossing_faces(1).expect("faces"), Vec::<[u32; 2]>::new());
        let way = run.scene.bodies()[1].positions()[plate.positions.len()] - tip;
        assert!(way.truncate().length() < 0.1, "the tip leaves by the way it came, not {way}");
    }

    /// Thin bodies of which a few vertices are at random places inside and beyond the other side.
    #[test]
    fn tangles_of_several_faces_open_one_after_the_other() {
        let muscle = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
        let (mut crossing, mut left) = (0, Vec::new());
        for seed in 0..40 {
            let bone = shapes::cube(1.0).translated(DVec3::Z * -9.0);
            let mut scene = bone_and_muscle(bone, muscle.clone());
            let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
            let run = Run::start(&mut scene, params, &conditions);
            let mut run = run.expect("a run");
            let (mut random, mut x) = (Random(seed), muscle.positions.clone());
            for x in x.iter_mut().filter(|x| x.z > 0.0 && x.truncate().length() < 2.5) {
                let mut within = |from, to| from + (to - from) * random.unit();
                *x += DVec3::new(within(-1.2, 1.2), within(-1.2, 1.2), within(-5.0, -2.0));
            }
            run.move_soft(|_, _| Some(x.clone())).expect("positions");
            let faces = run.crossing_faces(1).expect("faces");
            crossing += usize::from(!faces.is_empty());

            run.uncross_anew().expect("a state");
            let rest = run.crossing_faces(1).expect("faces").len();
            if rest > 0 {
                left.push((seed, faces.len(), rest));
            }
        }
        assert!(crossing > 30, "{crossing} bodies cross themselves");
        assert_eq!(left, [], "seeds, with the pairs of faces that cross before and after");
    }

    /// Builds a thin body that was taken out of a bone and has come to cross itself, and a run in which that is
    /// the last round.
    fn with_a_fold(max_rounds: u32, test: impl FnOnce(&mut Run<'_>)) {
        let muscle = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
        let bone = shapes::plate(DVec3::new(16.0, 16.0, 1.0), [4, 4]).translated(DVec3::Z * -2.3);
        let mut x = muscle.positions.clone();
        for x in &mut x {
            // So gently that no face turns.
            let pressed = 4.2 * (-x.truncate().length_squared() / 18.0).exp();
            x.z += 0.5 - if x.z > 0.0 { pressed } else { 0.0 };
        }
        let mut scene = bone_and_muscle(bone, muscle);
        let conditions = Conditions::default();
        let params = ResolveParams {
            max_rounds,
            max_volume_change: 0.5,
            max_strain: 100.0,
            ..ResolveParams::with_smoothing(6.0)
        };
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        run.move_soft(|_, _| Some(x.clone())).expect("positions");
        run.record().expect("a round");
        let last = run.rounds[1];
        assert_eq!((last.overlapping_pairs, last.self_crossings > 0), (0, true), "{last:?}");
        test(&mut run);
    }

    /// Two plates that are tied along a side. One of them was pressed through itself; the other one is above a bone.
    #[test]
    fn contacts_of_a_body_whose_seam_moves_are_detected() {
        let mut scene = Scene::new();
        for (name, x) in [("left", -4.0), ("right", 4.0)] {
            let plate = shapes::plate(DVec3::new(8.0, 8.0, 1.0), [8, 8]).translated(DVec3::X * x);
            scene.add(name, BodyKind::Deformable, plate.surface(), plate.positions).expect("body");
        }
        let bone = shapes::cube(2.0).translated(DVec3::new(1.1, 0.1, -1.7));
        scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions).expect("a body");
        let bodies = ["left", "right"].map(|name| scene.find(name).expect("a body"));
        let ties = vec![Tie { bodies, distance: f64::MIN_POSITIVE }];
        let conditions = Conditions { ties, ..Conditions::default() };
        let params = ResolveParams::with_smoothing(6.0);
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        let pressed = |x: &DVec3| {
            let is_pressed = x.z > 0.0 && x.distance(DVec3::new(-2.0, 0.0, x.z)) < 1.5;
            if is_pressed { *x - 1.4 * DVec3::Z } else { *x }
        };
        let is_left = |tissue: &Tissue| tissue.id == bodies[0];
        run.move_soft(|tissue, x| is_left(tissue).then(|| x.iter().map(pressed).collect()))
            .expect("positions");

        let right = run.scene.bodies()[1].positions().to_vec();
        run.uncross_anew().expect("a state");
        assert!(run.scene.bodies()[1].positions() != right, "the seam moves");
        let reports = |run: &Run<'_>| -> Vec<PairReport> {
            run.near.iter().map(|near| near.report.clone()).collect()
        };
        let known = reports(&run);
        run.detect_moved(&[true; 3]).expect("reports");
        assert_eq!(known, reports(&run));
    }

    #[test]
    fn what_crosses_itself_after_the_last_round_is_taken_apart() {
        with_a_fold(1, |run| {
            // After carried displacements nothing settles, which would take it apart as well.
            run.is_warm = true;
            let end = run.complete().expect("a resolution");
            assert_eq!(end.bodies[1].self_crossings, [0, 0]);
            assert!(end.resolved, "{:?} {:?}", end.remaining, end.broken_limits);
        });
    }

    #[test]
    fn where_nothing_else_is_left_one_round_takes_apart_what_crosses_itself() {
        with_a_fold(9, |run| {
            // After the elastic rounds, which would bring all back.
            while run.rounds.len() <= run.elastic_rounds() {
                run.record().expect("a round");
            }
            run.go_round().expect("displacements");
            run.record().expect("a round");
            let [.., last] = run.rounds[..] else { panic!("no round") };
            assert_eq!((last.overlapping_pairs, last.self_crossings), (0, 0), "{last:?}");
        });
    }
}
