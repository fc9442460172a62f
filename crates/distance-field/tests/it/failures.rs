//! What goes wrong with grids and bones, each with the figure that is expected.

use distance_field::{
    DistanceField, FieldError, FieldMethod, FieldParams, FieldWarning, Interpolation, NodeValues,
    Storage, Voxelization,
};
use fixtures::sampling::spread;
use fixtures::{Mesh, femur::femur, shapes};
use surface::glam::{DQuat, DVec3};
use surface::progress::Progress;
use surface::{SurfaceError, TriangleSurface};

use crate::support::{INTERPOLATING, build, nodes};

fn defaults() -> FieldParams {
    FieldParams { padding: 4.0, ..FieldParams::new(1.0) }
}

fn voxel(voxelization: Voxelization) -> FieldParams {
    let method = FieldMethod::Voxel { voxelization };
    FieldParams { method, padding: 4.0, ..FieldParams::voxel(1.0) }
}

/// Share of the nodes that a predicate calls inside which the field has below zero.
fn share_found(field: &DistanceField, is_inside: impl Fn(DVec3) -> bool) -> f64 {
    let (mut found, mut all) = (0.0, 0.0);
    for node in nodes(field.grid().dims()).filter(|&n| is_inside(field.grid().position(n))) {
        all += 1.0;
        found += if field.node(node) < 0.0 { 1.0 } else { 0.0 };
    }
    found / all
}

#[test]
fn refuses_what_is_not_a_surface() {
    let nothing = TriangleSurface::new(0, vec![]).unwrap();
    let x = nothing.positions(&[]).unwrap();
    assert_eq!(
        DistanceField::build(&nothing, x, &defaults(), Progress::none()).unwrap_err(),
        FieldError::Empty
    );

    // Neither a corner that does not exist nor one that is nowhere gets this far.
    let outside = SurfaceError::VertexOutOfRange { face: 0, vertex: 3, vertex_count: 3 };
    assert_eq!(TriangleSurface::new(3, vec![[0, 1, 3]]).unwrap_err(), outside);
    let triangle = TriangleSurface::new(3, vec![[0, 1, 2]]).unwrap();
    let nowhere = triangle.positions(&[DVec3::ZERO, DVec3::NAN, DVec3::X]);
    assert!(matches!(nowhere, Err(SurfaceError::NotFinite { vertex: 1, .. })));
}

