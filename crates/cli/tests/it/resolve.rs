//! Overlap removal: the written meshes do not overlap.

use std::fs;
use std::path::PathBuf;

use fixtures::shapes;
use glam::DVec3;

use crate::support::{Run, Workshop, obj, tetrahedron};

fn program(workshop: &Workshop, arguments: &[String]) -> Run {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match &arguments[..] {
        ["check", meshes @ ..] => workshop.check(meshes),
        [command, rest @ ..] => workshop.run(command, rest),
        [] => unreachable!("a command comes first"),
    }
}

fn strings(paths: impl IntoIterator<Item = PathBuf>) -> Vec<String> {
    paths.into_iter().map(|path| path.to_string_lossy().into_owned()).collect()
}

#[test]
fn written_meshes_do_not_overlap() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 10.0));
    workshop.write("muscle.obj", tetrahedron(9.0, 10.0));
    let at = |name: &str| workshop.path(name);
    let mut arguments = strings([at("bone.obj"), at("muscle.obj")]);
    let overlapping = program(&workshop, &[vec!["check".to_owned()], arguments.clone()].concat());
    assert_eq!(overlapping.status, 1, "they overlap at first");

    arguments.insert(0, "resolve".to_owned());
    arguments.extend(["--fixed", "bone", "--out"].map(str::to_owned));
    arguments.extend(strings([at("apart")]));
    let run = program(&workshop, &arguments);
    let text = &run.stdout;
    assert_eq!(run.status, 0, "{text}");
    assert!(text.contains("Nothing overlaps any more."), "{text}");

    let mut again = vec!["check".to_owned()];
    again.extend(strings([at("apart/bone.obj"), at("apart/muscle.obj")]));
    assert_eq!(program(&workshop, &again).status, 0, "nothing overlaps in the files");
    let map = workshop.read("apart/muscle_displacement.vtp");
    assert!(map.contains("Scalars=\"displacement_length\""), "the map is coloured by length");
    for page in ["apart/before.html", "apart/after.html"] {
        assert!(workshop.read(page).ends_with("</html>\n"), "{page}");
    }
}

/// An STL file has the corners of each face anew: numbers of vertices would be those of this program.
#[test]
fn vertices_of_stl_files_are_not_selected_by_number() {
    let workshop = Workshop::new();
    let [bone, muscle] = [0.0, 9.0].map(|x| shapes::icosphere(5.0, 1).translated(DVec3::X * x));
    workshop.write("bone.obj", obj(&bone));
    let muscle = mesh_io::MeshFormat::Stl.encode(&muscle.positions, &muscle.faces, None);
    workshop.write("muscle.stl", String::from_utf8(muscle).expect("text"));
    let scene = "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"muscle.stl\"\n\
                 [[fixed]]\nbody = \"muscle\"\n";
    workshop.write("ids.txt", "0\n");
    workshop.write("list.toml", format!("{scene}vertices = \"ids.txt\"\n"));
    let expected = "ids.txt: 'muscle' is of an STL file, whose vertices have no numbers";
    workshop.refuses("resolve", &[(&["list.toml"], expected)], &["--out", "apart"]);

    workshop.write("box.toml", format!("{scene}box = [[9, -9, -9], [19, 9, 9]]\n"));
    let run = workshop.run("resolve", &["box.toml", "--out", "apart", "--no-report"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
}

/// A comment ends with its line, whatever that ends with.
#[test]
fn lists_of_fixed_vertices_may_have_any_line_ends() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 10.0));
    workshop.write("muscle.obj", tetrahedron(9.0, 10.0));
    workshop.write(
        "scene.toml",
        "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"muscle.obj\"\n\
         [[fixed]]\nbody = \"muscle\"\nvertices = \"ids.txt\"\n",
    );
    for end in ["\n", "\r\n", "\r"] {
        workshop.write("ids.txt", "3 # the tip\n0\n# base\n1 2\n".replace('\n', end));
        let run = workshop.run("resolve", &["scene.toml", "--out", "apart"]);
        assert_eq!(run.status, 1, "{end:?}: {}{}", run.stdout, run.stderr);
        assert!(run.stdout.contains("muscle is fixed at 4 of"), "{end:?}: {}", run.stdout);
        workshop.write("wrong.toml", workshop.read("scene.toml").replace("ids", "wrong"));
        workshop.write("wrong.txt", "3 # the tip\n0\n# base\n1 4\n".replace('\n', end));
        let expected = "line 4: '4' is no vertex on the surface of 'muscle'";
        workshop.refuses("resolve", &[(&["wrong.toml"], expected)], &["--out", "held"]);
    }
}

