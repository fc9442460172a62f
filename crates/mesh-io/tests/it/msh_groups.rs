//! Physical groups of Gmsh files: planted parts over one list of nodes.

use std::collections::BTreeMap;

use glam::DVec3;
use mesh_io::{
    Mesh, ReadError, move_nodes, nodes_by_part, parse_mesh, parse_parts, part_names,
    replace_positions, set_names,
};

use crate::{Random, damaged};

/// Two tetrahedra and a wedge below them in two groups, a face of the first in a third one, and a bone of two
/// triangles apart from all.
const MODEL: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n3 2 \"soft \"upper\" tissue\"\n\
    2 7 \"skin\"\n3 4 \"base\"\n2 9 \"bone\"\n$EndPhysicalNames\n\
    $Nodes\n12\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 2\n6 0 0 -1\n7 1 0 -1\n8 0 1 -1\n\
    11 5 0 0\n12 6 0 0\n13 5 1 0\n14 6 1 .5\n$EndNodes\n\
    $Elements\n7\n1 15 2 5 5 1\n2 4 2 2 1 1 2 3 4\n3 2 2 7 1 1 3 2\n4 4 2 2 1 4 2 3 5\n5 6 2 4 2 6 7 8 1 2 3\n\
    6 2 2 9 3 11 12 13\n7 2 2 9 3 12 14 13\n$EndElements\n";

/// The same in version 4.1, in which entities are in groups, and one of them in two.
const MODEL_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 7 \"skin\"\n2 9 \"bone\"\n\
    3 2 \"soft \"upper\" tissue\"\n3 4 \"base\"\n$EndPhysicalNames\n\
    $Entities\n1 0 2 2\n1 0 0 0 1 5\n1 0 0 0 1 1 0 1 7 0\n3 5 0 0 6 1 .5 1 9 0\n\
    1 0 0 0 1 1 2 1 2 1 -1\n2 -1e-7 0 -1 1 1 0 1 4 1 1\n$EndEntities\n\
    $Nodes\n2 12 1 14\n3 1 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n\
    0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 2\n0 0 -1\n1 0 -1\n0 1 -1\n2 3 0 4\n11\n12\n13\n14\n5 0 0\n6 0 0\n5 1 0\n6 1 .5\n$EndNodes\n\
    $Elements\n5 7 1 7\n0 1 15 1\n1 1\n3 1 4 2\n2 1 2 3 4\n4 4 2 3 5\n2 1 2 1\n3 1 3 2\n3 2 6 1\n5 6 7 8 1 2 3\n\
    2 3 2 2\n6 11 12 13\n7 12 14 13\n$EndElements\n";

const NAMES: [&str; 3] = ["soft \"upper\" tissue", "base", "bone"];

fn names(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|&part| part.to_owned()).collect()
}

fn part(content: &str, parts: &[&str]) -> Result<Mesh, ReadError> {
    let meshes = parse_parts(content.as_bytes(), "msh", &[&names(parts)])?;
    Ok(meshes.into_iter().next().expect("one body"))
}

fn cell_numbers(content: &str, parts: &[&str]) -> Vec<u64> {
    part(content, parts).expect(content).volume.expect("a volume mesh").cell_numbers
}

fn bodies(content: &str) -> Vec<String> {
    part_names(content.as_bytes(), "msh").expect(content)
}

