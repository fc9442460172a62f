//! Overlaps planted so that one failure would show: edges alone, a bone thinner than the tissue is
//! deep, a spike, a bone that changes sides.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::{
    BodyStiffness, Conditions, FixedVertices, Obstacle, Remaining, Resolution, ResolveParams,
    Resolver,
};
use scene::{BodyId, BodyKind, CheckParams, Scene};
use surface::progress::Progress;

use crate::thigh::planted;
use crate::{PARAMS, max_depth, resolve, scene_of};

fn bone_and_muscle(bone: Mesh, muscle: Mesh) -> (Scene, [BodyId; 2]) {
    let bodies = [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)];
    let scene = scene_of(bodies);
    let ids = ["bone", "muscle"].map(|name| scene.find(name).expect("a body of the scene"));
    (scene, ids)
}

/// Checks that nothing remains, as detection finds it, and that tissue kept its shape.
fn assert_sound(scene: &mut Scene, resolution: &Resolution) {
    assert!(resolution.resolved, "{:?}", resolution.remaining);
    let left = max_depth(scene);
    assert!(left <= PARAMS.tolerance, "{left} left");
    for change in &resolution.bodies {
        assert_eq!(change.flipped_faces, 0, "{:?}", change.body);
        assert_eq!(change.self_crossings, [0, 0], "{:?}", change.body);
        let ratio = change.volume_ratio.expect("closed");
        assert!((ratio - 1.0).abs() < 0.01, "volume times {ratio}");
    }
}

#[test]
fn edges_that_cross_without_a_vertex_inside_are_separated() {
    let bone = shapes::octasphere(10.0, 0);
    // Two octahedra whose edges cross at right angles, 0.3 deep.
    let edge = 10.0 / f64::sqrt(2.0);
    let turned = bone.clone().rotated(DVec3::Y, 0.125).rotated(DVec3::Z, 0.25);
    let muscle = turned.translated(DVec3::Z * (2.0 * edge - 0.3));
    let bone = bone.rotated(DVec3::Y, 0.125);
    let (mut scene, _) = bone_and_muscle(bone, muscle);
    let before =
        scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
    assert!(before[0].overlaps && before[0].max_vertex_depth == 0.0, "edges alone: {before:?}");
    let resolution = resolve(&mut scene);
    assert!(resolution.rounds[0].max_depth > 0.2, "{:?}", resolution.rounds);
    assert!(resolution.resolved && resolution.remaining.is_empty(), "{:?}", resolution.remaining);
    let first = resolution.rounds[1].max_depth;
    assert!(first < 0.01, "pushed at once, not when all else fails: {first} left by one round");
    let after =
        scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
    assert!(after.iter().all(|pair| !pair.overlaps), "{after:?}");
}

#[test]
fn deep_tissue_leaves_a_thin_bone_by_the_side_it_entered() {
    // Bone 2 thick below z = 0; the tissue's lowest vertices are nearer to its other side.
    let bone = shapes::plate(DVec3::new(60.0, 60.0, 2.0), [12, 12]).translated(-DVec3::Z);
    let muscle = shapes::icosphere(12.0, 3).translated(DVec3::Z * 10.4);
    let (mut scene, [_, muscle]) = bone_and_muscle(bone, muscle);
    let lowest = |scene: &Scene| {
        scene.body(muscle).positions().iter().map(|x| x.z).fold(f64::INFINITY, f64::min)
    };
    assert!(lowest(&scene) < -1.1, "beyond the middle of the bone");
    let resolution = resolve(&mut scene);
    assert_sound(&mut scene, &resolution);
    assert!(lowest(&scene) > -PARAMS.tolerance, "{} is below the bone", lowest(&scene));
}