/// Selections may have vertices in common, and two ties may be of one pair.
#[test]
fn attachments_are_counted_once() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 10.0));
    workshop.write("muscle.obj", tetrahedron(9.0, 10.0));
    let fixed = |corner: i32| {
        format!("[[fixed]]\nbody = \"muscle\"\nbox = [[{corner}, -9, -9], [99, 99, 99]]\n")
    };
    let tie = |a: &str, b: &str| format!("[[tie]]\na = \"{a}\"\nb = \"{b}\"\nwithin = 2\n");
    workshop.write(
        "scene.toml",
        "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"muscle.obj\"\n"
            .to_owned()
            + &[fixed(0), fixed(10), tie("bone", "muscle"), tie("muscle", "bone")].concat(),
    );
    let arguments = ["scene.toml", "--out", "apart", "--no-report", "--json", "r"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let text = "muscle is tied to bone and fixed at 4 of its vertices:";
    assert!(run.stdout.contains(text), "{}", run.stdout);
    let document: serde_json::Value = serde_json::from_str(&workshop.read("r")).expect("JSON");
    let attachment = &document["attachments"][0];
    assert_eq!(attachment["tied_to"], serde_json::json!(["bone"]));
    assert_eq!(attachment["fixed_vertices"], 4);
}

/// A muscle in single precision, and a tendon and a body far away in double precision.
#[test]
fn what_stays_keeps_all_digits_beside_files_in_single_precision() {
    let workshop = Workshop::new();
    let ball = |x: f64, y: f64| shapes::icosphere(5.0, 2).translated(DVec3::new(x, y, 0.2));
    workshop.write("bone.obj", obj(&ball(0.0, 0.0)));
    let mut muscle = vec![0; 80];
    let mesh = ball(9.7, 0.1);
    muscle.extend(320_u32.to_le_bytes());
    for corners in mesh.faces {
        muscle.extend([0; 12]);
        for corner in corners.map(|corner| mesh.positions[corner as usize].as_vec3()) {
            muscle.extend(corner.to_array().map(f32::to_le_bytes).as_flattened());
        }
        muscle.extend([0; 2]);
    }
    workshop.write("muscle.stl", muscle);
    workshop.write("tendon.obj", obj(&ball(0.1, 9.8)));
    workshop.write("far.obj", obj(&ball(99.1, 9.8)));
    workshop.write(
        "scene.toml",
        "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"muscle.stl\"\n[[body]]\nfile = \
         \"tendon.obj\"\n[[body]]\nfile = \"far.obj\"\n[[fixed]]\nbody = \"tendon\"\nbox = [[-9, 9.8, -9], [9, \
         99, 9]]\n",
    );
    let arguments = ["scene.toml", "--gap", "0.05", "--out", "apart", "--no-report"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);

    assert!(workshop.read("apart/far.obj") == workshop.read("far.obj"), "a copy");
    let [before, after] = ["tendon.obj", "apart/tendon.obj"].map(|name| workshop.read(name));
    let (mut fixed, mut moved) = (0, 0);
    for (before, after) in before.lines().zip(after.lines()) {
        let y = before.split(' ').nth(2).and_then(|y| y.parse::<f64>().ok()).expect("a number");
        if before.starts_with('v') && y >= 9.8 {
            assert_eq!(before, after);
            fixed += 1;
        }
        moved += usize::from(before != after);
    }
    assert!(fixed > 70 && moved > 9, "{fixed} {moved}");
}

#[test]
fn a_body_that_crosses_itself_is_reported_and_uncrossed_on_request() {
    let workshop = Workshop::new();
    let ball = shapes::icosphere(10.0, 2);
    let both = ball.clone().joined(&ball.rotated(DVec3::Y, 0.1).translated(DVec3::X * 18.5));
    workshop.write("both.obj", obj(&both));
    let found = workshop.check(&["both.obj"]);
    assert!(found.stdout.contains(" self-crossings of "), "{}", found.stdout);

    let scene = "[[body]]\nfile = \"both.obj\"\n";
    workshop.write("left.toml", scene);
    workshop.write("uncrossed.toml", format!("{scene}uncross = true\n"));
    for (name, crosses) in [("left", true), ("uncrossed", false)] {
        let run = workshop.run("resolve", &[&format!("{name}.toml"), "--out", name, "--no-report"]);
        assert_eq!(run.status, 0, "{}", run.stdout);
        let after = workshop.check(&[&format!("{name}/both.obj")]);
        assert_eq!(after.stdout.contains(" self-crossings of "), crosses, "{}", after.stdout);
    }
}

