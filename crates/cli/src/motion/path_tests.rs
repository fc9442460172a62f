//! Paths between frames: their ends, and what follows what on the way.

use std::collections::BTreeMap;

use glam::{DVec3, dvec3};
use musculo_collide::surface::TriangleSurface;
use musculo_collide::{BodyKind, Path, Scene};

use super::tests::parsed;

/// A bone and a muscle along z, between a femur that turns by 60 degrees about x and a pelvis that
/// rests. Maps have nine digits.
fn replay() -> (Scene, super::Replay) {
    let text = r#"{
        "skin": {"axis": [0, 0, 1], "segments": ["femur", null], "blends": [[10, 20]]},
        "frames": [
            {"femur": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
            {"femur": [1, 0, 0, 3, 0, 0.5, -0.866025404, 0, 0, 0.866025404, 0.5, 1, 0, 0, 0, 1]},
            {"femur": [1, 0, 0, 3, 0, 0.5, -0.866025404, 0, 0, 0.866025404, 0.5, 1, 0, 0, 0, 1]}
        ]}"#;
    let mut scene = Scene::new();
    for (name, kind) in [("femur", BodyKind::Rigid), ("muscle", BodyKind::Deformable)] {
        let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("a triangle");
        let x = vec![dvec3(1.0, 2.0, 3.0), dvec3(5.0, -300.0, 16.0), dvec3(1.0, 2.0, 30.0)];
        scene.add(name, kind, surface, x).expect("a body");
    }
    let motion = parsed(text).expect("a motion");
    let replay = motion.bind(&scene, &BTreeMap::new()).expect("bodies");
    (scene, replay)
}

#[test]
fn paths_begin_and_end_at_frames() {
    let (_, replay) = replay();
    for frame in 0..2 {
        for body in 0..2 {
            let path = replay.path(body, frame);
            for (time, frame) in [(0.0, frame), (1.0, frame + 1)] {
                for (vertex, &x) in (0_u32..).zip(&replay.positions(frame)[body]) {
                    let distance = path.position(vertex, time).distance(x);
                    assert!(distance < 1e-12, "{distance} at {time} of frame {frame}");
                }
            }
        }
    }
}

/// Half way, the bone has turned by 30 degrees: its points keep their distances, which those of
/// chords do not. Vertices of the muscle below the blend follow it, those above rest.
#[test]
fn bones_turn_on_arcs_and_muscles_follow() {
    let (scene, replay) = replay();
    let [bone, muscle] = [0, 1].map(|body| replay.path(body, 0));
    let rest = scene.bodies()[0].positions();
    let middle: Vec<DVec3> = (0..3).map(|vertex| bone.position(vertex, 0.5)).collect();
    for [i, j] in [[0, 1], [1, 2], [2, 0]] {
        let (before, half_way) = (rest[i].distance(rest[j]), middle[i].distance(middle[j]));
        assert!((before - half_way).abs() < 1e-6, "{before} becomes {half_way}");
    }
    let spoke = (middle[1] - middle[0]).dot(rest[1] - rest[0]) / rest[1].distance_squared(rest[0]);
    assert!((spoke - 30.0_f64.to_radians().cos()).abs() < 1e-3, "a turn by 30 degrees: {spoke}");

    assert!(muscle.position(0, 0.5).distance(middle[0]) < 1e-12, "it follows the bone");
    assert!(muscle.position(2, 0.5).distance(rest[2]) < 1e-12, "it rests");
    let between = muscle.position(1, 0.5);
    assert!(between.distance(middle[1]) > 1.0 && between.distance(rest[1]) > 1.0, "it blends");
    assert!(muscle.bend(1) > 0.0 && muscle.bend(1) < bone.bend(1), "with part of the bend");
    for path in [&bone, &muscle] {
        check_deviation(path);
    }
}

/// Checks that positions stay as near their chord as the bend says.
fn check_deviation(path: &impl Path) {
    for vertex in 0..3 {
        let [start, middle, end] = [0.0, 0.5, 1.0].map(|time| path.position(vertex, time));
        let deviation = middle.distance(start.midpoint(end));
        assert!(deviation <= path.bend(vertex) / 8.0 + 1e-12, "{deviation} of vertex {vertex}");
    }
}

/// A bone says that it moves rigidly, and by how much it does not; a muscle that blends does not.
#[test]
fn bones_are_rigid_within_the_digits_of_their_maps() {
    let (_, replay) = replay();
    let bone = replay.path(0, 0);
    let near = bone.rigid().expect("a bone is rigid");
    assert!(near.deviation > 0.0 && near.deviation < 1e-6, "{}", near.deviation);
    for (vertex, &x) in (0_u32..).zip(&replay.positions(0)[0]) {
        for time in [0.0, 0.5, 1.0] {
            let distance = near.path.transform_point(x, time).distance(bone.position(vertex, time));
            assert!(distance <= near.deviation + 1e-12, "{distance} of {vertex} at {time}");
        }
    }
    assert!(replay.path(1, 0).rigid().is_none(), "a muscle that blends");
}

#[test]
fn what_does_not_move_has_straight_paths() {
    let (_, replay) = replay();
    for body in 0..2 {
        let path = replay.path(body, 1);
        assert!((0..3).all(|vertex| path.bend(vertex) <= 0.0), "body {body} rests");
    }
}
