//! Replayed motions: contact between frames, outputs, invalid input.

use std::path::PathBuf;

use crate::support::{Workshop, obj};
use fixtures::shapes::{icosphere, plate};
use glam::DVec3;
use serde_json::Value;

const THIGH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/scene.toml");

const REST: &str = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

/// Returns a thin plate in z = 0, and a needle above it that moves down by 4 in one step.
pub(crate) fn needle_through_plate() -> Workshop {
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
fn bodies_that_pass_through_between_frames_are_found() {
    let workshop = needle_through_plate();
    let run = workshop.run("motion", &["scene.toml", "--json", "m.json", "--chart", "m.svg"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let frames = &json(&workshop, "m.json")["frames"];
    assert_eq!(frames.as_array().unwrap().len(), 2, "two states are two frames");
    assert_eq!(frames[0]["step"], Value::Null, "no step leads to the first frame");
    for frame in 0..2 {
        assert_eq!(frames[frame]["overlapping_pairs"], 0, "neither frame shows anything");
    }

    let step = &frames[1]["step"];
    let [pair] = &step["pairs"].as_array().unwrap()[..] else { panic!("one pair: {step}") };
    assert_eq!(pair["passes_through"], true);
    assert!(pair["vertices_passing_through"].as_u64().unwrap() >= 4, "{pair}");
    // The tip starts 1 over z = 0, where the plate is some 0.19 high, and falls by 4.
    let free = step["free_step"].as_f64().unwrap();
    assert!((0.19..0.21).contains(&free), "{free}");
    assert_eq!(step["first_contact"], step["free_step"]);
    assert!(workshop.read("m.svg").starts_with("<svg"), "a picture");
}

/// Writes a motion of the needle along z, a frame per height.
pub(crate) fn write_heights(workshop: &Workshop, name: &str, heights: &[f64]) {
    let frame = |z: &f64| {
        let map = REST.replace("0,0,1,0, 0,0,0,1", &format!("0,0,1,{z}, 0,0,0,1"));
        format!("{{\"needle\": {map}}}")
    };
    let frames: Vec<String> = heights.iter().map(frame).collect();
    workshop.write(name, format!("{{\"frames\": [{}]}}", frames.join(", ")));
}

/// An overlap in the first frame only is counted, shown and decides the exit status.
#[test]
fn the_first_frame_is_reported() {
    let workshop = needle_through_plate();
    write_heights(&workshop, "up.json", &[-0.9, 0.0, 1.0, 2.0, 3.0, 4.0]);
    let arguments = ["scene.toml", "--motion", "up.json", "--json", "m.json", "--chart", "m.svg"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    for part in ["6 frames: overlap in 1, the deepest 0.0", " mm in frame 0; "] {
        assert!(run.stdout.contains(part), "{}", run.stdout);
    }
    let rows: Vec<&str> = run.stdout.lines().skip(1).take(6).collect();
    assert!(rows[0].trim_start().starts_with("0  "), "{}", run.stdout);

    let frames = &json(&workshop, "m.json")["frames"];
    let counts = frames.as_array().unwrap().iter().map(|frame| &frame["overlapping_pairs"]);
    assert_eq!(counts.collect::<Vec<_>>(), [1, 0, 0, 0, 0, 0]);
    assert!(frames[0]["deepest"]["depth"].as_f64().unwrap() > 0.01, "{}", frames[0]);

    // Edges alone have a depth, too.
    write_heights(&workshop, "edges.json", &[-1.2, 0.0]);
    let run = workshop.run("motion", &["scene.toml", "--motion", "edges.json"]);
    let expected = "2 frames: overlap in 1, the deepest 0.";
    assert!(run.stdout.contains(expected) && !run.stdout.contains("0.000 mm"), "{}", run.stdout);
}

/// Pairs that overlap at the start of a step count neither for the first contact nor for the
/// free step.
#[test]
fn the_first_contact_is_the_end_of_the_free_step() {
    let workshop = needle_through_plate();
    write_heights(&workshop, "deeper.json", &[-1.1, -1.3, -3.0, 1.0, -1.2]);
    let arguments = ["scene.toml", "--motion", "deeper.json", "--json", "m.json"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let document = json(&workshop, "m.json");
    let frames = document["frames"].as_array().unwrap();
    let overlapping: Vec<bool> =
        frames.iter().map(|frame| frame["overlapping_pairs"] == 1).collect();

    for (frame, record) in frames.iter().enumerate().skip(1) {
        let step = &record["step"];
        if overlapping[frame - 1] {
            assert_eq!((&step["first_contact"], &step["free_step"]), (&Value::Null, &1.0.into()));
        } else {
            assert!(step["first_contact"].as_f64().unwrap() < 1.0, "frame {frame}: {step}");
            assert_eq!(step["first_contact"], step["free_step"]);
        }
    }
    assert!(overlapping.contains(&true) && overlapping[1..4].contains(&false), "{overlapping:?}");
}

#[test]
fn bodies_at_rest_are_named() {
    let workshop = needle_through_plate();
    let soft = workshop.read("scene.toml") + "[[body]]\nfile = \"needle.obj\"\nname = \"soft\"\n";
    workshop.write("soft.toml", soft);
    let run = workshop.run("motion", &["soft.toml", "--json", "m.json"]);
    for line in [
        "At rest, as no map has their name: plate\n",
        "At rest, as they are soft, and the motion has no skin: soft\n",
    ] {
        assert!(run.stdout.contains(line), "{}{}", run.stdout, run.stderr);
        let plan = workshop.run("plan", &["soft.toml", "--tolerance", "0.1"]);
        assert!(plan.stdout.contains(line), "{}{}", plan.stdout, plan.stderr);
    }
    let resting = &json(&workshop, "m.json")["resting"];
    assert_eq!(resting[1], serde_json::json!({"body": "soft", "reason": "no_skin"}));
}

#[test]
fn every_pair_that_overlaps_in_a_frame_is_listed() {
    let workshop = Workshop::new();
    let run = workshop.run("motion", &[THIGH, "--json", "m.json"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let document = json(&workshop, "m.json");
    let mut most = 0;
    for frame in document["frames"].as_array().expect("frames") {
        let pairs = frame["pairs"].as_array().expect("pairs");
        assert_eq!(frame["overlapping_pairs"], pairs.len(), "{frame}");
        most = most.max(pairs.len());

        let (mut volume, mut deepest) = (0.0, 0.0_f64);
        for pair in pairs {
            volume += pair["overlap"]["volume"].as_f64().expect("a volume");
            for depth in ["depth_of_a_in_b", "depth_of_b_in_a"] {
                deepest = deepest.max(pair[depth]["lower"].as_f64().unwrap_or_default());
            }
        }
        assert_eq!(frame["volume"], volume, "{frame}");
        if !pairs.is_empty() {
            assert_eq!(frame["deepest"]["depth"], deepest, "{frame}");
        }
    }
    assert!(most > 1, "one pair shows nothing");
}

#[test]
fn threads_change_no_byte() {
    let workshop = Workshop::new();
    let report = |threads: &str| {
        let run = workshop.run("motion", &[THIGH, "--json", "m.json", "--threads", threads]);
        assert_eq!(run.status, 1, "{}", run.stderr);
        workshop.read("m.json")
    };
    assert_eq!(report("7"), report("1"));
}

#[test]
fn the_generated_thigh_moves_as_recorded() {
    let workshop = Workshop::new();
    workshop.run("motion", &[THIGH, "--json", "m.json"]);
    let document = json(&workshop, "m.json");
    let frames = document["frames"].as_array().unwrap().iter();
    let lines: Vec<String> = frames
        .map(|frame| {
            format!(
                "frame {:2}: {} overlap, {:.4} mm deep, {} contacts, {:.6} of the step free",
                frame["frame"],
                frame["overlapping_pairs"],
                frame["deepest"]["depth"].as_f64().unwrap(),
                frame["step"]["contacts"],
                frame["step"]["free_step"].as_f64().unwrap_or(f64::NAN),
            )
        })
        .collect();
    insta::assert_snapshot!(lines.join("\n"));
}

#[test]
fn invalid_input_is_named_and_nothing_is_written() {
    let workshop = needle_through_plate();
    workshop.write("still.toml", "[[body]]\nfile = \"plate.obj\"\n");
    let frames = |frames: &str| format!("{{\"frames\": [{frames}]}}").replace("REST", REST);
    let files = [
        ("empty.json", String::new()),
        ("one.json", frames("{\"needle\": REST}")),
        (
            "stretch.json",
            frames("{\"needle\": REST}, {\"needle\": REST}").replacen("[1,0", "[2,0", 1),
        ),
        ("ulna.json", frames("{\"ulna\": REST}, {\"ulna\": REST}")),
        (
            "spelling.json",
            frames("{\"needle\": REST, \"pate\": REST}, {\"needle\": REST, \"pate\": REST}"),
        ),
        ("short.json", frames("{\"needle\": REST}, {\"needle\": [1,0,0,0, 0,1,0,0]}")),
        ("text.json", frames("{\"t\": \"0 s\", \"needle\": REST}, {\"needle\": REST}")),
        ("equal.json", frames("{\"t\": 0.1, \"needle\": REST}, {\"t\": 0.1, \"needle\": REST}")),
        ("falling.json", frames("{\"t\": 0.1, \"needle\": REST}, {\"t\": 0, \"needle\": REST}")),
        ("twice.json", frames("{\"needle\": REST, \"needle\": REST}, {\"needle\": REST}")),
    ];
    let mut inputs = vec!["still.toml".to_owned(), "missing.toml".to_owned()];
    inputs.push("scene.toml --motion none.json --json m.json".to_owned());
    for (name, content) in &files {
        workshop.write(name, content);
        inputs.push(format!("scene.toml --motion {name} --json m.json"));
    }
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    insta::assert_snapshot!(workshop.outcomes("motion", &inputs));
}

/// Returns the files of all bodies in one frame.
fn frame_files(workshop: &Workshop, folder: &str, frame: usize) -> Vec<String> {
    let end = format!("_{frame:04}.vtp");
    let files = workshop.listing().into_iter();
    files.filter(|name| name.starts_with(folder) && name.ends_with(&end)).collect()
}

#[test]
fn every_frame_is_pushed_apart() {
    let workshop = Workshop::new();
    let run = workshop.run("motion", &[THIGH, "--resolve", "apart", "--json", "m.json"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let document = json(&workshop, "m.json");
    let frames = document["frames"].as_array().unwrap();
    assert!(frames.len() > 2, "{run}", run = run.stdout);
    for (number, frame) in frames.iter().enumerate() {
        assert!(frame["before"]["pairs"].as_u64().unwrap() > 0, "{frame}");
        assert!(frame["max_volume_change"].as_f64().unwrap() < 0.01, "{frame}");
        assert_eq!((&frame["new_pairs"], &frame["flipped_faces"]), (&0.into(), &0.into()));
        // The same from the files.
        let files = frame_files(&workshop, "apart/", number);
        assert_eq!(files.len(), 8, "one for each body");
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        let check = workshop.check(&[&files[..], &["--json", "c.json"]].concat());
        let report = json(&workshop, "c.json");
        let depth = |pair: &Value| pair["max_vertex_depth"].as_f64().unwrap();
        let deepest = report["pairs"].as_array().unwrap().iter().map(depth).fold(0.0, f64::max);
        assert!(deepest <= 0.05, "frame {number}: {deepest} left, {}", check.stdout);
    }
    let rounds = frames.iter().map(|frame| frame["rounds"].as_u64().unwrap());
    assert!(rounds.clone().all(|rounds| rounds <= 12), "{:?}", rounds.collect::<Vec<_>>());
}

#[test]
fn resolved_frames_are_the_same_bytes_for_any_number_of_threads() {
    let workshop = Workshop::new();
    let files = |threads: &str| {
        let folder = format!("apart{threads}");
        workshop.run("motion", &[THIGH, "--resolve", &folder, "--threads", threads]);
        let names = workshop.listing().into_iter().filter(|name| name.starts_with(&folder));
        let contents = names.filter(|name| name.ends_with(".vtp")).map(|name| workshop.read(&name));
        contents.collect::<Vec<_>>()
    };
    let one = files("1");
    assert!(!one.is_empty() && one == files("3"));
}

/// A muscle between two bones that leave less room than it is thick, and which it is tied to; one of them is away in
/// the second frame.
#[test]
fn what_holds_a_body_that_does_not_come_apart_is_named() {
    let workshop = Workshop::new();
    let mut scene = "motion = \"up.json\"\n".to_owned();
    for (name, height, kind) in
        [("lower", -1.7, "rigid"), ("muscle", 0.0, "deformable"), ("upper", 0.35, "rigid")]
    {
        let slab = plate(DVec3::new(12.0, 12.0, 2.0), [6; 2]).translated(height * DVec3::Z);
        workshop.write(&format!("{name}.obj"), obj(&slab));
        scene += &format!("[[body]]\nfile = \"{name}.obj\"\nkind = \"{kind}\"\n");
    }
    scene += "[[tie]]\na = \"lower\"\nb = \"muscle\"\nwithin = 0.5\n";
    workshop.write("tied.toml", scene);
    let up = REST.replace("0,0,1,0, 0,0,0,1", "0,0,1,9, 0,0,0,1");
    workshop
        .write("up.json", format!("{{\"frames\": [{{\"upper\": {REST}}}, {{\"upper\": {up}}}]}}"));

    let arguments = ["tied.toml", "--resolve", "apart", "--gap", "0.05", "--json", "m.json"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let line = "muscle is tied to lower: what is held there cannot give way.\n";
    assert!(run.stdout.contains(line), "{}", run.stdout);
    let document = json(&workshop, "m.json");
    let resolved = |frame: usize| document["frames"][frame]["resolved"].as_bool().unwrap();
    assert_eq!([resolved(0), resolved(1)], [false, true], "{document}");
    assert_eq!(document["attachments"][0]["tied_to"][0], "lower", "{document}");
    assert_eq!(document["attachments"].as_array().unwrap().len(), 1, "{document}");
}

/// A bone presses a sheet down, is far below it in the next frame, a little higher in one more, and gone in the last.
#[test]
fn frames_that_do_not_go_on_from_the_one_before_are_named() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", obj(&icosphere(5.0, 3)));
    workshop.write("sheet.obj", obj(&plate(DVec3::new(60.0, 60.0, 2.0), [24; 2])));
    workshop.write(
        "scene.toml",
        "motion = \"down.json\"\n[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n\
         [[body]]\nfile = \"sheet.obj\"\nkind = \"deformable\"\n",
    );
    let frames = [3.0, -3.0, -2.75, 30.0].map(|height| {
        let pose = REST.replace("0,0,1,0, 0,0,0,1", &format!("0,0,1,{height}, 0,0,0,1"));
        format!("{{\"bone\": {pose}}}")
    });
    workshop.write("down.json", format!("{{\"frames\": [{}]}}", frames.join(", ")));
    let arguments = ["scene.toml", "--resolve", "apart", "--gap", "0.1", "--json", "m.json"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let document = json(&workshop, "m.json");
    let anew = |frame: usize| document["frames"][frame]["starts_anew"].as_bool();
    let expected = [false, true, false, false].map(Some);
    assert_eq!([0, 1, 2, 3].map(anew), expected, "{}", run.stdout);
    let line = "frame 1: starts anew, without the displacements of the frame before";
    assert_eq!(run.stdout.matches("starts anew").count(), 1, "{}", run.stdout);
    assert!(run.stdout.contains(line), "{}", run.stdout);
}

/// The needle is 0.806 above the plate, then 0.306. Both are rigid.
#[test]
fn frames_that_fall_short_of_the_gap_are_named_and_marked() {
    let workshop = needle_through_plate();
    write_heights(&workshop, "near.json", &[0.0, -0.5]);
    let arguments = ["scene.toml", "--motion", "near.json", "--resolve", "apart", "--gap"];
    let run = workshop.run("motion", &[&arguments[..], &["0.5", "--json", "m.json"]].concat());
    assert_eq!(run.status, 1, "{}", run.stdout);
    let line = "frame 1: plate × needle: 0.306 mm apart: both are rigid, and neither moves; [[ignore]] in a scene \
                file leaves the pair out\n";
    assert!(run.stdout.contains(line), "{}", run.stdout);
    assert!(run.stdout.contains("have '_unproved' in their names"), "{}", run.stdout);

    let document = json(&workshop, "m.json");
    assert_eq!((&document["resolved"], &document["gap"]), (&false.into(), &0.5.into()));
    let short = |frame: usize| document["frames"][frame]["short_gaps"].as_array().unwrap().len();
    assert_eq!([short(0), short(1)], [0, 1], "{document}");
    let series = workshop.read("apart/frames.pvd");
    for file in ["needle_0000.vtp", "plate_0000.vtp", "needle_0001_unproved.vtp"] {
        assert!(series.contains(&format!("\"{file}\"")), "{series}");
        assert!(workshop.read(&format!("apart/{file}")).contains("</VTKFile>"), "{file}");
    }

    let run = workshop.run("motion", &[&arguments[..], &["0.1"]].concat());
    assert_eq!(run.status, 0, "{}", run.stdout);
    let line = "The gap of 0.1000 mm is proved in every frame for all pairs, faces and edges";
    assert!(run.stdout.contains(line), "{}", run.stdout);
}

#[test]
fn resolving_and_charting_exclude_each_other() {
    let workshop = needle_through_plate();
    let run = workshop.run("motion", &["scene.toml", "--resolve", "apart", "--chart", "m.svg"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    assert!(run.stderr.contains("--chart"), "{}", run.stderr);
    assert!(!workshop.listing().contains(&"apart".to_owned()));
    let run = workshop.run("motion", &["scene.toml", "--resolve", "apart", "--gap", "-1"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    assert!(run.stderr.contains("gap is -1"), "{}", run.stderr);
    assert!(!workshop.listing().contains(&"apart".to_owned()));
}

/// The frames of the gait where femur and pelvis close on the muscles between them, or all
/// frames where `MUSCULO_ALL_STEPS` is set.
#[test]
#[expect(clippy::print_stdout, reason = "the test prints what it skips or measures")]
fn frames_of_the_gait_are_pushed_apart() {
    let Some(data) = std::env::var_os("MUSCULO_DATA").map(PathBuf::from) else {
        println!("skipped: MUSCULO_DATA names no folder of anatomy");
        return;
    };
    let workshop = Workshop::new();
    let all = std::env::var_os("MUSCULO_ALL_STEPS").is_some();
    workshop.write("gait.json", gait(&data, if all { 0..73 } else { 34..38 }));
    workshop.write("scene.toml", thigh_scene(&data));
    let arguments = ["scene.toml", "--motion", "gait.json", "--resolve", "apart"];
    let run = workshop.run("motion", &[&arguments[..], &["--json", "m.json"]].concat());
    let frames = &json(&workshop, "m.json")["frames"];
    let frames = frames.as_array().expect("frames");
    let worst = |of: &dyn Fn(&Value) -> f64| frames.iter().map(of).fold(0.0, f64::max);
    let deepest = worst(&|frame| frame["after"]["deepest"].as_f64().unwrap());
    let new = worst(&|frame| frame["new_pairs"].as_f64().unwrap());
    let volume = worst(&|frame| frame["max_volume_change"].as_f64().unwrap());
    let flipped = worst(&|frame| frame["flipped_faces"].as_f64().unwrap());
    let crossed = worst(&|frame| {
        let [before, after] = [0, 1].map(|when| frame["self_crossings"][when].as_f64().unwrap());
        after - before
    });
    let rounds = worst(&|frame| frame["rounds"].as_f64().unwrap());
    let which = if all { "gait" } else { "four frames of the gait" };
    println!("measured: {which}: deepest overlap left [mm] | {deepest:.3} | 0.1");
    println!("measured: {which}: overlaps that are new | {new} | 0");
    println!("measured: {which}: change of a muscle's volume [%] | {:.2} | 1", 100.0 * volume);
    println!("measured: {which}: faces turned over, of a frame | {flipped} | 0");
    println!("measured: {which}: new self-crossings, of a frame | {crossed} | 0");
    println!("measured: {which}: rounds, of a frame | {rounds} | 60");
    let sound = new == 0.0 && flipped == 0.0 && crossed == 0.0;
    assert!(deepest <= 0.1 && volume <= 0.01 && sound, "{}", run.stdout);
}

/// The first frame has muscles 12 mm deep between femur and pelvis, without a frame before
/// it, and six rounds do not free them: remaining overlaps are named with the reason.
#[test]
#[expect(clippy::print_stdout, reason = "the test prints what it skips")]
fn a_motion_that_begins_too_deep_names_remaining_overlaps() {
    let Some(data) = std::env::var_os("MUSCULO_DATA").map(PathBuf::from) else {
        println!("skipped: MUSCULO_DATA names no folder of anatomy");
        return;
    };
    let workshop = Workshop::new();
    workshop.write("gait.json", gait(&data, 53..55));
    workshop.write("scene.toml", thigh_scene(&data));
    let arguments = ["scene.toml", "--motion", "gait.json", "--resolve", "apart", "--rounds", "6"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}", run.stdout);
    let pair = "bone_pelvis × muscle_adductor_magnus";
    assert!(run.stdout.contains(pair), "{}", run.stdout);
    let reason = "separating them further breaks the limits of a body";
    assert!(run.stdout.contains(reason), "{}", run.stdout);
    assert!(!run.stdout.contains(" 0 not resolved"), "{}", run.stdout);
}

/// Returns a motion file of some frames of the gait, with a skin from shank to thigh to pelvis.
pub(crate) fn gait(data: &std::path::Path, frames: impl IntoIterator<Item = usize>) -> String {
    let path = data.join("anatomy/motions/gait_walk.json");
    let text = std::fs::read_to_string(path).expect("a motion");
    let mut gait: Value = serde_json::from_str(&text).expect("JSON");
    let frames: Vec<Value> =
        frames.into_iter().map(|frame| gait["frames"][frame].clone()).collect();
    gait["frames"] = frames.into();
    let height = |joint: &str| gait["ambient_skin"][joint].as_f64().expect("a height");
    let (hip, knee) = (height("hip_z"), height("knee_z"));
    gait["skin"] = serde_json::json!({
        "axis": [0, 0, 1],
        "segments": ["tibia", "femur", null],
        "blends": [[knee - 40.0, knee + 40.0], [hip - 50.0, hip + 50.0]],
    });
    gait.to_string()
}

/// Returns a scene file of the decimated thigh, with bones recognized by their names.
pub(crate) fn thigh_scene(data: &std::path::Path) -> String {
    let entries = std::fs::read_dir(data.join("anatomy/vhf_left_thigh_lo")).expect("meshes");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let body = |path: &PathBuf| {
        let rigid = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("bone"));
        let kind = if rigid { "rigid" } else { "deformable" };
        format!("[[body]]\nfile = {path:?}\nkind = \"{kind}\"\n")
    };
    paths.iter().map(body).collect()
}

/// Bodies that coincide are as deep as rounding makes them; that is no depth to a reader.
#[test]
fn depths_of_rounding_are_zero() {
    let workshop = needle_through_plate();
    let cube = obj(&fixtures::shapes::cube(10.0));
    workshop.write("plate.obj", &cube);
    workshop.write("needle.obj", &cube);
    write_heights(&workshop, "up.json", &[0.0, 20.0]);
    let run = workshop.run("motion", &["scene.toml", "--motion", "up.json", "--json", "m.json"]);
    assert!(run.stdout.contains("the deepest 0 mm in frame 0"), "{}", run.stdout);
    let frame = &json(&workshop, "m.json")["frames"][0];
    assert!(frame["deepest"]["depth"].as_f64().unwrap() < 1e-12, "{frame}");
}
