//! The same bits for any number of threads, for every method.

#![cfg(feature = "rayon")]

mod common;

use common::build;
use distance_field::{FieldMethod, FieldParams, NodeValues, QueryParams, SampleBatch, Storage};
use fixtures::femur::femur;
use fixtures::sampling::points_near;

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads start").install(work)
}

#[test]
fn one_two_and_seven_threads_agree_to_the_bit() {
    let mut mesh = femur(7.0);
    // A hole and some faces the wrong way round, so that caps are at work too.
    mesh.faces.drain(100..140);
    for face in (0..mesh.faces.len()).step_by(31) {
        mesh.faces[face].swap(0, 1);
    }
    let exact = |relax, truncation| FieldParams {
        method: FieldMethod::ExactBand {
            band: 2.5,
            relax,
            node_values: NodeValues::QuasiInterpolating,
        },
        truncation,
        spacing: 2.0,
        ..FieldParams::new(1.0)
    };
    for options in [
        exact(false, Some(15.0)),
        exact(true, None),
        FieldParams { storage: Storage::Quantized { step: 0.001 }, ..exact(true, Some(10.0)) },
    ] {
        let one = with_threads(1, || build(&mesh, &options)).expect("a bone fits");
        let points = points_near(&mesh, 20_000, 9.0);
        let ask = |threads| {
            let mut samples = SampleBatch::default();
            with_threads(threads, || {
                one.query_batch(&points, &QueryParams::default(), &mut samples)
            });
            samples
        };
        for threads in [2, 7] {
            let other = with_threads(threads, || build(&mesh, &options)).expect("a bone fits");
            let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<_>>();
            assert!(bits(one.values()) == bits(other.values()), "{threads} threads: {options:?}");
            assert_eq!(one.report().measured_error, other.report().measured_error);
            assert!(ask(1) == ask(threads), "{threads} threads: {options:?}");
        }
    }
}
