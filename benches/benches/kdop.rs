//! What a tree of 18-DOPs costs: build, refits, pairs and self pairs of muscle meshes.
#![allow(missing_docs, reason = "criterion's macros emit undocumented items")]

use criterion::{Criterion, criterion_group, criterion_main};
use fixtures::muscle::{Placement, scene};
use kdop::{Leaves, Tree, Workspace};

fn muscles(c: &mut Criterion) {
    let scene = scene(6500, Placement::Oblique);
    let build = |muscle: &fixtures::muscle::Muscle| {
        Tree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]).expect("a valid mesh")
    };
    let [mut a, b] = [build(&scene.a), build(&scene.b)];
    let mut workspace = Workspace::new();
    let mut group = c.benchmark_group("kdop 6.5k");
    group.bench_function("build", |bench| bench.iter(|| build(&scene.a)));
    group.bench_function("refit", |bench| bench.iter(|| a.refit(&scene.a.states[0])));
    group.bench_function("pairs", |bench| {
        bench.iter(|| {
            let mut count = 0;
            a.pairs(&b, 0.0, &mut workspace, |_, _| count += 1);
            count
        });
    });
    group.bench_function("self pairs", |bench| {
        bench.iter(|| {
            let mut count = 0;
            a.self_pairs(0.0, &mut workspace, |_, _| count += 1);
            count
        });
    });
    group.finish();
}

criterion_group!(benches, muscles);
criterion_main!(benches);
