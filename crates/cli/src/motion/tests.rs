//! Motions computed by hand, and invalid files.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3, dvec3};
use musculo_collide::surface::TriangleSurface;
use musculo_collide::{BodyKind, Scene};

use super::skin::Skin;
use super::{Motion, MotionProblem, RestReason};
use crate::scene::Unit;

/// A map that turns a quarter about x through the origin, then shifts along y.
const QUARTER: &str = "[1,0,0,0, 0,0,-1,5, 0,1,0,0, 0,0,0,1]";
const REST: &str = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

/// Parses a file in millimeters.
pub(super) fn parsed(text: &str) -> Result<Motion, MotionProblem> {
    Motion::parse(text, Unit::Millimeter)
}

fn two_frames(skin: &str) -> String {
    format!(
        "{{{skin} \"frames\": [{{\"t\": 0, \"femur\": {REST}, \"angles\": [1, 2]}}, {{\"femur\": {QUARTER}}}]}}"
    )
}

const SKIN: &str =
    r#""skin": {"axis": [0, 0, 2], "segments": ["femur", null], "blends": [[10, 20]]},"#;

fn scene() -> Scene {
    let mut scene = Scene::new();
    let mut add = |name: &str, kind| {
        let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("a triangle");
        let x = vec![dvec3(1.0, 2.0, 3.0), dvec3(1.0, 2.0, 15.0), dvec3(1.0, 2.0, 30.0)];
        scene.add(name, kind, surface, x).expect("a body");
    };
    add("bone_femur", BodyKind::Rigid);
    add("muscle", BodyKind::Deformable);
    add("bone_pelvis", BodyKind::Rigid);
    scene
}

#[test]
fn bones_follow_their_maps_and_muscles_the_blend() {
    let scene = scene();
    let replay = parsed(&two_frames(SKIN)).unwrap().bind(&scene, &BTreeMap::new()).unwrap();
    let rest = scene.bodies()[0].positions();
    assert_eq!(replay.positions(0), [rest, rest, rest]);
    let [bone, muscle, pelvis] = &replay.positions(1)[..] else { panic!("three bodies") };
    let turned = |x: DVec3| dvec3(x.x, 5.0 - x.z, x.y);
    let expected: Vec<DVec3> = rest.iter().map(|&x| turned(x)).collect();
    assert_eq!(bone, &expected);
    assert_eq!(muscle[0], turned(rest[0]), "below the blend with the bone");
    assert_eq!(muscle[1], (turned(rest[1]) + rest[1]) / 2.0, "half way in the middle of the blend");
    assert_eq!(muscle[2], rest[2], "above the blend at rest");
    assert_eq!(pelvis, rest);
    assert_eq!([replay.time(0), replay.time(1)], [Some(0.0), None]);
}

/// Three segments: shank, thigh, and a pelvis that rests.
#[test]
fn weights_go_over_from_segment_to_segment() {
    let blends = vec![[460.0, 540.0], [850.0, 950.0]];
    let segments = vec![Some("tibia".to_owned()), Some("femur".to_owned()), None];
    let skin = Skin::new(DVec3::Z, segments, blends).unwrap();
    let quarter = parsed(&two_frames("")).unwrap().maps[1]["femur"];
    let maps = [("femur", DMat4::IDENTITY), ("tibia", quarter)];
    let maps = maps.map(|(name, map)| (name.to_owned(), map)).into();
    let at = |z: f64| skin.deform(&[dvec3(0.0, 0.0, z)], &maps)[0];
    assert_eq!(at(460.0), dvec3(0.0, -455.0, 0.0));
    assert_eq!(at(540.0), dvec3(0.0, 0.0, 540.0));
    let t = 60.0_f64 / 80.0;
    let up = t * t * (3.0 - 2.0 * t);
    let expected = up * dvec3(0.0, 0.0, 520.0) + (1.0 - up) * dvec3(0.0, 5.0 - 520.0, 0.0);
    assert!((at(520.0) - expected).length() < 1e-12);
}

