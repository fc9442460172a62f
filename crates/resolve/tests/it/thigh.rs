//! Overlaps planted in a generated thigh are removed, and nothing else is touched.

use fixtures::{shapes, thigh::thigh};
use glam::{DQuat, DVec3};
use resolve::{Obstacle, ResolveError, ResolveParams, Resolver};
use scene::{BodyKind, Scene};
use surface::progress::Progress;

use crate::{PARAMS, max_depth, move_all, resolve, scene_of};

/// Builds the generated thigh, in millimeters.
pub(crate) fn planted() -> Scene {
    scene_of(thigh().bodies.into_iter().map(|body| {
        let kind = if body.kind == "rigid" { BodyKind::Rigid } else { BodyKind::Deformable };
        (body.name, kind, body.mesh)
    }))
}

#[test]
fn planted_overlaps_are_removed() {
    let mut scene = planted();
    let before = scene.bodies().iter().map(|body| body.positions().to_vec()).collect::<Vec<_>>();
    let resolution = resolve(&mut scene);
    assert!(resolution.before.iter().filter(|pair| pair.overlaps).count() >= 5);
    assert!(resolution.resolved, "{:?}", resolution.remaining);

    let left = max_depth(&mut scene);
    assert!(left <= PARAMS.tolerance, "{left}");
    for ((body, change), before) in scene.bodies().iter().zip(&resolution.bodies).zip(&before) {
        let moved = body.positions().iter().zip(before).filter(|(x, y)| x != y).count();
        assert_eq!(moved, change.moved, "{}", body.name());
        assert_eq!(change.flipped_faces, 0, "{}", body.name());
        assert_eq!(change.self_crossings, [0, 0], "{}", body.name());
        let ratio = change.volume_ratio.expect("closed bodies");
        assert!((ratio - 1.0).abs() < 0.01, "{}: volume times {ratio}", body.name());
        if body.kind() == BodyKind::Rigid {
            assert_eq!(moved, 0, "{} is rigid", body.name());
        }
    }
}

#[test]
fn a_run_that_stops_at_any_round_has_no_new_overlap_and_is_within_limits() {
    for max_rounds in 0..5 {
        let mut scene = planted();
        let params = ResolveParams { max_rounds, ..PARAMS };
        let resolution = resolve::resolve(&mut scene, &params, Progress::none());
        let resolution = resolution.expect("a resolution");
        assert!(resolution.rounds.len() <= 1 + max_rounds as usize);
        for remaining in &resolution.remaining {
            assert!(remaining.at_first, "after {max_rounds} rounds: {remaining:?}");
        }
        for change in &resolution.bodies {
            assert_eq!((change.flipped_faces, change.self_crossings), (0, [0, 0]));
            assert!((change.volume_ratio.expect("closed") - 1.0).abs() <= 0.01);
        }
    }
}

#[test]
fn vertices_far_from_all_overlaps_keep_their_bits() {
    let mut scene = planted();
    let far: Vec<(usize, usize, DVec3)> = scene
        .bodies()
        .iter()
        .enumerate()
        .flat_map(|(b, body)| body.positions().iter().enumerate().map(move |(v, &x)| (b, v, x)))
        .filter(|(_, _, x)| x.z.abs() > 80.0)
        .collect();
    assert!(far.len() > 500, "{} vertices far from all overlaps", far.len());
    let resolution = resolve(&mut scene);
    assert!(resolution.bodies.iter().any(|change| change.moved > 0));
    for (b, v, x) in far {
        assert_eq!(
            scene.bodies()[b].positions()[v].to_array().map(f64::to_bits),
            x.to_array().map(f64::to_bits)
        );
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut scene = planted();
            resolve(&mut scene);
            scene.particle_positions()
        })
    };
    let one = run(1);
    for threads in [2, 7] {
        let other = run(threads);
        let same = one
            .iter()
            .zip(&other)
            .all(|(p, q)| p.to_array().map(f64::to_bits) == q.to_array().map(f64::to_bits));
        assert!(same, "{threads} threads");
    }
}

