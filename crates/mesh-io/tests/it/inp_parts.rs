//! Abaqus input files of several parts and instances, and of element sets: planted bodies and their places.

use std::collections::BTreeMap;

use glam::DVec3;
use mesh_io::{
    Mesh, ReadError, instances_by_part, move_nodes, nodes_by_part, parse_mesh, parse_parts,
    part_names, placement_roundings, replace_positions, set_names, tie_names,
};

use crate::volumes::INP;
use crate::{ROUNDS, Random, damaged};

/// A muscle of two tetrahedra that is placed, a bone of shells that is not, and two screws. The numbers of nodes
/// are by part, and instances are in another order than parts.
const MODEL: &str = "*Heading\n*Part, name=Bone\n*Node\n1, 0., 0, 0\n2, 4., 0., 0.\n3, 4., 4., 0.\n4, 0., 4., 0.\n\
    *Element, type=R3D4, elset=all\n1, 1, 2, 3, 4\n*Element, type=MASS\n2, 1\n*End Part\n\
    *Part, name=Screw\n*Node\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n\
    *Element, type=C3D4\n1, 1, 2, 3, 4\n*End Part\n\
    *Part, name=\"Soft tissue\"\n*Node\n 1,0.00,0, 0\n2,  1.0e0, 0., 0.\n7, 0., 1., 0.\n4, 0., 0., 1.\n\
    9, 0., 0., -1.\n*Element, type=C3D4\n5, 1, 2, 7, 4\n6, 1, 7, 2, 9\n*Element, type=S8R\n8, 1, 2, 7, 4,\n\
    1, 2, 7, 9\n*End Part\n*Part, name=ball\n*Node\n1, 0, 0, 0\n*End Part\n\
    *Assembly, name=a\n*Instance, name=muscle, part=\"soft Tissue\"\n10., 20., 30.\n\
    10., 20., 30., 10., 20., 31., 90.\n*Nset, nset=n\n1, 2\n*End Instance\n*Node\n1, 9., 9., 9.\n\
    *Instance, name=femur, part=BONE\n*End Instance\n\
    *Instance, name=screw-1, part=Screw\n 1., 1., 0.\n*End Instance\n\
    *Instance, name=\"Screw 2\", part=Screw\n 3., 1., 0.\n*End Instance\n\
    *Instance, name=ball-1, part=ball\n*End Instance\n*End Assembly\n";

pub(crate) fn names(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|&part| part.to_owned()).collect()
}

fn part(content: &str, parts: &[&str]) -> Result<Mesh, ReadError> {
    let meshes = parse_parts(content.as_bytes(), "inp", &[&names(parts)])?;
    Ok(meshes.into_iter().next().expect("one body"))
}

fn points<const N: usize>(points: [[f64; 3]; N]) -> Vec<DVec3> {
    points.map(DVec3::from_array).to_vec()
}

