//! Joint contact of scenes with known areas, gaps and forces.

use std::f64::consts::PI;

use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere};
use glam::DVec3;
use kdop::Workspace;
use overlap::{
    ElasticFoundation, FoundationLaw, JointContact, JointContactError, JointContactParams,
    OverlapDetector,
};
use proximity::SurfaceTree;
use surface::closest_on_triangle;
use surface::progress::Progress;

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("planted bodies are finite")
}

fn contact(a: &Mesh, b: &Mesh, params: &JointContactParams) -> [JointContact; 2] {
    let (a, b) = (tree(a), tree(b));
    let mut detector = OverlapDetector::default();
    detector.measure(&a, &b);
    let contact = detector.joint_contact([&a, &b], params, Progress::none());
    contact.expect("the parameters are in their ranges")
}

fn params(margin: f64, resolution: f64) -> JointContactParams {
    JointContactParams { margin, resolution, foundation: None }
}

/// A block under the plane z = 0, wide enough for what rests on it.
fn ground() -> Mesh {
    cube(1.0).scaled(DVec3::new(60.0, 60.0, 20.0)).translated(DVec3::new(0.0, 0.0, -10.0))
}

/// A condyle pressed into a plateau: areas, gaps and forces are the same whichever way faces look.
#[test]
fn faces_that_look_inward_change_no_contact() {
    let (youngs_modulus, poissons_ratio, thickness) = (5.0, 0.46, 5.0);
    let law = FoundationLaw::Linear;
    let layer = ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law };
    let params = JointContactParams { foundation: Some(layer), ..params(0.5, 0.2) };
    let condyle = icosphere(20.0, 3).translated(DVec3::new(0.3, 0.2, 19.5));
    let outward = contact(&condyle, &ground(), &params);
    assert!(outward[0].total.force.z > 1.0 && outward[1].total.force.z < -1.0, "{outward:?}");

    for turned in [[true, false], [false, true], [true; 2]] {
        let [femur, tibia] = [(condyle.clone(), turned[0]), (ground(), turned[1])]
            .map(|(mesh, turned)| if turned { mesh.flipped() } else { mesh });
        let inward = contact(&femur, &tibia, &params);
        for (one, other) in outward.iter().zip(&inward) {
            let [one, other] = [one.total, other.total];
            assert!(
                (one.area - other.area).abs() < 1e-6 * one.area,
                "{turned:?}: {one:?} {other:?}"
            );
            assert!((one.min_gap - other.min_gap).abs() < 1e-9, "{turned:?}: {one:?} {other:?}");
            assert!((one.mean_gap - other.mean_gap).abs() < 1e-9, "{turned:?}: {one:?} {other:?}");
            let apart = one.force.distance(other.force);
            assert!(apart < 1e-6 * one.force.length(), "{turned:?}: {one:?} {other:?}");
        }
    }
}

#[test]
fn a_gap_between_plates_is_contact_within_the_margin_and_none_below_it() {
    let upper = cube(1.0).translated(DVec3::new(0.0, 0.0, 0.6));
    let [of_upper, of_ground] = contact(&upper, &ground(), &params(0.2, 0.02));
    assert!((of_upper.total.min_gap - 0.1).abs() < 1e-12, "{:?}", of_upper.total);

    // The lower side lies at 0.1 as a whole, and 0.1 of the height of each other side within 0.2.
    let exact = 1.0 + 4.0 * 0.1;
    let total = of_upper.total;
    assert!(total.area_lower <= exact + 1e-12 && exact <= total.area_upper + 1e-12, "{total:?}");
    assert!(total.area_upper - total.area_lower < 4.0 * 2.0 * 0.04, "{total:?}");
    let mean = (0.1 + 4.0 * 0.1 * 0.15) / exact;
    assert!((total.mean_gap - mean).abs() < 2e-3, "{total:?}");
    assert!(total.center.truncate().length() < 1e-3);

    // Of the ground, the square below and a rim of it as wide as the margin allows.
    let rim = (0.2_f64.powi(2) - 0.1_f64.powi(2)).sqrt();
    let exact = 1.0 + 4.0 * rim + PI * rim * rim;
    let total = of_ground.total;
    assert!(total.area_lower <= exact && exact <= total.area_upper, "{total:?}, {exact}");

    let [apart, _] = contact(&upper, &ground(), &params(0.09, 0.02));
    assert_eq!(apart, JointContact::default());
}

