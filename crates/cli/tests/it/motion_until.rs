//! First contacts of pairs in a motion.

use serde_json::Value;

use crate::motion::{needle_through_plate, write_heights};

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// The needle comes down in three steps, and meets the plate in the last one, where the sweep of that
/// step alone has it.
#[test]
fn the_first_contact_is_found_in_its_step() {
    let workshop = needle_through_plate();
    write_heights(&workshop, "far.json", &[3.0, 2.0, 0.0, -4.0]);
    let arguments = ["scene.toml", "--motion", "far.json", "--until-contact", "--json", "u.json"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(run.stdout.contains("free to frame 2 + 0.2"), "{}", run.stdout);

    workshop.run("motion", &["scene.toml", "--json", "step.json"]);
    let step = json(&workshop.read("step.json"))["frames"][1]["step"]["first_contact"].clone();
    let found = json(&workshop.read("u.json"));
    let [contact] = &found["contacts"].as_array().expect("a list")[..] else { panic!("{found}") };
    assert_eq!((&contact["frame"], &contact["time"]), (&2.into(), &Value::Null));
    let [expected, fraction] = [&step, &contact["fraction"]].map(|t| t.as_f64().expect("a number"));
    assert!((expected - fraction).abs() < 1e-9, "{fraction} for {expected}");

    // The tip, at the height of the plate there.
    let at: Vec<f64> = contact["at"].as_array().unwrap().iter().flat_map(Value::as_f64).collect();
    let height = 1.0 - 4.0 * fraction;
    assert!((at[0] - 0.1).abs() < 1e-6 && (at[1] - 0.1).abs() < 1e-6, "{at:?}");
    assert!((at[2] - height).abs() < 1e-6 && (0.1..0.25).contains(&height), "{at:?}");
}

/// Neither a pair that overlaps from the start nor a motion without contact is a failure.
#[test]
fn no_contact_is_no_failure() {
    let workshop = needle_through_plate();
    write_heights(&workshop, "deep.json", &[-1.2, -3.0, -1.2]);
    write_heights(&workshop, "free.json", &[0.0, 4.0, 0.5]);
    let run = |motion: &str| {
        let run = workshop.run("motion", &["scene.toml", "--motion", motion, "--until-contact"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        run.stdout
    };
    let overlapping = "Overlapping from the start, without a first contact: plate × needle";
    assert!(run("deep.json").contains(overlapping));
    assert!(run("free.json").starts_with("free to the end; 0 pairs first met"));

    let other = workshop.run("motion", &["scene.toml", "--until-contact", "--chart", "m.svg"]);
    assert_eq!(other.status, 2, "{}", other.stdout);
}

/// Times below the decimals of the table are rounded down, and not to 0.
#[test]
fn short_times_are_not_written_as_zero() {
    let workshop = needle_through_plate();
    let motion = workshop.read("down.json").replace("{\"needle\"", "{\"t\": T, \"needle\"");
    let times = motion.replacen('T', "0", 1).replacen('T', "4e-6", 1);
    workshop.write("down.json", times);
    let run = workshop.run("motion", &["scene.toml", "--until-contact", "--json", "u.json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let time = &json(&workshop.read("u.json"))["contacts"][0]["time"];
    assert!((7.9e-7..8.1e-7).contains(&time.as_f64().expect("a time")), "{time}");
    assert!(
        run.stdout.contains(" 0.0000008 ") || run.stdout.contains(" 0.0000007 "),
        "{}",
        run.stdout
    );
}

/// A needle that turns as it comes down does so about its middle, of which a reference node far away is no part.
#[test]
fn vertices_without_a_face_change_no_way() {
    let workshop = needle_through_plate();
    let screw = "[0,-1,0,0, 1,0,0,0, 0,0,1,-4, 0,0,0,1]";
    let rest = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";
    let frames = format!("{{\"frames\": [{{\"needle\": {rest}}}, {{\"needle\": {screw}}}]}}");
    workshop.write("down.json", frames);
    let needle = workshop.read("needle.obj");
    let contact = || {
        let run = workshop.run("motion", &["scene.toml", "--until-contact", "--json", "u.json"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        let found = json(&workshop.read("u.json"));
        found["contacts"][0]["fraction"].as_f64().expect("a contact")
    };
    let expected = contact();
    workshop.write("needle.obj", needle.replace("f 1 3 2", "v 500 0 0\nf 1 3 2"));
    let found = contact();
    assert!((found - expected).abs() < 1e-9, "{found} in place of {expected}");
}