#[test]
fn a_muscle_fifteen_deep_between_two_bones_comes_free() {
    // Room for 30 between the bones; the muscle is 20 thick, and 15 deep in the lower one.
    let bone = shapes::plate(DVec3::new(90.0, 90.0, 40.0), [12, 12]);
    let muscle = shapes::ellipsoid(DVec3::new(25.0, 25.0, 10.0), 4);
    let mut scene = scene_of([
        ("below", BodyKind::Rigid, bone.clone().translated(DVec3::Z * -20.0)),
        ("muscle", BodyKind::Deformable, muscle.translated(DVec3::Z * -5.0)),
        ("above", BodyKind::Rigid, bone.translated(DVec3::Z * 50.0)),
    ]);
    let params = ResolveParams::with_smoothing(15.0);
    let resolution = resolve::resolve(&mut scene, &params, Progress::none());
    let resolution = resolution.expect("a resolution");
    let depth = resolution.rounds[0].surface_depth.expect("an overlap");
    assert!((depth.lower - 15.0).abs() < 0.1, "{depth:?}");
    assert_sound(&mut scene, &resolution);
    let displacement = resolution.bodies[1].max_displacement / depth.lower;
    assert!(displacement <= 1.3, "{displacement} of the depth");
}

/// The tip of a muscle is over the arc of a ring and in its hole: the nearest ways out lead to all
/// sides.
#[test]
fn tissue_over_the_arc_of_a_ring_leaves_it_by_one_side() {
    for height in [-16.0, -15.0] {
        let muscle = shapes::ellipsoid(DVec3::new(30.0, 16.0, 30.0), 4).rotated(DVec3::Y, 0.05);
        let muscle = muscle.translated(DVec3::new(22.0, 0.0, height));
        let (mut scene, _) = bone_and_muscle(shapes::torus(25.0, 5.0, [40, 12]), muscle);
        let params = ResolveParams::with_smoothing(12.0);
        let resolution = resolve::resolve(&mut scene, &params, Progress::none());
        let resolution = resolution.expect("a resolution");
        assert!(resolution.rounds[0].max_depth > 14.0, "{:?}", resolution.rounds[0]);
        assert_sound(&mut scene, &resolution);
    }
}

/// Nearest ways out of a bone in the outer half of a sheet lead out of the sheet, through its far side.
#[test]
fn a_sheet_around_a_bone_comes_off_it_on_all_sides() {
    let sheet = shapes::plate(DVec3::new(34.0, 34.0, 1.6), [24, 24]);
    let sheet = sheet.mapped(|p| {
        let (angle, direction) = (p.truncate().length() / 10.0, p.truncate().normalize_or_zero());
        let unit = (angle.sin() * direction).extend(angle.cos());
        (9.6 + p.z) * unit
    });
    let (mut scene, _) = bone_and_muscle(shapes::icosphere(10.0, 3), sheet);
    let deepest = max_depth(&mut scene);
    let resolution = resolve(&mut scene);
    assert_sound(&mut scene, &resolution);
    let farthest = resolution.bodies[1].max_displacement;
    assert!(farthest < 1.5 * deepest, "{farthest} for {deepest}");
}

/// A bone with a crest has moved sideways into one half of a thick sheet around it: the way back by the other
/// half leads across the bone.
#[test]
fn tissue_that_embraces_a_bone_beside_its_crest_follows_the_bone() {
    let crest = |p: DVec3| {
        let back = (-p.x / 10.0 - 0.6).max(0.0) / 0.4;
        DVec3::new(p.x - 6.0 * back * back, p.y * (1.0 - 0.6 * back), p.z)
    };
    let sheet = shapes::plate(DVec3::new(4.8, 30.0, 4.0), [32, 16]).mapped(|p| {
        let radius = 12.3 + p.z;
        DVec3::new(radius * p.x.cos(), radius * p.x.sin(), p.y)
    });
    for moved in [4.0, -4.0] {
        let bone = shapes::ellipsoid(DVec3::new(10.0, 10.0, 40.0), 4).mapped(crest);
        let bone = bone.translated(DVec3::new(-0.3, moved, 0.0));
        let (mut scene, _) = bone_and_muscle(bone, sheet.clone());
        let deepest = max_depth(&mut scene);
        let params = ResolveParams::with_smoothing(8.0);
        let resolution = resolve::resolve(&mut scene, &params, Progress::none());
        let resolution = resolution.expect("a resolution");
        assert_sound(&mut scene, &resolution);
        let farthest = resolution.bodies[1].max_displacement;
        assert!(farthest < 1.3 * deepest, "{moved}: {farthest} for {deepest}");
    }
}

