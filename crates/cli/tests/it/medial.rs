//! Medial surfaces of meshes: outputs, reports, refusals.

use std::fmt::Write;

use crate::support::Workshop;
use serde_json::Value;

const MUSCLE: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/rectus_femoris.ply");

/// Returns an ellipsoid of 60 × 24 × 16 about (`x`, 0, 0), wound outwards.
fn ellipsoid(x: f64, first: usize) -> String {
    const RINGS: usize = 12;
    const AROUND: usize = 20;
    let mut text = String::new();
    let mut vertex = |u: f64, v: f64, w: f64| {
        writeln!(text, "v {} {} {}", x + 8.0 * u, 12.0 * v, 30.0 * w).expect("text grows");
    };
    vertex(0.0, 0.0, 1.0);
    for ring in 1..RINGS {
        let (sin, cos) = (std::f64::consts::PI * as_f64(ring) / as_f64(RINGS)).sin_cos();
        for k in 0..AROUND {
            let (v, u) = (std::f64::consts::TAU * as_f64(k) / as_f64(AROUND)).sin_cos();
            vertex(sin * u, sin * v, cos);
        }
    }
    vertex(0.0, 0.0, -1.0);
    let at = |ring: usize, k: usize| first + 2 + (ring - 1) * AROUND + k % AROUND;
    let last = first + 2 + (RINGS - 1) * AROUND;
    for k in 0..AROUND {
        let mut face = |a, b, c| writeln!(text, "f {a} {b} {c}").expect("text grows");
        face(first + 1, at(1, k), at(1, k + 1));
        face(last, at(RINGS - 1, k + 1), at(RINGS - 1, k));
        for ring in 1..RINGS - 1 {
            face(at(ring, k), at(ring + 1, k), at(ring, k + 1));
            face(at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
        }
    }
    text
}

#[expect(clippy::cast_precision_loss, reason = "small counts")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("valid JSON")
}

fn bytes(workshop: &Workshop, name: &str) -> Vec<u8> {
    std::fs::read(workshop.path(name)).expect("a readable file")
}

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("muscle.obj", ellipsoid(0.0, 0));
    workshop
}

/// Returns arguments that write every kind of file for the muscle, after some others.
fn files<'a>(others: &[&'a str]) -> Vec<&'a str> {
    let outputs = ["--out", "m.ma", "--picture", "m.png", "--vtp", "m.vtp"];
    [&["muscle.obj"], others, &outputs].concat()
}

/// Returns the numbers of the lines of a .ma file that begin with a letter.
fn lines(text: &str, letter: &str) -> Vec<Vec<f64>> {
    let of = text.lines().filter_map(|line| line.strip_prefix(letter));
    of.map(|line| line.split_whitespace().map(|word| word.parse().expect("a number")).collect())
        .collect()
}

#[test]
fn a_muscle_becomes_balls_a_picture_and_figures() {
    let workshop = workshop();
    let run = workshop.run("medial", &files(&["--balls", "20", "--json", "m.json"]));
    assert_eq!(run.status, 0, "{}", run.stderr);
    for part in ["222 vertices, 440 faces", "balls      20, with", "as the surface", "wrote m.ma"] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    let record = json(&workshop, "m.json");
    let deviation = &record["deviation"];
    let rms = deviation["rms"].as_f64().unwrap();
    assert!(0.0 < rms && rms < 0.4, "{rms}");
    for side in ["surface_to_medial", "medial_to_surface"] {
        let bound = deviation[side]["upper"].as_f64().unwrap();
        assert!(deviation[side]["lower"].as_f64().unwrap() <= bound && bound < 3.0, "{bound}");
    }
    assert_eq!(record["union"]["components"], 1);

    let text = workshop.read("m.ma");
    let balls = lines(&text, "v ");
    assert_eq!(balls.len(), 20);
    // The middle of the ellipsoid is filled: some ball is nearly as thick as it is.
    let thickest = balls.iter().map(|ball| ball[3]).fold(0.0, f64::max);
    assert!((7.0..8.3).contains(&thickest), "{thickest}");
    assert_eq!(record["slabs"].as_u64().unwrap(), lines(&text, "f ").len() as u64);
    assert!(bytes(&workshop, "m.png").starts_with(b"\x89PNG"));

    // The VTP file is a mesh as any, and is colored by the distance.
    assert!(workshop.read("m.vtp").contains("Scalars=\"medial_distance\""));
    let again = workshop.run("medial", &["m.vtp", "--balls", "20", "--out", "again.ma"]);
    assert_eq!(again.status, 0, "{}", again.stderr);
    assert_eq!(workshop.read("again.ma"), text, "the same surface, the same balls");
}

