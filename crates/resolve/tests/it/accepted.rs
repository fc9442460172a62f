//! Accepted rounds: what is left falls from each to the next, bodies keep their limits in all, and
//! nothing crosses anew wherever a run stops.

use fixtures::shapes;
use glam::DVec3;
use resolve::{BodyStiffness, Conditions, Obstacle, Resolution, ResolveParams, Resolver};
use scene::{BodyKind, CheckParams, Scene};
use surface::progress::Progress;

use crate::{PARAMS, scene_of};

/// Builds a muscle half inside a bone, with another muscle `between` behind it and a bone behind both,
/// which leave `room` more than the muscles are thick.
fn stacked(between: f64, room: f64) -> Scene {
    let plate = || shapes::plate(DVec3::new(24.0, 24.0, 10.0), [6, 6]);
    let muscle = shapes::ellipsoid(DVec3::new(8.0, 8.0, 3.0), 2);
    let up = |height: f64| DVec3::Z * height;
    scene_of([
        ("below", BodyKind::Rigid, plate().translated(up(-5.0))),
        ("lower", BodyKind::Deformable, muscle.clone()),
        (
            "upper",
            BodyKind::Deformable,
            muscle.rotated(DVec3::Z, 0.1).translated(up(6.0 + between)),
        ),
        ("above", BodyKind::Rigid, plate().translated(up(17.0 + room))),
    ])
}

fn resolve(scene: &mut Scene, params: &ResolveParams) -> Resolution {
    resolve::resolve(scene, params, Progress::none()).expect("a resolution")
}

/// Checks the accepted rounds of both kinds, and that the last one of each is taken.
fn assert_accepted(resolution: &Resolution) {
    let rounds = (0..).zip(&resolution.rounds).filter(|(_, round)| round.is_accepted);
    let (mut last, mut merit) = (0, f64::INFINITY);
    for (number, round) in rounds {
        assert!(round.merit < merit, "{} after {merit}, in round {number}", round.merit);
        assert_eq!((round.new_pairs, round.flipped_faces), (0, 0), "in round {number}");
        assert!(round.volume_change <= PARAMS.max_volume_change, "in round {number}");
        (last, merit) = (number, round.merit);
    }
    assert_eq!(resolution.final_round, last, "the last accepted round");

    let mut merit = f64::INFINITY;
    for round in resolution.gap_rounds.iter().filter(|round| round.is_accepted) {
        assert!(round.merit < merit, "{} after {merit}", round.merit);
        merit = round.merit;
    }
    for change in &resolution.bodies {
        let volume = change.volume_ratio.map_or(0.0, |ratio| (ratio - 1.0).abs());
        assert!(volume <= PARAMS.max_volume_change, "volume by {volume}");
        assert!(change.strain <= PARAMS.max_strain, "strained by {}", change.strain);
        assert_eq!((change.flipped_faces, change.self_crossings[1]), (0, 0), "{:?}", change.body);
    }
}

#[test]
fn what_is_left_falls_from_each_accepted_round_to_the_next() {
    let mut worse = 0;
    for (room, gap) in [(-3.0, 0.0), (0.3, 0.0), (-3.0, 0.05), (0.3, 0.05)] {
        let params = ResolveParams { gap, max_rounds: 12, ..PARAMS };
        let resolution = resolve(&mut stacked(1.1, room), &params);
        assert_accepted(&resolution);
        worse += resolution.rounds.iter().filter(|round| !round.is_accepted).count();
    }
    assert!(worse > 0, "some rounds are no better, and are not taken");
}

#[test]
fn wherever_a_run_stops_nothing_crosses_anew() {
    let (mut new_pairs, mut gap_rounds) = (0, 0);
    for (max_rounds, gap) in [0, 1, 2, 3, 4, 5].into_iter().flat_map(|n| [(n, 0.0), (n, 0.05)]) {
        let mut scene = stacked(1.1, 0.3);
        let params = ResolveParams { max_rounds, gap, ..PARAMS };
        let resolution = resolve(&mut scene, &params);
        assert_accepted(&resolution);
        new_pairs += resolution.rounds.iter().map(|round| round.new_pairs).sum::<usize>();
        gap_rounds += resolution.gap_rounds.len();
        let after =
            scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
        for pair in after.iter().filter(|pair| pair.overlaps) {
            let before = resolution.before.iter().find(|before| before.pair == pair.pair);
            let was_there = before.is_some_and(|before| before.overlaps);
            assert!(was_there, "{max_rounds} rounds, gap {gap}: {:?}", pair.pair);
        }
    }
    assert!(new_pairs > 0 && gap_rounds > 6, "some rounds cross anew, and are not taken");
}

