//! Pairs that no push takes apart, beside others that come free.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::{Obstacle, Resolution, ResolveParams, resolve};
use scene::{BodyKind, PairId, Scene};
use surface::progress::Progress;

use crate::{PARAMS, scene_of};

/// Builds a muscle that is 1 deep in a bone, beside other bodies.
fn beside<const N: usize>(others: [(&str, BodyKind, Mesh); N]) -> Scene {
    let bone = shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]).translated(DVec3::Z * -4.0);
    let muscle = shapes::ellipsoid(DVec3::new(10.0, 10.0, 6.0), 3).translated(DVec3::Z * 5.0);
    let mut bodies =
        vec![("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)];
    bodies.extend(others);
    let mut scene = Scene::new();
    for (name, kind, mesh) in bodies {
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
    }
    scene
}

/// Resolves a scene; returns the pairs that are left, by name, with their obstacles.
fn left(scene: &mut Scene, params: &ResolveParams) -> (Resolution, Vec<([String; 2], Obstacle)>) {
    let resolution = resolve(scene, params, Progress::none()).expect("a resolution");
    let names = |pair: PairId| pair.bodies().map(|id| scene.body(id).name().to_owned());
    let left = resolution.remaining.iter().map(|left| (names(left.pair), left.obstacle)).collect();
    (resolution, left)
}

fn pair(a: &str, b: &str) -> [String; 2] {
    [a, b].map(str::to_owned)
}

/// Another muscle far to the side, and a copy of it beside itself.
fn twice(offset: f64) -> [(&'static str, BodyKind, Mesh); 2] {
    let muscle = shapes::ellipsoid(DVec3::new(8.0, 8.0, 5.0), 3).translated(60.0 * DVec3::X);
    let copy = muscle.clone().translated(offset * DVec3::new(0.6, 0.64, 0.48));
    [("one", BodyKind::Deformable, muscle), ("copy", BodyKind::Deformable, copy)]
}

#[test]
fn a_muscle_that_is_there_twice_is_not_resolved_without_a_gap() {
    let [one, copy] = twice(1e-3);
    let (resolution, left) = left(&mut scene_of([one, copy]), &PARAMS);
    assert_eq!(left, [(pair("one", "copy"), Obstacle::NearlyCoincident)]);
    assert!(resolution.remaining[0].depth.upper <= PARAMS.tolerance, "shallow, but all of both");
    assert!(!resolution.resolved);
}

#[test]
fn a_muscle_that_is_there_twice_holds_up_no_other() {
    for gap in [0.0, 0.05] {
        let (resolution, left) = left(&mut beside(twice(1e-3)), &ResolveParams { gap, ..PARAMS });
        assert_eq!(left, [(pair("one", "copy"), Obstacle::NearlyCoincident)], "{gap}");
        let short = resolution.gap.short.iter().map(|short| short.pair);
        let known: Vec<PairId> = resolution.remaining.iter().map(|left| left.pair).collect();
        assert_eq!(short.collect::<Vec<_>>(), if gap > 0.0 { known } else { Vec::new() });
        assert!(!resolution.resolved);
    }
}

/// Copies of a muscle that is 1 deep in a bone have a side to be pushed to, but too far.
#[test]
fn a_muscle_that_is_there_twice_comes_free_of_bone_where_its_copies_do_not() {
    let tall = ([8.0, 8.0, 30.0], DVec3::X);
    let long = ([30.0, 8.0, 8.0], 0.5 * DVec3::Z);
    for ((radii, offset), has_others, obstacle) in [
        (tall, false, Obstacle::Limits),
        (tall, true, Obstacle::Limits),
        (long, false, Obstacle::Stuck),
        (long, true, Obstacle::Limits),
    ] {
        let bone = shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]).translated(DVec3::Z * -4.0);
        let muscle = shapes::ellipsoid(DVec3::from(radii), 2);
        let muscle = muscle.translated((radii[2] - 1.0) * DVec3::Z);
        let copy = muscle.clone().translated(offset);
        let mut bodies = vec![
            ("bone", BodyKind::Rigid, bone),
            ("one", BodyKind::Deformable, muscle),
            ("copy", BodyKind::Deformable, copy),
        ];

        // Two muscles aside that overlap each other come free as well.
        for (name, y) in [("near", -30.0), ("other", -43.0)].into_iter().filter(|_| has_others) {
            let aside = shapes::ellipsoid(DVec3::new(8.0, 7.0, 5.0), 2);
            let aside = aside.translated(DVec3::new(0.0, y, 20.0));
            bodies.push((name, BodyKind::Deformable, aside));
        }
        let mut scene = scene_of(bodies);
        let (resolution, left) = left(&mut scene, &PARAMS);
        assert_eq!(left, [(pair("one", "copy"), obstacle)], "{radii:?}");
        let breaks = !resolution.broken_limits.is_empty();
        assert_eq!((resolution.resolved, breaks), (false, obstacle == Obstacle::Limits));
        assert!(resolution.bodies[1].max_displacement > 0.5, "{radii:?}");
    }
}

