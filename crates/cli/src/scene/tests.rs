//! Valid and invalid scene files and command lines.

use std::path::{Path, PathBuf};

use glam::DVec3;
use musculo_collide::BodyKind;
use musculo_collide::surface::Aabb;

use super::{IgnoredPair, SceneDescription, SceneProblem, Selection, Unit, unit_warnings};

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
    assert_eq!(scene.bodies[1].kind, None);
}

#[test]
fn every_key_is_read() {
    let text = format!(
        "unit = \"cm\"\nmargin = 0.25\n[[ignore]]\na = \"b\"\nb = \"a\"\n{TWO_BODIES}kind = \"rigid\"\nstiffness = 2\nuncross = true\n"
    );
    let mut scene = parse(&text).unwrap();
    assert_eq!((scene.unit, scene.margin), (Unit::Centimeter, Some(0.25)));
    assert_eq!(scene.ignored, [IgnoredPair { a: "b".to_owned(), b: "a".to_owned() }]);
    assert_eq!(scene.bodies[1].kind, Some(BodyKind::Rigid));
    let stiffness = scene.bodies[1].stiffness.as_ref().map(|stiffness| *stiffness.get_ref());
    assert_eq!((stiffness, scene.bodies[1].uncross), (Some(2.0), true));
    scene.set_rigid(&["a".to_owned()]).unwrap();
    assert_eq!(scene.bodies[0].kind, Some(BodyKind::Rigid));
}

#[test]
fn bodies_that_are_parts_of_one_file_have_the_names_of_their_first_parts() {
    let text = "[[body]]\nfile = \"k.feb\"\nparts = [\"bone\"]\n[[body]]\nfile = \"x.obj\"\n\
                [[body]]\nfile = \"k.feb\"\nparts = [\"disc\", \"rim\"]\n\
                [[body]]\nname = \"again\"\nfile = \"x.obj\"\n";
    let scene = parse(text).unwrap();
    let names: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["bone", "x", "disc", "again"]);
    assert_eq!(scene.bodies_by_file(), [vec![0, 2], vec![1], vec![3]]);
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
        ("[[body]]\nfile = \"x\\femur.ply\"\n", "output file: the path has control characters"),
        (
            "[[body]]\nfile = \"x\\old.ply\"\n",
            "a backslash begins an escape: write / between folders",
        ),
        ("unit = \n", "TOML parse error at line 1"),
    ];
    for (addition, expected) in cases {
        let message = parse(&format!("{addition}{TWO_BODIES}")).unwrap_err().to_string();
        assert!(message.contains(expected), "{addition}: {message}");
    }
    assert!(matches!(parse("margin = 1.0\n"), Err(SceneProblem::NoBodies)));
}

#[test]
fn conditions_are_read() {
    let text = format!(
        "{TWO_BODIES}[[tie]]\na = \"a\"\nb = \"b\"\nwithin = 0.5\n\
         [[fixed]]\nbody = \"a\"\nvertices = \"ids.txt\"\n\
         [[fixed]]\nbody = \"b\"\nbox = [[1, 5, 3], [4, 2, 6]]\n\
         [[fixed]]\nbody = \"b\"\nwithin = 1\nof = \"a\"\n"
    );
    let scene = parse(&text).unwrap();
    let tie = scene.ties[0].get_ref();
    assert_eq!((&*tie.a, &*tie.b, tie.within), ("a", "b", 0.5));
    let [file, corners, near] = &scene.fixed[..] else { panic!("three selections") };
    let ids = Path::new("folder/ids.txt");
    assert_eq!(file.get_ref().selection(), Ok(Selection::File(ids)));
    let [min, max] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)];
    assert_eq!(corners.get_ref().selection(), Ok(Selection::Box { min, max }));
    let expected = Selection::Near { other: "a", distance: 1.0 };
    assert_eq!(near.get_ref().selection(), Ok(expected));
}

#[test]
fn invalid_conditions_name_line_and_value() {
    let cases = [
        ("[[tie]]\na = \"a\"\nb = \"c\"\nwithin = 1", "line 6: [[tie]]: no body is named 'c'"),
        ("[[tie]]\na = \"a\"\nb = \"a\"\nwithin = 1", "line 6: [[tie]]: 'a' is paired with itself"),
        ("\n[[tie]]\na = \"a\"\nb = \"b\"\nwithin = -1", "line 7: [[tie]]: within is -1, but must"),
        ("[[tie]]\na = \"a\"\nb = \"b\"", "missing field `within`"),
        ("[[tie]]\na = \"a\"\nb = \"b\"\nwithin = \"far\"", "at line 9"),
        ("[[tie]]\na = \"a\"\nb = \"b\"\ngap = 1", "unknown field `gap`"),
        ("stiffness = -2", "line 6: [[body]]: stiffness is -2.0, but must be from 1e-9 to 1e9"),
        ("stiffness = nan", "line 6: [[body]]: stiffness is NaN, but must"),
        ("stiffness = 1e140", "line 6: [[body]]: stiffness is 1e140, but must"),
        ("stiffness = 1e-160", "line 6: [[body]]: stiffness is 1e-160, but must"),
        ("[[fixed]]\nbody = \"c\"\nvertices = \"v\"", "line 6: [[fixed]]: no body is named 'c'"),
        ("[[fixed]]\nbody = \"a\"", "line 6: [[fixed]]: select vertices in one way"),
        ("[[fixed]]\nbody = \"a\"\nwithin = 1", "'within' needs the body 'of'"),
        ("[[fixed]]\nbody = \"a\"\nof = \"b\"", "'of' needs a distance 'within'"),
        ("[[fixed]]\nbody = \"a\"\nwithin = nan\nof = \"b\"", "within is NaN, but must be finite"),
        ("[[fixed]]\nbody = \"a\"\nwithin = 1\nof = \"a\"", "'a' is paired with itself"),
        ("[[fixed]]\nbody = \"a\"\nbox = [[1, 2], [3, 4]]", "at line 8"),
        (
            "[[fixed]]\nbody = \"a\"\nbox = [[1, 2, inf], [3, 4, 5]]",
            "a corner of the box is not finite",
        ),
        ("[[fixed]]\nbody = \"a\"\nvertices = \"v\"\nof = \"b\"", "select vertices in one way"),
    ];
    for (addition, expected) in cases {
        let message = parse(&format!("{TWO_BODIES}{addition}\n")).unwrap_err().to_string();
        assert!(message.contains(expected), "{addition}: {message}");
    }
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
