//! Closed cavities, and wrong signs in the measured error.

use distance_field::{DistanceField, FieldMethod, FieldParams, FieldWarning, Voxelization};
use fixtures::shapes::icosphere;
use fixtures::{Mesh, damage, reference};
use surface::glam::DVec3;

use crate::support::{build, nodes};

const VOXELIZATIONS: [Voxelization; 3] =
    [Voxelization::Bresenham, Voxelization::SixSeparating, Voxelization::Conservative];

fn voxel(voxelization: Voxelization) -> FieldParams {
    let method = FieldMethod::Voxel { voxelization };
    FieldParams { method, padding: 3.0, ..FieldParams::voxel(1.0) }
}

/// A shell around a cavity, with faces smaller than a voxel.
fn shell() -> Mesh {
    icosphere(12.0, 4).joined(&icosphere(8.0, 4).flipped())
}

/// A shell around a cavity that holds a ball.
fn wrapped_ball() -> Mesh {
    shell().joined(&icosphere(4.0, 3))
}

/// Counts the nodes beyond one spacing from the surface whose sign is not that of `is_inside`, by
/// their winding number.
fn wrong_signs(mesh: &Mesh, field: &DistanceField, is_inside: impl Fn(f64) -> bool) -> usize {
    let (mut wrong, mut compared) = (0, 0);
    for node in nodes(field.grid().dims()).step_by(29) {
        let value = field.node(node);
        if value.abs() > 1.0 {
            let winding = reference::winding(mesh, field.grid().position(node));
            wrong += usize::from((value < 0.0) != is_inside(winding));
            compared += 1;
        }
    }
    assert!(compared > 300, "{compared}");
    wrong
}

/// Largest measured error near the surface and far from it.
fn measured(field: &DistanceField) -> [f64; 2] {
    let report = field.report();
    let error = [report.measured_error, report.measured_deep_error];
    error.map(|error| error.expect("compared by default").max)
}

/// Shells are signed by what they enclose, whichever way all of them face.
#[test]
fn voxels_leave_closed_cavities_outside() {
    for mesh in [shell(), wrapped_ball(), wrapped_ball().flipped()] {
        for voxelization in VOXELIZATIONS {
            let field = build(&mesh, &voxel(voxelization)).expect("closed");
            let wrong = wrong_signs(&mesh, &field, |winding| winding.abs() > 0.5);
            assert_eq!(wrong, 0, "{voxelization:?}");
            assert_eq!(field.report().warnings, [], "{voxelization:?}");

            // Distances beside voxels are off by a spacing and a half, and no more with signs.
            let [near, deep] = measured(&field);
            assert!(near < 1.5 && deep < 1.5, "{near} {deep} by {voxelization:?}");
            let volume = field.report().inside_volume;
            assert!(volume < mesh.volume().abs(), "{volume} by {voxelization:?}");
        }
    }
}

/// The opening is narrower than a voxel: no flood enters the pocket, which is outside.
#[test]
fn voxels_leave_pockets_behind_narrow_necks_outside() {
    let mut mesh = shell();
    let [outer, inner] = [40, 40 + mesh.faces.len() / 2].map(|face| mesh.faces[face]);
    mesh.faces.retain(|face| *face != outer && *face != inner);
    // The inner ball was flipped: its corners run the other way.
    let [a, b, c] = outer;
    let place = |v: u32| mesh.positions[v as usize].normalize();
    let below = |v: u32| {
        let found = inner.into_iter().find(|w| place(*w).distance(place(v)) < 1e-9);
        found.expect("both balls have the same corners")
    };
    for (from, to) in [(a, b), (b, c), (c, a)] {
        mesh.faces.extend([[from, to, below(to)], [from, below(to), below(from)]]);
    }
    mesh.surface().require_oriented().expect("the neck joins both shells");
    for voxelization in [Voxelization::SixSeparating, Voxelization::Conservative] {
        let field = build(&mesh, &voxel(voxelization)).expect("closed");
        assert_eq!(wrong_signs(&mesh, &field, |winding| winding > 0.5), 0, "{voxelization:?}");
    }
}

