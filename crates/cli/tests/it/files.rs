//! Files, devices, pipes and signals: no output replaces an input or another output,
//! nothing is left behind by a command that ends early, and nothing fails in silence.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use musculo_collide::distance_field::{DistanceField, FieldGrid, Storage};

use crate::support::{Run, Workshop, tetrahedron};

/// Two tetrahedra apart, a scene with a motion, a field, links to a mesh, to a folder and
/// to files that do not exist, and a folder.
pub(crate) fn workshop() -> Workshop {
    let workshop = Workshop::new();
    let link = |target: &str, name: &str| {
        symlink(target, workshop.path(name)).expect("a link");
    };
    workshop.write("a.obj", tetrahedron(0.0, 1.0));
    workshop.write("b.obj", tetrahedron(3.0, 1.0));
    workshop.write("walk.json", motion(2));
    let scene = "motion = \"walk.json\"\n[[body]]\nfile = \"a.obj\"\nkind = \"rigid\"\n[[body]]\nfile = \"b.obj\"\n";
    workshop.write("scene.toml", scene);
    let grid = FieldGrid::new(glam::DVec3::ZERO, 0.5, [2; 3]).expect("a grid");
    let field = DistanceField::from_values(grid, vec![1.0; 8], Storage::Float).expect("a field");
    workshop.write("a.nrrd", mesh_io::FieldFormat::Nrrd.encode(&field));

    link("a.obj", "link.obj");
    fs::hard_link(workshop.path("a.obj"), workshop.path("hard.obj")).expect("a hard link");
    fs::create_dir(workshop.path("folder")).expect("a folder");
    link("folder", "linked_folder");
    link("folder/target.json", "link.json");
    link("loop.json", "loop.json");
    link("/dev/null", "null.json");
    workshop
}

/// Returns a motion of `a` with a number of frames at rest.
pub(crate) fn motion(frames: usize) -> String {
    let map = "\"a\": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]";
    let frames: Vec<String> =
        (0..frames).map(|frame| format!("{{\"t\": {frame}, {map}}}")).collect();
    format!("{{\"frames\": [{}]}}", frames.join(", "))
}

/// Content of every file below a folder, and the target of every link.
pub(crate) fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut content = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(inner) = folders.pop() {
        for entry in fs::read_dir(inner).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(folder).expect("a path below").display().to_string();
            let kind = fs::symlink_metadata(&path).expect("metadata").file_type();
            let bytes = if kind.is_symlink() {
                let target = fs::read_link(&path).expect("a target");
                format!("link to {}", target.display()).into_bytes()
            } else if kind.is_dir() {
                folders.push(path);
                b"folder".to_vec()
            } else if kind.is_fifo() {
                b"pipe".to_vec()
            } else {
                fs::read(&path).expect("a file")
            };
            content.insert(name, bytes);
        }
    }
    content
}

/// Returns the names of files that are new, changed or gone.
pub(crate) fn changes(
    before: &BTreeMap<String, Vec<u8>>,
    after: &BTreeMap<String, Vec<u8>>,
) -> String {
    let mut changes = Vec::new();
    for (name, bytes) in after {
        match before.get(name) {
            None => changes.push(format!("+{name}")),
            Some(old) if old != bytes => changes.push(format!("~{name}")),
            Some(_) => {}
        }
    }
    changes
        .extend(before.keys().filter(|name| !after.contains_key(*name)).map(|n| format!("-{n}")));
    if changes.is_empty() { "nothing changed".to_owned() } else { changes.join(" ") }
}

/// Runs each command line in a folder of its own, and returns a table: the command line,
/// the exit status, what changed on disk, and the message.
fn table(lines: &[&str]) -> String {
    let mut table = String::new();
    for line in lines {
        let workshop = workshop();
        let before = content(&workshop.path(""));
        let mut words = line.split_whitespace();
        let command = words.next().expect("a command");
        let run = workshop.run(command, &words.collect::<Vec<_>>());
        let changes = changes(&before, &content(&workshop.path("")));
        let _ = writeln!(table, "{line}\n  {}, {changes}", run.status);
        for message in run.stderr.lines() {
            let _ = writeln!(table, "  {message}");
        }
    }
    table
}

