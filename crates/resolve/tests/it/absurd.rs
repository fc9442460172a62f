//! Scenes that have no solution, each answered with the reason.

use fixtures::{Mesh, damage, shapes};
use glam::DVec3;
use resolve::{
    Conditions, FixedVertices, GapObstacle, Obstacle, Resolution, ResolveError, ResolveParams,
    Resolver, Tie,
};
use scene::{BodyKind, PairId, Scene, SceneError};
use surface::progress::Progress;

use crate::{PARAMS, resolve, scene_of};

const WITH_GAP: ResolveParams = ResolveParams { gap: 0.05, max_rounds: 12, ..PARAMS };

/// Resolves a scene; checks that all bodies stay within their limits, whatever comes of it.
fn resolve_within_limits(scene: &mut Scene) -> Resolution {
    let resolution = resolve::resolve(scene, &WITH_GAP, Progress::none()).expect("a resolution");
    // Rounds for the gap give back volume, too, after which a round may be accepted that was not.
    let mut is_accepted = resolution.rounds[resolution.final_round].is_accepted;
    is_accepted |= resolution.gap_rounds.iter().any(|round| round.is_accepted);
    assert!(is_accepted, "{:?} {:?}", resolution.rounds, resolution.gap_rounds);
    for change in &resolution.bodies {
        assert_eq!((change.flipped_faces, change.self_crossings[1]), (0, 0), "{:?}", change.body);
        let volume = change.volume_ratio.map_or(0.0, |ratio| (ratio - 1.0).abs());
        assert!(volume <= WITH_GAP.max_volume_change, "volume by {volume}");
    }
    resolution
}

#[test]
fn a_scene_without_bodies_is_resolved() {
    for params in [PARAMS, WITH_GAP] {
        let resolution = resolve::resolve(&mut Scene::new(), &params, Progress::none());
        assert!(resolution.expect("a resolution").resolved);
    }
}

#[test]
fn a_body_is_not_tied_to_itself() {
    let mesh = shapes::icosphere(10.0, 2);
    let mut scene = scene_of([("muscle", BodyKind::Deformable, mesh)]);
    let muscle = scene.ids().next().expect("a body");
    let conditions = Conditions {
        ties: vec![Tie { bodies: [muscle; 2], distance: 1.0 }],
        ..Conditions::default()
    };
    let mut resolver = Resolver::new(WITH_GAP).expect("parameters").with_conditions(conditions);
    let refused = resolver.resolve(&mut scene, Progress::none()).expect_err("a refusal");
    assert_eq!(refused, ResolveError::Scene(SceneError::Itself { name: "muscle".into() }));
}

#[test]
fn a_bone_wholly_inside_another_is_named() {
    let bodies = [
        ("outer", BodyKind::Rigid, shapes::icosphere(10.0, 2)),
        ("inner", BodyKind::Rigid, shapes::icosphere(3.0, 2)),
    ];
    let resolution = resolve_within_limits(&mut scene_of(bodies));
    assert!(!resolution.resolved);
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::BothRigid);
}

#[test]
fn a_muscle_wholly_inside_a_bone_is_named() {
    let bodies = [
        ("bone", BodyKind::Rigid, shapes::icosphere(40.0, 3)),
        ("muscle", BodyKind::Deformable, shapes::icosphere(6.0, 2)),
    ];
    let resolution = resolve_within_limits(&mut scene_of(bodies));
    assert!(!resolution.resolved);
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::Enclosed, "{:?}", resolution.rounds);
}

#[test]
fn a_closed_shell_without_room_is_named() {
    let [outer, inner] = [12.0, 10.03].map(|radius| shapes::icosphere(radius, 3));
    let bodies = [
        ("shell", BodyKind::Rigid, outer.joined(&inner.flipped())),
        ("muscle", BodyKind::Deformable, shapes::icosphere(10.0, 3)),
    ];
    // It cannot become smaller, and keeps its volume: it is named, and not damaged.
    let resolution = resolve_within_limits(&mut scene_of(bodies));
    assert!(!resolution.resolved && resolution.remaining.is_empty());
    assert!(resolution.gap.short[0].distance.lower > 0.0, "{:?}", resolution.gap);
}