#[test]
fn a_skin_around_all_bodies_holds_up_none_of_them() {
    let plate = shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]).translated(DVec3::Z * -4.0);
    let skin = shapes::ellipsoid(DVec3::new(40.0, 36.0, 32.0), 2).translated(DVec3::Z * 3.0);
    let muscle = |x: f64| {
        let mesh = shapes::ellipsoid(DVec3::new(8.0, 8.0, 5.0), 2);
        mesh.translated(DVec3::new(x, 0.0, 4.0))
    };
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, plate),
        ("first", BodyKind::Deformable, muscle(-13.0)),
        ("second", BodyKind::Deformable, muscle(1.0)),
        ("third", BodyKind::Deformable, muscle(15.0)),
        ("skin", BodyKind::Deformable, skin),
    ]);
    let params = ResolveParams { max_rounds: 12, ..PARAMS };
    let (resolution, mut left) = left(&mut scene, &params);
    left.sort_by(|p, q| p.0.cmp(&q.0));
    let names = ["bone", "first", "second", "third"];
    assert_eq!(left, names.map(|name| (pair(name, "skin"), Obstacle::Enclosed)));
    assert!(!resolution.resolved && resolution.bodies[1].max_displacement > 0.5);
}

/// A muscle lies where two bones meet, and rounds press it out between its neighbors, which overlap the bones, too;
/// another muscle is in a bone far from them.
#[test]
fn a_muscle_without_room_that_is_pressed_into_others_holds_up_none() {
    let plate = || shapes::plate(DVec3::new(16.0, 16.0, 10.0), [4, 4]);
    let muscle = |radii| shapes::ellipsoid(DVec3::from(radii), 2);
    let neighbor = |side: f64| muscle([7.0, 7.0, 9.0]).translated(14.5 * side * DVec3::X);
    let far = 60.0 * DVec3::X;
    let mut scene = scene_of([
        ("lower", BodyKind::Rigid, plate().translated(-5.01 * DVec3::Z)),
        ("upper", BodyKind::Rigid, plate().translated(5.01 * DVec3::Z)),
        ("squeezed", BodyKind::Deformable, muscle([7.0, 7.0, 4.0])),
        ("right", BodyKind::Deformable, neighbor(1.0)),
        ("left", BodyKind::Deformable, neighbor(-1.0)),
        ("far bone", BodyKind::Rigid, plate().translated(far - 9.0 * DVec3::Z)),
        ("far muscle", BodyKind::Deformable, muscle([8.0, 8.0, 5.0]).translated(far)),
    ]);
    let (resolution, mut left) = left(&mut scene, &PARAMS);
    left.sort_by(|p, q| p.0.cmp(&q.0));
    assert_eq!(left.len(), 2, "{left:?}");
    for ((names, obstacle), bone) in left.iter().zip(["lower", "upper"]) {
        assert_eq!(*names, pair(bone, "squeezed"));
        assert!(matches!(obstacle, Obstacle::Squeezed { room, .. } if *room < 0.1), "{obstacle:?}");
    }
    assert!(!resolution.resolved && resolution.bodies[6].max_displacement > 0.9);
    for left in &resolution.remaining {
        let before = resolution.before.iter().find(|before| before.pair == left.pair);
        let depth = before.and_then(|before| before.max_depth()).expect("overlaps at the start");
        assert!(left.depth.lower <= depth.upper, "{left:?} was {depth:?} deep");
    }
}
