//! Polls for interruption within one pair of bodies.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use fixtures::shapes::icosphere;
use glam::DVec3;
use overlap::{
    AreaBracket, Depth, DepthParams, JointContact, JointContactError, JointContactParams,
    NearAreas, Overlap, OverlapDetector,
};
use proximity::{PairProximity, PairSide, SurfaceTree};
use surface::progress::{Interrupted, Progress};

const DEPTH: DepthParams =
    DepthParams { relative_tolerance: 1e-4, tolerance: 1e-9, max_queries: 100_000 };
const JOINT: JointContactParams =
    JointContactParams { margin: 0.5, resolution: 0.25, foundation: None };

/// All that is computed of a pair.
#[derive(Debug, PartialEq)]
struct Found {
    overlap: Overlap,
    depths: [Option<Depth>; 2],
    joint: [JointContact; 2],
    near: [AreaBracket; 2],
}

/// Two spheres, one of them 1 deep in the other.
fn spheres(level: u32) -> [SurfaceTree; 2] {
    let sphere = icosphere(10.0, level);
    let other = sphere.clone().translated(DVec3::new(19.0, 0.1, 0.2));
    [sphere, other].map(|mesh| {
        SurfaceTree::new(mesh.surface(), mesh.positions).expect("planted bodies are finite")
    })
}

/// Computes everything, in memory that an interrupted call may have left.
fn compute(
    [a, b]: [&SurfaceTree; 2],
    memory: &mut (OverlapDetector, NearAreas),
    progress: Progress<'_>,
) -> Result<Found, Interrupted> {
    let (detector, near_areas) = memory;
    let mut overlap = Overlap::default();
    detector.try_measure_into([a, b], &mut overlap, progress)?;
    let depths = detector.depths_from([a, b], [&[]; 2], &DEPTH, progress)?;
    let joint = detector.joint_contact([a, b], &JOINT, progress).map_err(|error| {
        assert_eq!(error, JointContactError::Interrupted(Interrupted), "the only error");
        Interrupted
    })?;

    let mut pair = PairProximity::default();
    pair.compute(a, b, JOINT.margin).expect("few faces are near");
    let near_faces = pair.sides().map(PairSide::near_faces);
    let near = near_areas.measure([a, b], JOINT.margin, near_faces, progress)?;
    Ok(Found { overlap, depths, joint, near })
}

/// Computes everything, ended by the poll of a number; returns the number of polls, too.
fn compute_until(
    bodies: [&SurfaceTree; 2],
    memory: &mut (OverlapDetector, NearAreas),
    last: usize,
) -> (Result<Found, Interrupted>, usize) {
    let polls = AtomicUsize::new(0);
    let handler = |_| {
        let is_last = polls.fetch_add(1, Ordering::Relaxed) + 1 >= last;
        if is_last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found = compute(bodies, memory, Progress::new(&handler));
    (found, polls.into_inner())
}

#[test]
fn a_pair_ends_at_any_poll_and_leaves_memory_that_serves_again() {
    let bodies = spheres(3);
    let bodies = bodies.each_ref();
    let mut memory = Default::default();
    let (expected, polls) = compute_until(bodies, &mut memory, usize::MAX);
    for last in (1..=polls).step_by(1 + polls / 30) {
        let (found, polled) = compute_until(bodies, &mut memory, last);
        assert_eq!((found, polled), (Err(Interrupted), last), "of {polls}");
        assert_eq!(compute_until(bodies, &mut memory, usize::MAX).0, expected, "after {last}");
    }
}

/// Polls are for pieces of the work, not for its stages: more work, more polls.
#[test]
fn polls_grow_with_the_bodies() {
    let [few, many] = [3, 6].map(|level| {
        let bodies = spheres(level);
        compute_until(bodies.each_ref(), &mut Default::default(), usize::MAX).1
    });
    assert!(many > 2 * few, "{few} polls, {many} for 64 times as many faces");
}

/// What was measured before is not taken for the pair whose measure was interrupted, nor is anything of a
/// detector that has measured nothing.
#[test]
fn nothing_is_left_of_a_measure_that_was_interrupted() {
    let (large, bodies) = (spheres(4), spheres(3));
    let [a, b] = bodies.each_ref();
    let mut detector = OverlapDetector::default();
    for last in 0..5 {
        let polls = AtomicUsize::new(0);
        let handler = |_| match polls.fetch_add(1, Ordering::Relaxed) + 1 {
            poll if poll >= last => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        if last > 0 {
            let mut overlap = detector.measure(&large[0], &large[1]);
            let measured = detector.try_measure_into([a, b], &mut overlap, Progress::new(&handler));
            assert_eq!((measured, overlap), (Err(Interrupted), Overlap::default()), "{last}");
        }

        assert_eq!(detector.depths([a, b], &DEPTH), [None; 2], "{last}");
        assert_eq!([0, 1].map(|side| detector.patches(side, a).len()), [0; 2], "{last}");
        assert!(detector.curve().is_empty(), "{last}");
        let joint = detector.joint_contact([a, b], &JOINT, Progress::none());
        let joint = joint.expect("parameters in range");
        assert!(joint.iter().all(|contact| contact.total.min_gap >= 0.0), "{last}");
    }
}