#[test]
fn ignored_pairs_are_left_out_of_what_is_said() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 10.0));
    workshop.write("muscle.obj", tetrahedron(9.0, 10.0));
    let scene = "[[body]]\nfile = \"bone.obj\"\n[[body]]\nfile = \"muscle.obj\"\n[[ignore]]\n\
                 a = \"bone\"\nb = \"muscle\"\n";
    workshop.write("scene.toml", scene);
    let arguments = ["scene.toml", "--gap", "0.1", "--out", "apart", "--no-report", "--json", "r"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let text = "Nothing overlaps any more, 1 ignored pair left out.";
    assert!(run.stdout.contains(text), "{}", run.stdout);
    let text = "proved for all pairs but 1 ignored";
    assert!(run.stdout.contains(text), "{}", run.stdout);
    let document: serde_json::Value = serde_json::from_str(&workshop.read("r")).expect("JSON");
    assert_eq!(document["ignored_pairs"], serde_json::json!([["bone", "muscle"]]));
}

#[test]
fn fixed_vertices_of_a_rigid_body_are_refused() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 10.0));
    let scene = "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n[[fixed]]\nbody = \"bone\"\n\
                 box = [[-1, -1, -1], [1, 1, 1]]\n";
    workshop.write("scene.toml", scene);
    let run = workshop.run("resolve", &["scene.toml", "--out", "apart"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    let problem = "[[fixed]]: 'bone' is rigid and never moves: leave it out";
    assert!(run.stderr.contains(problem), "{}", run.stderr);
}

/// Two bones that cross stay as they are.
#[test]
fn the_page_of_a_state_that_is_no_result_is_marked() {
    let workshop = Workshop::new();
    workshop.write("femur.obj", tetrahedron(0.0, 10.0));
    workshop.write("tibia.obj", tetrahedron(9.0, 10.0));
    let arguments = ["femur.obj", "tibia.obj", "--fixed", "femur", "--fixed", "tibia"];
    let run = workshop.run("resolve", &[&arguments[..], &["--out", "apart"]].concat());
    assert_eq!(run.status, 1, "{}", run.stdout);
    let mut files = workshop.listing();
    files.retain(|name| name.starts_with("apart/"));
    assert_eq!(files, ["apart/after_unproved.html", "apart/before.html"]);
    let page = workshop.read("apart/after_unproved.html");
    assert!(page.contains("Contact after overlap removal, which is not complete"), "the title");
}

#[test]
fn invalid_lengths_are_named() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 1.0));
    let mut arguments = vec!["resolve".to_owned()];
    arguments.extend(strings([workshop.path("a.obj")]));
    arguments.extend(["--smooth", "0", "--out"].map(str::to_owned));
    arguments.extend(strings([workshop.path("out")]));
    let run = program(&workshop, &arguments);
    let problem = &run.stderr;
    assert_eq!(run.status, 2);
    assert!(problem.contains("smoothing is 0, but must be finite and above 0"), "{problem}");
    assert_eq!(workshop.listing(), ["a.obj"]);
}

/// Pushes a set of real meshes apart, and checks what was written with the
/// program itself; bones are recognized by their names.
#[expect(clippy::print_stdout, reason = "the test prints what it skips or measures")]
fn comes_apart(set: &str) {
    let Some(data) = std::env::var_os("MUSCULO_DATA") else {
        println!("skipped: MUSCULO_DATA names no folder of anatomy");
        return;
    };
    let folder = PathBuf::from(data).join("anatomy").join(set);
    let entries = fs::read_dir(folder).expect("a folder of meshes");
    let mut meshes = strings(entries.map(|entry| entry.expect("an entry").path()));
    meshes.sort();
    let workshop = Workshop::new();
    let mut arguments = vec!["resolve".to_owned(), "--no-report".to_owned()];
    for bone in ["femur", "patella", "pelvis", "tibia"] {
        arguments.extend(["--fixed".to_owned(), format!("bone_{bone}")]);
    }
    arguments.push("--out".to_owned());
    arguments.extend(strings([workshop.path("apart")]));
    arguments.extend(meshes);
    let run = program(&workshop, &arguments);
    let text = &run.stdout;
    assert_eq!(run.status, 0, "{text}");

    let entries = fs::read_dir(workshop.path("apart")).expect("a folder");
    let written = entries.map(|entry| entry.expect("an entry").path());
    let mut written = strings(
        written.filter(|path| path.extension().is_some_and(|extension| extension == "ply")),
    );
    written.sort();
    assert_eq!(written.len(), 25, "a mesh for each body");
    written.insert(0, "check".to_owned());
    let check = program(&workshop, &written);
    let text = &check.stdout;
    assert_eq!(check.status, 0, "no faces cross in the files: {text}");
}

#[test]
fn decimated_thigh() {
    comes_apart("vhf_left_thigh_lo");
}
