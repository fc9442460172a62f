//! Interruption of generation by its progress handler.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use medial::{MedialError, MedialParams, MedialSurface, Topology, generate, generate_each};
use surface::parallel::on_calling_thread;
use surface::progress::{Interrupted, Progress};

use crate::support::muscle;

/// Runs generation until the handler has been called `limit` times; returns its error and the
/// number of calls.
fn interrupted_after(params: &MedialParams, limit: usize) -> (Option<MedialError>, usize) {
    let mesh = muscle();
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite");
    let calls = AtomicUsize::new(0);
    let handler = |_| {
        let is_over = calls.fetch_add(1, Ordering::Relaxed) + 1 >= limit;
        if is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    // Other threads may be within a call of theirs.
    let generated = on_calling_thread(|| generate(&surface, x, params, Progress::new(&handler)));
    (generated.err(), calls.into_inner())
}

/// At any call, the handler is not called again: no phase goes on without its permission.
#[test]
fn every_poll_can_end_generation() {
    for params in [MedialParams::balls(40), MedialParams::tolerance(3.0)] {
        let (error, polls) = interrupted_after(&params, usize::MAX);
        assert_eq!(error, None);
        assert!(polls > 50, "{polls} polls of {params:?}");
        for limit in [1, 2, 5, polls / 4, polls / 2, polls - 1] {
            let (error, calls) = interrupted_after(&params, limit);
            assert_eq!(error, Some(MedialError::Interrupted(Interrupted)), "call {limit}");
            assert_eq!(calls, limit, "of {polls}");
        }
    }
}

/// Returns the fractions that a call reports.
fn reported(call: impl Fn(Progress<'_>)) -> Vec<f64> {
    let fractions = Mutex::new(Vec::new());
    let handler = |fraction| {
        fractions.lock().expect("no panic").push(fraction);
        ControlFlow::Continue(())
    };
    on_calling_thread(|| call(Progress::new(&handler)));
    fractions.into_inner().expect("no panic")
}

#[test]
fn progress_rises_to_its_end() {
    let mesh = muscle();
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    for (params, end) in [(MedialParams::balls(20), 1.0), (MedialParams::tolerance(1.0), 0.5)] {
        let fractions = reported(|progress| {
            generate(&surface, x, &params, progress).unwrap();
        });
        assert!(fractions.is_sorted(), "{fractions:?}");
        assert!(fractions.last().is_some_and(|&last| last >= end && last <= 1.0), "{fractions:?}");
    }
}

/// Of several sizes, each takes as much of the bar as the others.
#[test]
fn progress_of_several_sizes_rises_to_its_end() {
    let mesh = muscle();
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let fractions = reported(|progress| {
        let params = MedialParams::balls(1);
        generate_each(&surface, x, &[20, 40, 30], &params, progress).unwrap();
    });
    assert!(fractions.is_sorted(), "{fractions:?}");
    assert!(fractions.last().is_some_and(|&last| (last - 1.0).abs() < 1e-12), "{fractions:?}");
    let steps = fractions.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(steps.fold(0.0, f64::max) < 0.3, "{fractions:?}");
}

/// Returns a cone of two balls, and a ball apart from it.
fn cone_and_ball() -> MedialSurface {
    let text = "3 1 0\nv 0 0 0 2\nv 5 0 0 1\nv 12 0 0 2\ne 0 1\n";
    MedialSurface::from_ma(text).expect("three balls")
}

/// No phase of the count stands still: each of its reports is near the one before.
#[test]
fn progress_of_topology_rises_to_its_end() {
    let medial = cone_and_ball();
    let fractions = reported(|progress| {
        let topology = Topology::of_union(&medial, 0.1, progress).expect("the grid fits");
        assert_eq!(topology, Topology { components: 2, tunnels: 0, cavities: 0 });
    });
    assert!(fractions.is_sorted(), "{fractions:?}");
    assert!(fractions.last().is_some_and(|&last| last > 0.99 && last <= 1.0), "{fractions:?}");
    let steps = fractions.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(steps.fold(fractions[0], f64::max) < 0.05, "{fractions:?}");
}

#[test]
fn every_poll_can_end_topology() {
    let medial = cone_and_ball();
    let polls = reported(|progress| {
        Topology::of_union(&medial, 0.1, progress).expect("the grid fits");
    });
    for limit in [1, 2, polls.len() / 4, polls.len() / 2, polls.len() - 1] {
        let calls = AtomicUsize::new(0);
        let handler = |_| {
            let is_over = calls.fetch_add(1, Ordering::Relaxed) + 1 >= limit;
            if is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let topology = Topology::of_union(&medial, 0.1, Progress::new(&handler));
        assert_eq!(topology, Err(MedialError::Interrupted(Interrupted)), "call {limit}");
        assert_eq!(calls.into_inner(), limit, "of {}", polls.len());
    }
}
