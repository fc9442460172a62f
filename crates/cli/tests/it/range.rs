//! Angles of first contact, beside a closed form.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use serde_json::Value;

use crate::support::{Workshop, obj};

/// A box between two corners.
fn cuboid(from: [f64; 3], to: [f64; 3]) -> Mesh {
    let [from, to] = [from, to].map(DVec3::from);
    shapes::cube(1.0).mapped(|x| (from + to) / 2.0 + x * (to - from))
}

/// A rod along x that turns about z, a wall above it, one that it never reaches, and a block that it
/// is in from the start.
fn rod_and_wall() -> Workshop {
    let workshop = Workshop::new();
    let bodies = [
        ("rod", cuboid([1.0, -0.1, -0.1], [10.0, 0.1, 0.1])),
        ("wall", cuboid([-20.0, 5.0, -9.0], [20.0, 6.0, 9.0])),
        ("far", cuboid([-20.0, 15.0, -9.0], [20.0, 16.0, 9.0])),
        ("block", cuboid([1.5, -0.5, -0.5], [2.0, 0.0, 0.5])),
    ];
    for (name, mesh) in bodies {
        workshop.write(&format!("{name}.obj"), obj(&mesh));
    }
    workshop
}

const BODIES: [&str; 4] = ["rod.obj", "wall.obj", "far.obj", "block.obj"];

const TURN: [&str; 6] = ["--turn", "rod", "--axis", "0,0,2", "--center", "0,0,0"];

#[test]
fn a_rod_meets_a_wall_at_the_angle_of_its_corner() {
    let workshop = rod_and_wall();
    let rest = ["--to", "80", "--json", "r.json"];
    let run = workshop.run("range", &[&BODIES[..], &TURN[..], &rest[..]].concat());
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);

    // The upper corner of the rod is at a radius, and ahead of its middle.
    let expected = (5.0 / 10.0_f64.hypot(0.1)).asin() - 0.01_f64.atan();
    let report: Value = serde_json::from_str(&workshop.read("r.json")).expect("valid JSON");
    let [contact] = &report["contacts"].as_array().expect("contacts")[..] else {
        panic!("one contact: {report}")
    };
    assert_eq!((&contact["a"], &contact["b"]), (&"rod".into(), &"wall".into()));
    let angle = contact["angle"].as_f64().expect("an angle");
    let early = expected.to_degrees() - angle;
    assert!((-1e-9..1e-3).contains(&early), "{angle} for {}", expected.to_degrees());
    assert!((contact["at"][1].as_f64().expect("a number") - 5.0).abs() < 1e-3, "{contact}");
    assert_eq!(report["overlapping"], serde_json::json!([["rod", "block"]]));
    assert!(run.stdout.contains("free to 29.4"), "{}", run.stdout);

    // The other way it meets nothing.
    let run = workshop.run("range", &[&BODIES[..], &TURN[..], &["--to", "-80"]].concat());
    assert!(run.status == 0 && run.stdout.contains("free to -80.0000°"), "{}", run.stdout);
}

#[test]
fn invalid_turns_are_named() {
    let workshop = rod_and_wall();
    let bodies = "rod.obj wall.obj";
    let inputs = [
        format!("{bodies} --turn rood --axis 0,0,1 --center 0,0,0 --to 9"),
        format!("{bodies} --turn rod --axis 0,0,0 --center 0,0,0 --to 9"),
        format!("{bodies} --turn rod --axis 0,0 --center 0,0,0 --to 9"),
        format!("{bodies} --turn rod --axis 0,0,1 --center 0,0,0 --to 400"),
        format!("{bodies} --turn rod --axis 0,0,1 --center 0,0,0 --to 9 --json rod.obj"),
    ];
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    insta::assert_snapshot!(workshop.outcomes("range", &inputs));
}