#[test]
fn groups_of_solids_and_surfaces_apart_from_them_are_parts() {
    for model in [MODEL, MODEL_4] {
        assert_eq!(bodies(model), NAMES);
        assert_eq!(cell_numbers(model, &[NAMES[0]]), [2, 4]);
        assert_eq!(cell_numbers(model, &[NAMES[1]]), [5]);
        assert_eq!(cell_numbers(model, &[NAMES[1], NAMES[0]]), [2, 4, 5]);

        let bone = part(model, &["bone"]).expect(model);
        assert_eq!(bone.faces, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(bone.nodes, Some(vec![8, 9, 10, 11]));
        assert_eq!(bone.positions[3], DVec3::new(6.0, 1.0, 0.5));

        // Together they are one body, as before, whose triangles beside solids are counted.
        let whole = parse_mesh(model.as_bytes(), "msh").expect(model);
        assert_eq!(whole.volume.map(|volume| volume.cell_numbers), Some(vec![2, 4, 5]));
        assert_eq!(whole.skipped.map(|skipped| skipped.counts["triangle"]), Some(2));
        let unnamed = part(model, &[]).expect(model);
        assert_eq!(unnamed.faces, whole.faces);
    }
}

#[test]
fn parts_have_the_nodes_of_their_elements() {
    for model in [MODEL, MODEL_4] {
        let parts = nodes_by_part(model.as_bytes(), "msh").expect(model);
        let nodes = |name: &str| parts[name].nodes.clone();
        assert_eq!(parts.len(), 3, "the skin is of the solid");
        assert_eq!(nodes(NAMES[0]), [0, 1, 2, 3, 4]);
        assert_eq!(nodes("base"), [0, 1, 2, 5, 6, 7]);
        assert_eq!(nodes("bone"), [8, 9, 10, 11]);
        assert_eq!(["base", "bone"].map(|name| parts[name].are_of_solids), [true, false]);

        let moves = BTreeMap::from([(9, DVec3::new(7.0, 0.0, 0.25))]);
        let moved = move_nodes(model.as_bytes(), "msh", &moves).expect(model);
        let moved = String::from_utf8(moved).expect("text");
        let expected =
            model.replace("12 6 0 0", "12 7.0 0 0.25").replace("\n6 0 0\n", "\n7.0 0 0.25\n");
        assert_eq!(moved, expected);
    }
}

#[test]
fn elements_without_a_group_are_a_part_beside_others() {
    let loose = MODEL.replace("5 6 2 4 2", "5 6 0");
    assert_eq!(bodies(&loose), [NAMES[0], "without group", "bone"]);
    let loose = MODEL.replace("5 6 2 4 2", "5 6 2 0 2");
    assert_eq!(bodies(&loose), [NAMES[0], "without group", "bone"]);
    let loose = MODEL_4.replace("1 1 0 1 4 1 1", "1 1 0 0 1 1");
    assert_eq!(bodies(&loose), [NAMES[0], "without group", "bone"]);

    // Groups without names have those of their kind and number.
    let unnamed = MODEL.replace("3 4 \"base\"", "1 4 \"base\"");
    assert_eq!(bodies(&unnamed), [NAMES[0], "volume 4", "bone"]);
    let unnamed = MODEL.replace("2 9 \"bone\"", "1 9 \"bone\"");
    assert_eq!(bodies(&unnamed), [NAMES[0], "base", "surface 9"]);
    let same = MODEL.replace("\"bone\"", "\"base\"");
    assert_eq!(bodies(&same), [NAMES[0], "base", "base (surface)"]);
}

#[test]
fn a_file_of_one_group_is_one_body() {
    let one = MODEL.replace("5 6 2 4 2", "5 6 2 2 2").replace("2 2 9 3 ", "1 2 9 3 ");
    assert_eq!(bodies(&one), names(&[]));
    assert_eq!(set_names(one.as_bytes(), "msh").expect("one group"), [NAMES[0]]);
    assert_eq!(cell_numbers(&one, &[NAMES[0]]), [2, 4, 5]);
}

#[test]
fn groups_of_the_same_elements_are_no_bodies_beside_each_other() {
    // A group of all solids is none of the bodies; one that has some of two others leaves the file one body.
    let also = |upper: &str, base: &str| {
        let model = MODEL_4.replace("1 2 1 2 1 -1", &format!("1 2 {upper} 1 -1"));
        model.replace("1 0 1 4 1 1", &format!("1 0 {base} 1 1"))
    };
    assert_eq!(bodies(&also("1 2", "1 4")), NAMES);
    let all = also("2 2 8", "2 4 8");
    assert_eq!(bodies(&all), NAMES);
    assert_eq!(cell_numbers(&all, &["volume 8"]), [2, 4, 5]);
    let parts = nodes_by_part(all.as_bytes(), "msh").expect("a model");
    assert!(!parts["volume 8"].is_whole, "the bone is another");
    let some = also("3 2 8 9", "1 4");
    assert_eq!(bodies(&some), names(&[]));
    assert_eq!(cell_numbers(&some, &["volume 9"]), [2, 4]);

    let solids = all.replace("2 3 2 2\n6 11 12 13\n7 12 14 13", "0 1 15 2\n6 1\n7 1");
    assert_eq!(bodies(&solids), NAMES[..2]);
    let parts = nodes_by_part(solids.as_bytes(), "msh").expect("a model");
    assert!(parts["volume 8"].is_whole && !parts["base"].is_whole, "all elements of the file");
}

/// Gmsh writes an element of version 2 once for each of its groups, and turned over for one with a negative number.
const COPIES: [(&str, &str); 4] = [
    ("2 4 2 2 1 1 2 3 4\n", "20 4 2 8 1 2 1 3 4\n"),
    ("4 4 2 2 1 4 2 3 5\n", "21 4 3 8 1 1 4 2 3 5\n"),
    ("6 2 2 9 3 11 12 13\n", "22 2 2 11 3 11 13 12\n"),
    ("7 2 2 9 3 12 14 13\n", "23 2 2 11 3 12 14 13\n"),
];

/// Returns version 2 with copies of some elements: behind each, as Gmsh writes them, or at the end.
fn with_copies(copies: &[(&str, &str)], are_together: bool) -> String {
    let count = 7 + copies.len();
    let mut model = MODEL.replace("$Elements\n7\n", &format!("$Elements\n{count}\n"));
    for (element, copy) in copies {
        model = if are_together {
            model.replace(element, &format!("{element}{copy}"))
        } else {
            model.replace("$EndElements", &format!("{copy}$EndElements"))
        };
    }
    model
}

#[test]
fn copies_of_an_element_are_one_in_several_groups() {
    // The same in version 4.1, where an entity is in two groups.
    let solids = |model: &str| model.replace("1 2 1 2 1 -1", "1 2 2 2 8 1 -1");
    let base = |model: &str| model.replace("1 0 1 4 1 1", "1 0 2 4 8 1 1");
    let bone = |model: &str| model.replace("1 .5 1 9 0", "1 .5 2 9 11 0");
    let base_copy = ("5 6 2 4 2 6 7 8 1 2 3\n", "24 6 2 8 2 6 7 8 1 2 3\n");
    let [lower, upper, first, second] = COPIES;
    for (copies, model_4) in [
        (vec![lower, upper], solids(MODEL_4)),
        (vec![lower, upper, base_copy], base(&solids(MODEL_4))),
        (vec![first, second], bone(MODEL_4)),
        (vec![lower, upper, first, second], bone(&solids(MODEL_4))),
    ] {
        let model = with_copies(&copies, true);
        assert_eq!(bodies(&model), bodies(&model_4), "{model}");
        let sets = set_names(model.as_bytes(), "msh").expect(&model);
        assert_eq!(sets, set_names(model_4.as_bytes(), "msh").expect(&model_4), "{model}");
        for model in [&model, &with_copies(&copies, false)] {
            for set in &sets {
                let [two, four] = [model, &model_4].map(|model| part(model, &[set]).expect(model));
                assert_eq!(two.faces.len(), four.faces.len(), "{set} of {model}");
                assert_eq!(two.nodes, four.nodes, "{set} of {model}");
                let numbers = |mesh: Mesh| {
                    mesh.volume.map(|volume| (volume.cell_numbers, volume.node_numbers))
                };
                assert_eq!(numbers(two), numbers(four), "{set} of {model}");
            }

            // Together they are one body with each element once, and stay in the file.
            let [once, twice] =
                [MODEL, model].map(|model| parse_mesh(model.as_bytes(), "msh").expect(model));
            assert_eq!(once, twice, "{model}");
            let nodes = once.volume.expect("solids").nodes;
            let same = replace_positions(model.as_bytes(), "msh", &nodes).expect(model);
            assert!(same == model.as_bytes(), "{model}");
        }
    }

    // Of surfaces alone, each has as many faces as elements.
    let surfaces = MODEL_OF_SURFACES.replace("COPY", "");
    let twice =
        MODEL_OF_SURFACES.replace("COPY", "22 2 2 11 3 1 3 2\n").replace("\n2\n1 2", "\n3\n1 2");
    let [once, twice] =
        [surfaces, twice].map(|model| parse_mesh(model.as_bytes(), "msh").expect("a surface"));
    assert_eq!((once.faces.len(), once), (2, twice));
}

/// Elements that are in two groups of one body are taken once.
#[test]
fn a_body_of_groups_with_elements_in_common_has_each_once() {
    let [lower, _, first, _] = COPIES;
    // All of an entity in version 4.1; one element of two in version 2, turned over.
    let model_4 =
        MODEL_4.replace("1 2 1 2 1 -1", "1 2 2 2 8 1 -1").replace("1 .5 1 9 0", "1 .5 2 9 11 0");
    for model in [with_copies(&[lower, first], true), with_copies(&[lower, first], false), model_4]
    {
        let solids = cell_numbers(&model, &[NAMES[0], "volume 8"]);
        assert_eq!(solids, [2, 4], "{model}");
        let all = cell_numbers(&model, &["volume 8", "base", NAMES[0]]);
        assert_eq!(all, [2, 4, 5], "{model}");

        let bone = part(&model, &["bone", "surface 11"]).expect(&model);
        assert_eq!(bone.faces, [[0, 1, 2], [1, 3, 2]], "{model}");
    }
}

/// Elements of other numbers, or with other nodes, are others: nothing is lost.
#[test]
fn elements_of_two_groups_are_one_by_number_and_nodes() {
    let same_nodes = MODEL.replace("5 6 2 4 2 6 7 8 1 2 3", "5 4 2 4 2 1 2 3 4");
    let refusal =
        part(&same_nodes, &[NAMES[0], "base"]).expect_err("two of four nodes").to_string();
    assert_eq!(refusal, "elements 2 and 5 have the same nodes");
    let same_number = MODEL.replace("5 6 2 4 2", "2 6 2 4 2");
    assert_eq!(cell_numbers(&same_number, &[NAMES[0], "base"]), [2, 4, 2]);
    let in_one_group = MODEL.replace("4 4 2 2 1 4 2 3 5", "2 4 2 2 1 1 2 3 4");
    let refusal = part(&in_one_group, &[NAMES[0], "base"]).expect_err("twice").to_string();
    assert_eq!(refusal, "elements 2, 2 and 5 share one face: at most two may");
}

/// Two triangles, with a place for a copy of the first one.
const MODEL_OF_SURFACES: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
    4 0 0 1\n$EndNodes\n$Elements\n2\n1 2 2 9 3 1 2 3\nCOPY2 2 2 9 3 2 1 4\n$EndElements\n";

/// In one group, or of several entities, elements with the same nodes are two.
#[test]
fn elements_of_one_group_with_the_same_nodes_are_no_copies() {
    let model = |others: &[&str]| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
             $Elements\n{}\n1 4 2 2 1 1 2 3 4\n{}$EndElements\n",
            1 + others.len(),
            others.concat()
        )
    };
    for others in [
        &["2 4 2 2 1 1 2 3 4\n"][..],
        &["2 4 2 0 1 1 2 3 4\n"],
        &["2 4 0 1 2 3 4\n"],
        &["2 4 2 8 5 1 2 3 4\n"],
        &["3 4 2 8 1 1 2 3 4\n", "2 4 2 8 1 2 1 3 4\n"],
    ] {
        let model = model(others);
        let message = parse_mesh(model.as_bytes(), "msh").expect_err(&model).to_string();
        assert_eq!(message, "elements 1 and 2 have the same nodes", "{model}");
    }
    let copies = model(&["3 4 2 8 1 1 2 3 4\n", "2 4 2 9 1 2 1 3 4\n"]);
    assert_eq!(parse_mesh(copies.as_bytes(), "msh").expect("one element").faces.len(), 4);
}

