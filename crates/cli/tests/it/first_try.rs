//! First use with two STL files: a picture of the contact, meshes pushed apart, a plan
//! with its reasons. Three commands, one option for the rigid femur.

use crate::support::Workshop;
use fixtures::Mesh;
use fixtures::thigh::thigh;

/// Returns a binary STL file without normals, as most programs write them.
fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = b"femur or muscle".to_vec();
    bytes.resize(80, b' ');
    let count = u32::try_from(mesh.faces.len()).expect("few faces");
    bytes.extend(count.to_le_bytes());
    for face in &mesh.faces {
        bytes.extend([0; 12]);
        for corner in face {
            let p = mesh.positions[*corner as usize].as_vec3().to_array();
            bytes.extend(p.into_iter().flat_map(f32::to_le_bytes));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn three_commands_from_two_files() {
    let scene = thigh();
    let workshop = Workshop::new();
    workshop.write("femur.stl", stl(&scene.body("femur").mesh));
    workshop.write("vastus.stl", stl(&scene.body("vastus_lateralis").mesh));
    let bodies = ["femur.stl", "vastus.stl", "--rigid", "femur"];
    let with = |more: &[&'static str]| [&bodies, more].concat();

    let seen = workshop.run("check", &with(&["--report", "contact.html"]));
    assert_eq!(seen.status, 1, "they overlap: {}{}", seen.stdout, seen.stderr);
    assert!(seen.stdout.contains("femur") && seen.stdout.contains("0.8"), "{}", seen.stdout);
    let report = workshop.read("contact.html");
    assert!(report.contains("<img") || report.contains("<svg"), "the report has a picture");

    let resolved = workshop.run("resolve", &with(&["--out", "apart"]));
    assert_eq!(resolved.status, 0, "{}{}", resolved.stdout, resolved.stderr);
    let apart = workshop.run("check", &["apart/femur.stl", "apart/vastus.stl"]);
    assert_eq!(apart.status, 0, "nothing overlaps in what was written: {}", apart.stdout);

    let planned = workshop.run("plan", &with(&["--tolerance", "0.5"]));
    assert!(planned.stdout.contains("tolerance 0.5"), "{}{}", planned.stdout, planned.stderr);
    for part in ["by operation counts", "femur", "vastus"] {
        assert!(planned.stdout.contains(part), "{part}: {}", planned.stdout);
    }
}
