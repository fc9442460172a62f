//! Contacts by a rigid body's field against exact detection and planted answers.

use arbitrary::{Result, Unstructured};
use distance_field::{
    DistanceField, FieldContact, FieldContacts, FieldDetector, FieldDistance, FieldError,
    FieldFeature, FieldGrid, FieldParams, Interpolation, Pose, Storage,
};
use fixtures::generate::cases;
use fixtures::{Mesh, shapes};
use proximity::{PairProximity, ParticleNumbers, SurfaceTree};
use surface::glam::{DQuat, DVec3};
use surface::{RigidState, closest_on_triangle, winding_number};

use crate::support::build;

const SPACING: f64 = 0.5;

fn bone() -> Mesh {
    shapes::ellipsoid(DVec3::new(9.0, 7.0, 5.0), 3)
}

fn field_of(mesh: &Mesh) -> DistanceField {
    let truncation = Some(15.0);
    let params =
        FieldParams { padding: 4.0, truncation, samples: 8192, ..FieldParams::new(SPACING) };
    build(mesh, &params).expect("a field")
}

/// The maximum error of a field by its own report.
fn measured(field: &DistanceField) -> f64 {
    field.report().measured_error.expect("samples").max
}

/// Number of the first particle of a body: some other body has those below.
const FIRST_PARTICLE: u32 = 8;

fn tree_of(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a body")
}

/// Finds the contacts of a body, and checks every identity that a producer of contacts
/// promises.
fn contacts_of(
    detector: &FieldDetector,
    state: &RigidState,
    body: &SurfaceTree,
) -> Vec<FieldContact> {
    let mut contacts = FieldContacts::default();
    contacts.compute(detector, state, body, ParticleNumbers::from(FIRST_PARTICLE));
    for FieldContact { contact, .. } in contacts.contacts() {
        let error = contact.identity_error(|particle| body.position(particle - FIRST_PARTICLE));
        assert!(error < 1e-11, "identity {error}: {contact:?}");
        assert!((contact.normal.length() - 1.0).abs() < 1e-12, "{contact:?}");
        let sum: f64 = contact.stencil.terms().iter().map(|term| term.weight).sum();
        assert!((sum + 1.0).abs() < 1e-15, "{contact:?}");
    }
    contacts.contacts().to_vec()
}

fn at_rest() -> RigidState {
    RigidState::at_rest(Pose::IDENTITY)
}

/// Signed distance of a point from a closed mesh, by all faces.
fn exact(p: DVec3, mesh: &Mesh) -> f64 {
    let triangles: Vec<[DVec3; 3]> = (0..mesh.faces.len()).map(|face| mesh.corners(face)).collect();
    let nearest = triangles.iter().map(|&t| closest_on_triangle(p, t).point.distance(p));
    let (surface, x) = (mesh.surface(), &mesh.positions);
    let is_inside = winding_number(&surface, surface.positions(x).expect("finite"), p) > 0.5;
    nearest.fold(f64::INFINITY, f64::min) * if is_inside { -1.0 } else { 1.0 }
}

fn number(u: &mut Unstructured<'_>, from: f64, to: f64) -> Result<f64> {
    Ok(from + (to - from) * f64::from(u.int_in_range(0_u16..=u16::MAX)?) / 65535.0)
}

fn vector(u: &mut Unstructured<'_>, size: f64) -> Result<DVec3> {
    Ok(DVec3::new(number(u, -size, size)?, number(u, -size, size)?, number(u, -size, size)?))
}

fn pose(u: &mut Unstructured<'_>) -> Result<Pose> {
    let axis = (vector(u, 1.0)? + DVec3::Z * 2.0).normalize();
    Ok(Pose::new(DQuat::from_axis_angle(axis, number(u, -3.0, 3.0)?), vector(u, 40.0)?))
}

