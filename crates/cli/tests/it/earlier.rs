//! Files of earlier runs in the folders of outputs.

use crate::motion::needle_through_plate;
use crate::support::{Workshop, tetrahedron};

/// Frames that a shorter motion does not have stay beside new ones, and are named.
#[test]
fn frames_of_an_earlier_run_are_named() {
    for option in ["--resolve", "--vtp"] {
        let workshop = needle_through_plate();
        let down = workshop.read("down.json");
        let longer =
            down.replace("]}]}", "]}, {\"needle\": [1,0,0,0, 0,1,0,0, 0,0,1,-8, 0,0,0,1]}]}");
        workshop.write("longer.json", longer);
        let long = ["scene.toml", "--motion", "longer.json", option, "apart"];
        for arguments in [&long[..], &long] {
            let run = workshop.run("motion", arguments);
            assert_eq!((run.status < 2, run.stderr.as_str()), (true, ""), "{option}");
        }

        // Files of others are not of this program.
        workshop.write("apart/notes.txt", "");
        workshop.write("apart/needle_notes.txt", "");
        workshop.write("apart/tibia_0000.vtp", "");
        let run = workshop.run("motion", &["scene.toml", option, "apart"]);
        let expected = "warning: apart has 2 files of these bodies that are not of this run, such as \
                        needle_0002.vtp: remove what an earlier run has left, or choose another folder\n";
        assert_eq!(run.stderr, expected, "{option}");
    }
}

#[test]
fn overlaps_of_an_earlier_run_are_named() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 10.0));
    workshop.write("b.obj", tetrahedron(9.0, 10.0));
    let run = workshop.check(&["a.obj", "b.obj", "--vtp", "maps"]);
    assert_eq!((run.status, run.stderr.as_str()), (1, ""));

    workshop.write("b.obj", tetrahedron(12.0, 10.0));
    let run = workshop.check(&["a.obj", "b.obj", "--vtp", "maps"]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let expected =
        "maps has 3 files of these bodies that are not of this run, such as a_b_curve.vtp";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
}

/// A run that fails writes no mesh, and does not pass off those of another run as its own.
#[test]
fn meshes_of_an_earlier_run_are_named() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 10.0));
    workshop.write("b.obj", tetrahedron(9.0, 10.0));
    let arguments = ["a.obj", "b.obj", "--rigid", "a", "--no-report", "--out", "apart"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!((run.status, run.stderr.as_str()), (0, ""));

    let run = workshop.run("resolve", &[&arguments[..], &["--rounds", "0"]].concat());
    assert_eq!(run.status, 1, "{}", run.stdout);
    let expected = "apart has 2 files of these bodies that are not of this run, such as a.obj";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
}
