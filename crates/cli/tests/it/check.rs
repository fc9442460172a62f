//! Scenes that can be checked: exit status, table, and every output.

use std::fs;

use crate::support::{Workshop, tetrahedron};
use serde_json::Value;

/// Scene of a thigh with planted overlaps.
const THIGH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/scene.toml");

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("valid JSON")
}

#[test]
fn the_exit_status_tells_whether_anything_overlaps() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 1.0));
    workshop.write("near.obj", tetrahedron(1.5, 1.0));
    workshop.write("in.obj", tetrahedron(0.2, 0.1).replace(" 0 0\n", " 0.1 0.1\n"));
    let clean = workshop.check(&["a.obj", "near.obj", "--margin", "1"]);
    assert_eq!((clean.status, clean.stderr.as_str()), (0, ""));
    assert!(
        clean.stdout.contains("No bodies overlap; 1 pair near (within 1 mm)."),
        "{}",
        clean.stdout
    );
    assert!(clean.stdout.contains("0.5000  a  near"), "{}", clean.stdout);

    let apart = workshop.check(&["a.obj", "near.obj", "--margin", "0.4"]);
    assert!(apart.stdout.contains("0 pairs near (within 0.4 mm)"), "{}", apart.stdout);

    let overlapping = workshop.check(&["a.obj", "near.obj", "in.obj"]);
    assert_eq!(overlapping.status, 1);
    assert!(
        overlapping.stdout.contains("1 pair overlaps, the deepest a × in"),
        "{}",
        overlapping.stdout
    );
}

#[test]
fn help_names_everything_a_newcomer_needs() {
    let help = Workshop::new().check(&["--help"]);
    assert_eq!(help.status, 0);
    for part in [
        "SCENE.toml",
        "--rigid",
        "--margin",
        "--depth-tolerance",
        "--joint-contact",
        "--foundation",
        "--json",
        "--vtp",
        "--report",
        "--threads",
        "Exit status",
        "[[body]]",
    ] {
        assert!(help.stdout.contains(part), "'{part}' is not in {}", help.stdout);
    }
}

