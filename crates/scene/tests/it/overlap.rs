//! Measured overlaps with planted answers, through a scene.

use crate::support::scene_of;
use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere, octasphere};
use glam::DVec3;
use scene::{
    BodyKind, CheckParams, Coincidence, NoInside, OverlapMeasures, PairReport, Progress, Scene,
    SceneError,
};

/// Reports the one pair of two bodies that meet.
fn report(a: &Mesh, b: &Mesh) -> PairReport {
    let params = CheckParams { depth_tolerance: Some(1e-6), ..CheckParams::new(0.0) };
    let (mut scene, _) = scene_of(&[a, b]);
    let reports = scene.check(&params, Progress::none()).expect("a check");
    let cheap = scene.check(&CheckParams::without_measures(0.0), Progress::none());

    // The decision is the same without measures.
    let [report] = &reports[..] else { unreachable!("two bodies are one pair") };
    let [cheap] = &cheap.expect("a check")[..] else { unreachable!("two bodies are one pair") };
    assert_eq!(report.overlaps, cheap.overlaps, "without measures");
    assert_eq!(cheap.overlap, None, "nothing is measured");
    report.clone()
}

fn volume(report: &PairReport) -> f64 {
    let overlap = report.overlap.as_ref().expect("they meet");
    overlap.measures.total.volume.expect("both are closed")
}

fn depth(report: &PairReport) -> f64 {
    let depth = report.max_depth().expect("they overlap");
    assert!(depth.upper - depth.lower <= 1e-6, "{depth:?}");
    depth.lower
}

/// A reference node far from a body, as solvers have them, is no part of its size.
#[test]
fn vertices_without_a_face_change_no_depth() {
    let (a, ball) = (icosphere(5.0, 2), icosphere(4.0, 2).translated(DVec3::new(7.0, 0.1, 0.2)));
    let mut with_node = ball.clone();
    with_node.positions.push(DVec3::new(1e5, 0.0, 0.0));
    let [expected, depth] = [ball, with_node].map(|b| {
        let (mut scene, _) = scene_of(&[&a, &b]);
        let reports = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
        reports[0].max_depth().expect("a depth")
    });
    assert_eq!(depth, expected);
    assert!(expected.upper - expected.lower < 0.01 * expected.lower, "{expected:?}");
}

/// Bodies one beside, in and across the other, and two whose edges alone cross.
fn overlapping_pairs() -> [[Mesh; 2]; 4] {
    let ball = icosphere(5.0, 2);
    let in_place = |mesh: &Mesh, x: f64| mesh.clone().translated(DVec3::new(x, 0.1, 0.2));
    let small = icosphere(2.0, 1);
    [
        [ball.clone(), in_place(&ball, 7.0)],
        [ball.clone(), in_place(&small, 1.0)],
        [in_place(&small, 5.0), ball],
        crossed_wedges(0.5),
    ]
}

