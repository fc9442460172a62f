//! Plans of scenes: what is told, and what is refused.

#[expect(dead_code, reason = "shared with the tests of other commands")]
mod support;

use support::{Workshop, tetrahedron};

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
    let told = [
        "tolerance 0.5; margin 0;",
        "bone    distance field",
        "muscle  tree",
        "muscle  no reduced surface:",
        "bone    muscle  field",
        "1 of 1 pairs overlap",
        "depths differ by 0.",
        "0 overlaps are not seen",
    ];
    for told in told {
        assert!(run.stdout.contains(told), "{told}: {}", run.stdout);
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
    for (force, told) in [
        ("muscle,bone", "expected two names and a method"),
        ("muscle,bone,wishes", "no method is called \"wishes\""),
        ("muscle,bane,field", "no body is called \"bane\""),
        ("muscle,bone,balls", "method balls does not suit"),
    ] {
        let refused = run(force);
        assert_eq!(refused.status, 2, "{force}: {}", refused.stdout);
        assert!(refused.stderr.contains(told), "{told}: {}", refused.stderr);
    }
}

#[test]
fn bodies_that_stay_apart_need_nothing() {
    let workshop = workshop();
    workshop.write("far.obj", tetrahedron(500.0, 30.0));
    let arguments = ["bone.obj", "far.obj", "--tolerance", "0.5", "--travel", "10"];
    let run = workshop.run("plan", &arguments);
    assert_eq!(run.status, 0, "{}", run.stderr);
    for told in ["bone  no tree: no pair needs it", "farther than they may move"] {
        assert!(run.stdout.contains(told), "{told}: {}", run.stdout);
    }
}

#[test]
fn needs_that_mean_nothing_are_refused_by_name() {
    let workshop = workshop();
    for (option, value, told) in [
        ("--tolerance", "0", "tolerance is 0, but must be finite and above 0"),
        ("--reach", "-1", "margin is -1, but must be finite and at least 0"),
        ("--travel", "-1", "max_displacement is -1, but must be at least 0"),
        ("--budget", "-1", "a budget of -1 ms cannot be kept to"),
    ] {
        let mut arguments = vec!["bone.obj", "muscle.obj", option, value];
        if option != "--tolerance" {
            arguments.extend(["--tolerance", "0.5"]);
        }
        let run = workshop.run("plan", &arguments);
        assert_eq!(run.status, 2, "{}", run.stdout);
        assert!(run.stderr.contains(told), "{told}: {}", run.stderr);
    }
}
