//! Plans of scenes: reports and refusals.

use std::path::PathBuf;

use fixtures::shapes::icosphere;

use crate::motion::{gait, thigh_scene};
use crate::support::{Workshop, obj, tetrahedron};

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 30.0));
    workshop.write("muscle.obj", tetrahedron(-3.0, 30.0));
    workshop
}

#[test]
fn a_plan_names_methods_bounds_and_what_a_frame_takes() {
    let workshop = workshop();
    let arguments =
        ["bone.obj", "muscle.obj", "--rigid", "bone", "--tolerance", "0.5", "--compare"];
    let run = workshop.run("plan", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let part = [
        "tolerance 0.5; margin 0; 1 frame",
        "bone    tree",
        "muscle  tree",
        "bone    muscle  exact     0.5000 proved",
        "1 of 1 pairs overlap",
        "1 state compared",
        "depths differ by at most 0.",
        "bone × muscle",
        "all depths are within the bounds of their pairs",
    ];
    for part in part {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    assert!(!run.stdout.contains("field"), "one frame builds no field: {}", run.stdout);
}

/// A body with faces that look inward is compared as any other.
#[test]
fn a_body_that_is_inside_out_is_compared() {
    let workshop = workshop();
    let flipped = tetrahedron(-3.0, 30.0)
        .replace("f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4", "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1");
    workshop.write("muscle.obj", flipped);
    let run =
        workshop.run("plan", &["bone.obj", "muscle.obj", "--tolerance", "0.001", "--compare"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    for part in ["instead of 3.0", "all depths are within the bounds of their pairs"] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    assert!(!run.stdout.contains("defined"), "{}", run.stdout);
}

/// Exact depths in a body that covers a place twice are undefined: they are not held against the plan.
#[test]
fn a_body_that_covers_a_place_twice_is_not_compared() {
    let workshop = workshop();
    let again = tetrahedron(-2.0, 30.0)
        .replace("f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4", "f 5 7 6\nf 5 6 8\nf 6 7 8\nf 7 5 8");
    workshop.write("muscle.obj", format!("{}{again}", tetrahedron(-3.0, 30.0)));
    let run =
        workshop.run("plan", &["bone.obj", "muscle.obj", "--tolerance", "0.001", "--compare"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    for part in [
        "1 of 1 pairs overlap",
        "all depths are within the bounds of their pairs",
        "1 overlap without a defined depth: a body covers a place twice, or in part inside out",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}

/// In meters, bounds and depths have the digits that the tolerance asks for.
#[test]
fn small_units_have_their_digits() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 0.03));
    workshop.write("muscle.obj", tetrahedron(-0.003, 0.03));
    let run = workshop.run("plan", &["bone.obj", "muscle.obj", "--tolerance", "2e-5", "--compare"]);
    for part in ["exact    2.00e-5 proved", "instead of 0.00300000"] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}

#[test]
fn a_method_can_be_forced_and_is_refused_where_it_cannot_serve() {
    let workshop = workshop();
    let base = ["bone.obj", "muscle.obj", "--rigid", "bone", "--tolerance", "3", "--force"];
    let run = |force: &str| workshop.run("plan", &[&base[..], &[force]].concat());
    for method in ["exact", "field"] {
        let forced = run(&format!("muscle,bone,{method}"));
        assert_eq!(forced.status, 1, "{}", forced.stderr);
        let line = format!("bone    muscle  {method}");
        assert!(forced.stdout.contains(&line), "{}", forced.stdout);
    }
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
fn a_method_has_one_name_in_what_is_given_printed_and_written() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", obj(&icosphere(5.0, 2)));
    workshop.write("muscle.obj", obj(&icosphere(6.0, 2)));
    let base = ["bone.obj", "muscle.obj", "--rigid", "bone", "--tolerance", "2"];
    for method in ["exact", "coarse", "field", "balls"] {
        let force = format!("bone,muscle,{method}");
        let json = ["--force", &force, "--json", "plan.json"];
        let run = workshop.run("plan", &[&base[..], &json].concat());
        assert_eq!(run.status, 1, "{}", run.stderr);
        let line = format!("bone    muscle  {method}");
        assert!(run.stdout.contains(&line), "{}", run.stdout);
        let document: serde_json::Value =
            serde_json::from_str(&workshop.read("plan.json")).expect("JSON");
        assert_eq!(document["pairs"][0]["method"], method);
    }
}

#[test]
fn json_holds_each_pair_with_its_bound_and_depths() {
    let workshop = workshop();
    let arguments = ["bone.obj", "muscle.obj", "--rigid", "bone", "--tolerance", "0.1"];
    let json = ["--compare", "--frames", "3", "--json", "plan.json"];
    let run = workshop.run("plan", &[&arguments[..], &json].concat());
    assert_eq!(run.status, 1, "{}", run.stderr);
    let document: serde_json::Value =
        serde_json::from_str(&workshop.read("plan.json")).expect("JSON");

    assert_eq!((&document["tolerance"], &document["frames"]), (&0.1.into(), &3.into()));
    assert_eq!(document["structures"].as_array().map(Vec::len), Some(2), "{document}");
    assert_eq!(document["structures"][0]["kind"], "tree");
    let pair = &document["pairs"][0];
    assert_eq!((&pair["a"], &pair["b"]), (&"bone".into(), &"muscle".into()));
    assert_eq!((&pair["method"], &pair["proved"]), (&"exact".into(), &true.into()));
    let number = |key: &str| pair[key].as_f64().unwrap_or_else(|| panic!("{key}: {pair}"));
    assert!(number("bound") <= 0.1 && pair["measured_error"].is_null(), "{pair}");
    assert!((number("depth") - number("exact_depth")).abs() <= number("bound"), "{pair}");
    assert!(number("depth_lower") <= number("depth_upper"), "{pair}");
    assert!(number("frame_ms") > 0.0 && number("predicted_ms") > 0.0, "{pair}");
}

#[test]
fn a_budget_leaves_pairs_out_and_says_so() {
    let workshop = workshop();
    let arguments = ["bone.obj", "muscle.obj", "--tolerance", "0.5", "--budget", "0", "--compare"];
    let run = workshop.run("plan", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let part = "0 of 1 pairs overlap, 1 are left out by the budget, at most ";
    assert!(run.stdout.contains(part), "{}", run.stdout);
    assert!(run.stdout.contains("all depths are within"), "{}", run.stdout);
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
        ("--budget", "1e25", " ms, but must be at least 0 and at most 1e20"),
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

/// Of two methods for one pair, one would hold without a word.
#[test]
fn a_pair_is_forced_once() {
    let workshop = workshop();
    let arguments =
        ["bone.obj", "muscle.obj", "--tolerance", "0.5", "--force", "bone,muscle,exact"];
    let forced =
        |other: &str| workshop.run("plan", &[&arguments[..], &["--force", other]].concat());
    for other in ["muscle,bone,coarse", "bone,muscle,exact"] {
        let run = forced(other);
        assert_eq!(run.status, 2, "{}", run.stdout);
        let problem = "--force: the pair bone and muscle is given more than once";
        assert!(run.stderr.contains(problem), "{}", run.stderr);
    }
}

/// A plan for many frames, made in the first one, over frames of a walk of real anatomy: all 73 where
/// `MUSCULO_ALL_STEPS` is set.
#[test]
#[expect(clippy::print_stdout, reason = "the test prints what it skips and measures")]
fn no_depth_of_a_walk_is_off_by_more_than_its_bound() {
    let Some(data) = std::env::var_os("MUSCULO_DATA").map(PathBuf::from) else {
        println!("skipped: MUSCULO_DATA names no folder of anatomy");
        return;
    };
    let all = std::env::var_os("MUSCULO_ALL_STEPS").is_some();
    let workshop = Workshop::new();
    workshop.write("gait.json", gait(&data, (0..73).step_by(if all { 1 } else { 18 })));
    workshop.write("scene.toml", format!("motion = \"gait.json\"\n{}", thigh_scene(&data)));
    let states = if all { "73 states compared" } else { "5 states compared" };

    // Of these simplified bodies, coarse surfaces pay within a large tolerance alone.
    for (tolerance, method) in [("4", "coarse"), ("2", "exact"), ("0.5", "exact")] {
        let arguments = ["scene.toml", "--tolerance", tolerance, "--frames", "100000", "--compare"];
        let run = workshop.run("plan", &arguments);
        assert_eq!(run.status, 1, "{}", run.stderr);
        for part in [states, method, "all depths are within the bounds of their pairs"] {
            assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
        }
        let differ = run.stdout.lines().find(|line| line.starts_with("depths differ"));
        println!("measured: within {tolerance}, {}", differ.unwrap_or_default());
    }
}