#[test]
fn instances_are_read_by_their_names_where_the_assembly_has_them() {
    let known = part_names(MODEL.as_bytes(), "inp").expect("a model");
    assert_eq!(known, ["muscle", "femur", "screw-1", "Screw 2"]);

    // Moved to (10, 20, 30), then turned there from x to y: by hand.
    let muscle = part(MODEL, &["Muscle"]).expect("a mesh");
    let expected = points([
        [10.0, 20.0, 30.0],
        [10.0, 21.0, 30.0],
        [9.0, 20.0, 30.0],
        [10.0, 20.0, 31.0],
        [10.0, 20.0, 29.0],
    ]);
    assert_eq!(muscle.positions, expected);
    assert_eq!(muscle.vertex_numbers, Some(vec![1, 2, 7, 4, 9]));
    assert_eq!((muscle.faces.len(), muscle.nodes), (6, Some(vec![0, 1, 2, 3, 4])));
    let volume = muscle.volume.expect("a volume mesh");
    assert_eq!((volume.nodes, volume.first_node), (expected, 0));
    assert_eq!(volume.cell_numbers, [5, 6]);
    let skipped = muscle.skipped.expect("a shell").counts;
    assert_eq!(skipped, BTreeMap::from([("S8R".to_owned(), 1)]));

    let femur = part(MODEL, &["femur"]).expect("a mesh");
    let square = [[0.0; 3], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
    assert_eq!((femur.positions, femur.faces), (points(square), vec![[0, 1, 2], [0, 2, 3]]));
    assert_eq!((femur.nodes, femur.volume), (Some(vec![5, 6, 7, 8]), None));
    assert_eq!(femur.skipped.expect("a mass").counts, BTreeMap::from([("MASS".to_owned(), 1)]));

    // One part, two places.
    let screws = ["screw-1", "SCREW 2"].map(|name| part(MODEL, &[name]).expect("a mesh"));
    for (number, (mesh, x)) in screws.iter().zip([1.0, 3.0]).enumerate() {
        let first = 9 + 4 * u32::try_from(number).expect("few");
        assert_eq!(mesh.positions[0], DVec3::new(x, 1.0, 0.0));
        assert_eq!(mesh.vertex_numbers, Some(vec![1, 2, 3, 4]));
        assert_eq!(mesh.nodes, Some((first..first + 4).collect()));
        assert_eq!(mesh.volume.as_ref().expect("a volume mesh").first_node, first);
    }

    // Bodies of several instances have the nodes of all, in the order of the file.
    let both = part(MODEL, &["Screw 2", "screw-1"]).expect("a mesh");
    let each: Vec<DVec3> = screws.iter().flat_map(|mesh| mesh.positions.clone()).collect();
    assert_eq!((both.positions, both.nodes), (each, Some((9..17).collect())));
    let cells = both.volume.expect("a volume mesh").mesh.cells().to_vec();
    assert_eq!(cells[1].nodes(), [4, 5, 6, 7]);

    let nodes = nodes_by_part(MODEL.as_bytes(), "inp").expect("a model");
    assert_eq!(nodes["muscle"].nodes, [0, 1, 2, 3, 4]);
    assert_eq!((&nodes["femur"].nodes[..], nodes["ball-1"].nodes.len()), (&[5, 6, 7, 8][..], 0));
    assert!(nodes["femur"].are_of_solids && !nodes["ball-1"].are_of_solids, "a rigid surface");
    let tied = MODEL
        .replace("*End Assembly", "*Tie, name=glue, adjust=yes\na, b\n*Tie\nc, d\n*End Assembly");
    assert_eq!(tie_names(tied.as_bytes(), "inp").expect("a model"), ["glue", "tie 2"]);
    let shared = instances_by_part(MODEL.as_bytes(), "inp").expect("a model");
    assert_eq!(shared["Screw"], ["screw-1", "Screw 2"]);
}

/// Without instances, parts are bodies; instances may have meshes of their own.
#[test]
fn meshes_stand_in_parts_or_in_instances() {
    let end = MODEL.find("*Assembly").expect("an assembly");
    let parts = &MODEL[..end];
    let known = part_names(parts.as_bytes(), "inp").expect("a model");
    assert_eq!(known, ["Bone", "Screw", "Soft tissue"]);
    let tissue = part(parts, &["soft tissue"]).expect("a mesh");
    assert_eq!(tissue.positions[1], DVec3::X);
    assert_eq!(tissue.nodes, Some(vec![8, 9, 10, 11, 12]));

    // As Abaqus/CAE writes independent instances.
    let mesh = |x: f64| {
        format!(
            "*Node\n1, {x}, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*Element, type=C3D4\n1, 1, 2, 3, 4\n"
        )
    };
    let model = format!(
        "*Part, name=p\n*End Part\n*Assembly, name=a\n*Instance, name=i, part=p\n0, 0, 5\n{}*End Instance\n\
         *Instance, name=j, part=p\n{}*End Instance\n*End Assembly\n",
        mesh(0.0),
        mesh(-1.0)
    );
    assert_eq!(part(&model, &["i"]).expect("a mesh").positions[0], 5.0 * DVec3::Z);
    assert_eq!(part(&model, &["j"]).expect("a mesh").positions[0], DVec3::NEG_X);
    assert!(instances_by_part(model.as_bytes(), "inp").expect("a model").is_empty(), "{model}");
    let moves = BTreeMap::from([(0, DVec3::new(-0.5, 0.0, 5.0)), (4, DVec3::new(-2.0, 0.0, 0.0))]);
    let moved = move_nodes(model.as_bytes(), "inp", &moves).expect("a model");
    let expected = model.replace("1, 0, 0, 0", "1, -0.5, 0, 0").replace("1, -1,", "1, -2.0,");
    assert_eq!(String::from_utf8(moved).expect("text"), expected);
}

/// One instance, which is placed, is the only body.
#[test]
fn a_placed_instance_needs_no_name() {
    let placed = INP.replace("part=block\n", "part=block\n0., 0., 1.\n0, 0, 0, 1, 0, 0, 90\n");
    let mesh = parse_mesh(placed.as_bytes(), "inp").expect("a mesh");
    let start = parse_mesh(INP.as_bytes(), "inp").expect("a mesh");
    let by_hand = |x: &DVec3| DVec3::new(x.x, -(x.z + 1.0), x.y);
    assert_eq!(mesh.positions, start.positions.iter().map(by_hand).collect::<Vec<_>>());
    assert_eq!(
        (mesh.nodes, part_names(placed.as_bytes(), "inp").expect("a model")),
        (None, vec![])
    );
    for name in ["i", "I"] {
        let named = part(&placed, &[name]).expect("a mesh");
        assert_eq!((&named.positions, &named.skipped), (&mesh.positions, &mesh.skipped), "{name}");
        assert_eq!((named.faces, named.nodes), (mesh.faces.clone(), Some((0..9).collect())));
    }
    let unknown = part(&placed, &["block"]).expect_err("an instance").to_string();
    assert_eq!(unknown, "has no part 'block'; its parts are 'i', 'base'");

    let mut nodes = mesh.volume.expect("a volume mesh").nodes;
    let same = replace_positions(placed.as_bytes(), "inp", &nodes).expect("a model");
    assert_eq!(same, placed.as_bytes());
    nodes[8] = DVec3::new(0.75, -3.0, 0.5);
    let moved = replace_positions(placed.as_bytes(), "inp", &nodes).expect("a model");
    let expected = placed.replace("91, 0.5, 5e-1, 1.75", "91, 0.75, 5e-1, 2.0");
    assert_eq!(String::from_utf8(moved).expect("text"), expected);
}

#[test]
fn moved_nodes_are_written_in_the_axes_of_their_part() {
    // Up by 1 in the assembly, along y, which is x of the part; and the bone's corner, which stands before.
    let moves = BTreeMap::from([
        (1, DVec3::new(10.0, 22.0, 30.0)),
        (3, DVec3::new(10.0, 20.0, 31.0)),
        (6, DVec3::new(4.0, 0.0, -1.0)),
    ]);
    let moved = move_nodes(MODEL.as_bytes(), "inp", &moves).expect("a model");
    let moved = String::from_utf8(moved).expect("text");
    let expected = MODEL.replace("2,  1.0e0, 0., 0.", "2,  2.0, 0., 0.").replacen(
        "2, 4., 0., 0.",
        "2, 4., 0., -1.0",
        1,
    );
    assert_eq!(moved, expected);
    let muscle = part(&moved, &["muscle"]).expect("a mesh");
    assert_eq!(muscle.positions[1], moves[&1]);
    let none = BTreeMap::new();
    assert_eq!(move_nodes(MODEL.as_bytes(), "inp", &none).expect("a model"), MODEL.as_bytes());

    // What moves in one of two places would move in the other.
    let screw = |x: DVec3| move_nodes(MODEL.as_bytes(), "inp", &BTreeMap::from([(13, x)]));
    assert_eq!(screw(DVec3::new(3.0, 1.0, 0.0)).expect("it stays"), MODEL.as_bytes());
    let refusal = screw(DVec3::new(3.0, 1.0, 0.5)).expect_err("it moves").to_string();
    assert!(refusal.starts_with("the part 'Screw' has several instances"), "{refusal}");
    for (node, x) in [(18, DVec3::ZERO), (0, DVec3::NAN), (0, DVec3::INFINITY)] {
        let moves = BTreeMap::from([(node, x)]);
        assert!(move_nodes(MODEL.as_bytes(), "inp", &moves).is_err(), "{node} to {x}");
    }

    let bodies = [names(&["femur"]), names(&["MUSCLE"]), names(&["screw-1"]), Vec::new()];
    let bodies: Vec<&[String]> = bodies.iter().map(Vec::as_slice).collect();
    let roundings = placement_roundings(MODEL.as_bytes(), "inp", &bodies, &[40.0; 4]);
    let roundings = roundings.expect("a model");
    let [femur, muscle, screw, all] = roundings[..] else { panic!("one per body: {roundings:?}") };
    assert!(femur.total_cmp(&0.0).is_eq(), "it stands where it is read");
    assert!(muscle > screw && muscle < 1e-9, "it is farther away: {muscle}, {screw}");
    assert!(all.total_cmp(&muscle).is_eq(), "the largest of all: {all}");
}

/// Two tissues over common nodes, as Gmsh and others write them, with a spring.
pub(crate) const FLAT: &str = "*Node, nset=all\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n5, 0., 0., -1.\n\
    *Element, type=C3D4, elset=Upper\n1, 1, 2, 3, 4\n*Element, elset=\"lower one\", type=C3D4\n2, 1, 3, 2, 5\n\
    *Element, type=S3, elset=skin\n3, 1, 2, 4\n*Element, type=C3D5, elset=odd\n4, 1, 2, 3, 4, 5\n\
    *Element, type=S3, elset=UPPER\n5, 2, 3, 4\n*Element, type=SPRINGA, elset=spring\n6, 4, 5\n";

#[test]
fn element_sets_of_a_flat_file_are_parts_where_they_are_named() {
    let upper = part(FLAT, &["upper"]).expect("a mesh");
    assert_eq!((upper.faces.len(), upper.nodes), (4, Some(vec![0, 1, 2, 3])));
    assert_eq!(upper.skipped.expect("a shell").counts, BTreeMap::from([("S3".to_owned(), 1)]));
    let lower = part(FLAT, &["Lower One"]).expect("a mesh");
    assert_eq!(lower.nodes, Some(vec![0, 1, 2, 4]));
    let skin = part(FLAT, &["skin"]).expect("a mesh");
    assert_eq!((skin.faces, skin.nodes), (vec![[0, 1, 2]], Some(vec![0, 1, 3])));
    let both = part(FLAT, &["lower one", "UPPER"]).expect("a mesh");
    assert_eq!(both.volume.expect("a volume mesh").cell_numbers, [1, 2]);
    let nodes = nodes_by_part(FLAT.as_bytes(), "inp").expect("a model");
    let expected: [(&str, &[u32]); 5] = [
        ("Upper", &[0, 1, 2, 3]),
        ("lower one", &[0, 1, 2, 4]),
        ("odd", &[0, 1, 2, 3, 4]),
        ("skin", &[0, 1, 3]),
        ("spring", &[3, 4]),
    ];
    for (part, expected) in expected {
        assert_eq!(nodes[part].nodes, expected, "{part}");
        let is_solid = !["bone", "skin", "spring"].contains(&part);
        assert_eq!(nodes[part].are_of_solids, is_solid, "{part}");
    }
    assert_eq!(nodes.len(), expected.len(), "{:?}", nodes.keys());

    // Sets of the only part are parts, too, and its name is that of all.
    let plain = FLAT.replace("C3D5", "T3D2");
    let one = format!("*Part, name=all\n{plain}*End Part\n");
    for sets in [&["upper"][..], &["lower one", "skin"]] {
        assert_eq!(part(&one, sets).expect("a mesh"), part(&plain, sets).expect("a mesh"));
    }
    let whole = part(&one, &["ALL"]).expect("a mesh");
    assert_eq!(whole.faces, parse_mesh(plain.as_bytes(), "inp").expect("a mesh").faces);
    for (file, expected) in [(&*one, &["Upper", "lower one", "skin"][..]), (MODEL, &[])] {
        assert_eq!(set_names(file.as_bytes(), "inp").expect("a model"), expected);
    }
    let nodes = nodes_by_part(one.as_bytes(), "inp").expect("a model");
    assert!(nodes["all"].is_whole && !nodes["Upper"].is_whole, "{nodes:?}");
    assert_eq!(nodes["all"].nodes, [0, 1, 2, 3, 4]);

    // Nodes move whatever elements there are.
    let moved = move_nodes(FLAT.as_bytes(), "inp", &BTreeMap::from([(0, DVec3::ONE)]));
    assert!(moved.is_ok_and(|moved| moved != FLAT.as_bytes()), "beside pyramids");

    // All of it is one body.
    assert!(part_names(FLAT.as_bytes(), "inp").expect("a model").is_empty(), "it is one body");
    let plain = FLAT.replace("C3D5", "T3D2");
    let whole = parse_mesh(plain.as_bytes(), "inp").expect("a mesh");
    assert_eq!((whole.faces.len(), whole.nodes), (6, None));
    let refusals = [
        (
            part(FLAT, &["odd"]),
            "the part 'odd' with elements of type 'C3D5', which a scene file may leave out, c",
        ),
        (part(FLAT, &["spring"]), "has no part 'spring'; its parts are 'Upper', 'lower one', 's"),
        (
            parse_mesh(FLAT.as_bytes(), "inp"),
            "INP file: line 13: elements of type 'C3D5' cannot be read",
        ),
    ];
    for (result, expected) in refusals {
        let refusal = result.expect_err(expected).to_string();
        assert!(refusal.contains(expected), "{refusal}");
    }

    let moves = BTreeMap::from([(4, DVec3::new(0.0, 0.0, -2.0))]);
    let moved = move_nodes(FLAT.replace("C3D5", "T3D2").as_bytes(), "inp", &moves);
    let expected = plain.replace("5, 0., 0., -1.", "5, 0., 0., -2.0");
    assert_eq!(String::from_utf8(moved.expect("a model")).expect("text"), expected);
}

/// A part is rigid if all elements of its mesh are: a mass upon it is none of them.
#[test]
fn parts_are_rigid_by_the_types_of_their_elements() {
    let rigid = |model: &str, parts: &[&str]| part(model, parts).expect(model).is_rigid;
    assert!(rigid(MODEL, &["femur"]) && !rigid(MODEL, &["muscle"]));
    assert!(!rigid(MODEL, &["femur", "screw-1"]));
    let flat = FLAT.replace("type=S3, elset=skin", "type=R3D3, elset=skin");
    assert!(rigid(&flat, &["skin"]) && !rigid(FLAT, &["skin"]) && !rigid(&flat, &["upper"]));
    let whole = |model: &str| parse_mesh(model.as_bytes(), "inp").expect(model).is_rigid;
    let shells = "*Node\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 1, 1, 0\n*Element, type=R3D3\n1, 1, 2, 3\n\
                  *Element, type=R3D3\n2, 2, 4, 3\n";
    assert!(whole(shells));
    assert!(!whole(&shells.replacen("R3D3", "S3", 1)));
}

/// Keyword lines that go on below a comma, abbreviated ones, and names that hold a comma.
#[test]
fn a_model_is_the_same_however_its_keywords_are_spelled() {
    let mut model = MODEL.to_owned();
    for (from, to) in [
        ("*Part, name=Bone\n", "*Part,\r\n  name=Bone\r\n"),
        ("*Instance, name=muscle, part=", "*Instance, name=muscle,\n** placed\n PART = "),
        ("*Instance, name=femur, part=BONE\n", "*Inst, n=femur, p=BONE,\n"),
        ("*Element, type=C3D4\n5", "*Element,\n elset=\"a, type=S3\",\n type=C3D4\n5"),
        ("6, 1, 7, 2, 9\n", "*Elem, elset=e, typ=C3D4,\n6, 1, 7, 2, 9\n"),
        ("*End Part\n*Assembly", "*End Par\n*Assem"),
    ] {
        assert!(model.contains(from), "{from}");
        model = model.replacen(from, to, 1);
    }
    assert_eq!(part_names(model.as_bytes(), "inp").ok(), part_names(MODEL.as_bytes(), "inp").ok());
    for name in ["muscle", "femur", "screw-1", "Screw 2"] {
        let (mesh, expected) = (part(&model, &[name]), part(MODEL, &[name]));
        assert_eq!(mesh.expect(name), expected.expect(name), "{name}");
    }

    let moves = BTreeMap::from([(4, DVec3::new(10.0, 20.0, 28.0))]);
    let moved = move_nodes(model.as_bytes(), "inp", &moves).expect("a model");
    let expected = model.replace("9, 0., 0., -1.", "9, 0., 0., -2.0");
    assert_eq!(String::from_utf8(moved).expect("text"), expected);
}

#[test]
fn refusals_name_parts_instances_and_lines() {
    let with = |from: &str, to: &str| {
        assert!(MODEL.contains(from), "{from}");
        let content = MODEL.replacen(from, to, 1);
        part(&content, &["muscle"]).expect_err(&content).to_string()
    };
    let line = |of: &str| {
        let place = MODEL.find(of).expect("a place");
        format!("INP file: line {}: ", MODEL[..place].lines().count() + 1)
    };
    let whole = |parts: &[&str]| part(MODEL, parts).expect_err("a refusal").to_string();
    let cases = [
        (
            whole(&[]),
            "has the parts 'muscle', 'femur', 'screw-1', 'Screw 2': name those".to_owned(),
        ),
        (whole(&["muscle", "tibia"]), "has no part 'tibia'; its parts are 'muscle', ".to_owned()),
        (whole(&["ball-1"]), "has no part 'ball-1'".to_owned()),
        (
            with("part=BONE", "part=Tibia"),
            line("*Instance, name=femur") + "'femur' is of the part 'Tibia', which",
        ),
        (
            with("name=femur, part=BONE", "name=femur"),
            "INP file: the instance 'femur' without a part cannot".to_owned(),
        ),
        (
            with("name=femur", "name=MUSCLE"),
            line("*Instance, name=femur") + "a second instance is named 'MUSCLE'",
        ),
        (with("name=femur, ", ""), line("*Instance, name=femur") + "instance 2 has no name"),
        (
            with("name=Screw", "name=bone"),
            line("*Part, name=Screw") + "a second part is named 'bone'",
        ),
        (
            with("10., 20., 30.\n10", "10., 20., up\n10"),
            line("10., 20., 30.\n10") + "'up' is no number of a tra",
        ),
        (
            with("31., 90.", "31., 90., 1."),
            line("10., 20., 30., 10") + "'1.' is no number of a rotation",
        ),
        (
            with("20., 31., 90.", "20., 30., 90."),
            line("10., 20., 30., 10") + "both points of an axis of rotation",
        ),
        (with("31., 90.", "31., 90.\n1., 2., 3."), "an instance is placed by two lines".to_owned()),
        (with("7, 0., 1., 0.", "2, 0., 1., 0."), line("7, 0., 1., 0.") + "node 2 is defined again"),
        (
            with("5, 1, 2, 7, 4", "5, 1, 2, 3, 4"),
            line("5, 1, 2, 7, 4") + "node 3 is not defined above",
        ),
        (with("6, 1, 7, 2, 9", "6, 1, 7, 1, 9"), "element 6 has node 1 twice".to_owned()),
        (
            with("*Heading\n", "*Node\n1, 0, 0, 0\n"),
            "nodes outside of its parts cannot be read".to_owned(),
        ),
        (
            with("*Heading\n", "*Include, input=a\n"),
            "the keyword 'INCLUDE' cannot be read".to_owned(),
        ),
        (
            with("*Nset, nset=n\n1, 2\n", "*Node\n1, 0, 0, 0\n"),
            "the instance 'muscle' with nodes beside those of its part cannot be read".to_owned(),
        ),
        (
            with("type=C3D4\n5", "type=C3D5\n5"),
            "the part 'muscle' with elements of type 'C3D5'".to_owned(),
        ),
    ];
    for (message, expected) in cases {
        assert!(message.contains(&expected), "{expected}: {message}");
    }

    // Of other parts, elements that cannot be read are no matter.
    let other = MODEL.replacen("type=C3D4\n1, 1", "type=C3D5\n1, 1", 1);
    assert_eq!(part(&other, &["muscle"]).expect("a mesh").faces.len(), 6);
}

/// A small file does not fill the memory.
#[test]
fn parts_are_repeated_within_limits() {
    let mut model = String::from("*Part, name=p\n*Node\n");
    for node in 1..=30_000 {
        model += &format!("{node}, 0, 0, 0\n");
    }
    model += "*Element, type=C3D4\n1, 1, 2, 3, 4\n*End Part\n*Assembly\n";
    for instance in 0..1000 {
        model += &format!("*Instance, name=i{instance}, part=p\n*End Instance\n");
    }
    let refusal = part_names(model.as_bytes(), "inp").expect_err("too many").to_string();
    assert!(refusal.contains("instances that repeat parts by more than 4194304"), "{refusal}");
}

#[test]
fn damaged_models_never_panic() {
    let rigid =
        "*Elset, elset=s, generate\n1, 9, 2\n*Elset, elset=t\ns, 4\n*Rigid Body, elset=t\n*Tie\n";
    let rigid = FLAT.to_owned() + rigid;
    let files = [(MODEL, ["muscle"]), (MODEL, ["femur"]), (FLAT, ["upper"]), (&rigid, ["upper"])];
    let mut random = Random(22);
    for round in 0..ROUNDS {
        let (file, parts) = files[round % files.len()];
        let file = damaged(file.as_bytes(), &mut random);
        let _ = (set_names(&file, "inp"), tie_names(&file, "inp"));
        let Ok(meshes) = parse_parts(&file, "inp", &[&names(&parts)]) else { continue };
        let in_range = |&vertex: &u32| (vertex as usize) < meshes[0].positions.len();
        assert!(meshes[0].faces.iter().flatten().all(in_range), "round {round}");
        let none = move_nodes(&file, "inp", &BTreeMap::new());
        assert!(none.is_err() || none.is_ok_and(|same| same == file), "round {round}");
    }
}
