//! Fields of meshes: outputs, reports, refusals.

use crate::support::{Workshop, obj, tetrahedron};
use fixtures::shapes::icosphere;
use glam::DVec3;
use serde_json::Value;

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 30.0));
    workshop.write("open.obj", tetrahedron(0.0, 30.0).replace("f 2 3 4\n", ""));
    workshop.write("turned.obj", tetrahedron(0.0, 30.0).replace("f 2 3 4\n", "f 2 4 3\n"));
    let twins = icosphere(9.0, 2).joined(&icosphere(9.0, 2).translated(6.0 * DVec3::X));
    workshop.write("twins.obj", obj(&twins));
    workshop.write("sheet.obj", "v 0 0 0\nv 30 0 0\nv 30 30 3\nv 0 30 0\nf 1 2 3\nf 1 3 4\n");
    workshop
}

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("valid JSON")
}

fn bytes(workshop: &Workshop, name: &str) -> Vec<u8> {
    std::fs::read(workshop.path(name)).expect("a readable file")
}

#[test]
fn a_bone_becomes_a_field_a_picture_and_figures() {
    let workshop = workshop();
    let outputs = ["--out", "f.nrrd", "--picture", "f.png", "--json", "f.json"];
    let run = workshop.run("field", &[&["bone.obj", "--spacing", "1"], &outputs[..]].concat());
    assert_eq!(run.status, 0, "{}", run.stderr);
    for part in [
        "4 vertices, 4 faces",
        "51 x 51 x 51, 132,651 nodes, spacing 1,",
        " max, at 512 points within two spacings of the surface",
        " max, at 64 points farther away, where it is expected to be largest",
        "measured at these points only: elsewhere it may be larger",
        "proved     error at most 0.9910 near the surface",
        "wrote f.nrrd",
        " s: build ",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    let record = json(&workshop, "f.json");
    let error = &record["built"]["measured_error"];
    assert!(error["rms"].as_f64().unwrap() > 0.0);
    assert!(error["max"].as_f64().unwrap() < 0.5, "{error}");
    assert_eq!(error["points"].as_u64(), Some(512));
    let deep = &record["built"]["measured_deep_error"];
    assert_eq!(deep["points"].as_u64(), Some(64));
    assert!(deep["max"].as_f64().unwrap() > error["rms"].as_f64().unwrap(), "{deep}");
    // Legs of 30 at a right angle: 30³ / 6.
    let volume = record["built"]["inside_volume"].as_f64().unwrap();
    assert!((volume - 4500.0).abs() < 600.0, "{volume}");
    // The sphere inside has a radius of 30 / (3 + √3).
    let min = record["min"].as_f64().unwrap();
    assert!((min + 30.0 / (3.0 + 3.0_f64.sqrt())).abs() < 0.5, "{min}");
    assert_eq!(record["max"].as_f64(), Some(15.0));
    assert!(bytes(&workshop, "f.nrrd").starts_with(b"NRRD0004\n"));
    assert!(bytes(&workshop, "f.png").starts_with(b"\x89PNG"));
}

#[test]
fn a_field_goes_from_format_to_format_and_back_unchanged() {
    let workshop = workshop();
    let steps = [["bone.obj", "a.nrrd"], ["a.nrrd", "b.vti"], ["b.vti", "c.nrrd"]];
    for [from, to] in steps {
        let spacing: &[&str] = if from == "bone.obj" { &["--spacing", "1"] } else { &[] };
        let run = workshop.run("field", &[spacing, &[from, "--out", to]].concat());
        assert_eq!(run.status, 0, "{from}: {}", run.stderr);
    }
    assert!(bytes(&workshop, "a.nrrd") == bytes(&workshop, "c.nrrd"), "the same file again");
}

/// Steps take half the bytes and round by half a step, both at a build and at a conversion.
#[test]
fn steps_are_kept_from_file_to_file() {
    let workshop = workshop();
    let runs: [&[&str]; 5] = [
        &["bone.obj", "--spacing", "1", "--out", "floats.nrrd", "--json", "floats.json"],
        &["bone.obj", "--spacing", "1", "--step", "0.07", "--out", "a.nrrd", "--json", "a.json"],
        &["a.nrrd", "--out", "b.vti"],
        &["b.vti", "--out", "c.nrrd", "--json", "c.json"],
        &["floats.nrrd", "--step", "0.07", "--out", "d.nrrd"],
    ];
    for arguments in runs {
        let run = workshop.run("field", arguments);
        assert_eq!(run.status, 0, "{arguments:?}: {}", run.stderr);
        let is_in_steps = run.stdout.contains("16 bits per node, in steps of 0.07");
        assert_eq!(is_in_steps, !arguments.contains(&"floats.json"), "{}", run.stdout);
    }
    let [floats, a, c, d] =
        ["floats.nrrd", "a.nrrd", "c.nrrd", "d.nrrd"].map(|name| bytes(&workshop, name));
    assert!(a == c && a == d, "the same file each way");
    assert!(a.len() < floats.len() / 2 + 300, "{} of {}", a.len(), floats.len());
    let min = |name: &str| json(&workshop, name)["min"].as_f64().unwrap();
    let apart = (min("a.json") - min("floats.json")).abs();
    assert!(apart > 0.0 && apart < 0.035 + 1e-6, "{apart}");
    assert_eq!(json(&workshop, "c.json")["storage"]["Quantized"]["step"].as_f64(), Some(0.07));
    assert_eq!(json(&workshop, "c.json")["nodes"], "QuasiInterpolating");
}

#[test]
fn options_change_the_build() {
    let workshop = workshop();
    let built = |arguments: &[&str]| {
        let arguments = [&["bone.obj", "--json", "f.json"], arguments].concat();
        let run = workshop.run("field", &arguments);
        assert_eq!(run.status, 0, "{}", run.stderr);
        json(&workshop, "f.json")
    };
    let coarse = built(&["--spacing", "2", "--padding", "4"]);
    assert_eq!(coarse["dims"], serde_json::json!([20, 20, 20]));
    let rms = |record: &Value| record["built"]["measured_error"]["rms"].as_f64().unwrap();
    assert!(
        rms(&built(&["--spacing", "1", "--method", "voxel"]))
            > 1.8 * rms(&built(&["--spacing", "1", "--method", "band"]))
    );
    assert!(built(&["--spacing", "1", "--truncate", "0"])["max"].as_f64().unwrap() > 16.0);
    assert!(
        (built(&["--spacing", "1", "--truncate", "3.5"])["max"].as_f64().unwrap() - 3.5).abs()
            < 1e-6
    );
}

/// A cavity is outside by either method, and an inside that leaks out shows in the measured error.
#[test]
fn measured_errors_count_wrong_signs() {
    let workshop = workshop();
    workshop.write("fat.obj", obj(&icosphere(12.0, 4).joined(&icosphere(8.0, 4).flipped())));
    let turn = DVec3::new(0.36, 0.48, 0.8);
    workshop.write("coarse.obj", obj(&icosphere(30.0, 2).rotated(turn, 0.13)));
    let built = |file: &str, method: &str| {
        let arguments = [file, "--spacing", "1", "--method", method, "--json", "f.json"];
        let run = workshop.run("field", &arguments);
        assert_eq!(run.status, 0, "{}", run.stderr);
        assert!(!run.stdout.contains("without their signs"), "{}", run.stdout);
        json(&workshop, "f.json")
    };
    let max = |record: &Value| record["built"]["measured_error"]["max"].as_f64();
    let min = |record: &Value| record["min"].as_f64();
    for method in ["voxel", "band"] {
        let fat = built("fat.obj", method);
        assert!(max(&fat) < Some(1.5), "{method}: {fat}");
        assert!(min(&fat) > Some(-3.0), "the cavity has a radius of 8: {method}: {fat}");
    }
    let lost = built("coarse.obj", "voxel");
    assert!(max(&lost) > Some(3.0) && min(&lost) > Some(-3.0), "{lost}");
    let kept = built("coarse.obj", "band");
    assert!(max(&kept) < Some(1.0) && min(&kept) < Some(-14.0), "{kept}");

    for file in ["open.obj", "turned.obj"] {
        let run = workshop.run("field", &[file, "--spacing", "1"]);
        assert!(run.stdout.contains("of distances without their signs"), "{}", run.stdout);
    }
}

#[test]
fn threads_change_no_byte() {
    let workshop = workshop();
    let files = |threads: &str| {
        let run = workshop.run(
            "field",
            &[
                "bone.obj",
                "--spacing",
                "1",
                "--out",
                "f.vti",
                "--picture",
                "f.png",
                "--threads",
                threads,
            ],
        );
        assert_eq!(run.status, 0, "{}", run.stderr);
        [bytes(&workshop, "f.vti"), bytes(&workshop, "f.png")]
    };
    assert!(files("1") == files("3"), "the same bytes");
}

#[test]
fn unreliable_fields_have_warnings() {
    let workshop = workshop();
    let cases = [
        (["open.obj", "--spacing", "1"], "the surface is open, with 3 boundary edges"),
        (["turned.obj", "--spacing", "1"], "opposite orientations, at 3 misoriented edges"),
        (["sheet.obj", "--spacing", "1"], "inside     none: the surface is a sheet"),
        (["sheet.obj", "--spacing", "1"], "no part of the field is reliably negative"),
        (["twins.obj", "--spacing", "1"], " pairs of faces cross each other: distances inside"),
        (["bone.obj", "--spacing", "12"], "the surface spans 2.50 cells"),
        (["bone.obj", "--spacing", "12"], "89 % of the surface bounds parts thinner than 18.00"),
    ];
    for (arguments, expected) in cases {
        let run = workshop.run("field", &arguments);
        assert_eq!(run.status, 0, "{arguments:?}: {}", run.stderr);
        assert!(run.stdout.contains(expected), "{arguments:?}: {}", run.stdout);
        // A closed surface is not called open, and a sheet has no volume.
        let [file, ..] = arguments;
        assert_eq!(run.stdout.contains("is open"), ["open.obj", "sheet.obj"].contains(&file));
        assert_eq!(run.stdout.contains("inside     volume"), file != "sheet.obj");
    }
}

/// The edges of a damaged mesh are counted as `check` counts them.
#[test]
fn edges_are_counted_as_check_counts_them() {
    let workshop = workshop();
    for (file, edges) in [("open.obj", "3 boundary edges"), ("turned.obj", "3 misoriented edges")] {
        let field = workshop.run("field", &[file, "--spacing", "1"]);
        assert!(field.stdout.contains(edges), "{}", field.stdout);
        let check = workshop.check(&[file]);
        assert!(check.stdout.contains(edges), "{}", check.stdout);
    }
}

#[test]
fn invalid_input_is_named_and_nothing_is_written() {
    let workshop = workshop();
    assert_eq!(
        workshop.run("field", &["bone.obj", "--spacing", "1", "--out", "good.nrrd"]).status,
        0
    );
    let good = bytes(&workshop, "good.nrrd");
    workshop.write("short.nrrd", &good[..good.len() - 7]);
    workshop.write("empty.vti", "");
    let cases: &[(&[&str], &str)] = &[
        (&["missing.obj"], "missing.obj: cannot be read"),
        (&["missing.vti"], "missing.vti: cannot be read"),
        (&["short.nrrd"], "short.nrrd: NRRD file: a grid of 51 x 51 x 51 nodes needs 530604 bytes"),
        (&["empty.vti"], "empty.vti: VTI file: element 'VTKFile': is missing"),
        (&["bone.obj", "--out", "f.mha"], "f.mha: unknown format of a field"),
        (&["bone.obj", "--spacing", "-1"], "bone.obj: spacing is -1"),
        (&["bone.obj", "--spacing", "nan"], "bone.obj: spacing is NaN"),
        (&["bone.obj", "--padding", "-2"], "bone.obj: padding is -2"),
        (&["bone.obj", "--spacing", "0.0001"], "bone.obj: a grid of 2.701e16 nodes needs"),
        (&["open.obj", "--method", "voxel"], "open.obj: the voxel method"),
        (
            &["bone.obj", "--step", "0"],
            "bone.obj: storage step is 0, but must be finite and positive",
        ),
        (&["bone.obj", "--step", "0.0001"], "bone.obj: a storage step of 0.0001 reaches 3.2767"),
        (&["good.nrrd", "--step", "-2"], "good.nrrd: storage step is -2"),
        (&["good.nrrd", "--step", "0.0001"], "good.nrrd: a storage step of 0.0001 reaches"),
        (&["good.nrrd", "--spacing", "2"], "good.nrrd: is a field already"),
        (&["good.nrrd", "--padding", "2"], "good.nrrd: is a field already"),
        (&["good.nrrd", "--method", "band"], "good.nrrd: is a field already"),
        (&["good.nrrd", "--truncate", "5"], "good.nrrd: is a field already"),
    ];
    workshop.refuses("field", cases, &["--json", "f.json", "--picture", "f.png"]);
}
