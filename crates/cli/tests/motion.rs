//! Motions that are replayed: what passes between frames, outputs, bad input.

#[expect(dead_code, reason = "shared with the tests of other commands")]
mod support;

use serde_json::Value;
use support::Workshop;

const THIGH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/scene.toml");

const REST: &str = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

/// A thin plate in z = 0, and a needle above it that moves down by 4 at once.
fn needle_through_plate() -> Workshop {
    let workshop = Workshop::new();
    let corner = |x: f64, y: f64, z: f64| format!("v {x} {y} {z}\n");
    let plate = [(-9.0, -9.0, 0.0), (9.0, -9.0, 0.0), (0.0, 9.0, 0.0), (0.0, 0.0, 0.2)];
    let needle = [(0.1, 0.1, 1.0), (0.2, 0.1, 1.8), (0.1, 0.2, 1.8), (0.0, 0.0, 1.8)];
    let faces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    for (name, corners) in [("plate.obj", plate), ("needle.obj", needle)] {
        let corners: String = corners.iter().map(|&(x, y, z)| corner(x, y, z)).collect();
        workshop.write(name, corners + faces);
    }
    workshop.write(
        "scene.toml",
        "motion = \"down.json\"\n[[body]]\nfile = \"plate.obj\"\nkind = \"rigid\"\n\
         [[body]]\nfile = \"needle.obj\"\nkind = \"rigid\"\n",
    );
    let down = REST.replace("0,0,1,0, 0,0,0,1", "0,0,1,-4, 0,0,0,1");
    workshop.write(
        "down.json",
        format!("{{\"frames\": [{{\"needle\": {REST}}}, {{\"needle\": {down}}}]}}"),
    );
    workshop
}

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("valid JSON")
}

#[test]
fn what_passes_through_between_frames_is_told() {
    let workshop = needle_through_plate();
    let run = workshop.run("motion", &["scene.toml", "--json", "m.json", "--chart", "m.svg"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let step = &json(&workshop, "m.json")["steps"][0];
    assert_eq!(step["overlapping_pairs"], 0, "neither frame shows anything");
    let [pair] = &step["pairs"].as_array().unwrap()[..] else { panic!("one pair: {step}") };
    assert_eq!(pair["unseen_pair"], true);
    assert!(pair["unseen_vertices"].as_u64().unwrap() >= 4, "{pair}");
    // The tip starts 1 over z = 0, where the plate is some 0.19 high, and falls by 4.
    let free = step["largest_free_step"].as_f64().unwrap();
    assert!((0.19..0.21).contains(&free), "{free}");
    assert!(workshop.read("m.svg").starts_with("<svg"), "a picture");
}

#[test]
fn threads_change_no_byte() {
    let workshop = Workshop::new();
    let report = |threads: &str| {
        let run = workshop.run("motion", &[THIGH, "--json", "m.json", "--threads", threads]);
        assert_eq!(run.status, 1, "{}", run.stderr);
        workshop.read("m.json")
    };
    let one = report("1");
    assert_eq!(report("2"), one);
    assert_eq!(report("7"), one);
}

#[test]
fn the_generated_thigh_moves_as_recorded() {
    let workshop = Workshop::new();
    workshop.run("motion", &[THIGH, "--json", "m.json"]);
    let document = json(&workshop, "m.json");
    let steps = document["steps"].as_array().unwrap().iter();
    let lines: Vec<String> = steps
        .map(|step| {
            let number = |field: &str| step[field].as_f64().unwrap();
            format!(
                "frame {:2}: {} overlap, {:.4} mm deep, {} contacts, {:.6} of the step free",
                step["frame"],
                step["overlapping_pairs"],
                step["deepest"]["depth"].as_f64().unwrap(),
                step["contacts"],
                number("largest_free_step"),
            )
        })
        .collect();
    insta::assert_snapshot!(lines.join("\n"));
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let workshop = needle_through_plate();
    workshop.write("still.toml", "[[body]]\nfile = \"plate.obj\"\n");
    workshop.write("empty.json", "");
    workshop.write("one.json", format!("{{\"frames\": [{{\"needle\": {REST}}}]}}"));
    let stretched = REST.replace("[1,0,0,0,", "[2,0,0,0,");
    workshop.write(
        "stretch.json",
        format!("{{\"frames\": [{{\"needle\": {REST}}}, {{\"needle\": {stretched}}}]}}"),
    );
    workshop.write(
        "ulna.json",
        format!("{{\"frames\": [{{\"ulna\": {REST}}}, {{\"ulna\": {REST}}}]}}"),
    );
    let before = workshop.listing();
    let cases = [
        (vec!["still.toml"], "names no motion"),
        (vec!["scene.toml", "--motion", "none.json"], "none.json: cannot be read"),
        (vec!["scene.toml", "--motion", "empty.json"], "empty.json: is not a motion"),
        (vec!["scene.toml", "--motion", "one.json"], "has 1 frames"),
        (vec!["scene.toml", "--motion", "stretch.json"], "\"needle\" of frame 1 is not rigid"),
        (vec!["scene.toml", "--motion", "ulna.json"], "no body follows it: it maps ulna"),
        (vec!["missing.toml"], "missing.toml"),
    ];
    for (mut arguments, expected) in cases {
        arguments.extend(["--json", "m.json"]);
        let run = workshop.run("motion", &arguments);
        assert_eq!(run.status, 2, "{arguments:?}: {}", run.stdout);
        assert!(run.stderr.contains(expected), "{arguments:?}: {}", run.stderr);
        assert_eq!(workshop.listing(), before, "{arguments:?}");
    }
}
