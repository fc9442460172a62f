//! Regions of surfaces that others cut, with planted answers.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use proximity::{Side, SurfaceTree, regions};

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

fn tree(mesh: Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("finite positions")
}

fn open(mesh: Mesh) -> SurfaceTree {
    tree(mesh).declared_open()
}

/// Finds the sides of all regions, and checks that each face is in one region at most, and that
/// the corners of all faces satisfy `is_right`.
fn sides(a: &SurfaceTree, by: &SurfaceTree, is_right: impl Fn(Side, DVec3) -> bool) -> Vec<Side> {
    let regions = regions(a, by);
    let mut seen = vec![false; a.surface().faces().len()];
    for region in &regions {
        assert!(region.area > 0.0 && region.faces.is_sorted(), "{region:?}");
        for &face in &region.faces {
            assert!(!std::mem::replace(&mut seen[face as usize], true), "face {face} twice");
            for p in a.corners(face) {
                assert!(is_right(region.side, p), "{p} of a region {:?}", region.side);
            }
        }
    }
    assert!(regions.is_sorted_by(|p, q| p.area >= q.area), "largest first");
    regions.iter().map(|region| region.side).collect()
}

#[test]
fn a_ball_cuts_a_disc_out_of_a_sheet() {
    let center = DVec3::new(0.4, 0.3, 1.0);
    let ball = tree(shapes::icosphere(10.3, 4).translated(center));
    let is_right = |side, p: DVec3| match side {
        Side::Inside => p.distance(center) < 10.3,
        _ => side == Side::Outside && p.distance(center) > 10.2,
    };
    assert_eq!(sides(&open(sheet()), &ball, is_right), [Side::Outside, Side::Inside]);
}

#[test]
fn a_sheet_divides_a_ball_into_front_and_back() {
    let ball = tree(shapes::icosphere(10.3, 4).translated(DVec3::new(0.4, 0.3, 1.1)));
    let mut sheet = open(sheet());
    let is_right = |side, p: DVec3| if side == Side::Front { p.z > 0.0 } else { p.z < 0.0 };
    assert_eq!(sides(&ball, &sheet, is_right), [Side::Front, Side::Back]);

    // By the sheet turned over, the same with front and back exchanged.
    let turned = sheet.positions().as_slice().to_vec();
    let turned = turned.iter().map(|p| DVec3::new(-p.x, p.y, -p.z));
    sheet.set_positions(turned).expect("finite positions");
    let is_right = |side, p: DVec3| if side == Side::Back { p.z > 0.0 } else { p.z < 0.0 };
    assert_eq!(sides(&ball, &sheet, is_right), [Side::Back, Side::Front]);
}

#[test]
fn around_a_border_there_is_no_side() {
    let ball = tree(shapes::icosphere(10.3, 4).translated(DVec3::new(20.2, 0.3, 1.1)));
    assert_eq!(sides(&ball, &open(sheet()), |_, _| true), [Side::Around]);
}

#[test]
fn an_uncut_surface_is_one_region() {
    let ball = tree(shapes::icosphere(10.0, 3).translated(DVec3::Z * 30.0));
    let mut sheet = open(sheet());
    assert_eq!(sides(&sheet, &ball, |_, _| true), [Side::Outside]);
    assert_eq!(sides(&ball, &sheet, |_, _| true), [Side::Apart]);

    let inside = sheet.positions().as_slice().to_vec();
    let inside = inside.iter().map(|p| 0.1 * *p + DVec3::Z * 30.0);
    sheet.set_positions(inside).expect("finite positions");
    assert_eq!(sides(&sheet, &ball, |_, _| true), [Side::Inside]);
}

/// A roof whose slopes meet at a ridge that a face without area fills: the corner in the middle of the
/// ridge is one of the left slope alone.
#[test]
fn a_ridge_beside_a_face_without_area_has_both_slopes() {
    let roof = Mesh {
        positions: [
            [0.0, -10.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 10.0, 0.0],
            [-10.0, -10.0, -30.0],
            [-10.0, 10.0, -30.0],
            [10.0, -10.0, -30.0],
            [10.0, 10.0, -30.0],
        ]
        .map(DVec3::from)
        .to_vec(),
        faces: vec![[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 0, 5], [2, 5, 6], [0, 2, 1]],
    };
    // From below a slope to in front of the ridge: nearest to it are the corners above.
    let strip = Mesh {
        positions: [[2.5, 0.5, 1.0], [2.5, -0.5, 1.0], [0.3, 0.0, -4.0], [6.0, 0.0, 3.0]]
            .map(DVec3::from)
            .to_vec(),
        faces: vec![[0, 1, 2], [1, 0, 3]],
    };
    for order in 0..roof.faces.len() {
        for mirrored in [false, true] {
            let mut roof = roof.clone();
            roof.faces.rotate_left(order);
            let sign = DVec3::new(if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0);
            let strip = tree(strip.clone().scaled(sign));
            let found = regions(&strip, &open(roof));
            let [region] = &found[..] else { panic!("one face is not cut: {found:?}") };
            assert_eq!(region.side, Side::Front, "{order} {mirrored}");
        }
    }
}
