//! Queries about one surface, and trees that follow it.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use ccd::{CcdParams, MovingPoints};
use fixtures::generate::{cases, convex};
use fixtures::shapes;
use glam::DVec3;
use kdop::{StepTree, Workspace};
use proximity::{
    LazySurfaceTree, NoInside, ProximityError, SurfaceTree, SweptError, SweptQuery, SweptSide,
};
use surface::progress::{Interrupted, Progress};
use surface::{Meeting, SurfaceError, triangles_meet};

#[test]
fn hints_never_change_the_closest_point() {
    let workspace = &mut Workspace::default();
    cases(1, 50, |u| {
        let mesh = convex(u)?;
        let tree = SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("finite");
        let point = mesh.positions[u.choose_index(mesh.positions.len())?] * 1.3;
        let face = u32::try_from(u.choose_index(mesh.faces.len())?).expect("a small mesh");
        let [plain, hinted] =
            [None, Some(face)].map(|hint| tree.closest_point(point, 1e3, hint, workspace));
        assert_eq!(plain, hinted);

        // By brute force, of equal distances the lowest face.
        let faces = 0..u32::try_from(mesh.faces.len()).expect("a small mesh");
        let all = faces.map(|face| tree.closest_on_face(point, face));
        let best = all.reduce(|best, found| if found.is_before(&best) { found } else { best });
        assert_eq!(plain, best);
        let distance = best.expect("a face").distance;
        assert!(tree.closest_point(point, 0.9 * distance, Some(face), workspace).is_none());
        Ok(())
    });
}

#[test]
fn a_near_point_is_of_the_surface_and_mostly_the_closest_one() {
    let ball = shapes::icosphere(1.0, 3);
    let tree = SurfaceTree::new(ball.surface(), ball.positions.clone()).expect("finite");
    let workspace = &mut Workspace::default();
    let mut closest = 0;
    for (number, corner) in ball.positions.iter().enumerate() {
        // From a face beside it, and from any.
        let point = 0.99 * *corner + 0.03 * corner.any_orthogonal_vector();
        let beside = ball.surface().vertex_faces(u32::try_from(number).expect("few vertices"))[0];
        for from in [beside, 700] {
            let near = tree.near_point(point, from);
            assert_eq!(near, tree.closest_on_face(point, near.face));
            assert!(near.distance <= tree.closest_on_face(point, from).distance);
            let found = tree.closest_point(point, f64::INFINITY, None, workspace).expect("a face");
            assert!(near.distance >= found.distance, "{near:?} {found:?}");
            closest += usize::from(from == beside && near.distance <= found.distance);
        }
    }
    assert!(closest > ball.positions.len() * 9 / 10, "{closest}");
}

#[test]
fn a_plate_pressed_through_itself_crosses_itself() {
    let plate = shapes::plate(DVec3::new(8.0, 8.0, 1.0), [8, 8]);
    let mut tree = SurfaceTree::new(plate.surface(), plate.positions.clone()).expect("finite");
    let workspace = &mut Workspace::default();
    assert_eq!(tree.self_crossings(workspace, Progress::none()), Ok(vec![]));

    let pressed = plate.positions.iter().map(|p| {
        let is_middle_of_top = p.z > 0.0 && p.truncate().length() < 1.5;
        *p - if is_middle_of_top { 1.5 * DVec3::Z } else { DVec3::ZERO }
    });
    tree.set_positions(pressed).expect("finite");
    let crossings = tree.self_crossings(workspace, Progress::none()).expect("no interruption");
    assert!(!crossings.is_empty() && crossings.is_sorted(), "{crossings:?}");
}

