//! Interruption by the progress handler.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use fixtures::shapes;
use glam::DVec3;
use resolve::{ResolveError, ResolveParams, Resolver};
use scene::BodyKind;
use surface::progress::Progress;

use crate::thigh::planted;
use crate::{PARAMS, scene_of};

#[test]
fn an_interrupted_call_puts_soft_bodies_back() {
    let mut scene = planted();
    let before = scene.particle_positions();
    let stop_after = |fraction: f64| {
        if fraction < 0.02 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let progress = Progress::new(&stop_after);
    let interrupted = resolve::resolve(&mut scene, &PARAMS, progress);
    assert!(matches!(interrupted, Err(ResolveError::Interrupted(_))), "{interrupted:?}");
    assert_eq!(scene.particle_positions(), before);

    // The interrupted call changes nothing of the next one.
    let (mut same, mut resolver) = (planted(), Resolver::new(PARAMS).expect("a resolver"));
    resolver.resolve(&mut scene, progress).expect_err("an interruption");
    let next = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert_eq!(next, crate::resolve(&mut same));
}

#[test]
fn progress_is_reported_in_fractions_that_do_not_fall() {
    let fractions = Mutex::new(Vec::new());
    let record = |fraction| {
        fractions.lock().expect("no panic while recording").push(fraction);
        ControlFlow::Continue(())
    };
    let mut scene = planted();
    let rounds = resolve::resolve(&mut scene, &PARAMS, Progress::new(&record));
    let rounds = rounds.expect("a resolution").rounds.len();

    let fractions = fractions.into_inner().expect("no panic while recording");
    assert!(fractions.len() > 5 * rounds, "{} reports in {rounds} rounds", fractions.len());
    assert!(fractions.is_sorted(), "{fractions:?}");
    assert!(fractions.iter().all(|fraction| (0.0..=1.0).contains(fraction)), "{fractions:?}");
}

/// Counts the polls of a resolution of two soft balls that overlap.
fn polls(halvings: u32) -> (usize, usize) {
    let polls = AtomicUsize::new(0);
    let count = |_| {
        polls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let ball = shapes::icosphere(30.0, halvings);
    let other = ball.clone().translated(DVec3::X * 57.0);
    let mut scene =
        scene_of([("a", BodyKind::Deformable, ball), ("b", BodyKind::Deformable, other)]);
    // Pushes spread over all vertices.
    let params = ResolveParams { max_rounds: 1, ..ResolveParams::with_smoothing(60.0) };
    let rounds = resolve::resolve(&mut scene, &params, Progress::new(&count));
    let rounds = rounds.expect("a resolution").rounds.len();
    (polls.load(Ordering::Relaxed), rounds)
}

#[test]
fn polls_of_a_round_grow_with_the_bodies() {
    let [few, many] = [3, 5].map(polls);
    assert_eq!((few.1, many.1), (2, 2), "one round each");
    // 10,242 vertices of each ball instead of 642.
    assert!(many.0 >= few.0 + 2 * 10_242 / 1024 - 2, "{few:?}, {many:?}");
}
