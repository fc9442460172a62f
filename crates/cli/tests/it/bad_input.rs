//! Invalid input is refused with exit status 2, by name and place, and nothing is
//! written.

use crate::support::{Workshop, tetrahedron};

const PLY: &str = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\n\
    end_header\n";

/// A tetrahedron as a binary PLY file, with one coordinate and one index to choose.
fn ply(z_of_last: f32, index_of_last: i32) -> Vec<u8> {
    let mut bytes = PLY.as_bytes().to_vec();
    for coordinate in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, z_of_last] {
        bytes.extend(f32::to_le_bytes(coordinate));
    }
    for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, index_of_last]] {
        bytes.push(3);
        face.into_iter().for_each(|corner| bytes.extend(i32::to_le_bytes(corner)));
    }
    bytes
}

#[cfg(not(windows))]
#[test]
fn paths_with_backslashes_are_answered_by_slashes() {
    let workshop = workshop();
    let advice = "the path has backslashes, which separate folders on Windows alone: write /, which \
                  does on all systems";
    for (file, problem) in [
        ("windows.toml", "x\\good.obj: cannot be read: No such file"),
        ("nameless.toml", "nameless.toml: the body of x\\good.obj is named 'x\\good'"),
        ("x\\good.obj", "the body of x\\good.obj is named 'x\\good'"),
    ] {
        let run = workshop.check(&[file]);
        assert_eq!(run.status, 2, "{file}");
        for part in [problem, advice] {
            assert!(run.stderr.contains(part), "{file}: '{part}' is not in {}", run.stderr);
        }
    }
    let run = workshop.check(&["escape.toml"]);
    let advice = "the path has control characters, as where a backslash begins an escape: write / \
                  between folders";
    assert!(run.stderr.contains(advice), "{}", run.stderr);

    // What is missing without them needs no advice, and a file that has them is read.
    assert!(!workshop.check(&["missing.toml"]).stderr.contains("write /"));
    workshop.write("x\\good.obj", tetrahedron(0.0, 1.0));
    assert_eq!(workshop.check(&["windows.toml"]).status, 0);
}

/// A folder with good and bad files.
fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("good.obj", tetrahedron(0.0, 1.0));
    workshop.write("good.ply", ply(1.0, 3));
    workshop.write("far.obj", tetrahedron(0.0, 1e110));
    workshop.write("small.obj", tetrahedron(0.0, 1e-110));
    workshop.write("empty.ply", "");
    workshop.write("truncated.ply", &ply(1.0, 3)[..PLY.len() + 48 + 20]);
    workshop.write("nan.ply", ply(f32::NAN, 3));
    workshop.write("range.ply", ply(1.0, 7));
    workshop.write("points.obj", "v 0 0 0\nv 1 0 0\n");
    workshop.write("notes.txt", "not a mesh\n");
    let scene = |text: &str| format!("[[body]]\nfile = \"good.obj\"\n{text}");
    workshop.write("kind.toml", scene("kind = \"soft\"\n"));
    workshop.write("key.toml", scene("colour = \"red\"\n"));
    workshop.write("ignore.toml", scene("[[ignore]]\na = \"good\"\nb = \"tibia\"\n"));
    workshop.write("missing.toml", scene("[[body]]\nfile = \"tibia.ply\"\n"));
    workshop.write("windows.toml", "[[body]]\nname = \"good\"\nfile = 'x\\good.obj'\n");
    workshop.write("nameless.toml", "[[body]]\nfile = 'x\\good.obj'\n");
    workshop.write("escape.toml", "[[body]]\nname = \"good\"\nfile = \"x\\food.obj\"\n");
    workshop.write("margin.toml", format!("margin = inf\n{}", scene("")));
    workshop.write("bodiless.toml", "unit = \"mm\"\n");
    workshop.write("broken.toml", "unit = mm\n");
    workshop
}