#[test]
fn a_tolerance_is_kept() {
    let workshop = workshop();
    let within = |tolerance: &str| {
        let run =
            workshop.run("medial", &["muscle.obj", "--tolerance", tolerance, "--json", "m.json"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        let record = json(&workshop, "m.json");
        for side in ["surface_to_medial", "medial_to_surface"] {
            let bound = record["deviation"][side]["upper"].as_f64().unwrap();
            assert!(bound <= tolerance.parse().unwrap(), "{bound} of {tolerance}");
        }
        record["balls"].as_u64().unwrap()
    };
    assert!(within("4") < within("0.9"));
}

#[test]
fn threads_change_no_byte() {
    let workshop = workshop();
    let written = |threads: &str| {
        let arguments = files(&["--balls", "16", "--threads", threads]);
        let run = workshop.run("medial", &arguments);
        assert_eq!(run.status, 0, "{}", run.stderr);
        ["m.ma", "m.png", "m.vtp"].map(|name| bytes(&workshop, name))
    };
    assert!(written("1") == written("3"), "the same bytes");
}

#[test]
fn a_muscle_of_the_fixtures_keeps_its_topology() {
    let workshop = Workshop::new();
    let run = workshop.run("medial", &[MUSCLE, "--balls", "60", "--json", "m.json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let record = json(&workshop, "m.json");
    assert_eq!(record["union"], record["inside"]);
}

#[test]
fn invalid_input_is_named_and_nothing_is_written() {
    let workshop = workshop();
    let muscle = ellipsoid(0.0, 0);
    let torn = muscle.trim_end().rsplit_once('\n').expect("lines").0.to_owned();
    workshop.write("torn.obj", torn);
    workshop.write("two.obj", muscle.clone() + &ellipsoid(50.0, 222));
    workshop.write("crossing.obj", muscle.clone() + &ellipsoid(9.0, 222));
    // The top is pulled through the bottom, so that faces of one body cross.
    workshop.write("pierced.obj", muscle.replacen("v 0 0 30", "v 0 0 -40", 1));
    let check = workshop.check(&["pierced.obj", "--json", "check.json"]);
    assert!(check.stdout.contains(", the first of faces "), "{}", check.stdout);
    let crossings = &json(&workshop, "check.json")["bodies"][0]["self_crossings"];
    let pairs = crossings["pairs"].as_array().expect("pairs of faces").len();
    assert_eq!(crossings["count"], pairs, "all pairs are listed");
    std::fs::remove_file(workshop.path("check.json")).expect("a file to remove");
    let turned: Vec<String> = muscle
        .lines()
        .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["f", a, b, c] => format!("f {a} {c} {b}"),
            _ => line.to_owned(),
        })
        .collect();
    workshop.write("turned.obj", turned.join("\n"));
    workshop.write("thin.obj", flattened(&muscle));
    let cases: &[(&[&str], &str)] = &[
        (&["missing.obj"], "missing.obj: cannot be read"),
        (&["torn.obj"], "torn.obj: the surface is open: 3 edges"),
        (&["two.obj"], "two.obj: the surface has 2 parts"),
        (&["crossing.obj"], "crossing.obj: the surface has 2 parts"),
        (&["turned.obj"], "turned.obj: the surface is inside out"),
        (&["pierced.obj"], "`check` lists them with their places. Remove them and fill the holes"),
        (&["thin.obj"], "thin.obj: the surface is too thin for its faces"),
        (&["muscle.obj", "--balls", "0"], "muscle.obj: number of balls is 0"),
        (&["muscle.obj", "--balls", "223"], "muscle.obj: 223 balls were requested"),
        (&["muscle.obj", "--tolerance", "-1"], "muscle.obj: tolerance is -1"),
        (&["muscle.obj", "--tolerance", "nan"], "muscle.obj: tolerance is NaN"),
        (&["muscle.obj", "--tolerance", "1e-3"], "muscle.obj: the tolerance 0.001 was not reached"),
        (&["muscle.obj", "--tolerance", "1", "--balls", "9"], "cannot be used with"),
        (&["muscle.obj", "--balls", "8", "--out", "no/m.ma"], "no/m.ma: cannot be written"),
    ];
    workshop.refuses("medial", cases, &["--json", "m.json", "--picture", "m.png"]);
}

/// Returns the mesh at a thousandth of its thickness.
fn flattened(mesh: &str) -> String {
    let line = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["v", x, y, z] => {
            format!("v {} {y} {z}\n", x.parse::<f64>().expect("a number") / 1000.0)
        }
        _ => format!("{line}\n"),
    };
    mesh.lines().map(line).collect()
}
