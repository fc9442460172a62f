//! Plans of scenes: reports and refusals.

use crate::support::{Workshop, tetrahedron};

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 30.0));
    workshop.write("muscle.obj", tetrahedron(-3.0, 30.0));
    workshop
}

#[test]
fn a_plan_names_methods_reasons_and_what_a_frame_takes() {
    let workshop = workshop();
    let arguments =
        ["bone.obj", "muscle.obj", "--rigid", "bone", "--tolerance", "0.5", "--compare"];
    let run = workshop.run("plan", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let part = [
        "tolerance 0.5; margin 0;",
        "bone    distance field",
        "muscle  tree",
        "muscle  no reduced surface:",
        "bone    muscle  field",
        "1 of 1 pairs overlap",
        "depths differ by at most 0.",
        "0 overlaps are missing",
    ];
    for part in part {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}

#[test]
fn a_method_can_be_forced_and_is_refused_where_it_cannot_serve() {
    let workshop = workshop();
    let base = ["bone.obj", "muscle.obj", "--rigid", "bone", "--tolerance", "3", "--force"];
    let run = |force: &str| workshop.run("plan", &[&base[..], &[force]].concat());
    let surfaces = run("muscle,bone,surfaces");
    assert_eq!(surfaces.status, 1, "{}", surfaces.stderr);
    assert!(surfaces.stdout.contains("bone    muscle  surfaces"), "{}", surfaces.stdout);
    for (force, part) in [
        ("muscle,bone", "expected two names and a method"),
        ("muscle,bone,wishes", "unknown method \"wishes\""),
        ("muscle,bane,field", "no body is named 'bane'"),
        ("bone,bone,field", "pairs 'bone' with itself, but a pair has two bodies"),
        ("muscle,bone,balls", "method balls does not suit"),
    ] {
        let refused = run(force);
        assert_eq!(refused.status, 2, "{force}: {}", refused.stdout);
        assert!(refused.stderr.contains(part), "{part}: {}", refused.stderr);
    }
}

#[test]
fn bodies_that_stay_apart_need_nothing() {
    let workshop = workshop();
    workshop.write("far.obj", tetrahedron(500.0, 30.0));
    let arguments = ["bone.obj", "far.obj", "--tolerance", "0.5", "--max-displacement", "10"];
    let run = workshop.run("plan", &arguments);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let part = "1 pairs farther apart";
    assert!(run.stdout.contains(part) && !run.stdout.contains("tree"), "{}", run.stdout);
}

#[test]
fn needs_that_mean_nothing_are_refused_by_name() {
    let workshop = workshop();
    for (option, value, part) in [
        ("--tolerance", "0", "tolerance is 0, but must be finite and above 0"),
        ("--margin", "-1", "margin is -1, but must be finite and at least 0"),
        ("--max-displacement", "-1", "max_displacement is -1, but must be at least 0"),
        ("--budget", "-1", "budget is -1 ms, but must be at least 0"),
    ] {
        let mut arguments = vec!["bone.obj", "muscle.obj", option, value];
        if option != "--tolerance" {
            arguments.extend(["--tolerance", "0.5"]);
        }
        let run = workshop.run("plan", &arguments);
        assert_eq!(run.status, 2, "{}", run.stdout);
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
}