#[test]
fn a_ball_pressed_into_the_ground_has_the_area_depth_and_force_of_its_cap() {
    let (radius, depth) = (10.0, 1.0);
    let ball = icosphere(radius, 5).translated(DVec3::new(0.0, 0.0, radius - depth));
    let law = FoundationLaw::Linear;
    let layer = ElasticFoundation { youngs_modulus: 5.0, poissons_ratio: 0.4, thickness: 2.0, law };
    let params = JointContactParams { foundation: Some(layer), ..params(0.0, 0.1) };
    let [of_ball, of_ground] = contact(&ball, &ground(), &params);

    // Archimedes: the depth is evenly distributed over the cap.
    let total = of_ball.total;
    let area = 2.0 * PI * radius * depth;
    assert!((total.area / area - 1.0).abs() < 5e-3, "{} for {area}", total.area);
    assert!(total.area_lower <= total.area && total.area <= total.area_upper);
    assert!((total.mean_gap + 0.5 * depth).abs() < 5e-3, "{}", total.mean_gap);
    assert!((total.min_gap + depth).abs() < 1e-2, "{}", total.min_gap);
    assert!((total.center.z + 0.5 * depth).abs() < 1e-2, "{}", total.center);
    assert!((total.mean_pressure / layer.pressure(0.5 * depth) - 1.0).abs() < 1e-2);

    // ∫ p n dA over the cap, with u = cos θ: 2π R² (M / h) ∫ u (R u − (R − d)) du.
    let from = 1.0 - depth / radius;
    let integral =
        radius * (1.0 - from.powi(3)) / 3.0 - (radius - depth) * (1.0 - from * from) / 2.0;
    let force = 2.0 * PI * radius * radius * layer.pressure(1.0) * integral;
    assert!((total.force.z / force - 1.0).abs() < 1e-2, "{} for {force}", total.force);
    assert!(total.force.truncate().length() < 1e-2 * force);
    assert!(total.center_of_pressure.z < total.center.z, "pressure is highest at the bottom");

    // The map adds up to the total, and the ground's disc is that of the cap's rim.
    let mapped: f64 = of_ball.faces.iter().map(|face| face.area).sum();
    assert!((mapped - total.area).abs() < 1e-9 * area);
    let disc = PI * (radius * radius - (radius - depth).powi(2));
    assert!((of_ground.total.area / disc - 1.0).abs() < 2e-2, "{}", of_ground.total.area);
}

#[test]
fn two_contacts_are_two_regions_the_larger_first() {
    let at = |x: f64, z: f64| icosphere(5.0, 4).translated(DVec3::new(x, 0.0, z));
    let balls = at(-12.0, 4.5).joined(&at(12.0, 4.8));
    let [of_balls, _] = contact(&balls, &ground(), &params(0.0, 0.1));
    assert_eq!(of_balls.regions.len(), 2);
    let [deep, shallow] = [of_balls.regions[0], of_balls.regions[1]];
    assert!(deep.area > 2.0 * shallow.area && deep.center.x < 0.0 && shallow.center.x > 0.0);
    for face in &of_balls.faces {
        let center = balls.faces[face.face as usize].map(|v| balls.positions[v as usize].x);
        assert_eq!(face.region == 0, center[0] < 0.0);
    }
}

#[test]
fn a_body_wholly_inside_is_in_contact_as_a_whole() {
    let inner = icosphere(2.0, 3).translated(DVec3::new(0.0, 0.0, -10.0));
    let [of_inner, _] = contact(&inner, &ground(), &params(0.1, 0.5));
    assert_eq!(of_inner.faces.len(), inner.faces.len());
    let uncertain = of_inner.total.area - of_inner.total.area_lower;
    assert!(of_inner.total.min_gap < -9.9 && uncertain.abs() < 1e-12);
}

#[test]
fn parameters_out_of_range_are_refused_by_value() {
    let (a, b) = (tree(&cube(1.0)), tree(&ground()));
    let mut detector = OverlapDetector::default();
    detector.measure(&a, &b);
    let mut refused = |params: JointContactParams| {
        detector.joint_contact([&a, &b], &params, Progress::none()).expect_err("out of range")
    };
    assert_eq!(refused(params(-1.0, 0.1)), JointContactError::Margin { margin: -1.0 });
    assert_eq!(refused(params(1.0, 0.0)), JointContactError::Resolution { resolution: 0.0 });
    assert!(matches!(refused(params(1.0, 1e-9)), JointContactError::TooFine { .. }));
    let law = FoundationLaw::Logarithmic;
    for [youngs_modulus, poissons_ratio, thickness] in [
        [5.0, 0.5, 2.0],
        [0.0, 0.4, 2.0],
        [5.0, 0.4, f64::NAN],
        // Pressures and forces would be infinite, or no numbers.
        [1e61, 0.4, 2.0],
        [1e-61, 0.4, 2.0],
        [5.0, 0.4, 1e-91],
        [5.0, 0.4, 1e31],
    ] {
        let layer = ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law };
        let params = JointContactParams { foundation: Some(layer), ..params(1.0, 0.1) };
        assert!(matches!(refused(params), JointContactError::Foundation { .. }), "{layer:?}");
    }
}

