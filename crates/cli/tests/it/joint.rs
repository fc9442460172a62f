//! Joint contact of planted scenes: table, JSON, VTP, motions, refusals.

use std::f64::consts::PI;

use crate::support::{Run, Workshop, obj};
use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere};
use glam::DVec3;
use serde_json::Value;

const THIGH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/scene.toml");

const RADIUS: f64 = 10.0;

/// Modulus, Poisson's ratio and thickness of the elastic layer.
const LAYER: [f64; 3] = [5.0, 0.4, 2.0];

/// Bits of the command line that ask for contact with the layer.
const CONTACT: [&str; 6] =
    ["--joint-contact", "0", "--joint-resolution", "0.1", "--foundation", "5,0.4,2"];

/// Returns a ball that reaches `depth` below the plane z = 0.
fn ball(depth: f64) -> Mesh {
    icosphere(RADIUS, 5).translated(DVec3::new(0.0, 0.0, RADIUS - depth))
}

/// Returns a block under the plane z = 0.
fn ground() -> Mesh {
    cube(1.0).scaled(DVec3::new(60.0, 60.0, 20.0)).translated(DVec3::new(0.0, 0.0, -10.0))
}

fn workshop(ball: &Mesh) -> Workshop {
    let workshop = Workshop::new();
    workshop.write("ball.obj", obj(ball));
    workshop.write("ground.obj", obj(&ground()));
    workshop
}

