//! Errors of builds and refits, and trees without leaves.

use glam::DVec3;
use kdop::{Extents, Leaves, Tree, TreeError, Workspace};

const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

#[test]
fn a_build_reports_the_first_offender() {
    let nan = [DVec3::ZERO, DVec3::new(0.0, f64::NAN, 0.0), DVec3::Y];
    let infinite = [DVec3::ZERO, DVec3::X, DVec3::Z * f64::INFINITY];
    let outside = Leaves::Triangles(&[[0, 1, 2], [0, 1, 3]]);
    let points = Leaves::Points;
    let cases = [
        (
            outside,
            Extents::Points(&TRIANGLE),
            TreeError::PointOutOfRange { leaf: 1, point: 3, points: 3 },
        ),
        (points, Extents::Points(&nan), TreeError::NonFinite { point: 1 }),
        (
            points,
            Extents::Swept { start: &TRIANGLE, end: &infinite },
            TreeError::NonFinite { point: 2 },
        ),
        (
            points,
            Extents::Swept { start: &TRIANGLE, end: &nan[..2] },
            TreeError::WrongLength { expected: 3, given: 2 },
        ),
        (
            points,
            Extents::Balls { centers: &TRIANGLE, radii: &[1.0, 0.0, -1.0] },
            TreeError::BadRadius { point: 2, radius: -1.0 },
        ),
    ];
    for (leaves, extents, expected) in cases {
        assert_eq!(Tree::build_from(leaves, extents).err(), Some(expected), "{extents:?}");
    }
}

#[test]
fn a_rejected_refit_leaves_the_tree_unchanged() {
    let many: Vec<DVec3> = (0..500).map(|i| DVec3::splat(f64::from(i))).collect();
    let mut tree = Tree::build(Leaves::Points, &many).unwrap();
    let before = tree.clone();
    let mut broken = many.clone();
    broken.iter_mut().for_each(|p| *p += DVec3::X * 100.0);
    broken[499].z = f64::NAN;
    assert_eq!(tree.refit(&broken), Err(TreeError::NonFinite { point: 499 }));
    assert_eq!(tree.refit_swept(&many, &broken), Err(TreeError::NonFinite { point: 499 }));
    assert_eq!(tree.refit(&many[1..]), Err(TreeError::WrongLength { expected: 500, given: 499 }));
    assert_eq!(tree.levels(), before.levels());
    tree.validate().unwrap();
}

#[test]
fn a_tree_without_leaves_overlaps_nothing() {
    let empty = Tree::build(Leaves::Triangles(&[]), &TRIANGLE).unwrap();
    let one = Tree::build(Leaves::Triangles(&[[0, 1, 2]]), &TRIANGLE).unwrap();
    let mut workspace = Workspace::new();
    empty.pairs(&one, 1e300, &mut workspace, |_, _| panic!("nothing to meet"));
    one.pairs(&empty, 1e300, &mut workspace, |_, _| panic!("nothing to meet"));
    empty.self_pairs(1e300, &mut workspace, |_, _| panic!("nothing to meet"));
    empty.nearest(DVec3::ZERO, f64::INFINITY, &mut workspace, |_, _| panic!("nothing is near"));
    assert!(empty.root().is_empty() && empty.levels().is_empty() && empty.validate().is_ok());
    let mut hits = 0;
    one.pairs(&one.clone(), 1e300, &mut workspace, |_, _| hits += 1);
    assert_eq!(hits, 1, "no more pairs than there are, however large the margin");
}
