//! Pairs in memory that other pairs have used.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use fixtures::{Mesh, shapes};
use glam::DVec3;
use proximity::{PairProximity, PairSide, SurfaceTree};
use surface::progress::{Interrupted, Progress};

fn tree(mesh: Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("a tree")
}

#[test]
fn memory_of_another_pair_is_no_part_of_an_answer() {
    let a = tree(shapes::icosphere(10.0, 3));
    let mut used = PairProximity::default();
    let mut inside = 0;
    for (by, margin) in [(15.0, 0.0), (19.5, 0.5), (2.0, 0.0), (2.0, 1.0), (40.0, 1.0)] {
        let other = shapes::ellipsoid(DVec3::new(10.0, 4.0, 4.0), 3);
        let b = tree(other.translated(DVec3::new(by, 0.3, 0.1)));
        let mut fresh = PairProximity::default();
        fresh.compute(&a, &b, margin);
        used.compute(&b, &a, 3.0 * margin);
        used.compute(&a, &b, margin);

        assert_eq!(used.crossing_faces(), fresh.crossing_faces(), "by {by}");
        for (used, fresh) in used.sides().into_iter().zip(fresh.sides()) {
            assert_eq!(used.inside_vertices(), fresh.inside_vertices(), "by {by}");
            assert_eq!(used.near(), fresh.near(), "by {by}");
            for face in 0..1280 {
                assert_eq!(used.near_faces().row(face), fresh.near_faces().row(face), "by {by}");
            }
            inside += fresh.inside_vertices().len();
        }

        // The first side alone is that of both.
        used.compute(&b, &a, margin);
        used.compute_first(&a, &b, margin);
        assert_eq!(used.crossing_faces(), fresh.crossing_faces(), "by {by}");
        let ([one, none], [same, _]) = (used.sides(), fresh.sides());
        assert_eq!(one.inside_vertices(), same.inside_vertices(), "by {by}");
        assert_eq!(one.near(), same.near(), "by {by}");
        assert!(none.near().is_empty() && none.inside_vertices().is_empty(), "by {by}");
    }
    assert!(inside > 20, "{inside}");
}

/// Computes a pair, ended by the poll of a number.
fn compute_until(
    pair: &mut PairProximity,
    [a, b]: [&SurfaceTree; 2],
    last: usize,
) -> Result<(), Interrupted> {
    let polls = AtomicUsize::new(0);
    let handler = |_: f64| {
        let poll = polls.fetch_add(1, Ordering::Relaxed);
        if poll < last { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    pair.try_compute(a, b, 0.5, Progress::new(&handler))
}

#[test]
fn nothing_is_left_of_a_pair_that_was_interrupted() {
    let [a, b] = [0.0, 15.0].map(|x| tree(shapes::icosphere(10.0, 2).translated(x * DVec3::X)));
    let mut pair = PairProximity::default();
    let mut polls = 0;
    loop {
        // The pair before overlaps.
        pair.compute(&b, &a, 1.0);
        if compute_until(&mut pair, [&a, &b], polls).is_ok() {
            break;
        }
        assert!(!pair.overlaps() && !pair.has_contact(), "ended by poll {polls}");
        assert!(pair.meeting_faces().is_empty() && pair.tested_faces() == 0, "poll {polls}");
        let is_empty = |side: &PairSide| side.near_faces().iter().next().is_none();
        assert!(pair.sides().into_iter().all(is_empty), "poll {polls}");
        polls += 1;
    }
    assert!(pair.overlaps() && polls > 4, "{polls}");
}

#[test]
fn a_body_deeper_inside_than_the_margin_is_near_with_all_of_its_vertices() {
    let (small, large) = (tree(shapes::cube(1.0)), tree(shapes::cube(9.0)));
    let mut pair = PairProximity::default();
    for margin in [0.0, 0.5, 5.0] {
        pair.compute(&small, &large, margin);
        let near = pair.sides()[0].near();
        assert_eq!(near.len(), 8, "margin {margin}");
        assert!(near.iter().all(|near| (near.gap + 4.0).abs() < 1e-12), "margin {margin}");
    }
}