/// The inner shell leaks, the outer one does not: nothing of the solid is lost, and the measured
/// error shows that the cavity has the wrong sign.
#[test]
fn cavities_that_leak_stay_inside() {
    let inner = icosphere(22.0, 1).rotated(DVec3::new(0.36, 0.48, 0.8), 0.13);
    let field =
        build(&icosphere(26.0, 5).joined(&inner.flipped()), &voxel(Voxelization::Bresenham))
            .expect("closed");
    let grid = field.grid();
    let is_solid = |p: DVec3| (23.5..24.5).contains(&p.length());
    let mut solid = nodes(grid.dims()).filter(|node| is_solid(grid.position(*node)));
    assert_eq!(solid.find(|node| field.node(*node) >= 0.0), None, "a node of the solid is outside");
    let center = grid.dims().map(|n| n / 2);
    assert!(field.node(center) < -15.0, "{}", field.node(center));
    assert!(measured(&field)[0] > 3.0, "{:?}", measured(&field));
}

/// A flood does not depend on orientations: what some of the faces enclose is inside.
#[test]
fn voxels_keep_reversed_and_doubly_covered_parts_inside() {
    let ball = icosphere(8.0, 4);
    let beside = icosphere(6.0, 4).translated(DVec3::X * 18.0);
    let overlapping = ball.clone().joined(&ball.clone().translated(DVec3::X * 6.0));
    for mesh in [ball.clone().joined(&beside.flipped()), ball.clone().joined(&ball), overlapping] {
        let field = build(&mesh, &voxel(Voxelization::SixSeparating)).expect("closed");
        assert_eq!(wrong_signs(&mesh, &field, |winding| winding.abs() > 0.5), 0);
        let [near, deep] = measured(&field);
        assert!(near < 1.5 && deep < 1.5, "{near} {deep}");
    }

    // With one reversed face, nothing is enclosed a whole number of times: a cavity stays inside.
    let mut mesh = shell();
    mesh.faces[17].swap(0, 1);
    let field = build(&mesh, &voxel(Voxelization::SixSeparating)).expect("closed");
    let center = field.grid().dims().map(|n| n / 2);
    assert!(field.node(center) < -6.0, "{}", field.node(center));
}

/// An exact band has the sign that its definition says, whichever way the surface faces.
#[test]
fn right_signs_add_nothing_to_the_measured_error() {
    let ball = icosphere(12.0, 3);
    let overlapping = ball.clone().joined(&ball.clone().translated(DVec3::X * 6.0));
    let reversed = ball.clone().joined(&icosphere(6.0, 3).translated(DVec3::X * 20.0).flipped());
    let bodies = [ball.clone(), ball.clone().joined(&ball), overlapping, reversed, wrapped_ball()];
    for (n, mesh) in bodies.into_iter().enumerate() {
        for mesh in [mesh.clone(), mesh.flipped()] {
            let field = build(&mesh, &FieldParams::new(1.0)).expect("a body");
            let [near, deep] = measured(&field);
            assert!(near < 0.5 && deep < 1.0, "body {n}: {near} {deep}");
        }
    }
}

/// Everything leaks out: values up to two spacings inside are off by up to four, and those farther
/// inside by more.
#[test]
fn a_lost_inside_shows_in_the_measured_error() {
    let ball = icosphere(30.0, 2).rotated(DVec3::new(0.36, 0.48, 0.8), 0.13);
    let field = build(&ball, &voxel(Voxelization::Bresenham)).expect("closed");
    let lost = |warning: &FieldWarning| matches!(warning, FieldWarning::InteriorLost { .. });
    assert!(field.report().warnings.iter().any(lost), "{:?}", field.report().warnings);
    let [near, deep] = measured(&field);
    assert!((3.5..5.0).contains(&near), "{near}");
    assert!(deep > 4.0, "{deep}");
    let rms = field.report().measured_error.expect("compared by default").rms;
    assert!((1.2..2.0).contains(&rms), "{rms}");
}

/// Around a hole the sign changes where no surface is: magnitudes are compared.
#[test]
fn errors_of_open_surfaces_are_those_of_magnitudes() {
    let open = damage::hole(icosphere(12.0, 4), DVec3::X * 12.0, 4.0);
    let field = build(&open, &FieldParams::new(1.0)).expect("a body");
    let is_open = |warning: &FieldWarning| matches!(warning, FieldWarning::Open { .. });
    assert!(field.report().warnings.iter().any(is_open), "{:?}", field.report().warnings);
    let [near, _] = measured(&field);
    assert!(near < 1.0, "{near}");
}