/// Ways out that lead to all sides, each of them the right one.
#[test]
fn tissue_around_a_bone_widens() {
    let bone = shapes::capsule(10.0, 40.0, 40).rotated(DVec3::Z, 0.05);
    let (mut scene, [_, muscle]) = bone_and_muscle(bone, shapes::torus(12.0, 4.0, [60, 24]));
    let resolution = resolve(&mut scene);
    let depth = resolution.rounds[0].surface_depth.expect("an overlap").lower;
    assert!((1.9..2.1).contains(&depth), "{depth} deep all around");
    assert_sound(&mut scene, &resolution);
    let displacement = resolution.bodies[muscle.index()].max_displacement / depth;
    assert!(displacement <= 1.3, "{displacement} of the depth");
}

#[test]
#[expect(clippy::print_stdout, reason = "the test reports its measurements")]
fn bodies_share_an_overlap_by_their_stiffness() {
    let displacements = |stiffness: f64| {
        let muscle = shapes::icosphere(10.0, 3);
        let other = muscle.clone().rotated(DVec3::Z, 0.1).translated(DVec3::X * 18.6);
        let mut scene = scene_of([
            ("soft", BodyKind::Deformable, muscle),
            ("stiff", BodyKind::Deformable, other),
        ]);
        let body = scene.find("stiff").expect("a body of the scene");
        let stiffnesses = vec![BodyStiffness { body, factor: stiffness }];
        let conditions = Conditions { stiffnesses, ..Conditions::default() };
        let mut resolver = Resolver::new(PARAMS).expect("parameters").with_conditions(conditions);
        let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
        assert_sound(&mut scene, &resolution);
        [0, 1].map(|body| resolution.bodies[body].max_displacement)
    };
    // Vertices of one body meet faces of the other: equal bodies do not move by the same.
    let [[soft, other], [softer, stiff]] = [1.0, 4.0].map(displacements);
    println!("measured: displacement of four times the stiffness | {:.2} | 0.6", stiff / other);
    assert!(softer > soft && stiff < 0.6 * other, "{soft}, {other}: {softer}, {stiff}");
}

#[test]
fn a_spike_flips_no_face() {
    let spike = shapes::ellipsoid(DVec3::new(0.8, 0.8, 9.0), 2);
    let muscle = shapes::icosphere(14.0, 4).translated(DVec3::Z * 20.0);
    let (mut scene, _) = bone_and_muscle(spike, muscle);
    let resolution = resolve(&mut scene);
    assert!(resolution.rounds[0].max_depth > 0.5 || resolution.rounds[0].overlapping_pairs > 0);
    assert_sound(&mut scene, &resolution);
}

#[test]
fn displacements_that_make_it_worse_are_not_carried_over() {
    let bone = shapes::icosphere(10.0, 3);
    let muscle = shapes::icosphere(10.0, 3).translated(DVec3::X * 18.0);
    let (mut scene, [bone, muscle]) = bone_and_muscle(bone, muscle);
    let rest = [bone, muscle].map(|id| scene.body(id).positions().to_vec());
    let mut resolver = Resolver::new(PARAMS).expect("a resolver");
    resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    // The bone goes round to the other side, where tissue is as deep in it.
    let round: Vec<DVec3> = rest[0].iter().map(|x| *x + DVec3::X * 36.0).collect();
    scene.move_body(bone, &round).expect("finite");
    scene.move_body(muscle, &rest[1]).expect("finite");
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert!(resolution.resolved, "{:?}", resolution.remaining);
    let moved = scene.body(muscle).positions().iter().zip(&rest[1]);
    let far = moved.filter(|(x, _)| x.x < 12.0);
    assert!(far.clone().count() > 50, "the side that was pushed before");
    // The volume that the push takes is given back by the whole sphere.
    let farthest = far.map(|(x, rest)| x.distance(*rest)).fold(0.0, f64::max);
    assert!(farthest < 0.2, "is back to {farthest}, after a push by 2");
}