/// The exact query and the field agree on every vertex, to the field's error.
#[test]
fn vertices_agree_with_exact_proximity() {
    let (bone, muscle) = (bone(), shapes::ellipsoid(DVec3::new(6.0, 8.0, 6.0), 4));
    let muscle = tree_of(&muscle.translated(DVec3::new(8.0, 3.0, 4.0)));
    let field = field_of(&bone);
    let (error, margin) = (measured(&field), 1.0);
    let detector = FieldDetector::new(field, margin).unwrap();
    let contacts = contacts_of(&detector, &at_rest(), &muscle);
    let by_field = |vertex: u32| {
        contacts.iter().find(|contact| contact.feature == FieldFeature::Vertex(vertex))
    };

    let mut pair = PairProximity::default();
    pair.compute(&muscle, &tree_of(&bone), margin + 0.5).expect("few faces are near");
    let (mut max, mut turned, mut count) = (0.0_f64, 0.0_f64, 0);
    for near in pair.sides()[0].near().iter().filter(|near| near.gap > -2.0 * SPACING) {
        let Some(FieldContact { contact, .. }) = by_field(near.vertex) else {
            assert!(near.gap > margin - error, "vertex {} at {} is lost", near.vertex, near.gap);
            continue;
        };
        max = max.max((contact.gap - near.gap).abs());
        turned = turned.max(contact.normal.angle_between(near.normal).to_degrees());
        count += 1;
    }
    assert!(count > 100, "{count}");
    assert!(max <= error, "{max} beyond {error}");
    assert!(turned < 20.0, "{turned}");
    let inside = contacts.iter().filter(|found| found.contact.gap < -error).count();
    assert!(inside <= pair.sides()[0].inside_count().unwrap(), "{inside}");
}

/// A sliver of a tetrahedron with one long edge from `a` to `b`; the rest is
/// farther from the origin.
fn needle(a: DVec3, b: DVec3) -> Mesh {
    let out = 0.5 * (a + b).normalize();
    let mut mesh = shapes::tetrahedron(1.0);
    mesh.positions = vec![a, b, a + 60.0 * out, b + 60.0 * out];
    mesh
}

/// An edge at a chosen height over the exact surface, along a tangent, of which neither end
/// is near.
#[test]
fn planted_dips_are_found_and_no_others() {
    let bone = shapes::ellipsoid(DVec3::new(9.0, 7.0, 5.0), 2);
    let field = field_of(&bone);
    let error = measured(&field);
    let detector = FieldDetector::new(field, 0.0).unwrap();
    let (mut found, mut free, mut max) = (0, 0, 0.0_f64);
    cases(1, 60, |u| {
        let direction = (vector(u, 1.0)? + DVec3::splat(1e-3)).normalize();
        let scale = DVec3::new(9.0, 7.0, 5.0);
        let normal = (direction / scale).normalize();
        let p = direction * scale + normal * number(u, -1.0, 0.7)?;
        let along = normal.any_orthonormal_vector();
        let along = DQuat::from_axis_angle(normal, number(u, 0.0, 3.0)?) * along;
        let [a, b] = [-number(u, 9.0, 40.0)?, number(u, 9.0, 40.0)?].map(|t| p + t * along);
        let lowest = (-120..=120)
            .map(|step| exact(p + 0.05 * f64::from(step) * along, &bone))
            .fold(f64::INFINITY, f64::min);

        let body = tree_of(&needle(a, b));
        let contacts = contacts_of(&detector, &at_rest(), &body);
        let edge = body.surface().edges().iter().position(|&ends| ends == [0, 1]);
        let edge = FieldFeature::Edge(u32::try_from(edge.expect("the edge")).expect("few edges"));
        match contacts.iter().find(|contact| contact.feature == edge) {
            Some(FieldContact { contact, .. }) => {
                assert!(lowest <= error, "found at {lowest}");
                max = max.max((contact.gap - lowest).abs());
                found += 1;
            }
            None => {
                assert!(lowest > -error, "an edge that dips to {lowest} is lost");
                free += 1;
            }
        }
        Ok(())
    });
    assert!(found > 10 && free > 10, "{found} found, {free} free");
    // The exact samples are 0.05 apart, over faces that slope by a third.
    assert!(max <= error + 0.01, "{max} beyond {error}");
}

/// A slab between two parallel planes, whose field rises by 1 along each axis: √3
/// along its normal, as steeply as its nodes allow.
fn steep_slab() -> DistanceField {
    let grid = FieldGrid::new(DVec3::splat(-12.0), SPACING, [49; 3]).expect("a grid");
    let along = |n: u8| f32::from(n) * 0.5 - 12.0;
    let value = |[i, j, k]: [u8; 3]| (along(i) + along(j) + along(k)).abs() - 0.75;
    let rows = (0..49).flat_map(|k| (0..49).map(move |j| (j, k)));
    let values = rows.flat_map(|(j, k)| (0..49).map(move |i| value([i, j, k]))).collect();
    DistanceField::from_values(grid, values, Storage::Float).expect("finite values")
}