#[test]
fn parts_that_cannot_be_read_are_refused_where_they_are_wanted() {
    let pyramid = MODEL.replace("5 6 2 4 2 6 7 8 1 2 3", "5 7 2 4 2 6 7 8 1 2");
    assert_eq!(bodies(&pyramid), NAMES);
    assert_eq!(cell_numbers(&pyramid, &[NAMES[0]]), [2, 4]);
    let refusal = part(&pyramid, &["base"]).expect_err("a pyramid").to_string();
    assert!(refusal.contains("the part 'base' with elements of type '7'"), "{refusal}");

    let refusal = part(MODEL, &["skin"]).expect_err("faces of a solid").to_string();
    assert!(refusal.contains("skin") && refusal.contains("bone"), "{refusal}");
    let refused = |from: &str, to: &str| {
        let content = MODEL.replace(from, to) + &MODEL_4.replace(from, to);
        part_names(content.as_bytes(), "msh").expect_err(&content).to_string()
    };
    let refusal = refused("3 4 \"base\"", "3 4 base");
    assert!(refusal.contains("line 8: a physical name stands in quotation marks"), "{refusal}");
    let refusal = refused("3 4 \"base\"", "3 x \"base\"");
    assert!(refusal.contains("line 8: a physical name has a dimension and a number"), "{refusal}");
    let cut = MODEL_4.replace("2 -1e-7 0 -1 1 1 0 1 4 1 1", "2 -1e-7 0 -1 1 1");
    let refusal = part_names(cut.as_bytes(), "msh").expect_err("no groups").to_string();
    assert!(refusal.contains("line 17: an entity has a number, a box and groups"), "{refusal}");
}

