//! What is refused, by name, and that a refused refit leaves the tree as it was.

use glam::DVec3;
use kdop::{Extents, Leaves, Tree, TreeError, Workspace};

const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

#[test]
fn builds_name_the_first_offender() {
    let nan = [DVec3::ZERO, DVec3::new(0.0, f64::NAN, 0.0), DVec3::Y];
    let infinite = [DVec3::ZERO, DVec3::X, DVec3::Z * f64::INFINITY];
    let inverted = [[DVec3::ZERO, DVec3::ONE], [DVec3::ONE, DVec3::ZERO]];
    let outside = Leaves::Triangles(&[[0, 1, 2], [0, 1, 3]]);
    let points = Leaves::Points;
    let cases = [
        (
            outside,
            Extents::points(&TRIANGLE),
            TreeError::PointOutOfRange { leaf: 1, point: 3, points: 3 },
        ),
        (points, Extents::points(&nan), TreeError::NonFinite { point: 1 }),
        (points, Extents::swept(&TRIANGLE, &infinite), TreeError::NonFinite { point: 2 }),
        (
            points,
            Extents::swept(&TRIANGLE, &nan[..2]),
            TreeError::WrongLength { expected: 3, given: 2 },
        ),
        (
            points,
            Extents::balls(&TRIANGLE, &[1.0, 0.0, -1.0]),
            TreeError::BadRadius { point: 2, radius: -1.0 },
        ),
        (
            points,
            Extents::points(&TRIANGLE).inflated(f64::INFINITY),
            TreeError::BadRadius { point: 0, radius: f64::INFINITY },
        ),
        (points, Extents::boxes(&inverted), TreeError::InvertedBox { point: 1 }),
    ];
    for (leaves, extents, expected) in cases {
        assert_eq!(Tree::build_from(leaves, extents).err(), Some(expected), "{extents:?}");
    }
}

#[test]
fn a_refused_refit_changes_nothing() {
    let many: Vec<DVec3> = (0..500).map(|i| DVec3::splat(f64::from(i))).collect();
    let mut tree = Tree::build(Leaves::Points, &many).unwrap();
    let probe = tree.clone();
    let mut broken = many.clone();
    broken.iter_mut().for_each(|p| *p += DVec3::X * 100.0);
    broken[499].z = f64::NAN;
    assert_eq!(tree.refit(&broken), Err(TreeError::NonFinite { point: 499 }));
    assert_eq!(tree.refit_swept(&many, &broken), Err(TreeError::NonFinite { point: 499 }));
    assert_eq!(tree.refit(&many[1..]), Err(TreeError::WrongLength { expected: 500, given: 499 }));
    assert_eq!(tree.levels(), probe.levels());
    tree.validate().unwrap();
}

#[test]
fn no_leaves_meet_nothing() {
    let empty = Tree::build(Leaves::Triangles(&[]), &TRIANGLE).unwrap();
    let one = Tree::build(Leaves::Triangles(&[[0, 1, 2]]), &TRIANGLE).unwrap();
    let mut workspace = Workspace::new();
    empty.pairs(&one, 1e300, &mut workspace, |_, _| panic!("nothing to meet"));
    one.pairs(&empty, 1e300, &mut workspace, |_, _| panic!("nothing to meet"));
    empty.self_pairs(1e300, &mut workspace, |_, _| panic!("nothing to meet"));
    empty.nearest(DVec3::ZERO, f64::INFINITY, &mut workspace, |_, _| panic!("nothing is near"));
    assert!(empty.root().is_empty() && empty.levels().is_empty() && empty.validate().is_ok());
    let mut met = 0;
    one.pairs(&one.clone(), 1e300, &mut workspace, |_, _| met += 1);
    assert_eq!(met, 1, "no more than there is, however large the margin");
}
