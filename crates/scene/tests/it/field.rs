//! Contacts by a bone's field against exact detection and planted answers.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use distance_field::{DistanceField, FieldGrid, FieldParams, Pose, Storage};
use fixtures::{Mesh, shapes};
use glam::{DQuat, DVec3};
use scene::Progress;
use scene::{
    BodyId, BodyKind, CheckParams, FieldContact, FieldDetector, FieldFeature, Scene, SceneError,
};
use surface::RigidState;
use surface::{closest_on_triangle, winding_number};

const SPACING: f64 = 0.5;

fn bone() -> Mesh {
    shapes::ellipsoid(DVec3::new(9.0, 7.0, 5.0), 3)
}

fn field_of(mesh: &Mesh) -> DistanceField {
    let (surface, samples) = (mesh.surface(), 8192);
    let params =
        FieldParams { padding: 4.0, truncation: Some(15.0), samples, ..FieldParams::new(SPACING) };
    let x = surface.positions(&mesh.positions).expect("finite");
    DistanceField::build(&surface, x, &params, Progress::none()).expect("a field")
}

/// The field's worst error by its own report.
fn stated(field: &DistanceField) -> f64 {
    field.report().measured_error.expect("a comparison").max
}

fn scene_of(mesh: &Mesh) -> (Scene, BodyId) {
    let mut scene = Scene::new();
    let other = shapes::cube(1.0).translated(DVec3::splat(500.0));
    let kind = BodyKind::Deformable;
    scene.add("elsewhere", kind, other.surface(), other.positions).expect("a body");
    let id = scene.add("muscle", kind, mesh.surface(), mesh.positions.clone()).expect("a body");
    (scene, id)
}

/// Signed distance of a point from a closed mesh, by looking at every face.
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

fn to_world(pose: &Pose, p: DVec3) -> DVec3 {
    pose.transform_vector(p - pose.inverse_transform_point(DVec3::ZERO))
}

/// Every identity that a producer of contacts promises.
fn assert_sound(contacts: &[FieldContact], scene: &Scene) {
    let x = scene.particle_positions();
    for FieldContact { contact, .. } in contacts {
        let error = contact.identity_error(|particle| x[particle as usize]);
        assert!(error < 1e-11, "identity {error}: {contact:?}");
        assert!((contact.normal.length() - 1.0).abs() < 1e-12, "{contact:?}");
        let sum: f64 = contact.stencil.terms().iter().map(|term| term.weight).sum();
        assert!((sum + 1.0).abs() < 1e-15, "{contact:?}");
    }
}

/// The exact check and the field agree on every vertex, to the field's error.
#[test]
fn vertices_agree_with_the_exact_check() {
    let (bone, muscle) = (bone(), shapes::ellipsoid(DVec3::new(6.0, 8.0, 6.0), 4));
    let muscle = muscle.translated(DVec3::new(8.0, 3.0, 4.0));
    let field = field_of(&bone);
    let (bound, margin) = (stated(&field), 1.0);
    let (mut scene, id) = scene_of(&muscle);
    let detector = FieldDetector::new(&field, margin).unwrap();
    let contacts =
        scene.field_contacts(id, &detector, &RigidState::at_rest(Pose::IDENTITY)).unwrap();
    assert_sound(&contacts, &scene);
    let by_field = |vertex: u32| {
        contacts.iter().find(|contact| contact.feature == FieldFeature::Vertex(vertex))
    };

    scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions.clone()).unwrap();
    let reports = scene.check(&CheckParams { margin: margin + 0.5 }, Progress::none()).unwrap();
    let [pair] = &reports[..] else { panic!("one pair") };
    let (mut worst, mut turned, mut count) = (0.0_f64, 0.0_f64, 0);
    for near in pair.a_against_b.near.iter().filter(|near| near.gap > -2.0 * SPACING) {
        let Some(FieldContact { contact, .. }) = by_field(near.vertex) else {
            assert!(near.gap > margin - bound, "vertex {} at {} is lost", near.vertex, near.gap);
            continue;
        };
        worst = worst.max((contact.gap - near.gap).abs());
        turned = turned.max(contact.normal.angle_between(near.normal).to_degrees());
        count += 1;
    }
    assert!(count > 100, "{count}");
    assert!(worst <= bound, "{worst} beyond {bound}");
    assert!(turned < 20.0, "{turned}");
    let inside = contacts.iter().filter(|c| c.contact.gap < -bound).count();
    assert!(inside <= pair.a_against_b.inside_count.unwrap(), "{inside}");
}