#[test]
fn surfaces_apart_are_counted_where_they_are_no_part() {
    // A triangle of the skin leads away from the solid, and so does a curved one.
    let model = MODEL.replace("3 2 2 7 1 1 3 2\n", "3 2 2 7 1 1 3 11\n").replace(
        "6 2 2 9 3 11 12 13\n7 2 2 9 3 12 14 13\n",
        "6 9 2 9 3 11 12 13 14 1 2\n7 9 2 9 3 1 2 3 4 5 6\n",
    );
    assert_eq!(bodies(&model), [NAMES[0], "base"]);
    let mesh = part(&model, &[NAMES[0]]).expect("a part");
    let counts = mesh.skipped.expect("elements apart").counts;
    let counted: Vec<_> = counts.iter().map(|(kind, count)| (kind.as_str(), *count)).collect();
    assert_eq!(counted, [("element type 9", 1), ("triangle", 1)]);
}

#[test]
fn patches_of_one_surface_are_one_body() {
    let surfaces = |second: &str| {
        let nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 5 0 0\n6 6 0 0\n7 5 1 0\n";
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n{nodes}$EndNodes\n\
             $Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 2 1 {second}\n$EndElements\n"
        )
    };
    assert_eq!(bodies(&surfaces("5 6 7")), ["surface 1", "surface 2"]);
    assert_eq!(bodies(&surfaces("2 1 4")), names(&[]));
    let whole = parse_mesh(surfaces("2 1 4").as_bytes(), "msh").expect("a surface");
    assert_eq!(whole.faces.len(), 2);
}

#[test]
fn damaged_groups_never_panic() {
    let mut random = Random(77);
    let copies = with_copies(&COPIES, true);
    for round in 0..3_000 {
        let model = [MODEL, MODEL_4, &copies][round % 3];
        let file = damaged(model.as_bytes(), &mut random);
        let Ok(known) = set_names(&file, "msh") else { continue };
        for part in &known {
            let _ = parse_parts(&file, "msh", &[std::slice::from_ref(part)]);
        }
        assert!(nodes_by_part(&file, "msh").is_ok(), "{}", String::from_utf8_lossy(&file));
    }
}
