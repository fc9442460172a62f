//! Scenes that cannot come apart, and scenes that look so: each is answered in words, with its exit
//! status, and nothing is written where it fails.

use fixtures::Mesh;
use fixtures::shapes::{ellipsoid, icosphere, plate};
use glam::DVec3;

use crate::support::{Workshop, obj};

/// Scenes of balls and plates: names with their meshes.
fn workshop() -> Workshop {
    let workshop = Workshop::new();
    let ball = |radius: f64| icosphere(radius, 2);
    let slab = |z: f64, thickness: f64| {
        plate(DVec3::new(12.0, 12.0, thickness), [6; 2]).translated(z * DVec3::Z)
    };
    let mut torn = ball(5.0).translated(9.0 * DVec3::X);
    torn.faces.pop();
    let meshes: [(&str, Mesh); 14] = [
        ("torn", torn),
        ("ball", ball(5.0)),
        ("same", ball(5.0)),
        ("inside", ball(1.5)),
        ("beside", ball(5.0).translated(9.0 * DVec3::X)),
        ("shell", shell()),
        ("sheet", sheet()),
        ("rod", ellipsoid(DVec3::new(2.0, 2.0, 40.0), 2)),
        ("lower", slab(-1.7, 2.0)),
        ("upper", slab(1.7, 2.0)),
        ("floor", slab(-1.08, 2.0)),
        ("ceiling", slab(1.08, 2.0)),
        ("twins", icosphere(9.0, 2).joined(&icosphere(9.0, 2).translated(6.0 * DVec3::X))),
        ("between", icosphere(2.0, 2).translated(3.0 * DVec3::X)),
    ];
    for (name, mesh) in meshes {
        workshop.write(&format!("{name}.obj"), obj(&mesh));
    }
    workshop.write("muscle.obj", obj(&slab(0.0, 2.0)));
    workshop.write(
        "sheet.toml",
        "[[body]]\nfile = \"sheet.obj\"\nkind = \"open\"\n[[body]]\nfile = \"rod.obj\"\nkind = \"rigid\"\n",
    );
    workshop.write(
        "tied.toml",
        "[[body]]\nfile = \"lower.obj\"\nkind = \"rigid\"\n\
         [[body]]\nfile = \"upper.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"muscle.obj\"\n\
         [[tie]]\na = \"lower\"\nb = \"muscle\"\nwithin = 0.5\n\
         [[fixed]]\nbody = \"muscle\"\nbox = [[-7, -7, -1.1], [-5, 7, 1.1]]\n",
    );
    workshop
}

/// A closed shell: a ball with a hollow.
fn shell() -> Mesh {
    let (mut outer, inner) = (icosphere(9.0, 2), icosphere(7.0, 2));
    let first = u32::try_from(outer.positions.len()).expect("few vertices");
    outer.positions.extend(inner.positions);
    outer.faces.extend(inner.faces.iter().map(|[a, b, c]| [first + a, first + c, first + b]));
    outer
}