#[test]
fn bodies_that_are_inside_out_overlap_as_others_do() {
    for [a, b] in overlapping_pairs() {
        let expected = report(&a, &b);
        for [turns_a, turns_b] in [[true, false], [false, true], [true, true]] {
            let turned =
                |mesh: &Mesh, turns| if turns { mesh.clone().flipped() } else { mesh.clone() };
            let bodies = [turned(&a, turns_a), turned(&b, turns_b)];
            let found = report(&bodies[0], &bodies[1]);
            let [expected_total, total] = [&expected, &found].map(|report| {
                let overlap = report.overlap.as_ref().expect("they overlap");
                assert_eq!(overlap.measures.covers_twice, [false; 2]);
                &overlap.measures.total
            });
            let values = |total: &OverlapMeasures| {
                let areas = [total.area_of_a_inside_b, total.area_of_b_inside_a];
                [total.volume, areas[0], areas[1]].map(|value| value.expect("both are closed"))
            };
            for (expected, found) in values(expected_total).into_iter().zip(values(total)) {
                assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found}: {expected}");
            }
            assert!((depth(&expected) - depth(&found)).abs() <= 1e-6, "{}", depth(&found));
            assert_eq!(expected.crossing_faces, found.crossing_faces);

            // Points are in weights of the corners as the body has them.
            let edges =
                |report: &PairReport| report.overlap.as_ref().map_or(0, |o| o.edge_overlaps.len());
            assert_eq!(edges(&found), edges(&expected));
            for edge in found.overlap.iter().flat_map(|overlap| &overlap.edge_overlaps) {
                let own = usize::from(edge.body != found.pair.a);
                for (point, mesh) in [(edge.point, &bodies[own]), (edge.foot, &bodies[1 - own])] {
                    let corners = mesh.faces[point.face as usize]
                        .map(|corner| mesh.positions[corner as usize]);
                    let at: DVec3 = corners
                        .into_iter()
                        .zip(point.barycentric)
                        .map(|(x, weight)| weight * x)
                        .sum();
                    assert!(at.distance(point.at) < 1e-12, "{at} for {}", point.at);
                }
            }
        }
    }
}

#[test]
fn a_body_that_is_inside_out_moves_with_its_overlaps() {
    let (a, b) = (cube(10.0).flipped(), cube(10.0).translated(DVec3::X * 20.0));
    let (mut scene, ids) = scene_of(&[&a, &b]);
    for way in [15.0, 12.0, 0.0, 18.0] {
        let moved: Vec<DVec3> = a.positions.iter().map(|x| *x + DVec3::X * way).collect();
        scene.move_body(ids[0], &moved).expect("positions");
        let reports = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
        let found = reports.first().map_or(0.0, volume);
        assert!((found - 100.0 * f64::max(0.0, way - 10.0)).abs() < 1e-9, "{found} at {way}");
    }
}

/// A wedge with a ridge of length 8 along x at height 0, over a base that is 6 wide.
fn wedge() -> Mesh {
    let positions = vec![
        DVec3::new(-4.0, 0.0, 0.0),
        DVec3::new(4.0, 0.0, 0.0),
        DVec3::new(0.0, -3.0, -3.0),
        DVec3::new(0.0, 3.0, -3.0),
    ];
    let mesh = Mesh { positions, faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] };
    if mesh.volume() > 0.0 { mesh } else { mesh.flipped() }
}

/// Two wedges whose ridges cross at right angles, `overlap` into each other.
fn crossed_wedges(overlap: f64) -> [Mesh; 2] {
    let upper = wedge().mapped(|p| DVec3::new(p.y, p.x, -p.z - overlap));
    [wedge(), if upper.volume() > 0.0 { upper } else { upper.flipped() }]
}

#[test]
fn boxes_that_share_half_their_volume() {
    let a = cube(10.0);
    let report = report(&a, &a.clone().translated(DVec3::X * 5.0));
    assert!(report.overlaps && report.crossing_faces.is_empty(), "their sides are flush");
    assert!((volume(&report) - 500.0).abs() < 1e-9, "{}", volume(&report));
    assert_eq!((report.coincidence, report.max_vertex_depth), (None, 0.0));

    // The end of each is at the middle of the other.
    assert!((depth(&report) - 5.0).abs() < 1e-6, "{}", depth(&report));
    let total = report.overlap.expect("measured").measures.total;
    assert!((total.flush_area - 200.0).abs() < 1e-9, "{total:?}");
    assert!((total.area_of_a_inside_b.expect("closed") - 100.0).abs() < 1e-9, "{total:?}");
}