#[test]
fn an_output_never_replaces_an_input() {
    insta::assert_snapshot!(table(&[
        "check a.obj b.obj --json a.obj",
        "check a.obj b.obj --report ./folder/../a.obj",
        "check a.obj b.obj --picture linked_folder/../b.obj",
        "check a.obj b.obj --json link.obj",
        "check link.obj b.obj --json a.obj",
        "check a.obj b.obj --json hard.obj",
        "check scene.toml --json scene.toml",
        "check scene.toml --report b.obj",
        "check scene.toml --json walk.json",
        "resolve a.obj b.obj --out .",
        "resolve a.obj b.obj --out folder/..",
        "resolve scene.toml --out linked_folder/..",
        "motion scene.toml --chart walk.json",
        "motion scene.toml --motion walk.json --json scene.toml",
        "field a.obj --json a.obj",
        "field a.nrrd --out a.nrrd",
        "medial a.obj --balls 8 --vtp a.obj",
    ]));
}

#[test]
fn two_outputs_never_share_a_file() {
    insta::assert_snapshot!(table(&[
        "check a.obj b.obj --json o --report o",
        "check a.obj b.obj --json o --report ./folder/../o",
        "check a.obj b.obj --json link.json --report folder/target.json",
        "check a.obj b.obj --json - --picture -",
        "check a.obj b.obj --json - --picture /dev/stdout",
        "check a.obj b.obj --json new --vtp new",
        "check a.obj b.obj --json folder/a.vtp --vtp linked_folder",
        "motion scene.toml --json o --chart o",
        "motion scene.toml --json o/a_0000.vtp --resolve o",
        "field a.obj --out f.nrrd --picture f.nrrd",
        "medial a.obj --balls 8 --out m --picture m",
    ]));
}

#[test]
fn places_where_no_file_can_be_are_named() {
    insta::assert_snapshot!(table(&[
        "check a.obj b.obj --json no/such/o.json",
        "check a.obj b.obj --json folder",
        "check a.obj b.obj --json loop.json",
        "check a.obj b.obj --json a.obj/o.json",
        "check a.obj b.obj --vtp a.obj/o",
        "check a.obj b.obj --vtp b.obj",
        "check a.obj b.obj --vtp -",
        "resolve a.obj b.obj --out -",
        "field a.obj --out -",
        "field a.obj --out f.vti --gzip",
    ]));
}

#[test]
fn outputs_that_may_be_written_are() {
    insta::assert_snapshot!(table(&[
        "check a.obj b.obj --json o.json --report o.html --vtp new/inner",
        "check a.obj b.obj --json new/o.json --vtp new",
        "check a.obj b.obj --json link.json",
        "check a.obj b.obj --json /dev/null --report null.json",
        "check a.obj b.obj --json -",
        "resolve a.obj b.obj --out apart --no-report",
        "motion scene.toml --resolve apart",
        "field a.obj --out a.nrrd --gzip",
        "field a.nrrd --out f.nrrd",
    ]));
}

