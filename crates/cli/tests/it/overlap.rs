//! Measured overlaps of planted scenes: table, JSON and VTP.

use crate::support::{Workshop, obj};
use fixtures::shapes::{cube, icosphere};
use fixtures::{Mesh, damage};
use glam::DVec3;
use serde_json::Value;

/// Returns a mesh with its volume above 0.
fn outward(mesh: Mesh) -> Mesh {
    if mesh.volume() > 0.0 { mesh } else { mesh.flipped() }
}

/// Two wedges whose ridges cross at right angles, 0.25 into each other.
fn crossed_wedges() -> [Mesh; 2] {
    let positions = [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, -3.0, -3.0], [0.0, 3.0, -3.0]];
    let positions = positions.map(DVec3::from).to_vec();
    let lower =
        outward(Mesh { positions, faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] });
    let upper = outward(lower.clone().mapped(|p| DVec3::new(p.y, p.x, -p.z - 0.25)));
    [lower, upper]
}

/// Checks two bodies; returns the table without its times, and the JSON of the pair.
fn check(a: &Mesh, b: &Mesh) -> (String, Value) {
    let workshop = Workshop::new();
    workshop.write("a.obj", obj(a));
    workshop.write("b.obj", obj(b));
    let run = workshop.check(&[
        "a.obj",
        "b.obj",
        "--margin",
        "1",
        "--depth-tolerance",
        "1e-6",
        "--json",
        "o.json",
    ]);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let (table, _) = run.stdout.trim_end().rsplit_once("\nwrote ").expect("one file is written");
    let document: Value = serde_json::from_str(&workshop.read("o.json")).expect("JSON");
    (table.to_owned(), document["pairs"][0].clone())
}

fn near(value: &Value, expected: f64) -> bool {
    value.as_f64().is_some_and(|value| (value - expected).abs() < 1e-6)
}

#[test]
fn boxes_that_share_half_their_volume() {
    let a = cube(10.0);
    let (table, pair) = check(&a, &a.clone().translated(DVec3::X * 5.0));
    insta::assert_snapshot!("boxes_that_share_half", table);
    assert!(near(&pair["overlap"]["volume"], 500.0), "{pair}");
    assert!(near(&pair["overlap"]["flush_area"], 200.0), "{pair}");
    assert!(near(&pair["overlap"]["area_of_a_inside_b"], 100.0), "{pair}");
    assert!(near(&pair["depth_of_a_in_b"]["upper"], 5.0), "{pair}");
    assert_eq!(pair["overlap"]["centroid"], serde_json::json!([2.5, 0.0, 0.0]));
}

#[test]
fn a_body_given_twice_is_named_at_the_top() {
    let (table, pair) = check(&cube(10.0), &cube(10.0));
    insta::assert_snapshot!("a_body_given_twice", table);
    let top: Vec<&str> = table.lines().take(10).collect();
    assert!(top.iter().any(|line| line.contains("a and b are one mesh")), "{table}");
    assert_eq!(pair["coincidence"], "same_mesh");
    assert!(near(&pair["overlap"]["volume"], 1000.0), "{pair}");
}

#[test]
fn edges_alone_have_a_depth() {
    let [a, b] = crossed_wedges();
    let (table, pair) = check(&a, &b);
    insta::assert_snapshot!("edges_alone", table);
    assert_eq!(pair["max_vertex_depth"], 0.0);
    assert!(near(&pair["depth_of_a_in_b"]["lower"], 0.25 / 2.0_f64.sqrt()), "{pair}");
    let regions = pair["overlap"]["regions"].as_array().expect("regions");
    assert_eq!((regions.len(), &pair["overlap"]["curve_loops"]), (1, &1.into()));
}

#[test]
fn an_open_sheet_in_a_box() {
    let sheet = Mesh {
        positions: [[-1.0, -1.0, 2.0], [3.0, -1.0, 2.0], [-1.0, 3.0, 2.0]].map(DVec3::from).into(),
        faces: vec![[0, 1, 2]],
    };
    let (table, pair) = check(&cube(10.0), &sheet);
    insta::assert_snapshot!("an_open_sheet", table);
    assert_eq!(pair["overlap"]["volume"], Value::Null);
    assert!(near(&pair["overlap"]["area_of_b_inside_a"], 8.0), "{pair}");
    assert!(near(&pair["depth_of_b_in_a"]["lower"], 3.0), "{pair}");
    assert_eq!(pair["depth_of_a_in_b"], Value::Null);
}

/// Every figure of a pair, in the order of the names.
#[test]
fn the_json_of_a_pair() {
    let [a, b] = crossed_wedges();
    let (_, pair) = check(&a, &b);
    insta::with_settings!({ sort_maps => true }, { insta::assert_json_snapshot!("pair", pair) });
}

#[test]
fn two_bodies_doubled_within_one_are_named() {
    let workshop = Workshop::new();
    workshop.write("a.obj", obj(&cube(10.0).joined(&cube(10.0))));
    workshop.write("b.obj", obj(&cube(2.0)));
    let run = workshop.check(&["a.obj", "b.obj"]);
    assert_eq!(run.status, 1, "{}", run.stdout);
    assert!(run.stdout.contains("'a' covers a place more than once"), "{}", run.stdout);
}

/// A cavity that is given the wrong way round is a defect of its body, and covers a place twice where the
/// other body is around it.
#[test]
fn a_cavity_facing_outward_is_named() {
    let (table, pair) = check(&cube(20.0).joined(&cube(10.0)), &cube(11.0));
    assert!(table.contains("1 part facing the wrong way"), "{table}");
    assert!(table.contains("that of vertex 8 at ("), "{table}");
    assert!(table.contains("'a' covers a place more than once"), "{table}");
    assert!(table.contains(" by at least "), "{table}");
    assert_eq!(pair["depth_of_b_in_a"], Value::Null, "{pair}");

    let (table, pair) = check(&cube(20.0).joined(&cube(10.0).flipped()), &cube(11.0));
    assert!(!table.contains("wrong way") && !table.contains("more than once"), "{table}");
    assert!(near(&pair["overlap"]["volume"], 331.0), "{pair}");
}