#[test]
fn a_state_that_strains_a_body_more_than_its_limit_is_not_taken() {
    let needle = || {
        let spike = shapes::ellipsoid(DVec3::new(0.8, 0.8, 9.0), 2);
        let muscle = shapes::icosphere(14.0, 3).translated(DVec3::Z * 20.0);
        scene_of([("spike", BodyKind::Rigid, spike), ("muscle", BodyKind::Deformable, muscle)])
    };
    let free = resolve(&mut needle(), &PARAMS);
    let strain = free.bodies[1].strain;
    assert!(free.resolved && strain > 0.1, "{strain}, {:?}", free.remaining);

    let params = ResolveParams { max_strain: 0.5 * strain, ..PARAMS };
    let held = resolve(&mut needle(), &params);
    assert!(!held.resolved && held.bodies[1].strain <= params.max_strain);
    let [broken] = held.broken_limits[..] else { panic!("{:?}", held.broken_limits) };
    assert!(broken.strain > params.max_strain && broken.flipped_faces == 0, "{broken:?}");
    assert!(broken.volume_change <= params.max_volume_change, "{broken:?}");
}

/// Builds a muscle that is pierced by a spike, and far from it one that is pressed on a plate; with a third one
/// above the first, if it is wanted.
fn pierced_and_pressed(has_third: bool) -> Scene {
    let spike = shapes::ellipsoid(DVec3::new(0.8, 0.8, 9.0), 2);
    let muscle = shapes::icosphere(14.0, 2).translated(DVec3::Z * 20.0);
    let far = DVec3::X * 60.0;
    let plate = shapes::plate(DVec3::new(24.0, 24.0, 10.0), [6, 6]);
    let mut bodies = vec![
        ("spike", BodyKind::Rigid, spike),
        ("pierced", BodyKind::Deformable, muscle.clone().translated(DVec3::Z * -3.0)),
        ("plate", BodyKind::Rigid, plate.translated(far)),
        ("pressed", BodyKind::Deformable, muscle.clone().translated(far - DVec3::Z * 4.0)),
    ];
    if has_third {
        bodies.push(("stiff", BodyKind::Deformable, muscle.translated(DVec3::Z * 19.0)));
    }
    scene_of(bodies)
}

#[test]
fn a_body_beyond_its_limits_holds_up_no_other() {
    let mut scene = pierced_and_pressed(false);
    let params = ResolveParams { max_strain: 0.1, ..PARAMS };
    let resolution = resolve(&mut scene, &params);
    let [left] = resolution.remaining[..] else { panic!("{:?}", resolution.remaining) };
    assert_eq!(scene.names(left.pair), ["spike", "pierced"]);
    assert_eq!(left.obstacle, Obstacle::Limits);
    let [broken] = resolution.broken_limits[..] else { panic!("{:?}", resolution.broken_limits) };
    assert!(broken.strain > params.max_strain && !resolution.resolved, "{broken:?}");
    assert!(resolution.bodies[3].max_displacement > 2.0, "{:?}", resolution.bodies[3].body);
}

/// A soft muscle is pierced, and a stiff one that it yields to has its own limits where the soft one is held.
#[test]
fn bodies_that_leave_their_limits_one_after_the_other_hold_up_no_other() {
    let mut scene = pierced_and_pressed(true);
    let pierced = scene.find("pierced").expect("a body");
    let stiffnesses = vec![BodyStiffness { body: pierced, factor: 0.02 }];
    let conditions = Conditions { stiffnesses, ..Conditions::default() };
    let params = ResolveParams { max_strain: 0.1, ..PARAMS };
    let mut resolver = Resolver::new(params).expect("parameters").with_conditions(conditions);
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    let mut names = Vec::new();
    for left in &resolution.remaining {
        assert_eq!(left.obstacle, Obstacle::Limits);
        names.push(scene.names(left.pair));
    }
    assert_eq!(names, [["spike", "pierced"], ["pierced", "stiff"]]);
    assert_eq!(resolution.broken_limits.len(), 2, "{:?}", resolution.broken_limits);
    assert!(!resolution.resolved && resolution.bodies[3].max_displacement > 2.0);
}