/// A state that is far deeper than pushes are long, which were long enough for the one before.
#[test]
fn a_deep_state_after_a_shallow_one_is_pushed_as_far_as_it_is_deep() {
    let at = |shift: f64| {
        let bone = shapes::ellipsoid(DVec3::new(4.0, 14.0, 14.0), 3);
        let muscle = shapes::icosphere(10.0, 3).translated(DVec3::X * shift);
        bone_and_muscle(bone, muscle).0
    };
    let params = ResolveParams::with_smoothing(0.5);
    let mut resolver = Resolver::new(params).expect("a resolver");
    let shallow = resolver.resolve(&mut at(13.8), Progress::none()).expect("a resolution");
    let deep = resolver.resolve(&mut at(8.0), Progress::none()).expect("a resolution");
    assert!(shallow.resolved && deep.resolved, "{:?}", deep.remaining);
}

#[test]
fn where_one_start_leads_to_no_end_others_push_longer() {
    // As above. Pushes of 0.6 are just too short; of 0.5 and of 0.3 those that are half as long again are so, too.
    for smoothing in [0.6, 0.5, 0.3] {
        let bone = shapes::ellipsoid(DVec3::new(4.0, 14.0, 14.0), 3);
        let muscle = shapes::icosphere(10.0, 3).translated(DVec3::X * 8.0);
        let (mut scene, _) = bone_and_muscle(bone, muscle);
        let params = ResolveParams::with_smoothing(smoothing);
        let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("an end");
        assert!(resolution.resolved, "{smoothing}: {:?}", resolution.remaining);
        assert_sound(&mut scene, &resolution);
    }
}

#[test]
fn another_start_counts_though_bones_overlap() {
    // As above, beside two bones that overlap in all ends.
    let muscle = shapes::icosphere(10.0, 3).translated(DVec3::X * 8.0);
    let far = shapes::icosphere(3.0, 2).translated(DVec3::Y * 60.0);
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, shapes::ellipsoid(DVec3::new(4.0, 14.0, 14.0), 3)),
        ("muscle", BodyKind::Deformable, muscle),
        ("one", BodyKind::Rigid, far.clone()),
        ("other", BodyKind::Rigid, far.translated(DVec3::X)),
    ]);
    let params = ResolveParams::with_smoothing(0.6);
    let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("an end");
    assert!(!resolution.resolved);
    let obstacles: Vec<Obstacle> = resolution.remaining.iter().map(|left| left.obstacle).collect();
    assert_eq!(obstacles, [Obstacle::BothRigid]);
}

#[test]
fn another_start_keeps_the_limits_of_the_first() {
    // Tissue may be moved by the smoothing length and no farther, which is less than it is deep: pushes that
    // are longer, too, leave it there.
    let muscle = shapes::icosphere(10.0, 3).translated(DVec3::X * 15.0);
    let (mut scene, [_, muscle]) = bone_and_muscle(shapes::icosphere(10.0, 3), muscle);
    let rest = scene.body(muscle).positions().to_vec();
    let params = ResolveParams { max_displacement: 0.1, ..ResolveParams::with_smoothing(4.0) };
    let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("an end");
    let moved = scene.body(muscle).positions().iter().zip(&rest);
    let farthest = moved.map(|(x, rest)| x.distance(*rest)).fold(0.0, f64::max);
    assert!(farthest <= params.smoothing && !resolution.resolved, "moved by {farthest}");
    let limit = resolution.broken_limits.first().map(|broken| broken.displacement_limit);
    assert_eq!(limit, Some(params.smoothing));
}

#[test]
fn displacements_of_bodies_with_other_vertices_are_not_carried_over() {
    let spheres = |level: u32| {
        let muscle = shapes::icosphere(10.0, level).translated(DVec3::X * 18.0);
        bone_and_muscle(shapes::icosphere(10.0, 2), muscle).0
    };
    let mut resolver = Resolver::new(PARAMS).expect("a resolver");
    resolver.resolve(&mut spheres(2), Progress::none()).expect("a resolution");
    let (mut carried, mut fresh) = (spheres(3), spheres(3));
    let with = resolver.resolve(&mut carried, Progress::none()).expect("a resolution");
    assert_eq!(with, resolve(&mut fresh));
}