#[test]
fn identical_bodies_coincide() {
    let ball = shapes::icosphere(10.0, 2);
    let bodies = [("a", BodyKind::Deformable, ball.clone()), ("b", BodyKind::Deformable, ball)];
    let resolution = resolve_within_limits(&mut scene_of(bodies));
    assert!(!resolution.resolved);
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::Coincident, "{:?}", resolution.rounds);
}

#[test]
fn bodies_that_nearly_coincide_are_named() {
    let ball = shapes::icosphere(10.0, 2);
    let other = ball.clone().rotated(DVec3::new(0.3, 1.0, 0.2), 1e-3);
    let bodies = [("a", BodyKind::Deformable, ball), ("b", BodyKind::Deformable, other)];
    let resolution = resolve_within_limits(&mut scene_of(bodies));
    assert!(!resolution.resolved);
    let obstacle = resolution.remaining[0].obstacle;
    assert_eq!(obstacle, Obstacle::NearlyCoincident, "{:?}", resolution.rounds);
}

#[test]
fn a_sheet_pierced_by_a_bone_is_named() {
    let sheet = shapes::plate(DVec3::new(40.0, 40.0, 0.5), [8, 8]);
    let bodies = [
        ("bone", BodyKind::Rigid, shapes::capsule(4.0, 60.0, 16)),
        ("sheet", BodyKind::Open, sheet),
    ];
    let resolution = resolve_within_limits(&mut scene_of(bodies));
    assert!(!resolution.resolved);
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::Pierced, "{:?}", resolution.rounds);
}

#[test]
fn a_squeeze_without_room_is_named_with_its_numbers() {
    let bone = shapes::plate(DVec3::new(60.0, 60.0, 6.0), [12, 12]);
    let up = DVec3::Z * 3.5;
    let mut scene = scene_of([
        ("below", BodyKind::Rigid, bone.clone().translated(-up)),
        ("above", BodyKind::Rigid, bone.translated(up)),
        ("muscle", BodyKind::Deformable, shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3)),
    ]);
    let resolution = resolve_within_limits(&mut scene);
    assert!(!resolution.resolved && !resolution.broken_limits.is_empty());
    let Obstacle::Squeezed { room, thickness } = resolution.remaining[0].obstacle else {
        panic!("{:?}", resolution.remaining)
    };
    assert!((room - 1.0).abs() < 0.05 && (thickness - 4.0).abs() < 0.05, "{room} {thickness}");
    let squeezed = resolution.gap.short.iter().find_map(|short| match short.obstacle {
        GapObstacle::Squeezed { room, thickness, gap } => Some([room, thickness, gap]),
        _ => None,
    });
    let [room, thickness, gap] = squeezed.expect("between two bones");
    assert!((room - 1.0).abs() < 0.05 && gap > 0.0, "{room}");
    assert!(thickness > 1.0 && thickness <= 4.0, "{thickness}");
}

/// A block of eight corners, whose normals lead along its diagonals: it is 4 thick.
#[test]
fn a_block_that_is_held_in_a_bone_is_not_squeezed_where_it_fits() {
    let bone = shapes::plate(DVec3::new(20.0, 20.0, 2.0), [6, 6]);
    for (room, is_squeezed) in [(6.0, false), (4.1, true)] {
        let mut scene = scene_of([
            ("below", BodyKind::Rigid, bone.clone().translated(-DVec3::Z)),
            ("muscle", BodyKind::Deformable, shapes::cube(4.0).translated(1.5 * DVec3::Z)),
            ("above", BodyKind::Rigid, bone.clone().translated((room + 1.0) * DVec3::Z)),
        ]);
        let muscle = scene.find("muscle").expect("a body");
        let fixed = vec![FixedVertices { body: muscle, vertices: (0..8).collect() }];
        let conditions = Conditions { fixed, ..Conditions::default() };
        let mut resolver = Resolver::new(ResolveParams { gap: 0.1, ..WITH_GAP })
            .expect("parameters")
            .with_conditions(conditions);
        let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
        let [short] = resolution.gap.short[..] else { panic!("{:?}", resolution.gap) };
        match short.obstacle {
            GapObstacle::Squeezed { room: found, thickness, gap } => {
                let numbers = DVec3::new(found, thickness, gap);
                assert!((numbers - DVec3::new(room, 4.0, 0.1)).length() < 1e-9, "{numbers}");
                assert!(is_squeezed, "{numbers}");
            }
            obstacle => assert!(!is_squeezed, "{obstacle}"),
        }
    }
}