/// Bytes of a mesh behind its declared end are no part of it, and are named by every
/// command.
#[test]
fn content_behind_the_end_of_a_mesh_is_named() {
    let workshop = workshop();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
    let body = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    workshop.write("long.ply", format!("{header}{body}3 0 1 2\n"));
    let mut stl = vec![b' '; 80];
    stl.extend(1_u32.to_le_bytes());
    for corner in [[0.0_f32; 12], [0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 6.0, 0.0, 0.0, 5.0, 1.0, 0.0]] {
        stl.extend(corner.into_iter().flat_map(f32::to_le_bytes));
        stl.extend([0; 2]);
    }
    workshop.write("long.stl", stl);

    let in_ply = "8 bytes from line 18 on, behind the declared end, not read";
    let in_stl = "50 bytes from byte 134 on, behind the declared end, not read";
    let warning = |name: &str, unread: &str| format!("warning: {name}: {unread}\n");
    let run = workshop.check(&["long.ply", "b.obj", "--json", "o.json"]);
    assert_eq!((run.status, run.stderr), (0, warning("long.ply", in_ply)));
    for text in [run.stdout, workshop.read("o.json")] {
        assert!(text.contains(in_ply), "{text}");
    }

    let cases: [&[&str]; 4] = [
        &["resolve", "long.stl", "b.obj", "--no-report", "--out", "apart"],
        &["plan", "long.stl", "b.obj", "--tolerance", "0.1"],
        &["field", "long.stl"],
        &["medial", "long.stl", "--balls", "8"],
    ];
    for arguments in cases {
        let run = workshop.run(arguments[0], &arguments[1..]);
        let expected = warning("long.stl", in_stl);
        assert!(run.stderr.starts_with(&expected), "{arguments:?}: {}", run.stderr);
    }
}

/// Text of a file, and names of files and bodies, may hold anything.
#[test]
fn nothing_that_is_read_commands_the_terminal() {
    let workshop = workshop();
    let commands = "\x1b]0;title\x07\x1b[31m\u{9b}2J\r";
    let name = format!("{}.obj", commands.replace('/', ""));
    workshop.write(&name, tetrahedron(0.0, 1.0));
    workshop.write("a.stl", format!("solid {commands}\n{commands}\nendsolid\n"));
    workshop.write("a.vtp", format!("<VTKFile type=\"{commands}\"/>"));
    workshop.write("a.toml", format!("unit = \"{commands}\"\n"));
    workshop.write("b.toml", format!("[[body]]\nfile = \"a.obj\"\nname = \"{commands}\"\n"));
    workshop.write("c.toml", "[[body]]\nfile = \"a.obj\"\nname = \"\\u001b[31m\"\n");
    workshop.write("a.json", format!("{{\"frames\": [{{\"{commands}\": 1}}]}}"));
    workshop.write("a.nrrd", format!("NRRD0004\n{commands}\n\n"));

    let cases: [(&str, &[&str]); 9] = [
        ("check", &[&name]),
        ("field", &[&name]),
        ("check", &["a.stl"]),
        ("check", &["a.vtp"]),
        ("check", &["a.toml"]),
        ("check", &["b.toml"]),
        ("check", &["c.toml"]),
        ("motion", &["scene.toml", "--motion", "a.json"]),
        ("field", &["a.nrrd"]),
    ];
    for (command, arguments) in cases {
        let run = workshop.run(command, arguments);
        let is_command = |c: char| c.is_control() && c != '\n';
        assert!(!run.stderr.contains(is_command), "{command} {arguments:?}: {:?}", run.stderr);
        assert!(!run.stdout.contains(is_command), "{command} {arguments:?}: {:?}", run.stdout);
    }
}

/// The meshes that are written have the formats of those that were read, and the same
/// vertices and faces where nothing moves.
#[test]
fn formats_and_orders_are_kept() {
    let workshop = workshop();
    for extension in ["obj", "off", "ply", "stl", "vtp"] {
        let format = mesh_io::MeshFormat::of(format!("x.{extension}").as_ref()).expect("a format");
        let mesh =
            mesh_io::parse_mesh(tetrahedron(0.1, 7.0 / 3.0).as_bytes(), "obj").expect("a mesh");
        let file = format.encode(&mesh.positions, &mesh.faces, None);
        workshop.write(&format!("mesh.{extension}"), file);
        let path = format!("mesh.{extension}");
        let run = workshop.run("resolve", &[&path, "--no-report", "--out", "apart"]);
        assert_eq!(run.status, 0, "{}", run.stderr);

        let [before, after] = [path.clone(), format!("apart/{path}")]
            .map(|path| mesh_io::read_mesh(&workshop.path(&path)).expect("a mesh"));
        assert_eq!(before, after, "{extension}");
    }
}