/// Faces between vertices anywhere on a ball are all near each other: each some thousand pairs are a
/// poll, and every poll can end the search.
#[test]
fn a_search_for_self_crossings_can_be_interrupted() {
    let mut mesh = shapes::icosphere(10.0, 2);
    let count = mesh.positions.len();
    mesh.positions = (0..count).map(|i| mesh.positions[37 * i % count]).collect();
    let tree = SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("finite");
    let workspace = &mut Workspace::default();
    let mut pairs = 0_usize;
    tree.tree().self_pairs(0.0, workspace, |_, _| pairs += 1);

    // All pairs of faces; neighbors at an edge touch.
    let (mut crossing, faces) = (Vec::new(), u32::try_from(mesh.faces.len()).expect("few"));
    for f in 0..faces {
        for g in f + 1..faces {
            let meeting = triangles_meet(tree.corners(f), tree.corners(g));
            if meeting == Meeting::Crossing {
                crossing.push([f, g]);
            }
        }
    }

    for last in [1, 4, usize::MAX] {
        let polls = AtomicUsize::new(0);
        let stop = |_| {
            let is_last = polls.fetch_add(1, Ordering::Relaxed) + 1 >= last;
            if is_last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let found = tree.self_crossings(workspace, Progress::new(&stop));
        assert!(found == if last < usize::MAX { Err(Interrupted) } else { Ok(crossing.clone()) });
        assert_eq!(polls.into_inner(), last.min((pairs + count).div_ceil(4096)), "{pairs} pairs");
    }
    assert!(pairs > 5 * 4096, "{pairs} pairs");
}

#[test]
fn positions_that_do_not_fit_change_nothing() {
    let ball = shapes::octasphere(2.0, 1);
    let mut tree = SurfaceTree::new(ball.surface(), ball.positions.clone()).expect("finite");
    let short = tree.set_positions(ball.positions[1..].iter().copied());
    let (expected, got) = (ball.positions.len(), ball.positions.len() - 1);
    let error = SurfaceError::PositionCount { expected, got };
    assert_eq!(short, Err(ProximityError::Surface(error)));
    assert!(tree.set_positions(ball.positions.iter().map(|p| *p / 0.0)).is_err());
    assert_eq!(tree.positions().as_slice(), ball.positions);
    assert!(tree.contains(DVec3::ZERO, &mut Workspace::default()));
}

#[test]
fn a_lazy_tree_is_fitted_on_demand() {
    let ball = shapes::octasphere(2.0, 1);
    let mut lazy = LazySurfaceTree::new(ball.surface(), ball.positions.clone()).expect("finite");
    assert!(lazy.fitted().is_none() && lazy.step_tree().is_none());

    let workspace = &mut Workspace::default();
    assert!(lazy.fit().expect("a tree").contains(DVec3::ZERO, workspace));
    lazy.set_positions(ball.positions.iter().map(|p| *p + 9.0 * DVec3::X)).expect("finite");
    assert!(lazy.fitted().is_none());
    assert!(!lazy.fit().expect("a tree").contains(DVec3::ZERO, workspace));
    assert!(lazy.fitted().is_some());
}

#[test]
fn a_surface_without_inside_is_reported() {
    let mut cube = shapes::cube(1.0);
    cube.faces.pop();
    let open = SurfaceTree::new(cube.surface(), cube.positions).expect("finite");
    let Err(NoInside::OddEdges { count, faces, .. }) = open.has_inside() else {
        panic!("{:?}", open.has_inside());
    };
    assert_eq!((count, faces), (3, 1));
}

#[test]
fn a_swept_query_can_be_interrupted() {
    // Both balls shrink at one place, where every face meets its double.
    let ball = shapes::icosphere(10.0, 3);
    let tree = SurfaceTree::new(ball.surface(), ball.positions.clone()).expect("finite");
    let start = [&ball.positions[..], &ball.positions].concat();
    let end: Vec<DVec3> = start.iter().map(|p| *p * 0.5).collect();
    let motion = MovingPoints::new(&start, &end).expect("finite");
    let (surface, count) = (tree.surface(), u32::try_from(ball.positions.len()).expect("few"));
    let mut end_tree = tree.tree().clone();
    end_tree.refit(&end[..ball.positions.len()]).expect("finite");
    let tree = StepTree::new(tree.tree(), &end_tree).expect("one arrangement");
    let [a, b] = [0, count].map(|first_particle| SweptSide { surface, tree, first_particle });

    let stop = |_| ControlFlow::Break(());
    let (query, workspace) =
        (SweptQuery::new(&motion, &CcdParams::DEFAULT), &mut Workspace::default());
    let interrupted = query.run(&a, &b, workspace, Progress::new(&stop));
    assert!(matches!(interrupted, Err(SweptError::Interrupted(_))), "{interrupted:?}");
}

/// A build is polled every some thousand faces, ends where it is told to, and can begin again.
#[test]
fn a_build_can_be_interrupted() {
    let ball = shapes::icosphere(10.0, 6);
    let mut lazy = LazySurfaceTree::new(ball.surface(), ball.positions.clone()).expect("finite");
    let polls = Cell::new(0);
    let stop_at = |last: u32| {
        let polls = &polls;
        move || {
            polls.set(polls.get() + 1);
            polls.get() < last
        }
    };
    for last in [1, 5, 10] {
        polls.set(0);
        assert!(!lazy.fit_while(&stop_at(last)).expect("a tree"), "{last}");
        assert_eq!(polls.get(), last);
        assert!(lazy.fitted().is_none() && !lazy.is_built());
    }
    polls.set(0);
    assert!(lazy.fit_while(&stop_at(u32::MAX)).expect("a tree"));
    assert!(polls.get() > 12, "{} polls in {} faces", polls.get(), ball.faces.len());

    // As one that nobody interrupts.
    let eager = SurfaceTree::new(ball.surface(), ball.positions).expect("finite");
    let lazy = lazy.fitted().expect("a tree");
    assert!(StepTree::new(eager.tree(), lazy.tree()).is_some(), "another arrangement");
    assert_eq!(eager.tree().root(), lazy.tree().root());
}

#[test]
fn trees_are_built_anew_where_they_have_become_loose() {
    // Alternating layers of an ellipsoid move apart, so that neighbors of the first tree are none.
    let mesh = shapes::ellipsoid(DVec3::new(12.0, 8.0, 80.0), 4);
    let shuffled = |p: &DVec3| *p + DVec3::Y * 600.0 * (p.z / 4.0).floor().rem_euclid(2.0);
    let moved: Vec<DVec3> = mesh.positions.iter().map(shuffled).collect();
    let (surface, x) = (mesh.surface(), mesh.positions.clone());
    let mut lazy = LazySurfaceTree::new(surface.clone(), x.clone()).expect("finite");
    lazy.fit().expect("a tree");
    let mut eager = SurfaceTree::new(surface.clone(), x.clone()).expect("finite");
    let mut plain = eager.tree().clone();
    plain.refit(&moved).expect("finite");
    assert!(plain.looseness() > 4.0, "{}", plain.looseness());

    // Both are as tight as built there; a small motion keeps a tree.
    lazy.set_positions(moved.iter().copied()).expect("finite");
    eager.set_positions(moved.iter().copied()).expect("finite");
    for tree in [lazy.fit().expect("a tree").tree(), eager.tree()] {
        assert!((tree.looseness() - 1.0).abs() < 1e-12, "{}", tree.looseness());
    }
    let lifted = moved.iter().map(|p| *p * 1.2);
    lazy.set_positions(lifted).expect("finite");
    let looseness = lazy.fit().expect("a tree").tree().looseness();
    assert!((looseness - 1.2).abs() < 1e-3, "{looseness}");

    // The tree of a step is of the new one.
    let end: Vec<DVec3> = mesh.positions.iter().map(|p| *p + DVec3::X).collect();
    lazy.set_positions(mesh.positions.iter().copied()).expect("finite");
    lazy.fit_step(surface.positions(&end).expect("finite")).expect("a step");
    lazy.set_positions(moved.iter().copied()).expect("finite");
    lazy.fit().expect("a tree");
    lazy.fit_step(surface.positions(&end).expect("finite")).expect("a step");
    let step = lazy.step_tree().expect("the arrangement of the new tree");
    assert_eq!(step.start().leaf_count(), mesh.faces.len());

    // So it is where steps alone are taken. After a move there is no step.
    let mut lazy = LazySurfaceTree::new(surface.clone(), mesh.positions.clone()).expect("finite");
    lazy.fit().expect("a tree");
    lazy.set_positions(moved.iter().copied()).expect("finite");
    lazy.fit_step(surface.positions(&end).expect("finite")).expect("a step");
    let looseness = lazy.fitted().expect("a tree").tree().looseness();
    assert!((looseness - 1.0).abs() < 1e-12, "{looseness}");
    assert!(lazy.step_tree().is_some());
    lazy.set_positions(mesh.positions.iter().copied()).expect("finite");
    lazy.fit().expect("a tree");
    assert!(lazy.step_tree().is_none(), "its start is not where the surface is");
}

#[test]
fn points_on_the_surface_are_not_inside() {
    let cube = shapes::cube(2.0);
    let tree = SurfaceTree::new(cube.surface(), cube.positions).expect("a tree");
    let mut workspace = Workspace::default();

    // A lattice on the faces, edges and corners, within and around the cube.
    for index in 0..11 * 11 * 11 {
        let place = [index % 11, index / 11 % 11, index / 121].map(f64::from);
        let point = 0.25 * (DVec3::from_array(place) - 5.0);
        let is_within = point.abs().max_element() < 1.0;
        assert_eq!(tree.contains(point, &mut workspace), is_within, "{point}");
    }
}

/// Three coordinates of 8 bytes per vertex, three numbers of 4 bytes per face, and the tree.
#[test]
fn memory_is_that_of_positions_faces_and_tree() {
    let ball = shapes::icosphere(2.0, 2);
    let tree = SurfaceTree::new(ball.surface(), ball.positions).expect("finite");
    assert_eq!(tree.bytes(), 162 * 24 + 320 * 12 + tree.tree().bytes());
}

#[test]
fn a_lazy_tree_can_be_declared_open() {
    let ball = shapes::octasphere(2.0, 1);
    let lazy = LazySurfaceTree::new(ball.surface(), ball.positions).expect("finite");
    assert_eq!(lazy.has_inside(), Ok(()));
    let mut open = lazy.declared_open();
    assert_eq!(open.has_inside(), Err(NoInside::DeclaredOpen));
    let fitted = open.fit().expect("a tree");
    assert_eq!(fitted.has_winding_number(), Err(NoInside::DeclaredOpen));
}