#[test]
fn refuses_lengths_that_make_no_sense() {
    let ball = shapes::octasphere(10.0, 2);
    let band = |band| FieldMethod::ExactBand { band, node_values: NodeValues::Interpolating };
    let cases = [
        (FieldParams { spacing: 0.0, ..defaults() }, "spacing"),
        (FieldParams { spacing: f64::NAN, ..defaults() }, "spacing"),
        (FieldParams::new(1e31), "spacing"),
        (FieldParams { padding: -1.0, ..defaults() }, "padding"),
        (FieldParams { truncation: Some(0.0), ..defaults() }, "truncation"),
        (FieldParams { method: band(1.0), ..defaults() }, "band"),
        (FieldParams { method: band(f64::INFINITY), ..defaults() }, "band"),
        (FieldParams { storage: Storage::Quantized { step: -1.0 }, ..defaults() }, "storage step"),
    ];
    for (params, expected) in cases {
        match build(&ball, &params) {
            Err(FieldError::InvalidParam { name, .. }) => assert_eq!(name, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
    let tiny = ball.clone().scaled(DVec3::splat(1e-46));
    assert!(build(&tiny, &FieldParams::new(1e-46)).is_err(), "all values would be 0");
    let storage = Storage::Quantized { step: 1e-5 };
    let refused = build(&ball, &FieldParams { storage, ..defaults() }).unwrap_err();
    assert!(matches!(refused, FieldError::StepTooSmall { .. }), "{refused}");
}

/// 300 Gvoxels: no machine allocates these, so that an error shows that none were.
#[test]
fn refuses_a_grid_beyond_its_budget() {
    let bone = femur(9.0);
    let refused = build(&bone, &FieldParams { spacing: 0.025, ..defaults() }).unwrap_err();
    let FieldError::TooLarge { nodes, bytes, max_bytes } = refused else { panic!("{refused}") };
    assert!(nodes > 1e11 && bytes >= 10.0 * nodes && max_bytes == 4 << 30, "{refused}");
    // Overflow of any count on the way is the same error.
    let refused = build(&bone, &FieldParams { spacing: 1e-300, ..defaults() }).unwrap_err();
    assert!(matches!(refused, FieldError::TooLarge { .. }), "{refused}");
}

/// Few nodes, but more in a row than squares of distances allow.
#[test]
fn refuses_an_axis_that_is_too_long() {
    let needle = shapes::cube(1.0).scaled(DVec3::new(100_000.0, 1.0, 1.0));
    let params = FieldParams { padding: 1.0, ..defaults() };
    let refused = build(&needle, &params).unwrap_err();
    assert!(matches!(refused, FieldError::AxisTooLong { nodes, .. } if nodes > 1e5), "{refused}");
}

#[test]
fn warns_of_a_unit_mistake() {
    // A ball of 10 mm given in metres.
    let field = build(&shapes::octasphere(0.01, 2), &defaults()).unwrap();
    let is_few =
        |w: &FieldWarning| matches!(w, FieldWarning::SpansFewCells { cells } if *cells < 0.03);
    assert!(field.report().warnings.iter().any(is_few), "{:?}", field.report().warnings);
}

#[test]
fn turns_an_inverted_surface_around_and_says_so() {
    let ball = shapes::octasphere(10.0, 3);
    let right = build(&ball, &defaults()).unwrap();
    let inverted = build(&ball.clone().flipped(), &defaults()).unwrap();
    assert_eq!(right.values(), inverted.values());
    assert_eq!(inverted.report().warnings, [FieldWarning::Inverted]);
    assert_eq!(right.report().warnings, []);
}

#[test]
fn open_surfaces_flood_never_and_wind_well() {
    let ball = shapes::icosphere(20.0, 4);
    // A hole of about 12 mm.
    let mut open = ball.clone();
    open.faces.retain(|&face| {
        let middle = face.map(|v| ball.positions[v as usize]).into_iter().sum::<DVec3>() / 3.0;
        middle.distance(DVec3::X * 20.0) > 6.0
    });
    let refused = build(&open, &voxel(Voxelization::Conservative)).unwrap_err();
    let FieldError::NotClosed { source: SurfaceError::Open { count, .. } } = refused else {
        panic!("{refused}")
    };
    assert!(count > 10, "{refused}");
    assert!(refused.to_string().contains("needs a closed surface"));
    let field = build(&open, &defaults()).unwrap();
    let far_from_hole = |p: DVec3| p.distance(DVec3::X * 20.0) > 8.0;
    let inside = |p: DVec3| p.length() < 19.8 && far_from_hole(p);
    assert!(share_found(&field, inside) == 1.0);
    let outside = |p: DVec3| p.length() > 20.0 && far_from_hole(p);
    assert!(share_found(&field, outside) == 0.0);
    assert!(matches!(field.report().warnings[..], [FieldWarning::Open { edges }] if edges > 10));
}

/// Three cones over one triangle, which share its edges: each edge has three faces, none has one.
#[test]
fn surfaces_whose_edges_have_three_faces_are_not_flooded() {
    let base = [DVec3::X, DVec3::Y, -DVec3::ONE].map(|x| 10.0 * x);
    let tips = [-20.0, 5.0, 20.0].map(|height| height * DVec3::new(1.0, 1.0, -1.0));
    let mut faces = Vec::new();
    for tip in 3..6 {
        faces.extend([[0, 1, tip], [1, 2, tip], [2, 0, tip]]);
    }
    let mesh = Mesh { positions: [base, tips].concat(), faces };
    let refused = build(&mesh, &voxel(Voxelization::Conservative)).unwrap_err();
    let FieldError::NotClosed { source: SurfaceError::Open { count: 3, .. } } = refused else {
        panic!("{refused}")
    };
}

/// A closed surface with one reversed face is not called open, and edges are counted as its
/// inspection counts them.
#[test]
fn reversed_faces_are_told_apart_from_holes() {
    let mut mesh = shapes::icosphere(12.0, 2);
    mesh.faces[17].swap(0, 1);
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite");
    let inspection = surface::inspect(&surface, x);
    assert_eq!(inspection.count(surface::Defect::MisorientedEdge), 3);
    let field =
        build(&mesh, &FieldParams { samples: 0, ..FieldParams::new(1.0) }).expect("a sphere");
    assert_eq!(field.report().warnings, [FieldWarning::Misoriented { edges: 3 }]);

    // With a hole beside it, both are named.
    mesh.faces.remove(40);
    let field =
        build(&mesh, &FieldParams { samples: 0, ..FieldParams::new(1.0) }).expect("a sphere");
    let expected = [FieldWarning::Open { edges: 3 }, FieldWarning::Misoriented { edges: 3 }];
    assert_eq!(field.report().warnings, expected);
}

/// Sheets enclose nothing, flat or turned or wavy, and the report says so.
#[test]
fn sheets_have_no_inside() {
    let rotation = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_y(0.5);
    for (turn, wave) in [(DQuat::IDENTITY, 0.0), (rotation, 0.0), (rotation, 0.5)] {
        let mut positions = Vec::new();
        for (i, j) in (0..11_u32).flat_map(|j| (0..11_u32).map(move |i| (i, j))) {
            let height = wave * (f64::from(i) + 0.5 * f64::from(j)).sin();
            positions.push(turn * DVec3::new(f64::from(i), f64::from(j), height));
        }
        let mut faces = Vec::new();
        for (i, j) in (0..10_u32).flat_map(|j| (0..10_u32).map(move |i| (i, j))) {
            let a = i + 11 * j;
            faces.extend([[a, a + 1, a + 12], [a, a + 12, a + 11]]);
        }
        let sheet = Mesh { positions, faces };
        let field = build(&sheet, &FieldParams::new(0.5)).expect("a sheet");
        // Rounding decides which side the sheet takes for its outside.
        let mut warnings = field.report().warnings.clone();
        warnings.retain(|warning| *warning != FieldWarning::Inverted);
        let expected = [FieldWarning::Open { edges: 40 }, FieldWarning::NoInside];
        assert_eq!(warnings, expected, "{turn} {wave}");
    }
}

/// A triangle has two sides and no inside.
#[test]
fn a_single_triangle_encloses_nothing() {
    let positions = vec![DVec3::ZERO, DVec3::X * 20.0, DVec3::Y * 20.0];
    let triangle = Mesh { positions, faces: vec![[0, 1, 2]] };
    let field = build(&triangle, &defaults()).unwrap();
    assert!(field.report().inside_volume == 0.0);
}

/// A tilted plate, as thick as `thickness` spacings: how much of its inside the
/// grid has below zero.
fn plate_found(thickness: f64, params: &FieldParams) -> (f64, DistanceField) {
    let size = DVec3::new(40.0, 40.0, thickness);
    let tilt = DQuat::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), 0.41);
    let shift = DVec3::new(0.31, 0.17, 0.23);
    let plate = shapes::plate(size, [20, 20]).mapped(|p| tilt * p + shift);
    let middle = plate.positions.iter().copied().sum::<DVec3>() / plate.positions.len() as f64;
    let field = build(&plate, params).unwrap();
    // Asked between the nodes, well away from the rim.
    let (mut found, mut all) = (0.0, 0.0);
    for n in 0..4000 {
        let at = (spread(n) - 0.5) * DVec3::new(30.0, 30.0, thickness);
        let value = field.evaluate(middle + tilt * at, Interpolation::Trilinear).unwrap();
        all += 1.0;
        found += if value.distance < 0.0 { 1.0 } else { 0.0 };
    }
    (found / all, field)
}

#[test]
fn thin_plates_keep_what_is_expected() {
    // Thickness in spacings; share kept by the exact band, by six-separating and
    // by conservative voxels: least and most.
    let rows = [
        (0.5, [0.25, 0.40], [0.0, 0.02], [0.0, 0.0]),
        (1.0, [0.75, 0.95], [0.0, 0.65], [0.0, 0.0]),
        (1.5, [0.97, 1.0], [0.60, 0.98], [0.0, 0.25]),
        (2.0, [0.995, 1.0], [0.80, 1.0], [0.55, 0.98]),
    ];
    for (thickness, exact, six, conservative) in rows {
        let (found, field) = plate_found(thickness, &defaults());
        println!("t = {thickness} h: exact {found:.3}");
        assert!((exact[0]..=exact[1]).contains(&found), "{thickness}: {found}");
        let warned = field.report().warnings.iter().find_map(|warning| match warning {
            FieldWarning::ThinnerThanGrid { fraction, thickness } => Some((*fraction, *thickness)),
            _ => None,
        });
        // At the very limit rounding decides.
        assert!(warned.is_some() || thickness >= 1.5, "{thickness}: {warned:?}");
        assert!(warned.is_none() || thickness <= 1.5, "{thickness}: {warned:?}");
        for (voxelization, [least, most]) in
            [(Voxelization::SixSeparating, six), (Voxelization::Conservative, conservative)]
        {
            let (found, _) = plate_found(thickness, &voxel(voxelization));
            println!("t = {thickness} h: {voxelization:?} {found:.3}");
            assert!((least..=most).contains(&found), "{thickness} {voxelization:?}: {found}");
        }
    }
}

/// Bresenham's lines do not hold a flood back where faces span several voxels;
/// the other conversions do.
#[test]
fn thin_conversion_leaks() {
    let ball = shapes::icosphere(30.0, 2).rotated(DVec3::new(0.36, 0.48, 0.8), 0.13);
    let inside = |p: DVec3| p.length() < 26.0;
    let field = build(&ball, &voxel(Voxelization::Bresenham)).unwrap();
    assert!(share_found(&field, inside) < 0.01);
    let is_lost =
        |w: &FieldWarning| matches!(w, FieldWarning::InteriorLost { fraction } if *fraction > 0.9);
    assert!(field.report().warnings.iter().any(is_lost), "{:?}", field.report().warnings);
    for voxelization in [Voxelization::SixSeparating, Voxelization::Conservative] {
        let field = build(&ball, &voxel(voxelization)).unwrap();
        assert!(share_found(&field, inside) == 1.0, "{voxelization:?}");
        assert_eq!(field.report().warnings, []);
    }
}

/// In the middle of a plate no direction is the right one, and the length of
/// the gradient says so.
#[test]
fn gradient_is_short_on_the_medial_axis_only() {
    let plate = shapes::plate(DVec3::new(40.0, 40.0, 10.0), [4, 4]);
    let middle = plate.positions.iter().copied().sum::<DVec3>() / plate.positions.len() as f64;
    let field = build(&plate, &defaults()).unwrap();
    let at = |height: f64| {
        let p = middle + DVec3::new(0.3, -0.2, height);
        field.evaluate(p, Interpolation::Smooth).unwrap()
    };
    assert!(at(0.0).gradient.length() < 0.5, "{:?}", at(0.0));
    assert_eq!(at(0.0).direction(0.5), None);
    for height in [-8.0, -6.5, -3.0, 3.0, 4.0, 5.5, 7.0] {
        let sample = at(height);
        assert!((0.9..1.05).contains(&sample.gradient.length()), "{height}: {sample:?}");
        let direction = sample.direction(0.5).unwrap();
        assert!(direction.distance(DVec3::Z * height.signum()) < 1e-3, "{height}: {direction}");
    }
}

#[test]
fn answers_on_nodes_faces_and_the_last_node_and_nowhere_else() {
    let params = FieldParams { method: INTERPOLATING, ..defaults() };
    let field = build(&shapes::octasphere(5.0, 3), &params).unwrap();
    let grid = *field.grid();
    let [nx, ny, nz] = grid.dims();
    for interpolation in [Interpolation::Trilinear, Interpolation::Smooth, Interpolation::Cubic] {
        let at = |p: DVec3| field.evaluate(p, interpolation).map(|sample| sample.distance);
        for node in nodes(grid.dims()) {
            let value = at(grid.position(node)).unwrap();
            assert!((value - field.node(node)).abs() < 1e-6, "{interpolation:?} {node:?}");
        }
        let last = grid.position([nx - 1, ny - 1, nz - 1]);
        let on_face = grid.position([2, 3, nz - 1]) + DVec3::new(0.25, 0.5, 0.0);
        assert!(at(last).is_some() && at(on_face).is_some());
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            assert_eq!(at(last + 1e-9 * axis), None);
            assert_eq!(at(grid.origin() - 1e-9 * axis), None);
            assert_eq!(at(last + f64::INFINITY * axis), None);
        }
        assert_eq!(at(DVec3::NAN), None);
    }
}