/// 3D Slicer's default is smaller, and reads back to the same field.
#[test]
fn fields_are_compressed_by_choice() {
    let workshop = workshop();
    let run = workshop.run("field", &["a.obj", "--spacing", "0.05", "--out", "raw.nrrd"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    workshop.run("field", &["raw.nrrd", "--gzip", "--out", "small.nrrd"]);
    workshop.run("field", &["small.nrrd", "--out", "again.nrrd"]);
    let bytes = |name: &str| fs::read(workshop.path(name)).expect("a file");
    assert_eq!(bytes("again.nrrd"), bytes("raw.nrrd"));
    assert!(10 * bytes("small.nrrd").len() < 9 * bytes("raw.nrrd").len());
}

#[test]
fn too_many_threads_are_refused_before_any_starts() {
    let processors = std::thread::available_parallelism().expect("a number").get();
    let max = 64.max(4 * processors);
    let workshop = workshop();
    let threads = (max + 1).to_string();
    let run = workshop.check(&["a.obj", "b.obj", "--threads", &threads, "--json", "o.json"]);
    assert_eq!(run.status, 2);
    let expected = format!("error: --threads is {threads}, but must be at most {max}");
    assert!(run.stderr.starts_with(&expected), "{}", run.stderr);
    let run = workshop.check(&["a.obj", "b.obj", "--threads", &max.to_string()]);
    assert_eq!(run.status, 0, "{}", run.stderr);
}

/// Starts the program with its standard output in `output`.
pub(crate) fn start(workshop: &Workshop, arguments: &[&str], output: Stdio) -> Child {
    Command::new(env!("CARGO_BIN_EXE_musculo-collide"))
        .args(arguments)
        .current_dir(workshop.path(""))
        .stdout(output)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

pub(crate) fn finish(child: Child) -> Run {
    Run::from(child.wait_with_output().expect("the program ends"))
}

/// `-`, `/dev/stdout` and the file behind standard output are the same place, in which no
/// table follows the document.
#[test]
fn a_document_on_standard_output_stands_alone() {
    let workshop = workshop();
    workshop.check(&["a.obj", "b.obj", "--json", "expected.json"]);
    let expected = workshop.read("expected.json");
    for name in ["-", "/dev/stdout"] {
        let run = workshop.check(&["a.obj", "b.obj", "--json", name]);
        assert_eq!((run.status, run.stdout, run.stderr), (0, expected.clone(), String::new()));
    }

    let arguments = ["check", "a.obj", "b.obj", "--json", "redirected.json"];
    let output = File::create(workshop.path("redirected.json")).expect("a file");
    assert_eq!(finish(start(&workshop, &arguments, output.into())).status, 0);
    assert_eq!(workshop.read("redirected.json"), expected);
}

#[test]
fn a_table_is_not_appended_to_an_input() {
    let workshop = workshop();
    let before = workshop.read("a.obj");
    let output = File::options().append(true).open(workshop.path("a.obj")).expect("a file");
    let run = finish(start(&workshop, &["check", "a.obj", "b.obj"], output.into()));
    assert_eq!(run.status, 2);
    assert_eq!(run.stderr, "error: a.obj: is an input, and standard output as well\n");
    assert_eq!(workshop.read("a.obj"), before);
}

/// Makes a named pipe, or returns false on a system without them.
pub(crate) fn make_pipe(workshop: &Workshop, name: &str) -> bool {
    let made = Command::new("mkfifo").arg(workshop.path(name)).status();
    made.is_ok_and(|status| status.success())
}

#[test]
fn a_pipe_is_written_and_stays_a_pipe() {
    let workshop = workshop();
    if !make_pipe(&workshop, "pipe") {
        return;
    }
    let child = start(&workshop, &["check", "a.obj", "b.obj", "--json", "pipe"], Stdio::piped());
    let mut document = String::new();
    let mut pipe = File::open(workshop.path("pipe")).expect("a pipe");
    pipe.read_to_string(&mut document).expect("text");
    let run = finish(child);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(run.stdout.ends_with(" s\n"), "the table is printed as well: {}", run.stdout);

    workshop.check(&["a.obj", "b.obj", "--json", "expected.json"]);
    assert_eq!(document, workshop.read("expected.json"));
    let kind = fs::symlink_metadata(workshop.path("pipe")).expect("metadata").file_type();
    assert!(kind.is_fifo());
}

/// The reader closes the pipe before the first byte: the status is that of the result.
#[test]
fn a_closed_pipe_is_silent() {
    let workshop = workshop();
    workshop.write("inside.obj", tetrahedron(0.1, 1.0));
    for (other, status) in [("b.obj", 0), ("inside.obj", 1)] {
        for more in [&[][..], &["--json", "-"]] {
            let arguments = [&["check", "a.obj", other], more].concat();
            let mut child = start(&workshop, &arguments, Stdio::piped());
            drop(child.stdout.take());
            let run = finish(child);
            assert_eq!((run.status, run.stderr), (status, String::new()), "{arguments:?}");
        }
    }
}

#[test]
fn a_full_device_is_an_error() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let full = || Stdio::from(File::options().write(true).open("/dev/full").expect("a device"));
    let workshop = workshop();
    let space = "cannot be written: No space left on device (os error 28)\n";
    for arguments in [
        &["check", "a.obj", "b.obj"][..],
        &["check", "a.obj", "b.obj", "--json", "-"],
        &["plan", "a.obj", "b.obj", "--rigid", "a", "--tolerance", "0.1"],
        &["--help"],
    ] {
        let run = finish(start(&workshop, arguments, full()));
        assert_eq!(run.status, 3, "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.ends_with(space), "{arguments:?}: {}", run.stderr);
    }

    // The other outputs of the command are not left.
    let before = content(&workshop.path(""));
    let arguments = ["check", "a.obj", "b.obj", "--report", "o.html", "--vtp", "new"];
    assert_eq!(finish(start(&workshop, &arguments, full())).status, 3);
    assert_eq!(changes(&before, &content(&workshop.path(""))), "nothing changed");
    let run = workshop.check(&["a.obj", "b.obj", "--report", "o.html", "--json", "/dev/full"]);
    assert_eq!((run.status, run.stderr), (3, format!("error: /dev/full: {space}")));
    assert_eq!(changes(&before, &content(&workshop.path(""))), "nothing changed");
}

/// A mesh through a pipe is read like a file.
#[test]
fn a_mesh_is_read_from_a_pipe() {
    let workshop = workshop();
    if !make_pipe(&workshop, "pipe.obj") {
        return;
    }
    let child = start(&workshop, &["check", "a.obj", "pipe.obj"], Stdio::piped());
    fs::write(workshop.path("pipe.obj"), tetrahedron(0.1, 1.0)).expect("a reader");
    let run = finish(child);
    assert_eq!(run.status, 1, "{}", run.stderr);
    assert!(run.stdout.contains("pipe"), "{}", run.stdout);
}

#[test]
fn a_stream_without_end_is_refused() {
    let zero = Path::new("/dev/zero");
    if !zero.exists() {
        return;
    }
    let workshop = workshop();
    for name in ["zero.obj", "zero.toml", "zero.json", "zero.nrrd"] {
        symlink(zero, workshop.path(name)).expect("a link");
    }
    let cases: [(&str, &[&str], &str); 4] = [
        ("check", &["a.obj", "zero.obj"], "zero.obj"),
        ("check", &["zero.toml"], "zero.toml"),
        ("motion", &["scene.toml", "--motion", "zero.json"], "zero.json"),
        ("field", &["zero.nrrd"], "zero.nrrd"),
    ];
    for (command, arguments, file) in cases {
        let run = workshop.run(command, arguments);
        let problem = "it has more than 268435456 bytes, the limit for a pipe or device";
        let expected = format!("error: {file}: cannot be read: {problem}\n");
        assert_eq!((run.status, run.stderr), (2, expected));
    }
}