/// A surface with a hole has no inside by parity; what it surrounds overlaps it all the same.
#[test]
fn what_lies_in_a_body_with_a_hole_overlaps_it() {
    let hollow = damage::hole(icosphere(10.0, 3), 10.0 * DVec3::X, 2.0);
    let (table, pair) = check(&hollow, &icosphere(2.0, 2));
    assert!(table.contains("≥ ") && table.contains(" by at least "), "{table}");
    assert!(
        table.contains("'a' surrounds 'b', and its inside is undefined (no inside: "),
        "{table}"
    );
    assert_eq!(pair["overlaps"], true, "{pair}");
    assert_eq!(pair["vertices_of_b_inside_a"], Value::Null, "{pair}");
    assert!(pair["max_vertex_depth"].as_f64().expect("a depth") > 7.9, "{pair}");
}

/// Every face of a surface that is not welded is a region: the largest have rows, and one row has the others.
#[test]
fn many_regions_of_a_surface_have_one_row() {
    let ball = icosphere(10.0, 2);
    let corners = ball.faces.iter().flatten().map(|&corner| ball.positions[corner as usize]);
    let first_corners = (0..).step_by(3).zip(&ball.faces);
    let faces = first_corners.map(|(first, _)| [first, first + 1, first + 2]);
    let soup = Mesh { positions: corners.collect(), faces: faces.collect() };
    let (table, _) = check(&soup, &icosphere(4.0, 2).translated(9.0 * DVec3::X));
    assert!(table.contains(" smaller regions") && table.lines().count() < 40, "{table}");
    assert!(table.contains("merge those at one place"), "{table}");
}

/// Two objects of an OBJ file are one body, which is told.
#[test]
fn objects_of_one_file_are_counted() {
    let workshop = Workshop::new();
    let ball = obj(&icosphere(2.0, 1));
    let count = icosphere(2.0, 1).positions.len();
    let second = "f 43 44 45\n".replace("43", &(count + 1).to_string());
    let second =
        second.replace("44", &(count + 2).to_string()).replace("45", &(count + 3).to_string());
    workshop.write(
        "two.obj",
        format!("o one\n{ball}o empty\no two\nv 9 0 0\nv 9 1 0\nv 9 0 1\n{second}"),
    );
    workshop.write("one.obj", format!("o one\ng a\n{ball}"));
    let run = workshop.check(&["two.obj", "one.obj"]);
    let warning =
        "warning: two.obj: 2 objects as one body: save each in a file of its own for several\n";
    assert_eq!(run.stderr, warning);
    assert!(run.stdout.contains("2 objects as one body"), "{}", run.stdout);
}

#[test]
fn patches_and_curves_are_written_as_vtp() {
    let workshop = Workshop::new();
    let [a, b] = crossed_wedges();
    workshop.write("a.obj", obj(&a));
    workshop.write("b.obj", obj(&b));
    // The third body has the name that the clipped faces of `a` would have.
    workshop.write("a_in_b.obj", obj(&a.translated(DVec3::X * 50.0)));
    let run = workshop.check(&["a.obj", "b.obj", "a_in_b.obj", "--vtp", "o"]);
    assert_eq!(run.status, 1, "{}", run.stdout);
    let names = workshop.listing();
    for name in ["o/a_in_b.vtp", "o/a_in_b_2.vtp", "o/b_in_a.vtp", "o/a_b_curve.vtp"] {
        assert!(names.iter().any(|found| found == name), "{name} is not in {names:?}");
    }

    // The ridge of each is cut on both sides: two faces are clipped to triangles.
    let patch = workshop.read("o/b_in_a.vtp");
    for part in ["NumberOfPolys=\"2\"", "Name=\"depth\"", "Name=\"face\"", "Name=\"region\""] {
        assert!(patch.contains(part), "{part}: {patch}");
    }
    let curve = workshop.read("o/a_b_curve.vtp");
    for part in ["NumberOfLines=\"1\"", "NumberOfPoints=\"4\"", "Name=\"loop\""] {
        assert!(curve.contains(part), "{part}: {curve}");
    }
}

/// Sides of 10 × 10 that are 0.5 apart, and 0.5 of the sides around them.
#[test]
fn near_pairs_have_an_area_within_the_margin() {
    let workshop = Workshop::new();
    workshop.write("a.obj", obj(&cube(10.0)));
    workshop.write("b.obj", obj(&cube(10.0).translated(DVec3::X * 10.5)));
    let run = workshop.check(&["a.obj", "b.obj", "--margin", "1", "--json", "o.json"]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let document: Value = serde_json::from_str(&workshop.read("o.json")).expect("JSON");
    for name in ["near_area_of_a", "near_area_of_b"] {
        let area = &document["pairs"][0][name];
        let [lower, upper] = ["lower", "upper"].map(|end| area[end].as_f64().expect("an area"));
        let exact = 100.0 + 4.0 * 10.0 * 0.5;
        assert!(lower <= exact && exact <= upper && upper - lower <= 0.05 * upper, "{area}");
    }
}

#[test]
fn tolerances_out_of_range_are_rejected() {
    let workshop = Workshop::new();
    workshop.write("a.obj", obj(&cube(1.0)));
    let run = workshop.check(&["a.obj", "--depth-tolerance", "-1"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    assert!(run.stderr.contains("the depth tolerance is -1"), "{}", run.stderr);
}