/// A sheet of 8 × 8 squares, through whose middle the rod goes.
fn sheet() -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), faces: Vec::new() };
    for j in 0..9_u32 {
        for i in 0..9_u32 {
            let [x, y] = [i, j].map(|k| 4.0 * f64::from(k) - 16.0);
            mesh.positions.push(DVec3::new(x + 0.1, y + 0.2, 0.3));
            if i < 8 && j < 8 {
                let [a, b] = [9 * j + i, 9 * j + i + 9];
                mesh.faces.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
    }
    mesh
}

#[test]
fn each_absurd_scene_is_answered_in_words() {
    // Arguments, exit status, words of the answer.
    let table: [(&str, i32, &[&str]); 18] = [
        ("ball.obj inside.obj --rigid ball", 0, &["Nothing overlaps any more."]),
        ("ball.obj same.obj", 1, &["the surfaces coincide", "No mesh is written"]),
        ("ball.obj same.obj --rigid ball --gap 0.1", 1, &["coincide"]),
        ("shell.obj ball.obj", 0, &["Nothing overlaps any more."]),
        ("shell.obj ball.obj --gap 0.5", 0, &["The gap of 0.5000 mm is proved for all pairs"]),
        ("twins.obj between.obj --rigid twins", 1, &["covers a place more than once"]),
        ("sheet.toml", 1, &["sheet × rod", "is pierced", "No mesh is written"]),
        ("ball.obj beside.obj --rigid ball --rigid beside", 1, &["both are rigid", "[[ignore]]"]),
        ("ball.obj beside.obj --rigid ball --gap 0.2", 0, &["is proved for all pairs"]),
        // Room for a muscle that grows wider, and less room than the gap on both sides.
        (
            "lower.obj muscle.obj upper.obj --rigid lower --rigid upper --gap 0.1",
            0,
            &["is proved for all pairs"],
        ),
        (
            "floor.obj muscle.obj ceiling.obj --rigid floor --rigid ceiling --gap 0.1",
            1,
            &[
                "muscle would leave its limits: moved by 3.758 mm, at most 3.514 mm allowed",
                "no room: rigid bodies leave 0.1600 mm, the body is 2.000 mm thick",
                "0.920 to 0.922 mm deep",
                "No mesh is written",
            ],
        ),
        (
            "ball.obj torn.obj --gap 0.1",
            0,
            &["The volume of torn is not kept: no inside: 3 edges", "is proved for all pairs"],
        ),
        ("ball.obj beside.obj --gap -1", 2, &["gap is -1, but must be"]),
        ("ball.obj beside.obj --gap nan", 2, &["gap is NaN, but must be"]),
        ("ball.obj beside.obj --gap 1e300", 2, &["gap is 1", "0, but must be at most 1e27"]),
        (
            "ball.obj beside.obj --smooth 1e28",
            2,
            &["smoothing is 1", "0, but must be at most 1e27"],
        ),
        ("ball.obj", 0, &["Nothing overlaps any more."]),
        (
            "tied.toml --gap 0.05",
            1,
            &[
                "no room",
                "muscle is tied to lower and fixed at",
                "what is held there cannot give way.",
            ],
        ),
    ];
    let workshop = workshop();
    let before = workshop.listing();
    let mut wrong = String::new();
    for (arguments, status, expected) in table {
        let mut arguments: Vec<&str> = arguments.split(' ').collect();
        arguments.extend(["--no-report", "--out", "apart"]);
        let run = workshop.run("resolve", &arguments);
        let answer = run.stdout + &run.stderr;
        let is_written = workshop.listing() != before;
        let has_words = expected.iter().all(|words| answer.contains(words));
        if run.status != status || !has_words || is_written != (status == 0) {
            wrong += &format!("{arguments:?}: {} {is_written}\n{answer}\n", run.status);
        }
        let _ = std::fs::remove_dir_all(workshop.path("apart"));
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// The state that is written on request is beyond the limits itself.
#[test]
fn a_state_beyond_its_limits_is_not_called_another_one() {
    let workshop = workshop();
    let scene = "floor.obj muscle.obj ceiling.obj --rigid floor --rigid ceiling --gap 0.1";
    let arguments: Vec<&str> =
        scene.split(' ').chain(["--out", "apart", "--no-report", "--keep-going"]).collect();
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    for expected in ["muscle leaves its limits: moved by", "the state breaks the limits of muscle"]
    {
        assert!(run.stdout.contains(expected), "{}", run.stdout);
    }
    for wrong in ["would leave", "better ones break", "a better state"] {
        assert!(!run.stdout.contains(wrong), "{}", run.stdout);
    }
}

/// All of the lower side of a plate is in the bone, and its upper side faces away.
#[test]
fn a_tie_that_holds_nothing_is_warned_of() {
    let workshop = Workshop::new();
    let side = |sides: DVec3, up: f64| obj(&plate(sides, [6, 6]).translated(up * DVec3::Z));
    workshop.write("bone.obj", side(DVec3::new(30.0, 30.0, 6.0), -3.0));
    workshop.write("sunk.obj", side(DVec3::new(20.0, 20.0, 0.8), 0.1));
    workshop.write(
        "tied.toml",
        "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"sunk.obj\"\n\
         [[tie]]\na = \"sunk\"\nb = \"bone\"\nwithin = 0.5\n",
    );
    let arguments =
        ["tied.toml", "--gap", "0.05", "--no-report", "--out", "apart", "--json", "o.json"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let warning = "warning: the tie of 'sunk' to 'bone' holds nothing";
    assert!(run.stderr.contains(warning), "{}", run.stderr);
    assert!(run.stdout.contains("sunk is tied to bone by 0 of "), "{}", run.stdout);
    let json: serde_json::Value = serde_json::from_str(&workshop.read("o.json")).expect("JSON");
    assert_eq!((&json["ties"][0]["tied"], &json["ties"][0]["loose"]), (&0.into(), &0.into()));
}

#[test]
fn a_body_that_is_pushed_out_of_another_is_named() {
    let workshop = Workshop::new();
    let tendon = ellipsoid(DVec3::new(1.0, 1.0, 6.0), 3).translated(DVec3::new(5.5, 0.2, 0.1));
    workshop.write("muscle.obj", obj(&ellipsoid(DVec3::new(8.0, 8.0, 20.0), 3)));
    workshop.write("tendon.obj", obj(&tendon));
    let body = |name: &str| format!("[[body]]\nfile = \"{name}.obj\"\n");
    let scene = body("muscle") + &body("tendon");
    workshop.write("ignored.toml", scene.clone() + "[[ignore]]\na = \"muscle\"\nb = \"tendon\"\n");
    workshop.write("scene.toml", scene);
    let warning =
        "warning: 'tendon' was wholly inside 'muscle', and is pushed out of it: [[ignore]]";
    for (name, is_pushed) in [("scene.toml", true), ("ignored.toml", false)] {
        let run =
            workshop.run("resolve", &[name, "--gap", "0.05", "--no-report", "--out", "apart"]);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        assert_eq!(run.stderr.contains(warning), is_pushed, "{}", run.stderr);
        let _ = std::fs::remove_dir_all(workshop.path("apart"));
    }
}

/// What an open surface surrounds is left where it is.
#[test]
fn pairs_that_rounds_leave_out_are_counted() {
    let workshop = workshop();
    workshop.write("within.obj", obj(&icosphere(1.5, 2).translated(9.0 * DVec3::X)));
    for (bodies, is_left_out) in
        [("ball.obj torn.obj within.obj", true), ("ball.obj torn.obj", false)]
    {
        let arguments = bodies.split(' ').chain(["--out", "apart", "--no-report"]);
        let run = workshop.run("resolve", &arguments.collect::<Vec<_>>());
        let is_named = run.stdout.contains("Rounds leave 1 overlapping pair out.");
        assert_eq!(is_named, is_left_out, "{bodies}: {}{}", run.stdout, run.stderr);
        let _ = std::fs::remove_dir_all(workshop.path("apart"));
    }
}