/// Turns of three seconds in which a busy machine may find enough cases.
const MOST_TURNS: u32 = 10;

/// A sliver of a tetrahedron with one long edge from `a` to `b`; the rest is
/// farther from the origin.
fn needle(a: DVec3, b: DVec3) -> Mesh {
    let out = 0.5 * (a + b).normalize();
    let mut mesh = shapes::tetrahedron(1.0);
    mesh.positions = vec![a, b, a + 60.0 * out, b + 60.0 * out];
    mesh
}

/// An edge at a chosen height over the bone's exact surface, along a tangent, of
/// which neither end is near.
#[test]
fn planted_dips_are_found_and_no_others() {
    let bone = shapes::ellipsoid(DVec3::new(9.0, 7.0, 5.0), 2);
    let field = field_of(&bone);
    let bound = stated(&field);
    let detector = FieldDetector::new(&field, 0.0).unwrap();
    let (mut found, mut free, mut worst) = (0, 0, 0.0_f64);
    let mut turns = 0..MOST_TURNS;
    while (found <= 10 || free <= 10) && turns.next().is_some() {
        arbtest(|u| {
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
            let (mut scene, id) = scene_of(&needle(a, b));
            let contacts = scene
                .field_contacts(id, &detector, &RigidState::at_rest(Pose::IDENTITY))
                .expect("a detector answers");
            assert_sound(&contacts, &scene);
            let edge = scene.body(id).surface().edges().iter().position(|&ends| ends == [0, 1]);
            let edge =
                FieldFeature::Edge(u32::try_from(edge.expect("the edge")).expect("few edges"));
            match contacts.iter().find(|contact| contact.feature == edge) {
                Some(FieldContact { contact, .. }) => {
                    assert!(lowest <= bound, "found at {lowest}");
                    worst = worst.max((contact.gap - lowest).abs());
                    found += 1;
                }
                None => {
                    assert!(lowest > -bound, "an edge that dips to {lowest} is lost");
                    free += 1;
                }
            }
            Ok(())
        })
        .budget_ms(3000);
    }
    assert!(found > 10 && free > 10, "{found} found, {free} free");
    // The samples of the slow twin are 0.05 apart, over faces that slope by a third.
    assert!(worst <= bound + 0.01, "{worst} beyond {bound}");
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

/// Edges through the slab, that dip into it anywhere along their way, wherever it is.
#[test]
fn an_edge_that_falls_as_steeply_as_can_be_is_found() {
    let field = steep_slab();
    let detector = FieldDetector::new(&field, 0.0).unwrap();
    let n = DVec3::ONE.normalize();
    let moved = Pose::new(DQuat::from_axis_angle(n, 0.7), 4.0 * n);
    for (pose, before) in [Pose::IDENTITY, moved].into_iter().flat_map(|p| [(p, 3.0), (p, 5.0)]) {
        let beside = DVec3::new(2.0, -2.0, 0.0);
        let ends = [beside - before * n, beside + (12.0 - before) * n];
        let [a, b] = ends.map(|end| to_world(&pose, end));
        let (mut scene, id) = scene_of(&needle(a, b));
        assert_eq!(scene.body(id).surface().edges()[0], [0, 1]);
        let contacts = scene.field_contacts(id, &detector, &RigidState::at_rest(pose)).unwrap();
        let found = contacts.iter().find(|contact| contact.feature == FieldFeature::Edge(0));
        let FieldContact { contact, .. } = found.unwrap_or_else(|| panic!("lost: {before}"));
        assert!((contact.gap + 0.75).abs() < 0.01, "{before}: {contact:?}");
    }
}

/// In the middle of the slab the field has no slope; the way out is then away from
/// the middle of the box.
#[test]
fn without_a_gradient_the_normal_leads_away_from_the_middle() {
    let field = steep_slab();
    let detector = FieldDetector::new(&field, 0.0).unwrap();
    let at = DVec3::new(3.0, -3.0, 0.0);
    let mesh = shapes::tetrahedron(1.0);
    let mesh = mesh.clone().translated(at - mesh.positions[0]);
    let (mut scene, id) = scene_of(&mesh);
    let contacts =
        scene.field_contacts(id, &detector, &RigidState::at_rest(Pose::IDENTITY)).unwrap();
    assert_sound(&contacts, &scene);
    let FieldContact { contact, feature, steepness } = contacts[0];
    assert_eq!(feature, FieldFeature::Vertex(0));
    assert!(steepness < 1e-12, "{steepness}");
    assert!((contact.normal - at.normalize()).length() < 1e-9, "{contact:?}");
}

/// The tree leaves nothing out, and neither does the search: every vertex and
/// edge by looking at all of them, edges at 1001 points.
#[test]
fn nothing_is_left_out() {
    let field = field_of(&bone());
    let detector = FieldDetector::new(&field, 0.1).unwrap();
    let (mut vertices, mut edges) = (0, 0);
    let mut turns = 0..MOST_TURNS;
    while (vertices <= 20 || edges <= 20) && turns.next().is_some() {
        arbtest(|u| {
            let mesh = shapes::ellipsoid(DVec3::new(4.0, 30.0, 4.0), u.int_in_range(0..=2)?);
            let mesh = mesh.rotated(DVec3::Z, number(u, 0.0, 1.0)?).translated(vector(u, 9.0)?);
            let state = RigidState::at_rest(pose(u)?);
            let mesh = mesh.mapped(|p| to_world(&state.pose, p));
            let (mut scene, id) = scene_of(&mesh);
            let contacts = scene.field_contacts(id, &detector, &state).expect("an answer");
            assert_sound(&contacts, &scene);
            let height = |p: DVec3| {
                let sample =
                    field.evaluate(state.pose.inverse_transform_point(p), Default::default());
                sample.map_or(f64::INFINITY, |sample| sample.distance)
            };
            let heights: Vec<f64> = mesh.positions.iter().map(|&p| height(p)).collect();
            let has = |feature| contacts.iter().any(|contact| contact.feature == feature);
            for (vertex, &height) in (0..).zip(&heights) {
                assert_eq!(has(FieldFeature::Vertex(vertex)), height <= 0.1, "{vertex}: {height}");
                vertices += usize::from(height <= 0.1);
            }
            for (edge, &[a, b]) in (0..).zip(scene.body(id).surface().edges()) {
                let ([a, b], outside) = (
                    [a, b].map(|end| mesh.positions[end as usize]),
                    [a, b].iter().all(|&end| heights[end as usize] > 0.1),
                );
                let points = (0..=1000).map(|step| height(a.lerp(b, f64::from(step) / 1000.0)));
                let lowest = points.fold(f64::INFINITY, f64::min);
                if outside && lowest <= 0.1 {
                    assert!(has(FieldFeature::Edge(edge)), "edge {edge} at {lowest} is lost");
                    edges += 1;
                }
                assert!(
                    outside || !has(FieldFeature::Edge(edge)),
                    "edge {edge} has a vertex inside"
                );
            }
            Ok(())
        })
        .budget_ms(3000);
    }
    assert!(vertices > 20 && edges > 20, "{vertices} vertices, {edges} edges");
}

/// A bone and a body that move as one have the same contacts, turned.
#[test]
fn contacts_turn_with_the_pose() {
    let field = field_of(&bone());
    let detector = FieldDetector::new(&field, 0.2).unwrap();
    let mesh =
        shapes::ellipsoid(DVec3::new(3.0, 25.0, 3.0), 1).translated(DVec3::new(9.0, 0.0, 1.3));
    let (mut scene, id) = scene_of(&mesh);
    let at_rest =
        scene.field_contacts(id, &detector, &RigidState::at_rest(Pose::IDENTITY)).unwrap();
    assert!(at_rest.len() > 3, "{}", at_rest.len());
    arbtest(|u| {
        let state = RigidState::at_rest(pose(u)?);
        let moved: Vec<DVec3> = mesh.positions.iter().map(|&p| to_world(&state.pose, p)).collect();
        scene.move_body(id, &moved).expect("finite");
        let contacts = scene.field_contacts(id, &detector, &state).expect("an answer");
        assert_eq!(contacts.len(), at_rest.len());
        for (rest, now) in at_rest.iter().zip(&contacts) {
            assert_eq!(rest.feature, now.feature);
            assert!((rest.contact.gap - now.contact.gap).abs() < 1e-3, "{rest:?} {now:?}");
            let turned = state.pose.transform_vector(rest.contact.normal);
            let is_vertex = matches!(now.feature, FieldFeature::Vertex(_));
            let tolerance = if is_vertex { 1e-9 } else { 0.1 };
            assert!((turned - now.contact.normal).length() < tolerance, "{rest:?} {now:?}");
        }
        Ok(())
    })
    .budget_ms(1000);
}

#[test]
fn anchors_move_with_the_bone() {
    let field = field_of(&bone());
    let detector = FieldDetector::new(&field, 0.0).unwrap();
    let (mut scene, id) =
        scene_of(&shapes::icosphere(3.0, 1).translated(DVec3::new(9.0, 1.0, 0.0)));
    let (about, linear) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 5.0, 0.5));
    let angular = DVec3::new(0.3, -0.2, 0.9);
    let state = RigidState {
        pose: Pose::IDENTITY,
        center: about,
        linear_velocity: linear,
        angular_velocity: angular,
    };
    let contacts = scene.field_contacts(id, &detector, &state).unwrap();
    assert!(!contacts.is_empty(), "they overlap");
    for FieldContact { contact, .. } in contacts {
        let anchor = contact.anchor.unwrap();
        // Where the point is a little later, by turning it about the centre.
        let dt = 1e-6;
        let turn = DQuat::from_scaled_axis(angular * dt);
        let later = about + linear * dt + turn * (anchor.point - about);
        let velocity = (later - anchor.point) / dt;
        assert!((velocity - anchor.velocity).length() < 1e-4, "{velocity} {anchor:?}");
    }
}

#[test]
fn what_is_far_or_wrong_is_answered() {
    let field = field_of(&bone());
    assert_eq!(FieldDetector::new(&field, -1.0).unwrap_err(), SceneError::Margin { margin: -1.0 });
    assert!(FieldDetector::new(&field, f64::NAN).is_err());
    let (mut scene, id) = scene_of(&shapes::icosphere(3.0, 1));
    let detector = FieldDetector::new(&field, 0.0).unwrap();
    let far = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::X * 1e6));
    assert_eq!(scene.field_contacts(id, &detector, &far), Ok(Vec::new()));
    let error = Scene::new().field_contacts(id, &detector, &far).unwrap_err();
    assert_eq!(error, SceneError::NoSuchBody { index: 1, count: 0 });
    // An edge of a size that no share can step through.
    let huge = needle(DVec3::new(-1e30, 6.0, 0.1), DVec3::new(1e30, 6.0, 0.1));
    let (mut scene, id) = scene_of(&huge);
    scene.field_contacts(id, &detector, &RigidState::at_rest(Pose::IDENTITY)).unwrap();
}