#[test]
fn values_come_back_from_a_file_or_are_refused() {
    let field = build(&shapes::octasphere(5.0, 3), &defaults()).unwrap();
    let grid = *field.grid();
    let again = DistanceField::from_values(grid, field.values(), Storage::Float).unwrap();
    assert_eq!(again.values(), field.values());
    let few = DistanceField::from_values(grid, vec![0.0; 3], Storage::Float).unwrap_err();
    assert_eq!(few, FieldError::ValueCount { expected: grid.node_count(), got: 3 });
    let mut values = field.values();
    values[7] = f32::NAN;
    let refused = DistanceField::from_values(grid, values, Storage::Float).unwrap_err();
    assert_eq!(refused, FieldError::NotFinite { node: 7 });
}

/// The tip of a needle in the middle of a cell is as far from all nodes as can
/// be: the field is off by nearly what it calls certain, and not by more.
#[test]
fn what_is_certain_holds_at_the_tip_of_a_needle() {
    let tip = DVec3::new(20.5, 0.0, 0.0);
    let base = [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.5]].map(|[y, z]| DVec3::new(0.0, y, z));
    let positions = vec![base[0], base[1], base[2], tip];
    let needle = Mesh { positions, faces: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] };
    let steps = Storage::Quantized { step: 0.01 };
    for (storage, nodes, given) in [
        (Storage::Float, NodeValues::Interpolating, 0.0),
        (steps, NodeValues::Interpolating, 0.0),
        (Storage::Float, NodeValues::QuasiInterpolating, 0.125),
        (steps, NodeValues::QuasiInterpolating, 0.125),
    ] {
        let method = FieldMethod::ExactBand { band: 3.0, node_values: nodes };
        let field = build(&needle, &FieldParams { storage, method, ..defaults() }).unwrap();
        let certain =
            field.report().error_bound.expect("a closed surface in an exact band") - given;
        assert!((0.866..0.88).contains(&certain), "{certain}");
        let at_tip = field.evaluate(tip, Interpolation::Trilinear).unwrap().distance;
        // A tip bends what is around it, so that nodes give way there by all they may.
        assert!((0.85 * certain - given..=certain).contains(&at_tip), "{at_tip} of {certain}");
        assert!(given == 0.0 || at_tip < 0.85 * certain, "{at_tip} of {certain}");
    }
    // Neither method nor surface allows more to be said.
    let ball = shapes::icosphere(10.0, 3);
    let mut open = ball.clone();
    open.faces.truncate(open.faces.len() - 1);
    assert_eq!(build(&open, &defaults()).unwrap().report().error_bound, None);
    assert_eq!(
        build(&ball, &voxel(Voxelization::Conservative)).unwrap().report().error_bound,
        None
    );
    let worst = build(&ball, &defaults()).unwrap().report().measured_error.unwrap().max;
    assert!(worst < 0.866, "{worst}");
}