#[test]
fn invalid_files_are_refused() {
    let stretched = QUARTER.replace("1,0,0,0, 0", "2,0,0,0, 0");
    let second = |entry: &str| {
        format!("{{\"frames\": [{{\"t\": 1, \"femur\": {REST}}}, {{{entry} \"femur\": {REST}}}]}}")
    };
    let swap = |old: &str, new: &str| two_frames(SKIN).replace(old, new);
    let cases = [
        (r#"{"frames": []}"#.to_owned(), "has 0 frames"),
        ("{".to_owned(), "is not a motion"),
        (r#"{"frames": [1, 2]}"#.to_owned(), "expected a frame with maps by name"),
        (
            r#"{"frames": [], "frames": []}"#.to_owned(),
            "duplicate field `frames` at line 1 column 23",
        ),
        (
            swap(QUARTER, &stretched),
            "map \"femur\" of frame 1 is not rigid: it changes lengths, or its last row",
        ),
        (
            swap(QUARTER, "[1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,0,1]"),
            "map \"femur\" of frame 1 is not rigid: it mirrors (its determinant is -1)",
        ),
        (
            swap("\"femur\": [1,0,0,0, 0,0,-1", "\"other\": [1,0,0,0, 0,0,-1"),
            "frame 0 has no map \"other\", which other frames have",
        ),
        (
            swap(QUARTER, "[1,0,0,0, 0,1,0,0, 0,0,1,0]"),
            "\"femur\" of frame 1 is a list of 12 numbers, but a map is a list of 16 numbers",
        ),
        (swap(QUARTER, "\"up\""), "\"femur\" of frame 1 is text, but a map is a list of 16"),
        (second("\"femur\": 1,"), "frame 1 has more than one entry \"femur\""),
        (second("\"t\": 2, \"t\": 3,"), "frame 1 has more than one entry \"t\""),
        (second("\"t\": \"late\","), "\"t\" of frame 1 is \"late\", but a time is a number"),
        (second("\"t\": null,"), "\"t\" of frame 1 is null, but a time is a number"),
        (second("\"t\": 1,"), "\"t\" of frame 1 is 1, but times must rise: that of frame 0 is 1"),
        (
            second("\"t\": 0.5,"),
            "\"t\" of frame 1 is 0.5, but times must rise: that of frame 0 is 1",
        ),
        (swap("[\"femur\", null]", "[\"tibia\", null]"), "follows \"tibia\""),
        (swap("[\"femur\", null]", "[null]"), "1 segments and 1 blends"),
        (swap("[10, 20]", "[20, 10]"), "blend 0 of the skin runs from 20 to 10"),
        (swap("[0, 0, 2]", "[0, 0, 0]"), "no direction"),
        (
            two_frames("\"ignore\": [\"femr\"],"),
            "the list \"ignore\" has \"femr\", but the frames have no such map",
        ),
    ];
    for (text, expected) in cases {
        let problem = parsed(&text).unwrap_err().to_string();
        assert!(problem.contains(expected), "{problem:?} for {text}");
    }
}

/// A map that moves nothing is refused while a rigid body rests, with the nearest names.
#[test]
fn misspelled_maps_are_refused() {
    let renamed = |list: &str| {
        let text = two_frames(&format!("{list}{SKIN}"));
        let extra = |map: &str| format!("\"femur\": {map}, \"pelwis\": {map}");
        [REST, QUARTER]
            .into_iter()
            .fold(text, |text, map| text.replace(&format!("\"femur\": {map}"), &extra(map)))
    };
    let problem = parsed(&renamed("")).unwrap().bind(&scene(), &BTreeMap::new()).unwrap_err();
    let expected = "map \"pelwis\" moves no body: the nearest names of bodies without a map are \
                    bone_pelvis; rename the map, let a body follow it (--follow), \
                    or add it to the list \"ignore\"";
    assert_eq!(problem.to_string(), expected);

    // It is accepted where the file says that it is meant.
    let replay =
        parsed(&renamed("\"ignore\": [\"pelwis\"],")).unwrap().bind(&scene(), &BTreeMap::new());
    assert_eq!(replay.unwrap().resting().len(), 1);

    // A list of another length under the name of a body is no map.
    let short = two_frames("").replace("\"angles\": [1, 2]", "\"pelvis\": [1, 2]");
    let problem = parsed(&short).unwrap().bind(&scene(), &BTreeMap::new()).unwrap_err().to_string();
    let expected =
        "\"pelvis\" of frame 0 is a list of 2 numbers, but a map is a list of 16 numbers";
    assert_eq!(problem, expected);
}

#[test]
fn bodies_at_rest_have_reasons() {
    let resting = |text: &str| {
        let replay = parsed(text).unwrap().bind(&scene(), &BTreeMap::new()).unwrap();
        let resting = replay.resting().iter();
        resting.map(|resting| (resting.body.clone(), resting.reason)).collect::<Vec<_>>()
    };
    let pelvis = ("bone_pelvis".to_owned(), RestReason::NoMap);
    assert_eq!(resting(&two_frames(SKIN)), std::slice::from_ref(&pelvis));
    let muscle = ("muscle".to_owned(), RestReason::NoSkin);
    assert_eq!(resting(&two_frames("")), [muscle, pelvis]);
}

#[test]
fn a_motion_of_other_bones_is_refused() {
    let text = two_frames("").replace("femur", "ulna");
    let motion = parsed(&text).unwrap();
    let problem = motion.bind(&scene(), &BTreeMap::new()).unwrap_err();
    assert!(matches!(problem, MotionProblem::NoFollower { .. }), "{problem}");
    assert!(problem.to_string().contains("its maps are ulna"), "{problem}");
}

#[test]
fn lengths_in_another_unit_are_converted() {
    let of = |unit: &str| {
        let text = two_frames(&format!("\"unit\": \"{unit}\", {SKIN}"));
        parsed(&text).expect("a motion").bind(&scene(), &BTreeMap::new()).expect("bodies")
    };
    let in_scene = parsed(&two_frames(SKIN)).expect("a motion");
    let in_scene = in_scene.bind(&scene(), &BTreeMap::new()).expect("bodies");
    for frame in 0..2 {
        assert_eq!(of("mm").positions(frame), in_scene.positions(frame));
    }
    // The way along y of the bone, and the heights of the blend, are ten times as far.
    assert_eq!(of("cm").positions(1)[0][0], in_scene.positions(1)[0][0] + dvec3(0.0, 45.0, 0.0));
    assert_eq!(of("cm").positions(1)[1][2], of("cm").positions(1)[0][2]);
    assert_ne!(in_scene.positions(1)[1][2], in_scene.positions(1)[0][2]);
    let refusal = parsed(&two_frames("\"unit\": \"ft\",")).expect_err("an unknown unit");
    assert!(refusal.to_string().contains("unknown variant `ft`"), "{refusal}");
}
