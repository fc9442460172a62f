//! Parallel refits and traversals return the results of one thread, bit for bit and in order.

use glam::DVec3;
use kdop::{Extents, Leaves, Tree, Workspace};

/// Builds a crumpled sheet of `2 n²` triangles.
fn sheet(n: u32, phase: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let point = |i: u32, j: u32| {
        let (x, y) = (f64::from(i), f64::from(j));
        DVec3::new(x, y, 2.0 * (0.9 * x + phase).sin() * (0.7 * y).cos())
    };
    let points = (0..=n).flat_map(|i| (0..=n).map(move |j| point(i, j))).collect();
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let cell = |i: u32, j: u32| {
        [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    (points, (0..n).flat_map(|i| (0..n).flat_map(move |j| cell(i, j))).collect())
}

/// Runs a check on pools of one, two and seven threads.
fn in_pools(run: impl Fn() + Sync) {
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of threads").install(&run);
    }
}

#[test]
fn pairs_have_the_sequential_order() {
    let ((x, t), (y, u)) = (sheet(60, 0.0), sheet(45, 1.0));
    let (a, b) = (
        Tree::build(Leaves::Triangles(&t), &x).unwrap(),
        Tree::build(Leaves::Triangles(&u), &y).unwrap(),
    );
    for margin in [0.0, 1.5] {
        let (mut pairs, mut own) = (Vec::new(), Vec::new());
        a.pairs(&b, margin, &mut Workspace::new(), |i, j| pairs.push((i, j)));
        a.self_pairs(margin, &mut Workspace::new(), |i, j| own.push((i, j)));
        assert!(
            pairs.len() > 1000 && (margin == 0.0 || own.len() > 1000),
            "{} {}",
            pairs.len(),
            own.len()
        );
        in_pools(|| {
            assert_eq!(a.par_pairs(&b, margin), pairs);
            assert_eq!(a.par_self_pairs(margin), own);
        });
    }
}

#[test]
fn refits_agree_to_the_bit() {
    let ((x, t), (y, _)) = (sheet(120, 0.0), sheet(120, 1.0));
    let radii = vec![0.25; x.len()];
    let cases = [
        Extents::Points(&y),
        Extents::Swept { start: &x, end: &y },
        Extents::Balls { centers: &y, radii: &radii },
    ];
    let built = Tree::build(Leaves::Triangles(&t), &x).unwrap();
    for extents in cases {
        let mut once = built.clone();
        once.refit_from(extents).unwrap();
        let mut pairs = Vec::new();
        once.pairs(&built, 0.0, &mut Workspace::new(), |i, j| pairs.push((i, j)));
        in_pools(|| {
            let mut tree = built.clone();
            tree.par_refit_from(extents).unwrap();
            tree.validate().unwrap();
            assert_eq!(tree.root(), once.root());
            assert_eq!(tree.par_pairs(&built, 0.0), pairs);
        });
    }
}