/// Builds a disc of tissue 4 thick, between two bones with a gap.
fn between_bones(gap: f64) -> Scene {
    let bone = shapes::plate(DVec3::new(60.0, 60.0, 6.0), [12, 12]);
    let muscle = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 4);
    let up = DVec3::Z * (3.0 + gap / 2.0);
    scene_of([
        ("below", BodyKind::Rigid, bone.clone().translated(-up)),
        ("above", BodyKind::Rigid, bone.translated(up)),
        ("muscle", BodyKind::Deformable, muscle),
    ])
}

/// Tissue that is pushed on both faces is free at its rim alone, and bulges there.
#[test]
#[expect(clippy::print_stdout, reason = "the test reports its measurements")]
fn a_disc_pressed_over_all_of_its_faces_keeps_its_volume() {
    let mut scene = between_bones(3.0);
    let resolution = resolve(&mut scene);
    let [.., last] = resolution.rounds[..] else { panic!("no rounds") };
    let lost = 1.0 - resolution.bodies[2].volume_ratio.expect("closed");
    println!(
        "measured: disc pressed to 3/4 of its thickness: volume lost [%] | {:.2} | 0.5",
        100.0 * lost
    );
    assert!(resolution.resolved, "{:?}", resolution.remaining);
    assert!(lost.abs() < 0.005, "{lost} of the volume");
    assert!((last.volume_change - lost.abs()).abs() < 1e-3, "settled by {lost}: {last:?}");

    assert!(!resolution.rounds.is_empty() && last.flipped_faces == 0);

    // From the displacements of an earlier state nothing settles: the last round is the end.
    let mut resolver = Resolver::new(PARAMS).expect("a resolver");
    let mut again = || resolver.resolve(&mut between_bones(3.0), Progress::none());
    let [_, carried] = [again(), again()].map(|end| end.expect("a resolution"));
    let [.., last] = carried.rounds[..] else { panic!("no rounds") };
    let lost = 1.0 - carried.bodies[2].volume_ratio.expect("closed");
    assert!((last.volume_change - lost.abs()).abs() < 1e-12, "{last:?}");
}

#[test]
fn tissue_without_room_is_named_with_the_reason() {
    let mut scene = between_bones(0.01);
    let params = ResolveParams { keep_going: true, ..PARAMS };
    let resolution = resolve::resolve(&mut scene, &params, Progress::none());
    let resolution = resolution.expect("a resolution");
    assert!(!resolution.resolved);
    let muscle = scene.find("muscle").expect("the muscle");
    assert_eq!(resolution.remaining[0].pair.b, muscle);
    let squeezed = matches!(resolution.remaining[0].obstacle, Obstacle::Squeezed { .. });
    assert!(squeezed, "{:?}", resolution.remaining);
    let [broken] = resolution.broken_limits[..] else { panic!("{:?}", resolution.broken_limits) };
    assert_eq!(broken.body, muscle, "listed once");

    // Later rounds were no better, so the scene is as after the best one.
    assert!(resolution.final_round + 1 < resolution.rounds.len(), "{:?}", resolution.rounds);
    let kept = &resolution.rounds[resolution.final_round];
    assert!((kept.max_depth - max_depth(&mut scene)).abs() < 1e-12, "{kept:?}");

    // Within limits it is as after an earlier one, and that is named.
    let mut scene = between_bones(0.01);
    let resolution = resolve(&mut scene);
    let kept = &resolution.rounds[resolution.final_round];
    assert!(kept.is_accepted && !resolution.broken_limits.is_empty());
    assert!((kept.max_depth - max_depth(&mut scene)).abs() < 1e-12, "{kept:?}");

    let hasty = ResolveParams { max_rounds: 1, ..PARAMS };
    let resolution = resolve::resolve(&mut planted(), &hasty, Progress::none());
    let resolution = resolution.expect("a resolution");
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::Rounds);
    assert_eq!(resolution.rounds.len(), 2);
}