#[test]
fn a_body_given_twice_is_named() {
    let a = icosphere(10.0, 2);
    let mut other = Mesh { faces: a.faces.iter().rev().copied().collect(), ..a.clone() };
    // The same mesh with its vertices numbered from the end.
    let last = u32::try_from(other.positions.len() - 1).expect("few vertices");
    other.positions.reverse();
    other.faces = other.faces.iter().map(|face| face.map(|corner| last - corner)).collect();
    let report = report(&a, &other);
    assert!(report.overlaps);
    assert_eq!(report.coincidence, Some(Coincidence::SameMesh));
    assert!((volume(&report) / a.volume() - 1.0).abs() < 1e-9);
    assert!(depth(&report) < 1e-9);

    // Coordinates of 0 have either sign, as files write them.
    let mut signed = other.clone();
    for x in signed.positions.iter_mut().step_by(2) {
        *x = -(DVec3::ZERO - *x);
    }
    assert!(signed.positions.iter().any(|x| x.x == 0.0 && x.x.is_sign_negative()));
    assert_eq!(self::report(&a, &signed).coincidence, Some(Coincidence::SameMesh));

    // A vertex apart is another mesh.
    other.positions[7] *= 1.001;
    assert_eq!(self::report(&a, &other).coincidence, None);
}

/// A cube whose sides are split from their centers is the same surface.
#[test]
fn one_surface_of_two_meshes_is_named() {
    let a = cube(10.0);
    let mut split = a.clone();
    split.faces.clear();
    for (number, &[p, q, r]) in (0_u32..).zip(&a.faces) {
        let [x, y, z] = [p, q, r].map(|corner| a.positions[corner as usize]);
        // Halfway along an edge, so that coordinates are exact.
        split.positions.push(0.5 * (y + z));
        let middle = 8 + number;
        assert!(x.is_finite());
        split.faces.extend([[p, q, middle], [p, middle, r]]);
    }
    let found = report(&a, &split);
    assert!(found.overlap.is_some());
    assert_eq!(found.coincidence, Some(Coincidence::SameSurface));
}

#[test]
fn a_body_whose_corners_rest_on_the_walls_around_it_overlaps() {
    let inner = octasphere(5.0, 0);
    let report = report(&cube(10.0), &inner);
    assert!(report.overlaps && report.crossing_faces.is_empty());
    assert!((volume(&report) - inner.volume()).abs() < 1e-9, "{}", volume(&report));
}

/// Points of a sphere within the margin of a plane are a cap, whose area is 2πr times its height.
#[test]
fn the_area_within_the_margin_is_that_of_a_cap() {
    let ball = icosphere(10.0, 5);
    let table = cube(60.0).translated(DVec3::Z * -40.5);
    let (mut scene, _) = scene_of(&[&ball, &table]);
    for margin in [0.75, 2.0, 5.0] {
        let reports = scene.check(&CheckParams::new(margin), Progress::none()).expect("a check");
        let [of_ball, of_table] = reports[0].near_areas.expect("they are near and do not overlap");

        // The ball's facets differ from the sphere by less than a percent.
        let cap = 2.0 * std::f64::consts::PI * 10.0 * (margin - 0.5);
        let disk = std::f64::consts::PI * ((10.0 + margin).powi(2) - 10.5_f64.powi(2));
        for (area, exact) in [(of_ball, cap), (of_table, disk)] {
            let holds = area.lower <= 1.01 * exact && 0.99 * exact <= area.upper;
            assert!(holds && area.upper - area.lower <= 0.05 * area.upper, "{margin}: {area:?}");
        }
    }
}

#[test]
fn bodies_that_touch_share_an_area_and_no_volume() {
    let a = cube(10.0);
    let report = report(&a, &a.clone().translated(DVec3::new(10.0, 5.0, 0.0)));
    assert!(!report.overlaps && report.max_depth().is_none());
    let total = report.overlap.expect("measured").measures.total;
    assert!((total.touching_area - 50.0).abs() < 1e-9, "{total:?}");
}

