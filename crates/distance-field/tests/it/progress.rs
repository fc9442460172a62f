//! Progress of builds, and their interruption.

use std::ops::ControlFlow;
use std::sync::Mutex;

use distance_field::{DistanceField, FieldError, FieldParams};
use fixtures::femur::femur;
use surface::progress::{Interrupted, Progress};

/// Builds a field by each method with a handler of its progress.
fn build_each(handler: &(dyn Fn(f64) -> ControlFlow<()> + Sync)) -> Vec<Result<(), FieldError>> {
    let mesh = femur(6.0);
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let untruncated = FieldParams { truncation: None, ..FieldParams::new(1.5) };
    let all = [FieldParams::new(1.5), untruncated, FieldParams::voxel(1.5)];
    let build = |params: FieldParams| {
        DistanceField::build(&surface, x, &params, Progress::new(handler)).map(|_| ())
    };
    all.map(build).into()
}

#[test]
fn builds_report_their_progress_and_complete() {
    let fractions = Mutex::new(Vec::new());
    let results = build_each(&|fraction| {
        fractions.lock().unwrap().push(fraction);
        ControlFlow::Continue(())
    });
    assert_eq!(results, [Ok(()), Ok(()), Ok(())]);
    let fractions = fractions.into_inner().unwrap();
    assert!(fractions.len() > 100 && fractions.iter().all(|f| (0.0..=1.0).contains(f)));
}

#[test]
fn builds_end_where_their_handler_says() {
    for limit in [0.0, 0.2, 0.5, 0.85] {
        let results = build_each(&|fraction| {
            if fraction <= limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let interrupted = Err(FieldError::Interrupted(Interrupted));
        assert!(results.iter().filter(|result| **result == interrupted).count() >= 2, "{limit}");
    }
}