/// Returns two wedges whose ridges cross at right angles, `depth` into each other.
pub(crate) fn crossed_wedges(depth: f64) -> [Mesh; 2] {
    let positions = [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, -3.0, -3.0], [0.0, 3.0, -3.0]];
    let positions = positions.map(DVec3::from).to_vec();
    let lower = Mesh { positions, faces: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] };
    let lower = if lower.volume() > 0.0 { lower } else { lower.flipped() };
    let upper = lower.clone().mapped(|p| DVec3::new(p.y, p.x, -p.z - depth));
    let upper = if upper.volume() > 0.0 { upper } else { upper.flipped() };
    [lower, upper]
}

/// Judges a rigid body and one of a kind, all of whose vertices are fixed, with a tolerance.
fn judged(bodies: [Mesh; 2], kind: BodyKind, tolerance: f64) -> Resolution {
    let [a, b] = bodies;
    let vertices = (0..).take(b.positions.len()).collect();
    let mut scene = scene_of([("a", BodyKind::Rigid, a), ("b", kind, b)]);
    let fixed = vec![FixedVertices { body: scene.find("b").expect("the body"), vertices }];
    let resolver = Resolver::new(ResolveParams { tolerance, ..PARAMS }).expect("a resolver");
    let mut resolver = resolver.with_conditions(Conditions { fixed, ..Conditions::default() });
    resolver.resolve(&mut scene, Progress::none()).expect("a resolution")
}

#[test]
fn edges_without_a_vertex_inside_are_as_deep_as_their_surfaces() {
    let (exact, wedges) = (0.25 / f64::sqrt(2.0), crossed_wedges(0.25));
    let resolution = judged(wedges.clone(), BodyKind::Rigid, 0.17);
    let Remaining { depth, obstacle, .. } = resolution.remaining[0];
    assert!(!resolution.resolved && depth.lower <= exact && exact <= depth.upper, "{depth:?}");
    assert_eq!(obstacle, Obstacle::BothRigid);
    assert!(resolution.before[0].max_vertex_depth <= 0.0, "no vertex is inside");
    assert!(
        judged(wedges, BodyKind::Rigid, 0.25).resolved,
        "within a tolerance beyond the bracket"
    );
}

/// The deepest vertex is within the tolerance, the ridges between the vertices are not.
#[test]
fn a_shallow_vertex_does_not_hide_a_deep_surface() {
    let [lower, upper] = crossed_wedges(0.25);
    let grain = shapes::cube(0.02).translated(DVec3::X * 4.0);
    let resolution = judged([lower, upper.joined(&grain)], BodyKind::Deformable, 0.1);
    let start = &resolution.rounds[0];
    assert!(start.max_depth > 0.0 && start.max_depth < 0.02, "{start:?}");
    assert!(start.surface_depth.is_some_and(|depth| depth.lower > 0.16), "{start:?}");
    assert!(!resolution.resolved, "{:?}", resolution.remaining);

    // Nothing moves, and in no round do vertices alone decide that it is within the tolerance.
    assert!(resolution.rounds.len() > 1, "{:?}", resolution.rounds);
    for round in &resolution.rounds[1..] {
        assert!(round.surface_depth.is_some_and(|depth| depth.upper > 0.1), "{round:?}");
    }
}

/// Two bones that cross stay, and no round tries to change that.
#[test]
fn rigid_bodies_that_cross_cost_no_rounds() {
    let mut rounds = Vec::new();
    for crosses in [false, true] {
        let mut scene = planted();
        let [first, second] = crossed_wedges(if crosses { 0.25 } else { -0.25 });
        for (name, mesh) in [("first", first), ("second", second)] {
            let mesh = mesh.translated(DVec3::Z * 500.0);
            scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions).expect("a bone");
        }
        let resolution = resolve(&mut scene);
        assert_eq!(resolution.resolved, !crosses, "{:?}", resolution.remaining);
        rounds.push(resolution.rounds.len());
    }
    assert_eq!(rounds[0], rounds[1]);
}

#[test]
fn bodies_that_coincide_are_not_called_free() {
    let (mut scene, _) = bone_and_muscle(shapes::cube(10.0), shapes::cube(10.0));
    let resolution = resolve(&mut scene);
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::Coincident, "{:?}", resolution.rounds);
    assert!(!resolution.resolved && resolution.after[0].overlaps);
}