#[test]
fn the_length_unit_changes_no_bit() {
    // By a power of two nothing is rounded otherwise, so that all must be the same to the bit.
    let scale = 1.0 / 1024.0;
    let ResolveParams { tolerance, gap, smoothing, .. } = PARAMS;
    let scaled = ResolveParams {
        tolerance: scale * tolerance,
        gap: scale * gap,
        smoothing: scale * smoothing,
        ..PARAMS
    };
    let (mut one, mut other) = (planted(), planted());
    move_all(&mut other, |_, x| scale * x);
    let rounds = resolve(&mut one).rounds.len();
    assert!(rounds > 3, "{rounds} rounds");
    let resolution = resolve::resolve(&mut other, &scaled, Progress::none());
    assert_eq!(resolution.expect("a resolution").rounds.len(), rounds);
    for (p, q) in one.particle_positions().into_iter().zip(other.particle_positions()) {
        assert_eq!(scale * p, q);
    }
}

#[test]
fn overlaps_of_rigid_bodies_remain_and_are_named() {
    let cube = shapes::cube(10.0);
    let other = cube.clone().translated(DVec3::new(9.0, 0.5, 0.25));
    let mut scene = scene_of([("a", BodyKind::Rigid, cube), ("b", BodyKind::Rigid, other)]);
    let before = scene.particle_positions();
    let resolution = resolve(&mut scene);
    assert!(!resolution.resolved);
    assert_eq!(resolution.remaining[0].obstacle, Obstacle::BothRigid);
    assert_eq!(scene.particle_positions(), before);
}

#[test]
fn parameters_out_of_range_are_named() {
    let mut scene = planted();
    for (expected, params) in [
        ("tolerance", ResolveParams { tolerance: 0.0, ..PARAMS }),
        ("smoothing", ResolveParams { smoothing: -1.0, ..PARAMS }),
        ("gap", ResolveParams { gap: f64::NAN, ..PARAMS }),
    ] {
        let refused = resolve::resolve(&mut scene, &params, Progress::none());
        let Err(ResolveError::Parameter(error)) = refused else { panic!("{refused:?}") };
        assert_eq!(error.name, expected);
    }
}

/// The planted scene with all bodies turned about an axis aslant.
fn turned(angle: f64) -> Scene {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), angle);
    let mut scene = planted();
    move_all(&mut scene, |_, x| turn * x);
    scene
}

#[test]
fn warm_starts_turn_with_each_vertex() {
    let mut resolver = Resolver::new(PARAMS).expect("a resolver");
    let first = resolver.resolve(&mut planted(), Progress::none()).expect("a resolution");
    let (mut scene, mut same) = (turned(1.2), turned(1.2));
    let next = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert!(first.resolved && next.resolved, "{:?}", next.remaining);
    // The state as it stands, then displaced as before: a fiftieth of each push is left.
    let [stands, displaced, ..] = next.rounds[..] else { panic!("{:?}", next.rounds) };
    assert!(displaced.max_depth < 0.1 * stands.max_depth, "{:?}", next.rounds);
    let cold = resolve(&mut same);
    assert!((stands.max_depth / cold.rounds[0].max_depth - 1.0).abs() < 1e-9);
    let [_, pushed, ..] = cold.rounds[..] else { panic!("{:?}", cold.rounds) };
    assert!(displaced.max_depth < 0.5 * pushed.max_depth, "{:?}, {:?}", next.rounds, cold.rounds);
}

#[test]
fn displacements_that_are_needed_no_more_fade() {
    let mut resolver = Resolver::new(PARAMS).expect("a resolver");
    resolver.resolve(&mut planted(), Progress::none()).expect("a resolution");
    let mut scene = planted();
    let shift = |number: usize| f64::from(u32::try_from(number).unwrap()) * 500.0 * DVec3::X;
    move_all(&mut scene, |id, x| x + shift(id.index()));
    let before = scene.particle_positions();
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert!(resolution.resolved && resolution.rounds.len() == 1);
    assert_eq!(scene.particle_positions(), before, "nothing is pushed where nothing overlaps");
}

#[test]
fn displacements_of_another_scene_are_not_carried_over() {
    let mut resolver = Resolver::new(PARAMS).expect("a resolver");
    resolver.resolve(&mut planted(), Progress::none()).expect("a resolution");
    let cubes = || {
        let muscle = shapes::cube(10.0).translated(DVec3::new(9.0, 0.5, 0.25));
        let bone = shapes::cube(10.0);
        scene_of([("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)])
    };
    let (mut carried, mut fresh) = (cubes(), cubes());
    let with = resolver.resolve(&mut carried, Progress::none()).expect("a resolution");
    assert_eq!(with, resolve(&mut fresh));
}