/// Edges through the slab that dip into it anywhere along their length, in any pose.
#[test]
fn an_edge_that_falls_as_steeply_as_can_be_is_found() {
    let detector = FieldDetector::new(steep_slab(), 0.0).unwrap();
    let n = DVec3::ONE.normalize();
    let moved = Pose::new(DQuat::from_axis_angle(n, 0.7), 4.0 * n);
    for (pose, before) in [Pose::IDENTITY, moved].into_iter().flat_map(|p| [(p, 3.0), (p, 5.0)]) {
        let beside = DVec3::new(2.0, -2.0, 0.0);
        let ends = [beside - before * n, beside + (12.0 - before) * n];
        let [a, b] = ends.map(|end| pose.transform_point(end));
        let body = tree_of(&needle(a, b));
        assert_eq!(body.surface().edges()[0], [0, 1]);
        let contacts = contacts_of(&detector, &RigidState::at_rest(pose), &body);
        let found = contacts.iter().find(|contact| contact.feature == FieldFeature::Edge(0));
        let FieldContact { contact, .. } = found.unwrap_or_else(|| panic!("lost: {before}"));
        assert!((contact.gap + 0.75).abs() < 0.01, "{before}: {contact:?}");
    }
}

/// In the middle of the slab the field has no gradient; the normal then points away from the
/// center of the box.
#[test]
fn without_a_gradient_the_normal_points_away_from_the_center() {
    let detector = FieldDetector::new(steep_slab(), 0.0).unwrap();
    let at = DVec3::new(3.0, -3.0, 0.0);
    let mesh = shapes::tetrahedron(1.0);
    let mesh = mesh.clone().translated(at - mesh.positions[0]);
    let contacts = contacts_of(&detector, &at_rest(), &tree_of(&mesh));
    let FieldContact { contact, feature, gradient_length } = contacts[0];
    assert_eq!(feature, FieldFeature::Vertex(0));
    assert!(gradient_length < 1e-12, "{gradient_length}");
    assert!((contact.normal - at.normalize()).length() < 1e-9, "{contact:?}");
}

/// Neither the tree nor the search leaves anything out: every vertex and edge by brute force,
/// edges at 1001 points.
#[test]
fn nothing_is_left_out() {
    let field = field_of(&bone());
    let detector = FieldDetector::new(field.clone(), 0.1).unwrap();
    let (mut vertices, mut edges) = (0, 0);
    cases(2, 30, |u| {
        let mesh = shapes::ellipsoid(DVec3::new(4.0, 30.0, 4.0), u.int_in_range(0..=2)?);
        let mesh = mesh.rotated(DVec3::Z, number(u, 0.0, 1.0)?).translated(vector(u, 9.0)?);
        let state = RigidState::at_rest(pose(u)?);
        let mesh = mesh.mapped(|p| state.pose.transform_point(p));
        let body = tree_of(&mesh);
        let contacts = contacts_of(&detector, &state, &body);
        let value = |p: DVec3| {
            let p = state.pose.inverse_transform_point(p);
            let sample = field.evaluate(p, Interpolation::Trilinear);
            sample.map_or(f64::INFINITY, |sample| sample.distance)
        };
        let values: Vec<f64> = mesh.positions.iter().map(|&p| value(p)).collect();
        let has = |feature| contacts.iter().any(|contact| contact.feature == feature);

        for (vertex, &value) in (0..).zip(&values) {
            assert_eq!(has(FieldFeature::Vertex(vertex)), value <= 0.1, "{vertex}: {value}");
            vertices += usize::from(value <= 0.1);
        }
        for (edge, &ends) in (0..).zip(body.surface().edges()) {
            let is_outside = ends.iter().all(|&end| values[end as usize] > 0.1);
            let [a, b] = ends.map(|end| body.position(end));
            let points = (0..=1000).map(|step| value(a.lerp(b, f64::from(step) / 1000.0)));
            let lowest = points.fold(f64::INFINITY, f64::min);
            let is_found = has(FieldFeature::Edge(edge));
            assert!(is_outside || !is_found, "edge {edge} has a vertex inside");
            if is_outside && lowest <= 0.1 {
                assert!(is_found, "edge {edge} at {lowest} is lost");
                edges += 1;
            }
        }
        Ok(())
    });
    assert!(vertices > 20 && edges > 20, "{vertices} vertices, {edges} edges");
}