/// Returns a pyramid over a warped square of an edge, which is divided along the diagonal of its raised corners or
/// along the other one.
fn pyramid_over_warped_square(edge: f64, warp: f64, apex: f64, is_ridge: bool) -> Mesh {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(300.0 + x, 200.0 + y, z);
    let square = [(0.0, 0.0, 0.0), (edge, 0.0, warp), (edge, edge, 0.0), (0.0, edge, warp)];
    let mut positions: Vec<DVec3> = square.map(|(x, y, z)| corner(x, y, z)).to_vec();
    positions.push(corner(0.5 * edge, 0.5 * edge, apex));
    let base = if is_ridge { [[0, 1, 3], [1, 2, 3]] } else { [[0, 1, 2], [0, 2, 3]] };
    let sides = [[1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]];
    let mut faces: Vec<[u32; 3]> = base.into_iter().chain(sides).collect();
    if apex > 0.0 {
        faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
    Mesh { positions, faces }
}

/// Of bodies that are much larger, no faces cross and no vertex is inside.
#[test]
fn what_common_corners_leave_between_two_diagonals_is_an_overlap() {
    for warp in [0.05, 0.005, 5e-5] {
        let below = pyramid_over_warped_square(0.2, warp, -500.0, true);
        let above = pyramid_over_warped_square(0.2, warp, 500.0, false);
        let found = report(&below, &above);
        let exact = 0.2 * 0.2 * 2.0 * warp / 6.0;
        assert!(
            found.overlaps && (volume(&found) - exact).abs() < 1e-6 * exact,
            "{warp}: {found:?}"
        );

        // Divided alike they touch, and in the other order they are apart between the corners.
        for [is_ridge, is_ridge_above] in [[true; 2], [false; 2], [false, true]] {
            let below = pyramid_over_warped_square(0.2, warp, -500.0, is_ridge);
            let above = pyramid_over_warped_square(0.2, warp, 500.0, is_ridge_above);
            let found = report(&below, &above);
            assert!(!found.overlaps, "{warp}: {found:?}");
            if let Some(overlap) = found.overlap {
                let total = overlap.measures.total;
                let of = [total.volume, total.area_of_a_inside_b, total.area_of_b_inside_a];
                assert!(of.into_iter().flatten().all(|measure| measure >= 0.0), "{total:?}");
            }
        }
    }
}

#[test]
fn edges_alone_have_a_depth_and_a_contact() {
    let height = 0.25;
    let [a, b] = crossed_wedges(height);
    let report = report(&a, &b);
    assert!(report.overlaps && report.max_vertex_depth == 0.0);

    // Where the ridges cross, each is that far from the slopes of the other.
    let exact = height / 2.0_f64.sqrt();
    assert!((depth(&report) - exact).abs() < 1e-6, "{}", depth(&report));

    for kinds in [
        [BodyKind::Rigid, BodyKind::Deformable],
        [BodyKind::Deformable; 2],
        [BodyKind::Deformable, BodyKind::Rigid],
    ] {
        let mut scene = Scene::new();
        for (mesh, (name, kind)) in [&a, &b].into_iter().zip(["a", "b"].into_iter().zip(kinds)) {
            scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body");
        }
        let reports = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
        let contacts = reports[0].contacts(&scene);
        let x = scene.particle_positions();
        let [contact] = &contacts[..] else { unreachable!("one region: {contacts:?}") };
        assert!(contact.identity_error(|k| x[k as usize]) < 1e-13, "{contact:?}");
        assert!((contact.gap + exact).abs() < 0.011 * exact, "{contact:?}");
        assert_eq!(contact.anchor.is_some(), kinds.contains(&BodyKind::Rigid));
        let sum: f64 = contact.stencil.terms().iter().map(|term| term.weight).sum();
        let expected = if contact.anchor.is_some() { -1.0 } else { 0.0 };
        assert!((sum - expected).abs() < 1e-12, "{contact:?}");
    }
}

#[test]
fn an_open_sheet_in_a_box_has_a_depth_and_no_volume() {
    let room = cube(10.0);
    let sheet = Mesh {
        positions: [[-1.0, -1.0, 2.0], [3.0, -1.0, 2.0], [-1.0, 3.0, 2.0]].map(DVec3::from).into(),
        faces: vec![[0, 1, 2]],
    };
    let report = report(&room, &sheet);
    let overlap = report.overlap.expect("the sheet is inside");
    assert_eq!(overlap.measures.total.volume, None);
    assert!(matches!(overlap.measures.no_inside, [None, Some(NoInside::OddEdges { .. })]));
    let inside = overlap.measures.total.area_of_b_inside_a.expect("the box has an inside");
    assert!((inside - 8.0).abs() < 1e-12, "{inside}");
    let depth = overlap.depth_of_b_in_a.expect("the sheet is inside");
    assert!((depth.lower - 3.0).abs() < 1e-6, "{depth:?}");
    assert_eq!(overlap.depth_of_a_in_b, None);
}

/// By the parity of crossings nothing is inside a body doubled within one mesh.
#[test]
fn a_body_inside_a_doubled_one_overlaps_it() {
    let doubled = cube(10.0).joined(&cube(10.0));
    let report = report(&doubled, &cube(2.0));
    assert!(report.overlaps && report.max_depth().is_none());
    assert_eq!(report.overlap.expect("measured").measures.covers_twice, [true, false]);
}

/// A rod reaches deep into one of two cubes that cross each other, with its tip in what both cover: the
/// cubes reach less deep into the rod.
#[test]
fn the_larger_depth_is_undefined_where_one_of_both_is() {
    let twins = cube(10.0).joined(&cube(12.0).translated(DVec3::new(9.0, 0.0, 0.0)));
    let rod = cube(2.0).mapped(|p| DVec3::new(3.0 * p.x + 1.0, p.y, p.z));
    let report = report(&twins, &rod);
    let overlap = report.overlap.as_ref().expect("they meet");
    assert_eq!(overlap.measures.covers_twice, [true, false]);
    assert_eq!(overlap.depth_of_b_in_a, None);
    let shallower = overlap.depth_of_a_in_b.expect("the cube's face crosses the rod");
    assert!(shallower.upper < report.max_vertex_depth, "{shallower:?}");
    assert_eq!(report.max_depth(), None);
    assert_eq!(overlap.max_depth(), None);
}

/// Parts of a body with a hole are around and within another one.
#[test]
fn the_larger_depth_is_undefined_where_a_body_with_a_hole_surrounds_the_other() {
    let mut walls = cube(10.0);
    walls.faces.pop();
    let report = report(&walls.joined(&cube(1.0)), &cube(4.0));
    let overlap = report.overlap.as_ref().expect("the small part is inside");
    let of_part = overlap.depth_of_a_in_b.expect("the small part is inside");
    assert!((of_part.lower - 2.0).abs() < 0.51, "{of_part:?}");
    assert!(report.max_vertex_depth > 0.0, "the other body is surrounded");
    assert_eq!(report.max_depth(), None);
}

#[test]
fn tolerances_out_of_range_are_rejected() {
    let (mut scene, _) = scene_of(&[&cube(1.0), &cube(1.0)]);
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let params = CheckParams { depth_tolerance: Some(tolerance), ..CheckParams::new(0.0) };
        let refused = scene.check(&params, Progress::none());
        assert!(matches!(refused, Err(SceneError::DepthTolerance { .. })), "{refused:?}");
    }
}

#[test]
fn the_larger_of_both_depths_is_bracketed() {
    let report = report(&cube(10.0), &octasphere(3.0, 0).translated(DVec3::new(6.5, 0.3, 0.2)));
    let max = report.max_depth().expect("they overlap");
    let overlap = report.overlap.as_ref().expect("they meet");
    let of_bodies =
        [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a].map(|depth| depth.expect("inside"));
    assert!(max.lower > 1.0 && max.lower <= max.upper, "{max:?}");
    for depth in of_bodies {
        assert!(depth.lower <= max.lower && depth.upper <= max.upper, "{depth:?} {max:?}");
    }
}
