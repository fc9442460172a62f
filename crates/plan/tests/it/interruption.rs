//! Polls for interruption while a plan is made.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use plan::{Plan, PlanError, PlanParams};
use surface::progress::Progress;

use crate::three_of;

/// Makes a plan on one thread, ended by the poll of a number; returns true if it was completed,
/// and the number of polls.
fn plan_with_polls(halvings: u32, last: usize) -> (bool, usize) {
    let polls = AtomicUsize::new(0);
    let handler = |_| {
        let is_last = polls.fetch_add(1, Ordering::Relaxed) + 1 >= last;
        if is_last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let is_made = one.install(|| {
        let (mut scene, _) = three_of(halvings);
        let params = PlanParams { frames: 10_000_000, ..PlanParams::with_tolerance(0.5) };
        let made = Plan::new(&mut scene, &params, Progress::new(&handler));
        assert!(matches!(made, Ok(_) | Err(PlanError::Interrupted(_))), "{made:?}");
        made.is_ok()
    });
    (is_made, polls.load(Ordering::Relaxed))
}

#[test]
fn a_plan_ends_at_any_poll() {
    let (is_made, polls) = plan_with_polls(3, usize::MAX);
    assert!(is_made);
    for last in (1..=polls).step_by(1 + polls / 40) {
        let (is_made, polled) = plan_with_polls(3, last);
        assert!(!is_made, "poll {last} of {polls}");
        // Every piece of the loops that are under way polls once more, and does nothing.
        assert!(polled <= last + 128, "{polled} polls after the interruption at {last}");
    }
}

/// Polls are for pieces of the work, not for its stages: more work, more polls.
#[test]
fn polls_grow_with_the_bodies() {
    let [few, many] = [3, 5].map(|halvings| plan_with_polls(halvings, usize::MAX).1);
    // Three bodies of 20,480 faces each; a thousand faces take some milliseconds.
    assert!(many > few + 3 * 20_480 / 1024, "{few} polls, {many} for 16 times as many faces");
}