/// The two layers of a closed sheet without thickness: what its volume becomes is no multiple of what it was.
#[test]
fn a_sheet_of_two_layers_has_no_volume_to_keep() {
    for turns in [0.0, 0.17] {
        let turned = |mesh: Mesh| mesh.rotated(DVec3::new(1.0, 2.0, -3.0).normalize(), turns);
        let sheet = shapes::plate(DVec3::new(12.0, 12.0, 0.0), [6, 6]);
        let bone = shapes::icosphere(5.0, 2).translated(-4.8 * DVec3::Z);
        let mut scene = scene_of([
            ("bone", BodyKind::Rigid, turned(bone)),
            ("sheet", BodyKind::Deformable, turned(sheet)),
        ]);
        let resolution = resolve_within_limits(&mut scene);
        assert_eq!(resolution.bodies[1].volume_ratio, None, "turned by {turns}");
        assert!(resolution.broken_limits.iter().all(|broken| broken.volume_change == 0.0));
    }
}

#[test]
fn no_state_is_kept_in_which_faces_are_deeper_than_at_the_start() {
    // Faces as long as the muscle is thick: corners come out to a third of their depth, and what is between goes in.
    let slab = |height: f64| {
        shapes::plate(DVec3::new(12.0, 12.0, 2.0), [6; 2]).translated(height * DVec3::Z)
    };
    let mut scene = scene_of([
        ("below", BodyKind::Rigid, slab(-1.08)),
        ("muscle", BodyKind::Deformable, slab(0.0)),
        ("above", BodyKind::Rigid, slab(1.08)),
    ]);
    let ids: Vec<_> = scene.ids().collect();
    let tie = Tie { bodies: [ids[0], ids[1]], distance: 1.5 };
    let conditions = Conditions { ties: vec![tie], ..Conditions::default() };
    let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(3.464) };
    let mut resolver = Resolver::new(params).expect("parameters").with_conditions(conditions);
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");

    let [start, round] = [0, 1].map(|round| resolution.rounds[round].max_depth);
    assert!(round < 0.5 * start && resolution.gap_rounds.iter().any(|round| round.is_accepted));
    assert_eq!((resolution.resolved, resolution.final_round), (false, 0));
    assert!(resolution.bodies.iter().all(|change| change.max_displacement == 0.0));
    for overlap in resolution.after.iter().filter(|report| report.overlaps) {
        let depth = overlap.max_depth().expect("closed bodies");
        assert!((depth.lower - 0.92).abs() < 1e-9 && depth.upper < 0.93, "{depth:?}");
    }
}

/// A skin that is open at one end holds a muscle that overlaps a bone: nothing shows that the skin is no solid, and
/// nothing is pushed out of it.
#[test]
fn what_a_surface_with_holes_surrounds_stays_in_it() {
    let skin = damage::hole(shapes::icosphere(30.0, 3), 30.0 * DVec3::X, 10.0);
    let muscle = shapes::icosphere(5.0, 3).translated(9.0 * DVec3::X);
    let mut scene = scene_of([
        ("skin", BodyKind::Deformable, skin.clone()),
        ("bone", BodyKind::Rigid, shapes::icosphere(5.0, 3)),
        ("muscle", BodyKind::Deformable, muscle),
    ]);
    let [skin_id, bone, muscle] =
        ["skin", "bone", "muscle"].map(|name| scene.find(name).expect("a body"));
    let end = resolve(&mut scene);
    assert!(!end.resolved, "the skin has both in it");
    assert_eq!(scene.body(skin_id).positions(), &skin.positions[..], "it stays");
    let change = end.bodies[muscle.index()].max_displacement;
    assert!(change > 0.5 && change < 2.0, "{change}: off the bone, not out of the skin");
    let left = |pair: PairId| end.remaining.iter().find(|left| left.pair == pair);
    assert!(left(PairId::new(bone, muscle)).is_none_or(|left| left.depth.lower < 0.06));
    for body in [bone, muscle] {
        let obstacle = left(PairId::new(skin_id, body)).map(|left| left.obstacle);
        assert_eq!(obstacle, Some(Obstacle::Enclosed), "{body:?}");
    }
}