/// Eight tips around the middle of a cell, towards its nodes: these are nearer to them by half a
/// diagonal. In a wide band, the rounding of distances is added to that.
#[test]
fn what_is_certain_holds_amid_far_tips() {
    // Numbers of which single precision rounds the distances of the nodes down the farthest.
    let (spacing, distance) = (1.005_200_204_211_204_3, 74.417_902_730_337_26);
    let mut tips = Mesh::default();
    for corner in shapes::cube(2.0).positions {
        let (tip, base) = (corner * (distance * spacing / 3.0_f64.sqrt()), corner * 44.5 * spacing);
        let x = tips.positions.len();
        let [a, b, c, d] = [x, x + 1, x + 2, x + 3].map(|vertex| u32::try_from(vertex).unwrap());
        let beside = [DVec3::X, DVec3::Y].map(|axis| base - 1e-4 * corner * axis);
        tips.positions.extend([tip, base, beside[0], beside[1]]);
        tips.faces.extend([[a, b, c], [a, c, d], [a, d, b], [b, d, c]]);
    }
    let method = FieldMethod::ExactBand { band: 77.0, node_values: NodeValues::Interpolating };
    let params =
        FieldParams { method, padding: 0.0, truncation: None, samples: 0, spacing, ..defaults() };
    let field = build(&tips, &params).unwrap();
    let middle = field.grid().position([44; 3]) + 0.5 * spacing;
    assert!(middle.length() < 1e-12, "{middle}");

    let value = field.evaluate(middle, Interpolation::Trilinear).unwrap().distance;
    let error = (value - distance * spacing).abs();
    let certain = field.report().error_bound.expect("closed surfaces");
    assert!((0.9999 * certain..=certain).contains(&error), "{error} of {certain}");
}