/// At the ends of the ranges, of material and size, every measure is a number.
#[test]
fn loads_of_extreme_layers_are_finite() {
    let (small, large) = (1e-80, 1e28);
    for (size, youngs_modulus, thickness, poissons_ratio) in [
        (large, 1e60, 1e-90, 0.499_999_999_999_999_9),
        (large, 1e-60, 1e30, 0.4),
        (1.0, 1e60, 1e-90, 0.4),
        (1.0, 1e-60, 1e30, 0.4),
        (small, 1e60, 1e-90, 0.4),
        (small, 1e-60, 1e-90, -0.999),
    ] {
        let [a, b] = [cube(1.0), ground()].map(|mesh| mesh.scaled(DVec3::splat(size)));
        for law in [FoundationLaw::Linear, FoundationLaw::Logarithmic] {
            let layer = ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law };
            let params = JointContactParams { foundation: Some(layer), ..params(0.0, 0.5 * size) };
            for JointContact { total, .. } in contact(&a, &b, &params) {
                let vectors = [total.force, total.center_of_pressure, total.center];
                let numbers = [total.area, total.mean_pressure, total.max_pressure];
                let is_finite = vectors.iter().all(|vector| vector.is_finite());
                assert!(is_finite && numbers.iter().all(|x| x.is_finite()), "{layer:?}: {total:?}");
                assert!(total.area > 0.0 && total.max_pressure > 0.0, "{layer:?}: {total:?}");
            }
        }
    }
}

/// Sums of the reference: cells as they are defined, each against every face of the other body.
#[derive(Debug, Default)]
struct Reference {
    area: f64,
    area_lower: f64,
    area_upper: f64,
    gap: f64,
}

impl Reference {
    fn of(body: &Mesh, other: &Mesh, params: &JointContactParams) -> Self {
        let (mut reference, tree) = (Self::default(), tree(other));
        for face in &body.faces {
            let corners = face.map(|vertex| body.positions[vertex as usize]);
            reference.add(corners, other, &tree, params);
        }
        reference
    }

    fn add(
        &mut self,
        corners: [DVec3; 3],
        other: &Mesh,
        tree: &SurfaceTree,
        params: &JointContactParams,
    ) {
        let [a, b, c] = corners;
        let center = (a + b + c) / 3.0;
        let radius = corners.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
        if radius > params.resolution {
            let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
            for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                self.add(part, other, tree, params);
            }
            return;
        }

        let mut distance = f64::INFINITY;
        for face in &other.faces {
            let corners = face.map(|vertex| other.positions[vertex as usize]);
            distance = distance.min(closest_on_triangle(center, corners).point.distance(center));
        }
        let is_inside = tree.contains(center, &mut Workspace::default());
        let gap = if is_inside { -distance } else { distance };
        let area = 0.5 * (b - a).cross(c - a).length();
        if gap - radius <= params.margin {
            self.area_upper += area;
        }
        if gap + radius <= params.margin {
            self.area_lower += area;
        }
        if gap <= params.margin {
            self.area += area;
            self.gap += area * gap;
        }
    }
}

#[test]
fn cells_find_the_nearest_of_all_faces() {
    let ball = icosphere(3.0, 2).translated(DVec3::new(0.3, 0.2, 2.4));
    let cases = [
        // Large faces against small ones, both ways.
        [ball.clone(), cube(1.0).scaled(DVec3::new(9.0, 9.0, 4.0)).translated(-2.0 * DVec3::Z)],
        // Thin parts with a wall on either side.
        [ball.clone(), cube(1.0).scaled(DVec3::new(9.0, 9.0, 0.3))],
        [ball.clone(), ball.translated(DVec3::new(1.0, -2.0, 4.9))],
    ];
    for [a, b] in cases {
        let params = params(0.4, 0.3);
        let [of_a, of_b] = contact(&a, &b, &params);
        for (found, [body, other]) in [(of_a, [&a, &b]), (of_b, [&b, &a])] {
            let reference = Reference::of(body, other, &params);
            let total = found.total;
            assert!(total.area > 0.1, "{total:?}");
            for (found, expected) in [
                (total.area, reference.area),
                (total.area_lower, reference.area_lower),
                (total.area_upper, reference.area_upper),
                (total.mean_gap * total.area, reference.gap),
            ] {
                assert!((found - expected).abs() < 1e-10, "{found} for {expected}");
            }
        }
    }
}
