//! Runs of a motion that were interrupted, and go on from a cache.

use crate::motion::needle_through_plate;
use crate::support::Workshop;

const THIGH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/scene.toml");

/// All outputs of a motion, with the frames kept.
const OUTPUTS: &[&str] = &[
    "--cache", "m.frames", "--json", "m.json", "--chart", "m.svg", "--table", "m.csv", "--report",
    "m.html", "--vtp", "vtp",
];

/// Runs a motion with all outputs; returns them, and what is printed.
fn run(workshop: &Workshop, scene: &str) -> Vec<(String, String)> {
    let _ = std::fs::remove_dir_all(workshop.path("vtp"));
    let run = workshop.run("motion", &[&[scene], OUTPUTS].concat());
    assert_eq!(run.status, 1, "{}", run.stderr);

    // All but the line of times.
    let printed: Vec<&str> = run.stdout.lines().filter(|line| !line.contains(" s: load")).collect();
    let mut outputs = vec![("stdout".to_owned(), printed.join("\n"))];
    for name in workshop.listing() {
        let is_output = name.starts_with("m.") || name.starts_with("vtp/");
        if is_output && name != "m.frames" {
            let content = workshop.read(&name);
            outputs.push((name, content));
        }
    }
    assert!(outputs.len() > 8, "{} outputs", outputs.len());
    outputs
}

/// A run goes on after any frame, also where the last line is cut, and writes the same bytes.
#[test]
fn an_interrupted_motion_goes_on() {
    let workshop = Workshop::new();
    let whole = run(&workshop, THIGH);
    let kept = workshop.read("m.frames");
    let lines: Vec<&str> = kept.lines().collect();
    assert!(lines.len() > 12, "{} lines", lines.len());

    for finished in [0, 1, 2, 9, lines.len() - 1] {
        let cut = &lines[finished][..lines[finished].len() / 2];
        let before: String = lines[..finished].iter().map(|line| format!("{line}\n")).collect();
        workshop.write("m.frames", before + cut);
        let resumed = run(&workshop, THIGH);
        for (whole, resumed) in whole.iter().zip(&resumed) {
            assert!(whole == resumed, "{} differs after {finished} lines", whole.0);
        }
        assert_eq!(resumed.len(), whole.len());
        assert_eq!(workshop.read("m.frames"), kept, "after {finished} lines");
    }
}

/// Frames that are kept are not computed again: another value stays.
#[test]
fn kept_frames_are_taken() {
    let workshop = needle_through_plate();
    let arguments = ["scene.toml", "--cache", "m.frames", "--json", "m.json"];
    assert_eq!(workshop.run("motion", &arguments).status, 1);
    let (kept, found) = (workshop.read("m.frames"), workshop.read("m.json"));
    assert!(found.contains("\"passes_through\": true"), "{found}");

    workshop.write("m.frames", kept.replace("\"passes_through\":true", "\"passes_through\":false"));
    assert_eq!(workshop.run("motion", &arguments).status, 1);
    let expected = found.replace("\"passes_through\": true", "\"passes_through\": false");
    assert_eq!(workshop.read("m.json"), expected);
}

#[test]
fn other_caches_are_refused() {
    let workshop = needle_through_plate();
    let arguments = ["scene.toml", "--cache", "m.frames"];
    assert_eq!(workshop.run("motion", &arguments).status, 1);
    let kept = workshop.read("m.frames");
    workshop.write("other.json", workshop.read("down.json") + "\n");
    workshop.write("foreign.frames", "frame,time\n0,0\n");
    workshop.write("damaged.frames", kept.replace("candidates", "candidate5"));
    workshop.write("order.frames", kept.replace("{\"frame\":1", "{\"frame\":2"));
    let inputs = [
        "scene.toml --cache foreign.frames",
        "scene.toml --cache damaged.frames",
        "scene.toml --cache order.frames",
        "scene.toml --cache m.frames --motion other.json",
        "scene.toml --cache down.json",
        "scene.toml --cache new --json new",
        "scene.toml --cache new --resolve apart",
    ];
    insta::assert_snapshot!(workshop.outcomes("motion", &inputs));
}
