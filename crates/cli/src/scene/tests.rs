//! Valid and invalid scene files and command lines.

use std::path::{Path, PathBuf};

use glam::DVec3;
use musculo_collide::BodyKind;
use musculo_collide::surface::Aabb;

use super::{IgnoredPair, SceneDescription, SceneProblem, Unit, unit_warnings};

fn parse(text: &str) -> Result<SceneDescription, SceneProblem> {
    SceneDescription::parse(text, Path::new("folder"))
}

const TWO_BODIES: &str = "[[body]]\nfile = \"a.ply\"\n[[body]]\nname = \"b\"\nfile = \"x/y.obj\"\n";

#[test]
fn defaults_replace_absent_keys() {
    let scene = parse(TWO_BODIES).unwrap();
    assert_eq!((scene.unit, scene.margin), (Unit::Millimeter, None));
    assert_eq!([&scene.bodies[0].name, &scene.bodies[1].name], ["a", "b"]);
    assert_eq!(scene.bodies[1].path, PathBuf::from("folder/x/y.obj"));
    assert_eq!(scene.bodies[1].kind, BodyKind::Deformable);
}

#[test]
fn every_key_is_read() {
    let text = format!(
        "unit = \"cm\"\nmargin = 0.25\n[[ignore]]\na = \"b\"\nb = \"a\"\n{TWO_BODIES}kind = \"rigid\"\n"
    );
    let mut scene = parse(&text).unwrap();
    assert_eq!((scene.unit, scene.margin), (Unit::Centimeter, Some(0.25)));
    assert_eq!(scene.ignored, [IgnoredPair { a: "b".to_owned(), b: "a".to_owned() }]);
    assert_eq!(scene.bodies[1].kind, BodyKind::Rigid);
    scene.set_rigid(&["a".to_owned()]).unwrap();
    assert_eq!(scene.bodies[0].kind, BodyKind::Rigid);
}

#[test]
fn invalid_scenes_are_refused() {
    let cases = [
        ("colour = 1\n", "unknown field `colour`"),
        ("unit = \"furlong\"\n", "unknown variant `furlong`"),
        ("reach = 1.0\n", "unknown field `reach`"),
        ("margin = nan\n", "margin is NaN"),
        ("margin = inf\n", "margin is inf"),
        ("margin = -1.0\n", "margin is -1"),
        ("[[ignore]]\na = \"a\"\nb = \"c\"\n", "no body is named 'c': the bodies are a, b"),
        ("[[ignore]]\na = \"a\"\nb = \"a\"\n", "[[ignore]] pairs 'a' with itself"),
        ("[[body]]\nfile = \"b.stl\"\n", "two bodies are named 'b': b.stl and x/y.obj"),
        ("[[body]]\nfile = \"c.ply\"\nkind = \"soft\"\n", "unknown variant `soft`"),
        ("[[body]]\nfile = \"c.ply\"\nmass = 3\n", "unknown field `mass`"),
        ("[[body]]\nname = \"c\"\n", "missing field `file`"),
        ("[[body]]\nfile = \"c.ply\"\nname = \"../c\"\n", "cannot name an output file"),
        ("unit = \n", "TOML parse error at line 1"),
    ];
    for (addition, expected) in cases {
        let message = parse(&format!("{addition}{TWO_BODIES}")).unwrap_err().to_string();
        assert!(message.contains(expected), "{addition}: {message}");
    }
    assert!(matches!(parse("margin = 1.0\n"), Err(SceneProblem::NoBodies)));
}

#[test]
fn files_name_their_bodies() {
    let paths = ["x/femur.ply", "vastus.left.stl"].map(PathBuf::from);
    let mut scene = SceneDescription::from_inputs(&paths).unwrap();
    assert_eq!([&scene.bodies[0].name, &scene.bodies[1].name], ["femur", "vastus.left"]);
    let unknown = scene.set_rigid(&["tibia".to_owned()]).unwrap_err().to_string();
    assert_eq!(unknown, "no body is named 'tibia': the bodies are femur, vastus.left");

    let twice = ["x/femur.ply", "y/femur.stl"].map(PathBuf::from);
    let problems = |paths: &[PathBuf]| SceneDescription::from_inputs(paths).unwrap_err().problems;
    assert!(problems(&twice)[0].contains("two bodies are named 'femur'"), "{:?}", problems(&twice));
    let mixed = ["femur.ply", "scene.toml"].map(PathBuf::from);
    assert!(problems(&mixed)[0].contains("scene.toml is a scene"), "{:?}", problems(&mixed));
}

#[test]
fn a_body_in_meters_beside_millimeters_is_suspected() {
    let sized = |size: f64| Aabb { min: DVec3::ZERO, max: DVec3::splat(size) };
    let thigh = [("pelvis", sized(200.0)), ("femur", sized(400.0)), ("patella", sized(40.0))];
    assert_eq!(unit_warnings(&thigh), Vec::<String>::new());
    let mixed = [thigh[0], ("femur", sized(0.4)), thigh[2]];
    let warnings = unit_warnings(&mixed);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    for part in
        ["'femur' may have another unit", "(0.4000, 0.4000, 0.4000)", "(40.0000, 40.0000, 40.0000)"]
    {
        assert!(warnings[0].contains(part), "{part}: {warnings:?}");
    }
    let two = [("femur", sized(0.4)), ("tibia", sized(400.0))];
    assert_eq!(unit_warnings(&two).len(), 1);
}
