//! Golden file of a small scene: levels, root, and the order of visits.

use std::fmt::Write;

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};

/// Builds a wavy band of `n` cells along x, two triangles each, whose coordinates are exact binary
/// fractions.
fn band(n: u32, height: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let wave = [0.0, 0.75, 1.0, 0.75, 0.0, -0.75, -1.0, -0.75];
    let point = |i: u32| {
        let column = i / 2;
        let z = wave[column as usize % 8] + height;
        DVec3::new(f64::from(column) * 0.5, f64::from(i % 2), z)
    };
    let cell = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]];
    ((0..2 * n + 2).map(point).collect(), (0..n).flat_map(cell).collect())
}

#[test]
fn two_bands_that_cross() {
    let ((x, t), (y, u)) = (band(40, 0.0), band(12, 0.5));
    let turned: Vec<DVec3> = y.iter().map(|p| DVec3::new(6.0 - p.y, p.x - 3.0, p.z)).collect();
    let a = Tree::build(Leaves::Triangles(&t), &x).unwrap();
    let b = Tree::build(Leaves::Triangles(&u), &turned).unwrap();
    let mut text = String::new();
    for (level, bounds) in a.levels().iter().enumerate() {
        writeln!(text, "level {level}: {} bounds", bounds.len()).unwrap();
    }
    for k in 0..9 {
        let [lo, hi] = a.root().interval(k);
        writeln!(text, "root along {}: {lo} to {hi}", kdop::direction::<9>(k)).unwrap();
    }
    let mut workspace = Workspace::new();
    for margin in [0.0, 0.25] {
        let mut pairs = Vec::new();
        a.pairs(&b, margin, &mut workspace, |i, j| pairs.push((i, j)));
        writeln!(text, "within {margin}: {pairs:?}, {:?}", workspace.counters()).unwrap();
    }
    let mut order = Vec::new();
    a.nearest(DVec3::new(6.0, 0.5, 3.0), f64::INFINITY, &mut workspace, |leaf, bound| {
        order.push((leaf, bound));
        2.5
    });
    writeln!(text, "nearest: {order:?}").unwrap();
    insta::assert_snapshot!(text);
}
