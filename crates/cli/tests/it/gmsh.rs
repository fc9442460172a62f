//! Gmsh files of several physical groups: bodies of one file, which is written as one.

use std::fmt::Write as _;

use fixtures::volume::Block;
use glam::DVec3;

use crate::support::Workshop;

/// Two groups of hexahedra, the upper one 0.1 in the lower.
fn model() -> String {
    let lower = Block::new(DVec3::new(8.0, 8.0, 2.0), [8, 8, 3]);
    let upper = Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]);
    let upper = upper.translated(DVec3::new(2.13, 1.97, 1.9));
    let (mut nodes, mut elements) = (String::new(), String::new());
    let (mut node_count, mut element_count) = (0, 0);
    for (group, block) in (1..).zip([lower, upper]) {
        let first = node_count + 1;
        for x in &block.nodes {
            node_count += 1;
            writeln!(nodes, "{node_count} {:?} {:?} {:?}", x.x, x.y, x.z).expect("text");
        }
        for corners in &block.hexahedra {
            element_count += 1;
            let corners = corners.map(|corner| (first + corner).to_string()).join(" ");
            writeln!(elements, "{element_count} 5 2 {group} 1 {corners}").expect("text");
        }
    }
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"cartilage\"\n3 2 \"meniscus\"\n\
         $EndPhysicalNames\n$Nodes\n{node_count}\n{nodes}$EndNodes\n\
         $Elements\n{element_count}\n{elements}$EndElements\n"
    )
}

#[test]
fn groups_are_bodies_of_one_file_and_written_as_one() {
    let workshop = Workshop::new();
    workshop.write("knee.msh", model());
    let check = workshop.check(&["knee.msh"]);
    assert_eq!(check.status, 1, "{}{}", check.stdout, check.stderr);
    assert!(check.stdout.contains("cartilage × meniscus by 0.1000 mm"), "{}", check.stdout);

    let arguments =
        ["knee.msh", "--rigid", "cartilage", "--gap", "0.05", "--no-report", "--out", "apart"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let again = workshop.check(&["apart/knee.msh", "--margin", "0.049"]);
    assert_eq!(again.status, 0, "{}", again.stdout);

    // No line of the other group or of the elements differs.
    let [before, after] = ["knee.msh", "apart/knee.msh"].map(|name| workshop.read(name));
    let lines = || before.lines().zip(after.lines());
    let differs = lines().filter(|(before, after)| before != after);
    assert!(differs.clone().count() > 30, "the meniscus has moved");
    let number = |line: &str| line.split(' ').next().and_then(|word| word.parse::<u32>().ok());
    assert!(
        differs.clone().all(|(before, _)| number(before) > Some(9 * 9 * 4)),
        "the cartilage stays"
    );
    assert_eq!(before.lines().count(), after.lines().count());
}

#[test]
fn groups_of_a_body_that_names_none_are_one() {
    let workshop = Workshop::new();
    workshop.write("knee.msh", model());
    workshop.write("whole.toml", "[[body]]\nfile = \"knee.msh\"\n");
    let check = workshop.check(&["whole.toml"]);
    let note = "knee.msh is one body of 2 element sets, the first 'cartilage'";
    assert!(check.stderr.contains(note), "{}", check.stderr);
    workshop.write("one.toml", "[[body]]\nfile = \"knee.msh\"\nparts = [\"meniscus\"]\n");
    let check = workshop.check(&["one.toml"]);
    assert_eq!(check.status, 0, "{}{}", check.stdout, check.stderr);
    assert!(check.stdout.contains("meniscus"), "{}", check.stdout);
}