/// A bone and a body that move as one have the same contacts, turned.
#[test]
fn contacts_turn_with_the_pose() {
    let detector = FieldDetector::new(field_of(&bone()), 0.2).unwrap();
    let mesh =
        shapes::ellipsoid(DVec3::new(3.0, 25.0, 3.0), 1).translated(DVec3::new(9.0, 0.0, 1.3));
    let mut body = tree_of(&mesh);
    let before = contacts_of(&detector, &at_rest(), &body);
    assert!(before.len() > 3, "{}", before.len());
    cases(3, 100, |u| {
        let state = RigidState::at_rest(pose(u)?);
        let moved: Vec<DVec3> =
            mesh.positions.iter().map(|&p| state.pose.transform_point(p)).collect();
        body.set_positions(moved.iter().copied()).expect("finite");
        let contacts = contacts_of(&detector, &state, &body);
        assert_eq!(contacts.len(), before.len());
        for (before, now) in before.iter().zip(&contacts) {
            assert_eq!(before.feature, now.feature);
            let gaps = [before, now].map(|found| found.contact.gap);
            assert!((gaps[0] - gaps[1]).abs() < 1e-3, "{before:?} {now:?}");
            let turned = state.pose.transform_vector(before.contact.normal);
            let is_vertex = matches!(now.feature, FieldFeature::Vertex(_));
            let tolerance = if is_vertex { 1e-9 } else { 0.1 };
            assert!((turned - now.contact.normal).length() < tolerance, "{before:?} {now:?}");
        }
        Ok(())
    });
}

#[test]
fn anchors_have_the_velocity_of_the_body() {
    let detector = FieldDetector::new(field_of(&bone()), 0.0).unwrap();
    let body = tree_of(&shapes::icosphere(3.0, 1).translated(DVec3::new(9.0, 1.0, 0.0)));
    let state = RigidState {
        pose: Pose::IDENTITY,
        center: DVec3::new(1.0, 2.0, 3.0),
        linear_velocity: DVec3::new(-4.0, 5.0, 0.5),
        angular_velocity: DVec3::new(0.3, -0.2, 0.9),
    };
    let contacts = contacts_of(&detector, &state, &body);
    assert!(!contacts.is_empty(), "they overlap");
    for FieldContact { contact, .. } in contacts {
        let anchor = contact.anchor.unwrap();
        assert_eq!(anchor.velocity, state.velocity_at(anchor.point));
    }
}

/// A coarser surface adds the deepest of the vertices that it represents.
#[test]
fn the_deepest_vertex_of_a_finer_surface_is_added() {
    let detector = FieldDetector::new(field_of(&bone()), 0.0).unwrap();
    let coarse = tree_of(&shapes::icosphere(3.0, 1).translated(DVec3::new(10.0, 1.0, 0.0)));
    let fine = tree_of(&shapes::icosphere(3.0, 3).translated(DVec3::new(9.5, 1.0, 0.0)));
    let all: Vec<u32> = (0..).take(fine.surface().vertex_count()).collect();
    let numbers = ParticleNumbers::from(FIRST_PARTICLE);

    let mut contacts = FieldContacts::default();
    contacts.compute(&detector, &at_rest(), &coarse, numbers);
    let before = contacts.contacts().len();
    contacts.add_deepest(&detector, &at_rest(), fine.positions(), numbers, |_| &all);
    let deepest = contacts_of(&detector, &at_rest(), &fine)
        .into_iter()
        .min_by(|a, b| a.contact.gap.total_cmp(&b.contact.gap));
    assert_eq!(contacts.contacts().len(), before + 1);
    assert_eq!(contacts.contacts().last(), deepest.as_ref());

    // No vertex of the coarse surface is deeper.
    let coarse_vertices: Vec<u32> = (0..).take(coarse.surface().vertex_count()).collect();
    let represented = |_| &coarse_vertices[..];
    contacts.add_deepest(&detector, &at_rest(), coarse.positions(), numbers, represented);
    assert_eq!(contacts.contacts().len(), before + 1);
}