/// Checks ball and ground, and returns the run with the JSON of the report.
fn check(workshop: &Workshop, arguments: &[&str]) -> (Run, Value) {
    let run = workshop.check(
        &[&["ball.obj", "ground.obj", "--rigid", "ground", "--json", "o.json"], arguments].concat(),
    );
    let document = serde_json::from_str(&workshop.read("o.json")).expect("JSON");
    (run, document)
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Returns the table of joint contact in a report.
fn joint_table(report: &str) -> &str {
    let start = report.find("Joint contact").expect("a table of joint contact");
    report[start..].split("\n\n").next().expect("a paragraph")
}

/// Returns the force with which the ground presses back on the cap of a ball: ∫ p n dA with
/// u = cos θ is 2π R² (M / h) ∫ u (R u − (R − d)) du.
fn force(depth: f64) -> f64 {
    let [modulus, nu, thickness] = LAYER;
    let constrained = (1.0 - nu) * modulus / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let from = 1.0 - depth / RADIUS;
    let integral =
        RADIUS * (1.0 - from.powi(3)) / 3.0 - (RADIUS - depth) * (1.0 - from * from) / 2.0;
    2.0 * PI * RADIUS * RADIUS * constrained / thickness * integral
}

#[test]
fn a_pressed_ball_has_the_area_depth_and_force_of_its_cap() {
    let depth = 1.0;
    let workshop = workshop(&ball(depth));
    let (run, document) = check(&workshop, &CONTACT);
    assert_eq!(run.status, 1, "{}", run.stderr);
    insta::assert_snapshot!("pressed_ball", joint_table(&run.stdout));

    let contact = &document["pairs"][0]["joint_contact"]["of_a"];
    assert_eq!([&contact["surface"], &contact["against"]], ["ball", "ground"]);
    let [area, lower, upper] =
        ["area", "area_lower", "area_upper"].map(|name| number(&contact[name]));
    let cap = 2.0 * PI * RADIUS * depth;
    assert!(lower < area && area < upper && (area / cap - 1.0).abs() < 5e-3, "{contact}");

    // The depth is evenly distributed over the cap.
    assert!((number(&contact["mean_gap"]) + 0.5 * depth).abs() < 5e-3, "{contact}");
    assert!((number(&contact["min_gap"]) + depth).abs() < 1e-2, "{contact}");
    assert!((number(&contact["center"][2]) + 0.5 * depth).abs() < 1e-2, "{contact}");
    assert!((number(&contact["force"][2]) / force(depth) - 1.0).abs() < 1e-2, "{contact}");

    // Both surfaces press on each other.
    let of_ground = &document["pairs"][0]["joint_contact"]["of_b"];
    assert!((number(&of_ground["force"][2]) / force(depth) + 1.0).abs() < 5e-2, "{of_ground}");
    assert_eq!(document["joint_contact"]["foundation"]["law"], "linear");
}

#[test]
fn the_logarithmic_law_is_stiffer() {
    let workshop = workshop(&ball(1.0));
    let law = [&CONTACT[..], &["--foundation-law", "logarithmic"]].concat();
    let [linear, logarithmic] = [&CONTACT[..], &law[..]].map(|arguments| {
        let (_, document) = check(&workshop, arguments);
        number(&document["pairs"][0]["joint_contact"]["of_a"]["max_pressure"])
    });

    // At the bottom the strain is a half, −ln(1 − ½) against ½.
    let ratio = 2.0_f64.ln() / 0.5;
    assert!((logarithmic / linear / ratio - 1.0).abs() < 1e-2, "{logarithmic} for {linear}");
}

/// Two plates that are 0.5 apart: a joint space, in which nothing overlaps and nothing presses.
#[test]
fn a_gap_is_contact_within_the_margin() {
    let plate = cube(10.0).translated(DVec3::Z * 5.5);
    let workshop = workshop(&plate);
    let (run, document) = check(
        &workshop,
        &["--margin", "0.1", "--joint-contact", "0.6", "--joint-resolution", "0.1"],
    );
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert!(!joint_table(&run.stdout).contains("PRESSURE"), "{}", run.stdout);
    assert_eq!(document["margin"], 0.6, "contact beyond the margin raises it");

    // The lower side as a whole, and 0.1 of the height of each other side.
    let contact = &document["pairs"][0]["joint_contact"]["of_a"];
    let exact = 100.0 + 4.0 * 10.0 * 0.1;
    let [lower, upper] = ["area_lower", "area_upper"].map(|name| number(&contact[name]));
    assert!(lower <= exact && exact <= upper, "{contact}");
    assert!((number(&contact["min_gap"]) - 0.5).abs() < 1e-9, "{contact}");
    assert_eq!(contact["max_pressure"], 0.0);

    let (run, document) = check(&workshop, &["--margin", "1", "--joint-contact", "0.4"]);
    assert!(!run.stdout.contains("Joint contact"), "{}", run.stdout);
    assert_eq!(document["pairs"][0]["joint_contact"], Value::Null);
}

#[test]
fn separate_regions_have_rows_of_their_own() {
    let small = |x: f64, z: f64| icosphere(5.0, 4).translated(DVec3::new(x, 0.0, z));
    let workshop = workshop(&small(-12.0, 4.5).joined(&small(12.0, 4.8)));
    let (run, document) = check(&workshop, &CONTACT);
    insta::assert_snapshot!("two_regions", joint_table(&run.stdout));
    let regions = document["pairs"][0]["joint_contact"]["of_a"]["regions"].clone();
    assert_eq!(regions.as_array().map(Vec::len), Some(2));
    assert!((number(&regions[0]["center"][0]) + 12.0).abs() < 1e-2, "{regions}");
    assert!(number(&regions[0]["area"]) > 2.0 * number(&regions[1]["area"]), "{regions}");
}

#[test]
fn maps_of_gap_and_pressure_are_written_as_vtp() {
    let workshop = workshop(&ball(1.0));
    let arguments = [&CONTACT[..], &["--vtp", "o", "--report", "o.html"]].concat();
    let (run, _) = check(&workshop, &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    for name in ["o/ball_on_ground.vtp", "o/ground_on_ball.vtp"] {
        let file = workshop.read(name);
        let arrays = ["gap", "pressure", "contact_area", "face", "region"];
        for part in arrays.map(|array| format!("Name=\"{array}\"")) {
            assert!(file.contains(&part), "{part} is not in {name}");
        }
    }

    // The map has the faces of the cap, and no others.
    let mesh = mesh_io::read_mesh(&workshop.path("o/ball_on_ground.vtp")).expect("a mesh");
    let lowest = |face: &[u32; 3]| face.map(|v| mesh.positions[v as usize].z).into_iter();
    let below = |face: &[u32; 3]| lowest(face).fold(f64::INFINITY, f64::min) < 0.0;
    assert!(mesh.faces.len() > 100 && mesh.faces.iter().all(below), "{}", mesh.faces.len());
    let section = "<h2>Joint contact, at gaps up to 0 mm; gaps below 0 are depths</h2>";
    let html = workshop.read("o.html");
    for part in [section, "alt=\"ball against ground\"", "pressure, in the unit of the modulus"] {
        assert!(html.contains(part), "{part} is not in the report");
    }
}

#[test]
fn a_motion_has_the_contact_of_every_frame() {
    let depths = [0.0, 0.5, 1.0];
    let workshop = workshop(&ball(-0.5));
    workshop.write(
        "scene.toml",
        "motion = \"down.json\"\n[[body]]\nfile = \"ground.obj\"\nkind = \"rigid\"\n\
         [[body]]\nfile = \"ball.obj\"\nkind = \"rigid\"\n",
    );
    let frame = |depth: f64| {
        let z = -0.5 - depth;
        format!("{{\"ball\": [1,0,0,0, 0,1,0,0, 0,0,1,{z}, 0,0,0,1]}}")
    };
    let frames = depths.map(frame).join(", ");
    workshop.write("down.json", format!("{{\"ignore\": [], \"frames\": [{frames}]}}"));
    let arguments = [&["scene.toml", "--json", "m.json", "--vtp", "o"], &CONTACT[..]].concat();
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    insta::assert_snapshot!("motion", joint_table(&run.stdout));

    let document: Value = serde_json::from_str(&workshop.read("m.json")).expect("JSON");
    for (frame, depth) in depths.iter().enumerate().skip(1) {
        let contacts = document["frames"][frame]["joint_contact"].as_array().expect("contacts");
        let of_ball = contacts.iter().find(|contact| contact["surface"] == "ball");
        let force_z = number(&of_ball.expect("the ball")["force"][2]);
        assert!((force_z / force(*depth) - 1.0).abs() < 3e-2, "{force_z} at {depth}");
    }
    let names = workshop.listing();
    assert!(names.contains(&"o/ball_on_ground_0002.vtp".to_owned()), "{names:?}");
    assert!(!names.contains(&"o/ball_on_ground_0000.vtp".to_owned()), "{names:?}");
}

#[test]
fn parameters_out_of_range_are_refused() {
    let workshop = workshop(&ball(1.0));
    let cases: [(&[&str], &str); 9] = [
        (&["--joint-contact", "-1"], "the contact margin is -1"),
        (&["--joint-contact", "1", "--joint-resolution", "0"], "the resolution is 0"),
        (&["--joint-contact", "1", "--joint-resolution", "1e-9"], "cells; 1e8 are allowed"),
        (&["--joint-contact", "1", "--foundation", "5,0.4"], "expected three numbers"),
        (&["--joint-contact", "1", "--foundation", "5,x,1"], "'x' is no number"),
        (&["--joint-contact", "1", "--foundation", "5,0.5,1"], "Poisson's ratio 0.5"),
        (&["--joint-contact", "1", "--foundation", "1e300,0.4,1"], "between 1e-60 and 1e60"),
        (&["--joint-contact", "1", "--foundation", "5,0.4,1e-300"], "between 1e-90 and 1e30"),
        (&["--foundation", "5,0.4,2"], "--joint-contact"),
    ];
    workshop.refuses("check", &cases, &["ball.obj", "ground.obj", "--json", "o.json"]);
}

#[test]
fn the_table_of_a_motion_has_the_joint_contact_of_each_frame() {
    let workshop = Workshop::new();
    let arguments = [THIGH, "--joint-contact", "0.5", "--table", "m.csv", "--json", "m.json"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let document: Value = serde_json::from_str(&workshop.read("m.json")).expect("JSON");
    let table = workshop.read("m.csv");
    for frame in document["frames"].as_array().expect("frames") {
        let contacts = frame["joint_contact"].as_array().expect("contacts");
        let start = format!(",{},", frame["frame"]);
        let areas = table.lines().filter(|line| {
            line.contains(&start) && line.contains("joint_contact.of_") && line.contains(".area,")
        });
        let areas: Vec<f64> = areas
            .map(|line| line.rsplit(',').next().expect("a value").parse().expect("a number"))
            .collect();
        let expected: Vec<f64> =
            contacts.iter().map(|contact| contact["area"].as_f64().expect("an area")).collect();
        assert_eq!(areas, expected, "{start}");
        assert!(!areas.is_empty(), "{start}");
    }
}
