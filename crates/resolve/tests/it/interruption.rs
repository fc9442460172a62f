//! Interruption by the progress handler.

use std::ops::ControlFlow;
use std::sync::Mutex;

use resolve::{ResolveError, Resolver};
use surface::progress::Progress;

use crate::PARAMS;
use crate::thigh::planted;

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
