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

#[test]
fn turns_in_which_nothing_can_meet_are_refused() {
    let workshop = rod_and_wall();
    let far = ["--turn", "rod", "--axis", "0,0,1", "--center", "0,-1e200,0", "--to", "9"];
    let cases = [
        ([&BODIES[..2], &TURN[..], &["--turn", "wall", "--to", "9"]].concat(), "leaves no body"),
        ([&BODIES[..2], &far[..]].concat(), "--center has the coordinate -1e200"),
    ];
    for (arguments, expected) in &cases {
        workshop.refuses("range", &[(arguments, expected)], &["--json", "r.json"]);
        let map = [&arguments[..], &MAP[..4]].concat();
        workshop.refuses("range", &[(&map, expected)], &["--table", "map.csv"]);
    }
}

/// A map whose cells are known: the first turn takes its share of the last one, the second turns
/// the axis around, so that the last one goes away from the wall.
const MAP: [&str; 8] =
    ["--over", "0,0,1:0:20:3", "--over", "1,0,0:0:180:2", "--to", "45", "--table", "map.csv"];

fn map_arguments<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&BODIES[..2], &TURN[..], &MAP[..], more].concat()
}

#[test]
fn a_map_has_the_angle_of_each_cell() {
    let workshop = rod_and_wall();
    let run = workshop.run("range", &map_arguments(&["--map", "map.svg"]));
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("6 cells: 3 meet, 3 free to 45.0000°"), "{}", run.stdout);

    let expected = ((5.0 / 10.0_f64.hypot(0.1)).asin() - 0.01_f64.atan()).to_degrees();
    let table = workshop.read("map.csv");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 6, "{table}");
    for row in &rows {
        let first: f64 = row[0].parse().expect("an angle");
        if row[1] == "180" {
            assert_eq!(row[2], "free", "{row:?}");
            continue;
        }
        let angle: f64 = row[3].parse().expect("an angle");
        let early = expected - first - angle;
        assert!((-1e-9..1e-3).contains(&early), "{angle} after {first} for {expected}");
        assert_eq!([row[2], row[5], row[6]], ["contact", "rod", "wall"]);
    }
    let picture = workshop.read("map.svg");
    assert!(picture.starts_with("<svg") && picture.matches("<rect").count() > 6, "{picture}");
}

/// A run goes on from what another one has kept, and writes the same bytes.
#[test]
fn an_interrupted_map_goes_on() {
    let workshop = rod_and_wall();
    let outputs = ["--map", "map.svg", "--cache", "map.cells"];
    assert_eq!(workshop.run("range", &map_arguments(&outputs)).status, 0);
    let whole = [workshop.read("map.csv"), workshop.read("map.svg")];

    // All but three cells are lost, and the third is cut.
    let kept = workshop.read("map.cells");
    let lines: Vec<&str> = kept.lines().collect();
    assert_eq!(lines.len(), 7, "{kept}");
    let cut = &lines[3][..lines[3].len() - 5];
    workshop.write("map.cells", format!("{}\n{cut}", lines[..3].join("\n")));
    assert_eq!(workshop.run("range", &map_arguments(&outputs)).status, 0);
    assert_eq!([workshop.read("map.csv"), workshop.read("map.svg")], whole);
    assert_eq!(workshop.read("map.cells").lines().count(), 7);

    // What is kept is not computed again: another value stays.
    workshop.write("map.cells", kept.replace(",free,", ",overlap,"));
    assert_eq!(workshop.run("range", &map_arguments(&outputs)).status, 0);
    assert_eq!(workshop.read("map.csv"), whole[0].replace(",free,", ",overlap,"));
}

#[test]
fn invalid_maps_are_named() {
    let workshop = rod_and_wall();
    // One thread finishes the cells in their order.
    let in_order = map_arguments(&["--cache", "map.cells", "--threads", "1"]);
    assert_eq!(workshop.run("range", &in_order).status, 0);
    workshop.write("other.cells", "0,0,1,2\n");
    workshop.write("damaged.cells", workshop.read("map.cells").replace("free", "fre"));
    let common = "rod.obj wall.obj --turn rod --axis 0,0,1 --center 0,0,0";
    let both = format!("{common} {}", MAP[..6].join(" "));
    let inputs = [
        format!("{common} --to 9 --over 0,0,1:0:20:3"),
        format!("{common} --to 9 --over 0,0,1:0:20"),
        format!("{common} --to 9 --over 0,0,1:0:20:1 --over 1,0,0:0:9:2"),
        format!("{common} --to 9 --over 0,0,0:0:20:2 --over 1,0,0:0:9:2"),
        format!("{common} --to 9 --over 0,0,1:0:400:2 --over 1,0,0:0:9:2"),
        format!("{common} --to 9 --map map.svg"),
        format!("{both} --cache other.cells"),
        format!("{both} --cache damaged.cells"),
        format!("{} --cache map.cells", both.replace("--to 45", "--to 44")),
        format!("{both} --cache rod.obj"),
        format!("{both} --cache new --map new"),
    ];
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    insta::assert_snapshot!(workshop.outcomes("range", &inputs));
}