/// Distances are values where the field has them, and lower bounds elsewhere.
#[test]
fn distances_are_values_or_lower_bounds() {
    let bone = bone();
    let detector = FieldDetector::new(field_of(&bone), 0.5).unwrap();
    let (mut values, mut bounds) = (0, 0);
    cases(4, 200, |u| {
        let (pose, local) = (pose(u)?, vector(u, 20.0)?);
        let exact = exact(local, &bone);
        match detector.distance(&pose, pose.transform_point(local)) {
            FieldDistance::Value { distance, normal } => {
                assert!((distance - exact).abs() < 0.3, "{distance} {exact}");
                assert!((normal.length() - 1.0).abs() < 1e-12);
                values += 1;
            }
            FieldDistance::AtLeast(bound) => {
                assert!(bound <= exact + 0.3, "{bound} {exact}");
                bounds += 1;
            }
        }
        Ok(())
    });
    assert!(values > 20 && bounds > 20, "{values} values, {bounds} bounds");
}

/// Where values fall up to the border of a grid, an edge is deepest where it leaves the grid.
#[test]
fn edges_that_leave_the_grid_are_found_in_any_pose() {
    let grid = FieldGrid::new(DVec3::ZERO, 1.0, [5, 5, 5]).unwrap();
    let values = (0..125_u8).map(|node| 4.0 - f32::from(node % 5)).collect();
    let field = DistanceField::from_values(grid, values, Storage::Float).unwrap();
    let detector = FieldDetector::new(field, 1.0).unwrap();
    cases(6, 200, |u| {
        let (pose, along) = (pose(u)?, vector(u, 1.0)?);
        let from = DVec3::new(2.5, 2.0, 2.0);
        let mesh = needle(from, from + 4.0 * (along + 2.0 * DVec3::X));
        let body = tree_of(&mesh.mapped(|p| pose.transform_point(p)));
        let contacts = contacts_of(&detector, &RigidState::at_rest(pose), &body);
        assert!(!contacts.is_empty());
        for FieldContact { contact, .. } in contacts {
            assert!(contact.gap.abs() < 1e-8, "{contact:?}");
            assert!(contact.normal.distance(pose.rotation() * -DVec3::X) < 1e-9, "{contact:?}");
        }
        Ok(())
    });
}

/// Beside a grid that ends within the margin, and beside one without a node within it.
#[test]
fn distances_beside_a_tight_grid_are_lower_bounds() {
    let bone = bone();
    let plate = shapes::plate(DVec3::new(9.0, 9.0, 0.2), [2, 2]);
    let plate = plate.translated(DVec3::splat(0.45));
    let mut bounds = 0;
    for (mesh, padding, margin) in [(&bone, 0.0, 5.0), (&bone, 2.0, 5.0), (&plate, 0.55, 0.0)] {
        let field = build(mesh, &FieldParams { padding, ..FieldParams::new(1.0) }).unwrap();
        let detector = FieldDetector::new(field, margin).unwrap();
        cases(5, 200, |u| {
            let p = vector(u, 20.0)?;
            if let FieldDistance::AtLeast(bound) = detector.distance(&Pose::IDENTITY, p) {
                let exact = exact(p, mesh);
                assert!(bound <= exact + 0.3, "{bound} {exact}");
                bounds += 1;
            }
            Ok(())
        });
    }
    assert!(bounds > 300, "{bounds}");
}

/// The bounds have a number for every 64 cells, and the field one for every node.
#[test]
fn bounds_take_little_memory_beside_the_field() {
    let field = field_of(&bone());
    let of_field = field.bytes();
    let detector = FieldDetector::new(field, 1.0).unwrap();
    let of_bounds = detector.bytes() - of_field;
    assert!(of_bounds > of_field / 128 && of_bounds < of_field / 32, "{of_bounds} of {of_field}");
}

#[test]
fn far_bodies_and_huge_edges_are_accepted() {
    let field = field_of(&bone());
    for margin in [-1.0, f64::NAN] {
        let refused = FieldDetector::new(field.clone(), margin).unwrap_err();
        assert!(matches!(refused, FieldError::InvalidParam { name: "margin", .. }));
    }
    let detector = FieldDetector::new(field, 0.0).unwrap();
    let far = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::X * 1e6));
    assert!(contacts_of(&detector, &far, &tree_of(&shapes::icosphere(3.0, 1))).is_empty());
    // An edge of a size that no step of a share can resolve.
    let huge = needle(DVec3::new(-1e30, 6.0, 0.1), DVec3::new(1e30, 6.0, 0.1));
    let mut contacts = FieldContacts::default();
    contacts.compute(&detector, &at_rest(), &tree_of(&huge), ParticleNumbers::from(0));
}
