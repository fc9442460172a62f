//! The same bits for any number of threads, for every method.

use distance_field::{
    FieldMethod, FieldParams, NodeValues, QueryParams, SampleBatch, Storage, Voxelization,
};
use fixtures::Mesh;
use fixtures::femur::femur;
use fixtures::sampling::points_near;

use crate::support::build;

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads start").install(work)
}

fn assert_same_bits(mesh: &Mesh, params: &FieldParams) {
    let one = with_threads(1, || build(mesh, params)).expect("a bone fits");
    let points = points_near(mesh, 20_000, 9.0);
    let query = |threads| {
        let mut samples = SampleBatch::default();
        let batch = || one.query_batch(&points, &QueryParams::default(), &mut samples);
        with_threads(threads, batch);
        samples
    };
    for threads in [2, 7] {
        let other = with_threads(threads, || build(mesh, params)).expect("a bone fits");
        let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<_>>();
        assert!(bits(one.values()) == bits(other.values()), "{threads} threads: {params:?}");
        assert_eq!(one.report(), other.report(), "same report for any number of threads");
        assert!(query(1) == query(threads), "{threads} threads: {params:?}");
    }
}

#[test]
fn one_two_and_seven_threads_agree_to_the_bit() {
    let mut open = femur(7.0);
    // A hole and some reversed faces, so that caps are at work too.
    open.faces.drain(100..140);
    for face in (0..open.faces.len()).step_by(31) {
        open.faces[face].swap(0, 1);
    }
    let exact = |truncation| {
        let node_values = NodeValues::QuasiInterpolating;
        let method = FieldMethod::ExactBand { band: 2.5, node_values };
        FieldParams { method, truncation, ..FieldParams::new(2.0) }
    };
    let storage = Storage::Quantized { step: 0.001 };
    assert_same_bits(&open, &exact(Some(15.0)));
    assert_same_bits(&open, &exact(None));
    assert_same_bits(&open, &FieldParams { storage, ..exact(Some(10.0)) });
    for voxelization in [Voxelization::Bresenham, Voxelization::Conservative] {
        let method = FieldMethod::Voxel { voxelization };
        assert_same_bits(&femur(7.0), &FieldParams { method, ..FieldParams::voxel(2.0) });
    }
}