#[test]
fn every_mistake_is_named_and_leaves_nothing_behind() {
    let workshop = workshop();
    let before = workshop.listing();
    let cases: &[(&[&str], &[&str])] = &[
        (&["nowhere.ply"], &["nowhere.ply: cannot be read", "No such file"]),
        (&["empty.ply"], &["empty.ply: is empty (0 bytes)"]),
        (&["truncated.ply"], &["truncated.ply: PLY file: element 'face'", "end of file"]),
        (&["nan.ply"], &["nan.ply: vertex 3 is at (0, 0, NaN), which is not finite"]),
        (&["range.ply"], &["range.ply: face 3 refers to vertex 7, but there are 4"]),
        (&["points.obj"], &["points.obj: has 2 vertices and no faces"]),
        (
            &["notes.txt"],
            &[
                "notes.txt: unknown format: expected PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH, INP or FEB",
            ],
        ),
        (&["good.obj", "good.ply"], &["two bodies are named 'good'", "good.obj", "good.ply"]),
        (&["good.obj", "--rigid", "tibia"], &["no body is named 'tibia': the bodies are good"]),
        (&["good.obj", "--rigid", "tibia"], &["--rigid: no body is named 'tibia'"]),
        (&["good.obj", "--fixed", "nobody"], &["--fixed: no body is named 'nobody'"]),
        (&["good.obj", "far.obj"], &["body \"far\": vertex 1 has the coordinate 1e110"]),
        (
            &["small.obj"],
            &["body \"small\": the largest coordinate is 1e-110, but must reach 1e-90"],
        ),
        (&["good.obj", "--margin", "nan"], &["margin is NaN"]),
        (&["good.obj", "--margin", "-1"], &["margin is -1"]),
        (&["good.obj", "--margin", "far"], &["invalid value 'far'"]),
        (&["good.obj", "--threads", "0"], &["invalid value '0'"]),
        (&["kind.toml"], &["kind.toml", "line 3", "unknown variant `soft`", "rigid"]),
        (&["key.toml"], &["key.toml", "line 3", "unknown field `colour`"]),
        (&["ignore.toml"], &["ignore.toml: no body is named 'tibia': the bodies are good"]),
        (&["missing.toml"], &["tibia.ply: cannot be read"]),
        (&["margin.toml"], &["margin.toml: margin is inf"]),
        (&["bodiless.toml"], &["bodiless.toml: has no [[body]]"]),
        (&["broken.toml"], &["broken.toml", "line 1"]),
        (&["nowhere.toml"], &["nowhere.toml: cannot be read"]),
        (&["kind.toml", "good.obj"], &["kind.toml is a scene"]),
        (&[], &["required"]),
    ];
    for (arguments, expected) in cases {
        let outputs =
            ["--json", "o.json", "--report", "o.html", "--vtp", "o", "--picture", "o.png"];
        let run = workshop.check(&[arguments, &outputs[..]].concat());
        assert_eq!(run.status, 2, "{arguments:?}: {}{}", run.stdout, run.stderr);
        for part in *expected {
            assert!(run.stderr.contains(part), "{arguments:?}: '{part}' is not in {}", run.stderr);
        }
        assert_eq!(run.stdout, "", "{arguments:?}");
        assert_eq!(workshop.listing(), before, "{arguments:?}");
    }
}

#[test]
fn every_bad_file_is_named_at_once() {
    let run = workshop().check(&["nan.ply", "good.obj", "range.ply", "empty.ply"]);
    assert_eq!(run.status, 2);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert_eq!(lines.len(), 3, "{}", run.stderr);
    for (line, file) in lines.iter().zip(["nan.ply", "range.ply", "empty.ply"]) {
        assert!(line.starts_with(&format!("error: {file}: ")), "{line}");
    }
}

#[test]
fn an_output_that_cannot_be_written_takes_the_others_with_it() {
    let workshop = workshop();
    let before = workshop.listing();
    for bad in [["--report", "no/such/folder.html"], ["--picture", "."], ["--vtp", "good.obj"]] {
        let run = workshop.check(&[&["good.obj", "--json", "o.json"], &bad[..]].concat());
        assert_eq!(run.status, 3, "{bad:?}: {}", run.stderr);
        assert!(run.stderr.contains(": cannot be written: "), "{bad:?}: {}", run.stderr);
        assert_eq!(workshop.listing(), before, "{bad:?}");
    }
}

/// Formats of outputs are named by their extensions; files without one and devices have any content.
#[test]
fn outputs_of_unknown_formats_are_refused() {
    let workshop = workshop();
    let check: [(&[&str], &str); 3] = [
        (&["--picture", "p.jpg"], "p.jpg: unknown format of a picture: expected .png"),
        (&["--table", "t.txt"], "t.txt: unknown format of a table: expected .csv"),
        (&["--report", "r.pdf"], "r.pdf: unknown format of a report: expected .html"),
    ];
    workshop.refuses("check", &check, &["good.obj"]);
    let medial: [(&[&str], &str); 3] = [
        (&["--out", "m.txt"], "m.txt: unknown format of a medial surface: expected .ma"),
        (&["--picture", "m.svg"], "m.svg: unknown format of a picture: expected .png"),
        (&["--vtp", "m.vtk"], "m.vtk: unknown format of a surface with distances: expected .vtp"),
    ];
    workshop.refuses("medial", &medial, &["good.obj", "--balls", "4"]);
    let field: [(&[&str], &str); 1] =
        [(&["--picture", "f.jpeg"], "f.jpeg: unknown format of a picture: expected .png")];
    workshop.refuses("field", &field, &["good.obj"]);

    let accepted = ["good.obj", "--picture", "P.PNG", "--table", "table", "--report", "-"];
    let run = workshop.check(&accepted);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(workshop.path("P.PNG").exists() && workshop.path("table").exists());
}

#[test]
fn a_body_in_another_unit_is_suspected_with_both_boxes() {
    let workshop = Workshop::new();
    workshop.write("millimeters.obj", tetrahedron(0.0, 400.0));
    workshop.write("meters.obj", tetrahedron(0.0, 0.4));
    let run = workshop.check(&["millimeters.obj", "meters.obj", "--json", "o.json"]);
    for text in [run.stdout, workshop.read("o.json")] {
        for part in [
            "'meters' may have another unit",
            "(0.4000, 0.4000, 0.4000)",
            "(400.0000, 400.0000, 400.0000)",
        ] {
            assert!(text.contains(part), "'{part}' is not in {text}");
        }
    }
}
