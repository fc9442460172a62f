//! Motions that are tables of poses, and the tables and series that replays write.

use crate::motion::needle_through_plate;
use crate::support::Workshop;
use serde_json::Value;

/// The needle of the scene 4 lower in the second row, by OpenSim's columns.
const DOWN: &str = "Positions\nnRows=2\ninDegrees=yes\nendheader\n\
    time n_X n_Y n_Z n_Ox n_Oy n_Oz\n0 0 0 0.5 90 0 0\n0.25 0 0 0.496 90 0 0\n";

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("valid JSON")
}

/// Rows of a long table: subject, frame, time, pair, measure, value.
fn rows(workshop: &Workshop, name: &str) -> Vec<Vec<String>> {
    let text = workshop.read(name);
    let mut lines = text.lines();
    let columns = lines.next().unwrap_or_default();
    assert_eq!(columns, "subject,frame,time,a,b,measure,value", "the columns of {name}");
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Meters and degrees of OpenSim, the rows of a camera, and maps from rest in the scene's
/// millimeters are one motion.
#[test]
fn tables_of_poses_replay_as_maps_do() {
    let workshop = needle_through_plate();
    workshop.write("down.sto", DOWN);
    workshop.write(
        "down.csv",
        "time,body,qw,qx,qy,qz,x,y,z\n0,n,0,1,0,0,0,0,7\n0.25,n,0,1,0,0,0,0,3\n",
    );
    for (old, file) in [("old.sto", "down.sto"), ("old.csv", "down.csv")] {
        workshop.write(old, workshop.read(file).replace('\n', "\r"));
    }
    workshop.run("motion", &["scene.toml", "--json", "maps.json"]);
    let maps = json(&workshop, "maps.json");
    let expected = maps["frames"][1]["step"]["free_step"].as_f64().expect("a number");

    for file in ["down.sto", "down.csv", "old.sto", "old.csv"] {
        let arguments =
            ["scene.toml", "--motion", file, "--follow", "needle=n", "--json", "m.json"];
        let run = workshop.run("motion", &arguments);
        assert_eq!(run.status, 1, "{}", run.stderr);
        let step = &json(&workshop, "m.json")["frames"][1]["step"];
        let free = step["free_step"].as_f64().expect("a number");
        assert!((free - expected).abs() < 1e-9, "{file}: {free} for {expected}");
        assert_eq!(step["pairs"][0]["passes_through"], true);
    }

    // In the frames of bodies, positions of mass centers are no origins, as those of a camera may be.
    for (file, meshes, is_warned) in
        [("down.sto", "body", true), ("down.sto", "first-pose", false), ("down.csv", "body", false)]
    {
        let arguments =
            ["scene.toml", "--motion", file, "--follow", "needle=n", "--meshes", meshes];
        let run = workshop.run("motion", &arguments);
        let warning = "down.sto: its positions are taken for the origins of bodies";
        assert_eq!(run.stderr.contains(warning), is_warned, "{file} {meshes}: {}", run.stderr);
    }

    // The scene file may have the name instead; lengths in another unit are another motion.
    let follows = workshop
        .read("scene.toml")
        .replace("file = \"needle.obj\"\n", "file = \"needle.obj\"\nfollows = \"n\"\n");
    workshop.write("follows.toml", follows.replace("down.json", "down.sto"));
    assert_eq!(workshop.run("motion", &["follows.toml"]).status, 1);
    workshop.write("old.toml", workshop.read("follows.toml").replace('\n', "\r"));
    assert_eq!(workshop.run("motion", &["old.toml"]).status, 1);
    let run = workshop.run("motion", &["follows.toml", "--motion-unit", "mm"]);
    assert_eq!(run.status, 0, "a move of 0.004: {}", run.stdout);
}

#[test]
fn options_without_effect_are_refused() {
    let workshop = needle_through_plate();
    for (options, expected) in [
        (&["--motion-unit", "m"][..], "--motion-unit is for tables of poses"),
        (&["--meshes", "body"], "--meshes is for tables of poses"),
        (
            &["--follow", "needle=needle", "--follow", "needle=n"],
            "needle follows both \"needle\" and \"n\"",
        ),
        (&["--gap", "0.05"], "--resolve <DIR>"),
        (&["--max-strain", "2"], "--resolve <DIR>"),
        (&["--rounds", "60"], "--resolve <DIR>"),
    ] {
        let run = workshop.run("motion", &[&["scene.toml"], options].concat());
        assert_eq!(run.status, 2, "{options:?}: {}", run.stderr);
        assert!(run.stderr.contains(expected), "{options:?}: {}", run.stderr);
    }
}

#[test]
fn wrong_tables_are_named_and_nothing_is_written() {
    let workshop = needle_through_plate();
    workshop.write("down.sto", DOWN);
    workshop.write("cut.sto", DOWN.replace("nRows=2", "nRows=200"));
    workshop.write("angles.mot", "inDegrees=yes\nendheader\ntime knee_angle_r\n0 1\n1 2\n");
    workshop.write("word.csv", "time,body,qw,qx,qy,qz,x,y,z\n0,n,1,0,0,0,0,zero,0\n");
    workshop.write("one.csv", "time,body,qw,qx,qy,qz,x,y,z\n0,needle,1,0,0,0,0,0,0\n");
    workshop.write(
        "gap.csv",
        "time,body,qw,qx,qy,qz,x,y,z\n0,needle,1,0,0,0,0,0,0\n1,n,1,0,0,0,0,0,0\n",
    );
    let inputs = [
        "scene.toml --motion down.sto --json m.json",
        "scene.toml --motion down.sto --follow needle --json m.json",
        "scene.toml --motion down.sto --follow needle=m --json m.json",
        "scene.toml --motion down.sto --follow nedle=n --json m.json",
        "scene.toml --motion cut.sto --follow needle=n --json m.json",
        "scene.toml --motion angles.mot --json m.json",
        "scene.toml --motion word.csv --json m.json",
        "scene.toml --motion one.csv --json m.json",
        "scene.toml --motion gap.csv --json m.json",
    ];
    insta::assert_snapshot!(workshop.outcomes("motion", &inputs));
}

/// Line ends of three systems, comments and blank lines change neither a table nor the lines that
/// errors name.
#[test]
fn line_ends_of_tables_do_not_matter() {
    let workshop = needle_through_plate();
    let rows = "time,body,qw,qx,qy,qz,x,y,z\n# rest\n\n0,needle,0,1,0,0,0,0,7\n# down\n\
        0.25,needle,0,1,0,0,0,0,3\n";
    let wrong = [
        ("word.csv", rows.replace("0,3\n", "0,low\n"), "line 6, column 'z': 'low'"),
        ("short.csv", rows.replace("0,3\n", "3\n"), "line 6 has 8 columns, but 9 are declared"),
    ];
    for end in ["\n", "\r\n", "\r"] {
        workshop.write("down.csv", rows.replace('\n', end));
        workshop.write("down.sto", DOWN.replace('\n', end));
        for file in [&["down.csv"][..], &["down.sto", "--follow", "needle=n"]] {
            let run = workshop.run("motion", &[&["scene.toml"], file].concat());
            assert_eq!(run.status, 1, "{file:?} {end:?}: {}{}", run.stdout, run.stderr);
        }
        for (file, text, expected) in &wrong {
            workshop.write(file, text.replace('\n', end));
            workshop.refuses("motion", &[(&["scene.toml", file], expected)], &["--json", "m.json"]);
        }
    }
}

#[test]
fn poses_that_move_no_body_or_too_far_are_named() {
    let workshop = needle_through_plate();
    let rows = "time,body,qw,qx,qy,qz,x,y,z\n0,needle,1,0,0,0,0,0,0\n0,,1,0,0,0,0,0,0\n\
        1,needle,1,0,0,0,0,0,0\n1,,1,0,0,0,0,0,9\n";
    workshop.write("unnamed.csv", rows);
    workshop.write("more.csv", rows.replace(",,", ",knee,"));
    workshop.write("far.sto", DOWN.replace("0.25 0 0", "0.25 1e307 0"));
    workshop.write("far.json", workshop.read("down.json").replace("-4", "-4e200"));
    let cases: [(&[&str], &str); 4] = [
        (&["scene.toml", "unnamed.csv"], "unnamed.csv: map \"\" moves no body"),
        (
            &["scene.toml", "more.csv"],
            "let a body follow it (--follow), or leave it out of the table",
        ),
        (&["scene.toml", "far.sto", "--follow", "needle=n"], "far.sto: map \"n\" of frame 1 moves"),
        (&["scene.toml", "far.json"], "far.json: map \"needle\" of frame 1 moves"),
    ];
    workshop.refuses("motion", &cases, &["--json", "m.json"]);
}

/// All numbers of the JSON stand in the table, with the same digits.
#[test]
fn a_check_writes_its_numbers_as_a_long_table() {
    let workshop = needle_through_plate();
    let arguments = ["plate.obj", "needle.obj", "--margin", "5"];
    let table = ["--json", "c.json", "--table", "c.csv", "--subject", "p07"];
    let run = workshop.check(&[&arguments[..], &table[..]].concat());
    assert_eq!(run.status, 0, "{}", run.stderr);

    let pair = &json(&workshop, "c.json")["pairs"][0];
    let rows = rows(&workshop, "c.csv");
    for row in &rows {
        assert_eq!(row[..5], ["p07", "0", "", "plate", "needle"]);
        let path = format!("/{}", row[5].replace('.', "/"));
        let expected = match pair.pointer(&path) {
            Some(Value::Bool(holds)) => u8::from(*holds).to_string(),
            Some(value) => value.to_string(),
            None => panic!("{path} is not in {pair}"),
        };
        assert_eq!(row[6], expected, "{path}");
    }
    for measure in ["distance", "min_gap", "overlaps", "near_area_of_a.lower"] {
        assert!(rows.iter().any(|row| row[5] == measure), "{measure} of {rows:?}");
    }

    // Without a subject, the first input is one.
    workshop.check(&[&arguments[..], &["--table", "c.csv"]].concat());
    assert!(workshop.read("c.csv").contains("\nplate.obj,0,,plate,needle,distance,"));
}

/// The frame that overlaps and the step that passes through are in the table, and ParaView's list
/// names every file that was written.
#[test]
fn a_motion_writes_a_table_and_a_series() {
    let workshop = needle_through_plate();
    let heights = "time,body,qw,qx,qy,qz,x,y,z\n0,needle,1,0,0,0,0,0,0\n\
                   0.5,needle,1,0,0,0,0,0,-4\n1,needle,1,0,0,0,0,0,-0.9\n";
    workshop.write("heights.csv", heights);
    let arguments =
        ["scene.toml", "--motion", "heights.csv", "--table", "t.csv", "--vtp", "frames"];
    let run = workshop.run("motion", &[&arguments[..], &["--json", "m.json"]].concat());
    assert_eq!(run.status, 1, "{}", run.stderr);

    let rows = rows(&workshop, "t.csv");
    let value = |frame: &str, measure: &str| {
        let row = rows.iter().find(|row| row[1] == frame && row[5] == measure);
        row.map(|row| (row[2].as_str(), row[6].parse::<f64>().expect("a number")))
    };
    assert_eq!(value("1", "passes_through"), Some(("0.5", 1.0)));
    assert_eq!(value("1", "overlaps"), None, "frame 1 is free");
    assert_eq!(value("2", "overlaps"), Some(("1", 1.0)));
    let depth = json(&workshop, "m.json")["frames"][2]["deepest"]["depth"].as_f64();
    let deepest = ["depth_of_a_in_b.lower", "depth_of_b_in_a.lower"]
        .map(|measure| value("2", measure).map_or(0.0, |(_, depth)| depth));
    assert_eq!(Some(deepest[0].max(deepest[1])), depth);

    let list = workshop.read("frames/frames.pvd");
    let written = workshop.listing().into_iter();
    let files: Vec<String> =
        written.filter_map(|name| name.strip_prefix("frames/").map(str::to_owned)).collect();
    assert_eq!(files.len(), 2 * 3 + 1, "{files:?}");
    for file in files.iter().filter(|file| file.ends_with(".vtp")) {
        let frame: usize = file[file.len() - 8..file.len() - 4].parse().expect("a number");
        let entry = format!("timestep=\"{}\"", [0.0, 0.5, 1.0][frame]);
        let line = list.lines().find(|line| line.contains(&format!("file=\"{file}\"")));
        assert!(line.expect("a listed file").contains(&entry), "{file} in {list}");
    }

    // With joint contact its faces are parts of the series, too.
    let joint = ["--joint-contact", "2", "--vtp", "joint"];
    workshop.run("motion", &[&arguments[..3], &joint[..]].concat());
    assert!(workshop.read("joint/frames.pvd").contains("_on_"), "{:?}", workshop.listing());
}

/// The scene as an OpenSim model: the needle's file has half its size and hangs on an offset frame,
/// and its mass center is not the origin of its body.
const MODEL: &str = "<OpenSimDocument Version=\"40000\"><Model name=\"m\"><BodySet><objects>\
    <Body name=\"base\"><attached_geometry><Mesh><mesh_file>plate.obj</mesh_file></Mesh>\
    </attached_geometry></Body>\
    <Body name=\"n\"><mass_center>0.3 0 0.4</mass_center><components>\
    <PhysicalOffsetFrame name=\"o\"><translation>0 -5 0</translation>\
    <orientation>-1.5707963267948966 0 0</orientation><attached_geometry><Mesh>\
    <scale_factors>2 2 2</scale_factors><mesh_file>needle_half.obj</mesh_file></Mesh>\
    </attached_geometry></PhysicalOffsetFrame></components></Body>\
    <Body name=\"lost\"><attached_geometry><Mesh><mesh_file>lost.vtp</mesh_file></Mesh>\
    </attached_geometry></Body></objects></BodySet></Model></OpenSimDocument>";

/// Both bodies by the positions of their mass centers, in an order of its own.
const MODEL_DOWN: &str = "Positions\ninDegrees=yes\nendheader\n\
    n_Oz n_Oy n_Ox time n_Z n_Y n_X base_X base_Y base_Z base_Ox base_Oy base_Oz\n\
    0 0 90 0 5 -0.4 0.3 0 0 0 0 0 0\n0 0 90 0.25 1 -0.4 0.3 0 0 0 0 0 0\n";

/// Writes the model with its meshes and its motion.
fn model_of_needle() -> Workshop {
    let workshop = needle_through_plate();
    let half = |line: &str| match line.strip_prefix("v ") {
        Some(vertex) => {
            let numbers = vertex.split(' ').map(|x| 0.5 * x.parse::<f64>().expect("a number"));
            let words: Vec<String> = numbers.map(|x| x.to_string()).collect();
            format!("v {}\n", words.join(" "))
        }
        None => format!("{line}\n"),
    };
    let needle: String = workshop.read("needle.obj").lines().map(half).collect();
    std::fs::create_dir(workshop.path("Geometry")).expect("a folder");
    workshop.write("Geometry/needle_half.obj", needle);
    workshop.write("leg.osim", MODEL);
    workshop.write("leg.sto", MODEL_DOWN);
    workshop
}

#[test]
fn a_model_and_its_kinematics_are_a_motion() {
    let workshop = model_of_needle();
    workshop.run("motion", &["scene.toml", "--json", "maps.json"]);
    let maps = json(&workshop, "maps.json");
    let expected = maps["frames"][1]["step"]["free_step"].as_f64().expect("a number");

    let run = workshop.run("motion", &["leg.osim", "leg.sto", "--json", "m.json"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let report = json(&workshop, "m.json");
    let step = &report["frames"][1]["step"];
    let free = step["free_step"].as_f64().expect("a number");
    assert!((free - expected).abs() < 1e-9, "{free} for {expected}");
    let pair = &step["pairs"][0];
    assert_eq!((&pair["a"], &pair["b"]), (&"base".into(), &"n".into()));
    assert_eq!((&pair["passes_through"], &report["unit"]), (&true.into(), &"m".into()));

    // Which mesh follows which body is stated, and what is left out.
    assert!(run.stderr.contains("n follows n: Geometry/needle_half.obj"), "{}", run.stderr);
    assert!(run.stderr.contains("lost is left out: its mesh 'lost.vtp'"), "{}", run.stderr);
}

#[test]
fn wrong_models_are_named_and_nothing_is_written() {
    let workshop = model_of_needle();
    workshop.write("cut.osim", &MODEL[..200]);
    workshop.write("empty.osim", MODEL.replace("plate", "p").replace("needle", "q"));
    workshop.write("number.osim", MODEL.replace("0.3 0 0.4", "0.3 0"));
    workshop.write("other.sto", MODEL_DOWN.replace("base", "torso"));
    let inputs = [
        "leg.osim --json m.json",
        "leg.osim leg.sto --motion leg.sto --json m.json",
        "cut.osim leg.sto --json m.json",
        "empty.osim leg.sto --json m.json",
        "number.osim leg.sto --json m.json",
        "leg.osim other.sto --json m.json",
        "gone.osim leg.sto --json m.json",
    ];
    insta::assert_snapshot!(workshop.outcomes("motion", &inputs));
}
