//! Scene files and command lines that must be understood, and those that must
//! be refused.

use std::path::{Path, PathBuf};

use glam::DVec3;
use musculo_collide::BodyKind;

use super::{Bounds, Scene, SceneError, Unit, file, unit_warnings};

fn parse(text: &str) -> Result<Scene, SceneError> {
    file::parse(text, Path::new("folder/scene.toml"))
}

const TWO_BODIES: &str = "[[body]]\nfile = \"a.ply\"\n[[body]]\nname = \"b\"\nfile = \"x/y.obj\"\n";

#[test]
fn what_is_left_out_has_a_default() {
    let scene = parse(TWO_BODIES).unwrap();
    assert_eq!((scene.unit, scene.reach), (Unit::Millimetre, 1.0));
    assert_eq!([&scene.bodies[0].name, &scene.bodies[1].name], ["a", "b"]);
    assert_eq!(scene.bodies[1].path, PathBuf::from("folder/x/y.obj"));
    assert_eq!(scene.bodies[1].kind, BodyKind::Deformable);
    let metres = parse(&format!("unit = \"m\"\n{TWO_BODIES}")).unwrap();
    assert!((metres.reach - 0.001).abs() < 1e-15, "a millimetre in metres");
}

#[test]
fn everything_can_be_said() {
    let text = format!(
        "unit = \"cm\"\nreach = 0.25\n[[ignore]]\na = \"b\"\nb = \"a\"\n{TWO_BODIES}kind = \"rigid\"\n"
    );
    let mut scene = parse(&text).unwrap();
    assert_eq!((scene.unit, scene.reach), (Unit::Centimetre, 0.25));
    assert_eq!(scene.ignored, [[0, 1]]);
    assert_eq!(scene.bodies[1].kind, BodyKind::Rigid);
    scene.set_rigid(&["a".to_owned()]).unwrap();
    assert_eq!(scene.bodies[0].kind, BodyKind::Rigid);
}

#[test]
fn what_cannot_be_checked_is_refused() {
    let cases = [
        ("colour = 1\n", "unknown field `colour`"),
        ("unit = \"furlong\"\n", "unknown variant `furlong`"),
        ("reach = nan\n", "reach is NaN"),
        ("reach = inf\n", "reach is inf"),
        ("reach = -1.0\n", "reach is -1"),
        ("[[ignore]]\na = \"a\"\nb = \"c\"\n", "[[ignore]] names 'c', but the bodies are: a, b"),
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
    assert!(matches!(parse("reach = 1.0\n"), Err(SceneError::NoBodies { .. })));
}

#[test]
fn files_name_their_bodies() {
    let paths = ["x/femur.ply", "vastus.left.stl"].map(PathBuf::from);
    let mut scene = Scene::from_inputs(&paths).unwrap();
    assert_eq!([&scene.bodies[0].name, &scene.bodies[1].name], ["femur", "vastus.left"]);
    let unknown = scene.set_rigid(&["tibia".to_owned()]).unwrap_err().to_string();
    assert_eq!(unknown, "--rigid names 'tibia', but the bodies are: femur, vastus.left");

    let twice = ["x/femur.ply", "y/femur.stl"].map(PathBuf::from);
    assert!(matches!(Scene::from_inputs(&twice), Err(SceneError::SameName { .. })));
    let mixed = ["femur.ply", "scene.toml"].map(PathBuf::from);
    assert!(matches!(Scene::from_inputs(&mixed), Err(SceneError::SceneAmongOthers { .. })));
}

#[test]
fn a_body_in_metres_beside_millimetres_is_suspected() {
    let sized = |size: f64| Bounds::of(&[DVec3::ZERO, DVec3::splat(size)]);
    let thigh = [("pelvis", sized(200.0)), ("femur", sized(400.0)), ("patella", sized(40.0))];
    assert_eq!(unit_warnings(&thigh), Vec::<String>::new());
    let mixed = [thigh[0], ("femur", sized(0.4)), thigh[2]];
    let warnings = unit_warnings(&mixed);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    for part in ["'femur' may be", "(0.4000, 0.4000, 0.4000)", "(40.0000, 40.0000, 40.0000)"] {
        assert!(warnings[0].contains(part), "{part}: {warnings:?}");
    }
    let two = [("femur", sized(0.4)), ("tibia", sized(400.0))];
    assert_eq!(unit_warnings(&two).len(), 1);
}