/// A bounded carry reaches every node that is not truncated: as an unbounded one
/// has it, in every direction from a small ball.
#[test]
fn truncation_takes_nothing_that_is_nearer() {
    let ball = shapes::icosphere(3.0, 3).translated(DVec3::new(0.31, 0.17, 0.23));
    for limit in [6.2, 9.0, 15.0] {
        let params = FieldParams { padding: 16.0, samples: 0, ..FieldParams::new(1.0) };
        let whole = build(&ball, &FieldParams { truncation: None, ..params }).unwrap();
        let cut = build(&ball, &FieldParams { truncation: Some(limit), ..params }).unwrap();
        for (whole, cut) in whole.values().into_iter().zip(cut.values()) {
            let expected = f64::from(whole).min(limit);
            // Where two seeds are as near, each may take another face.
            assert!((f64::from(cut) - expected).abs() < 0.25, "{cut}, not {expected}");
        }
    }
}

/// `MeasuredError` looks two spacings to either side: no farther, for then it would
/// leave a grid of that padding, and no less.
#[test]
fn comparison_is_within_two_spacings() {
    let points = |padding: f64| {
        let params = FieldParams { padding, samples: 512, ..FieldParams::new(1.0) };
        let field = build(&shapes::cube(12.0), &params).unwrap();
        field.report().measured_error.unwrap().points
    };
    assert_eq!(points(2.0), 512);
    // An eighth of the points is over the last half of a spacing outside.
    assert!((420..475).contains(&points(1.5)), "{}", points(1.5));
}

/// A band may be wider than the grid around the surface is.
#[test]
fn a_band_beyond_the_grid_is_cut_off() {
    let mesh = shapes::icosphere(6.0, 2);
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let nodes = NodeValues::QuasiInterpolating;
    let method = FieldMethod::ExactBand { band: 20.0, node_values: nodes };
    let built = |padding: f64| {
        let params = FieldParams { method, padding, spacing: 0.5, ..FieldParams::new(1.0) };
        DistanceField::build(&surface, x, &params, Progress::none()).unwrap()
    };
    let (narrow, wide) = (built(0.0), built(10.0));
    for p in [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 5.5, 0.5)] {
        let [a, b] =
            [&narrow, &wide].map(|field| field.evaluate(p, Interpolation::Trilinear).unwrap());
        assert!((a.distance - b.distance).abs() < 0.05, "{p}: {a:?} {b:?}");
    }
}
