//! Surfaces cut into regions by others, with planted answers.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use scene::{BodyId, BodyKind, Scene, Side};

/// A sheet of 40 × 40 in the plane z = 0, its normals upward, of 20 × 20 squares.
fn sheet() -> Mesh {
    const N: u32 = 20;
    let at = |i: u32, j: u32| DVec3::new(2.0 * f64::from(i) - 20.0, 2.0 * f64::from(j) - 20.0, 0.0);
    let positions = (0..=N).flat_map(|j| (0..=N).map(move |i| at(i, j))).collect();
    let corner = |i: u32, j: u32| i + (N + 1) * j;
    let square = |i: u32, j: u32| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let faces = (0..N).flat_map(|j| (0..N).flat_map(move |i| square(i, j))).collect();
    Mesh { positions, faces }
}

fn scene(bodies: [(&str, BodyKind, Mesh); 2]) -> (Scene, [BodyId; 2]) {
    let mut scene = Scene::new();
    let ids = bodies.map(|(name, kind, mesh)| {
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body")
    });
    (scene, ids)
}

/// Sides and areas, with each region's faces all there and on one side by `is_right`.
fn sides(
    (scene, [body, by]): (&mut Scene, [BodyId; 2]),
    is_right: impl Fn(Side, DVec3) -> bool,
) -> Vec<Side> {
    let regions = scene.segment(body, by).expect("regions");
    let (surface, x) = (scene.body(body).surface(), scene.body(body).positions());
    let mut seen = vec![false; surface.faces().len()];
    for region in &regions {
        assert!(region.area > 0.0 && region.faces.is_sorted(), "{region:?}");
        for &face in &region.faces {
            assert!(!std::mem::replace(&mut seen[face as usize], true), "face {face} twice");
            for corner in surface.faces()[face as usize] {
                let p = x[corner as usize];
                assert!(is_right(region.side, p), "{p} of a region {:?}", region.side);
            }
        }
    }
    assert!(regions.is_sorted_by(|p, q| p.area >= q.area), "largest first");
    regions.iter().map(|region| region.side).collect()
}

#[test]
fn a_ball_cuts_a_disc_out_of_a_sheet() {
    let ball = shapes::icosphere(10.3, 4).translated(DVec3::new(0.4, 0.3, 1.0));
    let (mut scene, ids) =
        scene([("sheet", BodyKind::Open, sheet()), ("ball", BodyKind::Rigid, ball)]);
    let is_right = |side, p: DVec3| {
        let distance = p.distance(DVec3::new(0.4, 0.3, 1.0));
        if side == Side::Inside {
            distance < 10.3
        } else {
            side == Side::Outside && distance > 10.2
        }
    };
    assert_eq!(sides((&mut scene, ids), is_right), [Side::Outside, Side::Inside]);
}

#[test]
fn a_sheet_parts_a_ball_into_front_and_back() {
    let ball = shapes::icosphere(10.3, 4).translated(DVec3::new(0.4, 0.3, 1.1));
    let (mut scene, [sheet, ball]) =
        scene([("sheet", BodyKind::Open, sheet()), ("ball", BodyKind::Deformable, ball)]);
    let is_right = |side, p: DVec3| if side == Side::Front { p.z > 0.0 } else { p.z < 0.0 };
    let found = sides((&mut scene, [ball, sheet]), is_right);
    assert_eq!(found, [Side::Front, Side::Back]);
    // Through the sheet turned over, the same with front and back exchanged.
    let turned: Vec<DVec3> =
        scene.body(sheet).positions().iter().map(|p| DVec3::new(-p.x, p.y, -p.z)).collect();
    scene.move_body(sheet, &turned).unwrap();
    let is_right = |side, p: DVec3| if side == Side::Back { p.z > 0.0 } else { p.z < 0.0 };
    assert_eq!(sides((&mut scene, [ball, sheet]), is_right), [Side::Back, Side::Front]);
}

#[test]
fn round_a_border_there_is_no_side() {
    let ball = shapes::icosphere(10.3, 4).translated(DVec3::new(20.2, 0.3, 1.1));
    let (mut scene, [sheet, ball]) =
        scene([("sheet", BodyKind::Open, sheet()), ("ball", BodyKind::Deformable, ball)]);
    assert_eq!(sides((&mut scene, [ball, sheet]), |_, _| true), [Side::Around]);
}

#[test]
fn what_is_not_cut_is_one_region() {
    let ball = shapes::icosphere(10.0, 3).translated(DVec3::Z * 30.0);
    let (mut scene, [sheet, ball]) =
        scene([("sheet", BodyKind::Open, sheet()), ("ball", BodyKind::Deformable, ball)]);
    assert_eq!(sides((&mut scene, [sheet, ball]), |_, _| true), [Side::Outside]);
    assert_eq!(sides((&mut scene, [ball, sheet]), |_, _| true), [Side::Apart]);
    let inside: Vec<DVec3> =
        scene.body(sheet).positions().iter().map(|p| 0.1 * *p + DVec3::Z * 30.0).collect();
    scene.move_body(sheet, &inside).unwrap();
    assert_eq!(sides((&mut scene, [sheet, ball]), |_, _| true), [Side::Inside]);
}