/// The whole JSON of the thigh with planted overlaps, number by number.
#[test]
fn the_thigh_in_json() {
    let workshop = Workshop::new();
    let run = workshop.check(&[THIGH, "--json", "thigh.json"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    insta::assert_snapshot!("thigh", workshop.read("thigh.json"));
}

/// The table without its last line, which has the times.
#[test]
fn the_thigh_in_a_table() {
    let run = Workshop::new().check(&[THIGH]);
    let (table, times) = run.stdout.trim_end().rsplit_once('\n').expect("several lines");
    insta::assert_snapshot!("table", table);
    for phase in ["load", "detect", "write"] {
        assert!(times.contains(phase), "{times}");
    }
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let workshop = Workshop::new();
    for threads in ["1", "7"] {
        let outputs = ["json", "html", "png", "vtp"].map(|kind| format!("{threads}.{kind}"));
        let [json, html, png, vtp] = outputs.each_ref().map(String::as_str);
        let run = workshop.check(&[
            THIGH,
            "--threads",
            threads,
            "--json",
            json,
            "--report",
            html,
            "--picture",
            png,
            "--vtp",
            vtp,
            "--joint-contact",
            "1",
        ]);
        assert_eq!(run.status, 1, "{}", run.stderr);
    }
    let names = workshop.listing();
    assert!(names.iter().all(|name| !name.contains(".tmp")), "{names:?}");
    let bytes = |name: String| fs::read(workshop.path(&name)).expect("a file");
    let patch = "vtp/adductor_magnus_in_femur.vtp";
    let files = ["json", "html", "png", "vtp/femur.vtp", patch];
    for file in files {
        assert_eq!(bytes(format!("1.{file}")), bytes(format!("7.{file}")), "{file}");
    }
}

/// The bodies written as VTP are the bodies that were read: checked again, they
/// give the same answers to the last digit.
#[test]
fn written_bodies_read_back_the_same() {
    let workshop = Workshop::new();
    workshop.check(&[THIGH, "--json", "first.json", "--vtp", "bodies"]);
    let scene = fs::read_to_string(THIGH).expect("the fixture").replace(".ply", ".vtp");
    workshop.write("bodies/scene.toml", scene);
    let run = workshop.check(&["bodies/scene.toml", "--json", "second.json"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let (first, second) = (json(&workshop, "first.json"), json(&workshop, "second.json"));
    assert!(first["pairs"].as_array().is_some_and(|pairs| pairs.len() > 3), "{first}");
    assert_eq!(first["pairs"], second["pairs"]);
}

/// Two corners, each 0.25 into the other: what VTP shows at the vertices.
#[test]
fn vtp_holds_the_signed_gap_and_the_depth() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 8.0));
    // The corner at the origin of `b` is 0.25 inside three faces of `a`.
    let b = "v 0.25 0.25 0.25\nv -9 0.25 0.25\nv 0.25 -9 0.25\nv 0.25 0.25 -9\n\
             f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";
    workshop.write("b.obj", b);
    let run =
        workshop.check(&["a.obj", "b.obj", "--vtp", "o", "--json", "o.json", "--margin", "1"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let text = workshop.read("o/b.vtp");
    assert_eq!(numbers(&text, "signed_gap"), [-0.25, 1.0, 1.0, 1.0], "the margin where farther");
    assert_eq!(numbers(&text, "penetration_depth"), [0.25, 0.0, 0.0, 0.0]);
    let pair = &json(&workshop, "o.json")["pairs"][0];
    assert_eq!((&pair["max_vertex_depth"], &pair["max_depth"]), (&0.25.into(), &Value::Null));
    assert_eq!(pair["depth_of_b_in_a"]["lower"], 0.25);
    assert_eq!(pair["nearest_vertex"]["vertex"], 0);
    assert_eq!(pair["nearest_vertex"]["body"], "a", "its origin is as deep in b; the first wins");
}

/// The numbers of an array of doubles, behind the count of their bytes.
fn numbers(vtp: &str, name: &str) -> Vec<f64> {
    use base64::Engine;
    let start = vtp.find(&format!("Name=\"{name}\"")).expect("the array");
    let text = vtp[start..].split(['>', '<']).nth(1).expect("its content");
    let bytes = base64::engine::general_purpose::STANDARD.decode(text).expect("base64");
    bytes[8..].as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect()
}

#[test]
fn the_report_is_one_file_with_all_pictures() {
    let workshop = Workshop::new();
    let run = workshop.check(&[THIGH, "--report", "o.html", "--json", "o.json"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let html = workshop.read("o.html");
    let pairs = json(&workshop, "o.json")["pairs"].as_array().expect("pairs").clone();
    let overlapping = pairs.iter().filter(|pair| pair["overlaps"] == true).count();
    assert_eq!(html.matches("data:image/png;base64,").count(), 3 + overlapping);
    for foreign in ["http://", "https://", "<link", "@import"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    for part in ["adductor_magnus", "1.2", "Meshes and their defects", "Near pairs"] {
        assert!(html.contains(part), "{part}");
    }
    for tag in ["figure", "section", "table", "div", "svg", "tr", "td"] {
        let (open, close) = (format!("<{tag}"), format!("</{tag}>"));
        let opened =
            html.matches(&format!("{open}>")).count() + html.matches(&format!("{open} ")).count();
        assert_eq!(opened, html.matches(&close).count(), "{tag}");
    }
}

#[test]
fn names_are_written_as_text_not_as_markup() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 1.0));
    workshop.write("s.toml", "[[body]]\nname = \"<b>&\"\nfile = \"a.obj\"\n");
    workshop.check(&["s.toml", "--report", "o.html"]);
    let html = workshop.read("o.html");
    assert!(html.contains("&lt;b&gt;&amp;") && !html.contains("<b>"));
}

#[test]
fn ignored_pairs_are_left_out() {
    let workshop = Workshop::new();
    workshop.write("a.obj", tetrahedron(0.0, 1.0));
    workshop.write("b.obj", tetrahedron(0.2, 1.0));
    let scene = "[[body]]\nfile = \"a.obj\"\n[[body]]\nfile = \"b.obj\"\n";
    workshop.write("both.toml", scene);
    workshop.write("none.toml", format!("{scene}[[ignore]]\na = \"b\"\nb = \"a\"\n"));
    assert_eq!(workshop.check(&["both.toml"]).status, 1);
    assert_eq!(workshop.check(&["none.toml"]).status, 0);
}

/// Properties that an open body does not have are undefined, by its name.
#[test]
fn an_open_body_is_checked_as_far_as_it_goes() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 1.0));
    workshop.write("sheet.obj", "v 0.1 0.1 -1\nv 0.2 0.1 2\nv 0.1 0.2 2\nf 1 2 3\n");
    let run = workshop.check(&["bone.obj", "sheet.obj", "--json", "o.json"]);
    assert_eq!(run.status, 1, "{}", run.stdout);
    let refusal = "the inside of 'sheet' is undefined";
    assert!(
        run.stdout.contains(refusal) && run.stdout.contains("3 boundary edges"),
        "{}",
        run.stdout
    );
    let pair = &json(&workshop, "o.json")["pairs"][0];
    assert_eq!(pair["vertices_of_a_inside_b"], Value::Null);
    assert_eq!(pair["vertices_of_b_inside_a"], 0);
    assert!(pair["refusals"][0].as_str().is_some_and(|text| text.contains(refusal)), "{pair}");
}

/// A strip through a tetrahedron: one triangle inside, one on either side, and what
/// is between them cut.
#[test]
fn an_open_body_is_divided_where_it_is_crossed() {
    let workshop = Workshop::new();
    workshop.write("bone.obj", tetrahedron(0.0, 10.0));
    let strip = "v 2 1 -9\nv 3 1 -9\nv 2 1 -5\nv 3 1 1\nv 2 1 1\nv 3 1 2\nv 2 1 20\nv 3 1 21\nv 2 1 22\n\
                 f 1 2 3\nf 2 4 3\nf 3 4 5\nf 4 6 5\nf 5 6 7\nf 6 8 7\nf 7 8 9\n";
    workshop.write("strip.obj", strip);
    let run = workshop.check(&["bone.obj", "strip.obj", "--json", "o.json"]);
    let division = &json(&workshop, "o.json")["divisions"][0];
    assert_eq!((&division["body"], &division["by"]), (&"strip".into(), &"bone".into()));
    let regions = division["regions"].as_array().expect("regions");
    let found: Vec<_> = regions.iter().map(|region| (&region["side"], &region["faces"])).collect();
    let (outside, inside) = ("outside".into(), "inside".into());
    let one = 1.into();
    assert_eq!(found, [(&outside, &one), (&outside, &one), (&inside, &one)]);
    for part in ["Divided", "inside", "outside"] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}
