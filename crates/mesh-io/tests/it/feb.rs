//! FEBio models: planted parts over one list of nodes.

use std::collections::BTreeMap;

use glam::DVec3;
use mesh_io::{
    Mesh, ReadError, move_nodes, nodes_by_part, parse_mesh, parse_parts, part_names,
    replace_positions, tie_names,
};
use volume_mesh::Cell;

use crate::volumes::{NODES, cells};
use crate::{ROUNDS, Random, damaged};

/// The planted block as soft tissue, of hexahedra and of tetrahedra, and a bone of shells upon its base.
const MODEL: &str = "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<febio_spec version=\"4.0\">\n\
    <Module type=\"solid\"/>\n<Material>\n<material id=\"1\" name=\"m\" type=\"neo-Hookean\"><E>1,2</E></material>\n\
    </Material>\n<Mesh>\n<Nodes name=\"block\">\n<!-- 11 is a corner -->\n\
    <node id=\"11\">  0.0,0, 0</node>\n<node id=\"21\">1.000,0,0</node>\n<node id=\"31\">1,1,0</node>\n\
    <node id=\"41\">0,1,0</node>\n<node id=\"51\">0,0,1</node>\n<node id=\"61\">1,0,1</node>\n\
    <node id=\"71\">1,1,1</node>\n<node id=\"81\">0,1,1</node>\n</Nodes>\n<Nodes name=\"tip\">\n\
    <node id=\"5\">-3,-4,-5</node>\n<node id='91'>5e-1, 0.5,1.75</node>\n</Nodes>\n\
    <Elements type=\"hex8\" name=\"cartilage\">\n<elem id=\"3\">11,21,31,41,\n 51,61,71,81</elem>\n</Elements>\n\
    <Elements type=\"quad4\" name=\"bone\">\n<elem id=\"4\">11,21,31,41</elem>\n</Elements>\n\
    <Elements type=\"tri3\" name=\"bone\">\n<elem id=\"5\">21,11,61</elem>\n</Elements>\n\
    <Elements type=\"tet4\" name=\"muscle\">\n<elem id=\"7\">51,61,71,91</elem>\n\
    <elem id=\"8\">51,71,81,91</elem>\n</Elements>\n\
    <Elements type=\"pyra5\" name=\"pyramid\">\n<elem id=\"9\">51,61,71,81,91</elem>\n</Elements>\n\
    <Elements type=\"truss2\" name=\"spring\">\n<elem id=\"10\">51,61</elem>\n</Elements>\n\
    <Surface name=\"top\"><quad4 id=\"1\">51,61,71,81</quad4></Surface>\n\
    <NodeSet name=\"n\">11,21</NodeSet>\n</Mesh>\n<MeshDomains>\n\
    <SolidDomain name=\"cartilage\" mat=\"m\"/>\n</MeshDomains>\n</febio_spec>\n";

fn names(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|&part| part.to_owned()).collect()
}

fn part(content: &str, parts: &[&str]) -> Result<Mesh, ReadError> {
    let meshes = parse_parts(content.as_bytes(), "feb", &[&names(parts)])?;
    Ok(meshes.into_iter().next().expect("one body"))
}

/// Returns the cells of some parts with their numbers in the file.
fn numbered_cells(content: &str, parts: &[&str]) -> Vec<(u64, Cell)> {
    let volume = part(content, parts).expect(content).volume.expect("a volume mesh");
    volume.cell_numbers.into_iter().zip(volume.mesh.cells().iter().copied()).collect()
}

/// Places of the planted nodes among all of the file, in which one of another body stands before the tip.
fn cells_of_file() -> Vec<Cell> {
    let place = |node: u32| if node == 8 { 9 } else { node };
    cells()
        .into_iter()
        .map(|cell| match cell {
            Cell::Hexahedron(nodes) => Cell::Hexahedron(nodes.map(place)),
            Cell::Tetrahedron(nodes) => Cell::Tetrahedron(nodes.map(place)),
            Cell::Wedge(nodes) => Cell::Wedge(nodes.map(place)),
        })
        .collect()
}

#[test]
fn parts_are_read_by_their_names() {
    let known = part_names(MODEL.as_bytes(), "feb").expect("a model");
    assert_eq!(known, ["cartilage", "bone", "muscle", "pyramid"]);
    let [hexahedron, first, second] = cells_of_file()[..] else { panic!("three cells") };
    assert_eq!(numbered_cells(MODEL, &["cartilage"]), [(3, hexahedron)]);
    assert_eq!(numbered_cells(MODEL, &["muscle"]), [(7, first), (8, second)]);
    let both = [(3, hexahedron), (7, first), (8, second)];
    assert_eq!(numbered_cells(MODEL, &["muscle", "cartilage"]), both);

    // Of a volume mesh, vertices are nodes of its own; all nodes of the file are its nodes.
    let mesh = part(MODEL, &["muscle"]).expect("a mesh");
    assert_eq!(mesh.positions, [4, 5, 6, 7, 8].map(|node| DVec3::from_array(NODES[node])));
    assert_eq!((mesh.faces.len(), mesh.nodes), (6, Some(vec![4, 5, 6, 7, 9])));
    let numbers = mesh.vertex_numbers.expect("numbers");
    assert_eq!(numbers, [51, 61, 71, 81, 91]);
    let volume = mesh.volume.expect("a volume mesh");
    assert_eq!(volume.nodes.len(), 10);
    assert_eq!(volume.node_numbers[8..], [5, 91]);

    // All bodies of a file are read at once.
    let bodies: [&[String]; 2] = [&names(&["bone"]), &names(&["muscle"])];
    let meshes = parse_parts(MODEL.as_bytes(), "feb", &bodies).expect("a model");
    let apart = [&["bone"], &["muscle"]].map(|parts| part(MODEL, parts).expect("a mesh"));
    assert_eq!(meshes, apart);

    // Of a surface, too: lists of one name are one part.
    let bone = part(MODEL, &["bone"]).expect("a mesh");
    assert_eq!(bone.positions, [0, 1, 2, 3, 5].map(|node| DVec3::from_array(NODES[node])));
    assert_eq!(bone.faces, [[0, 1, 2], [0, 2, 3], [1, 0, 4]]);
    assert_eq!(bone.vertex_numbers, Some(vec![11, 21, 31, 41, 61]));
    assert_eq!((bone.nodes, bone.volume), (Some(vec![0, 1, 2, 3, 5]), None));
}

#[test]
fn earlier_versions_name_parts_in_other_ways() {
    let [hexahedron, first, second] = cells_of_file()[..] else { panic!("three cells") };
    let tetrahedra = [(7, first), (8, second)];
    let with_geometry = MODEL.replace("<Mesh>", "<Geometry>").replace("</Mesh>", "</Geometry>");
    assert_eq!(numbered_cells(&with_geometry, &["muscle"]), tetrahedra);
    let of_sets = with_geometry.replace("\" name=\"muscle\"", "\" mat=\"2\" elset=\"muscle\"");
    assert_eq!(numbered_cells(&of_sets, &["muscle"]), tetrahedra);
    let nameless = with_geometry.replace(" name=\"muscle\"", "");
    assert_eq!(numbered_cells(&nameless, &["part 3"]), tetrahedra);

    // Version 1 has all elements in one list, with their types as tags.
    let elements = "<Elements>\n<hex8 id=\"3\" mat=\"1\">11,21,31,41,51,61,71,81</hex8>\n\
        <tet4 id=\"7\" mat=\"2\">51,61,71,91</tet4>\n<tet4 id=\"8\" mat=\"2\">51,71,81,91</tet4>\n</Elements>\n";
    let start = with_geometry.find("<Elements").expect("elements");
    let end = with_geometry.find("<Surface").expect("a surface");
    let first_version = [&with_geometry[..start], elements, &with_geometry[end..]].concat();
    let known = part_names(first_version.as_bytes(), "feb").expect("a model");
    assert_eq!(known, ["material 1", "material 2"]);
    assert_eq!(numbered_cells(&first_version, &["material 1"]), [(3, hexahedron)]);
    assert_eq!(numbered_cells(&first_version, &["material 2"]), tetrahedra);
}

/// A part is rigid if all of its elements have rigid materials, by the numbers or the names of these.
#[test]
fn parts_are_rigid_by_their_materials() {
    let rigid = |model: &str, parts: &[&str]| part(model, parts).expect(model).is_rigid;
    let materials = "<material id=\"2\" name=\"b\" type=\"rigid body\"/>\n</Material>";
    let model = MODEL.replace("</Material>", materials);
    assert!(!rigid(&model, &["bone"]), "it has no material");
    let domains = "<ShellDomain name=\"bone\" mat=\"b\"/>\n<SolidDomain name=\"none\" mat=\"b\"/>\n\
                   </MeshDomains>";
    let model = model.replace("</MeshDomains>", domains);
    assert!(rigid(&model, &["bone"]) && !rigid(&model, &["cartilage"]));
    assert!(!rigid(&model, &["bone", "cartilage"]) && !rigid(&model, &["bone", "muscle"]));
    assert_eq!(part_names(model.as_bytes(), "feb").ok(), part_names(MODEL.as_bytes(), "feb").ok());

    // A name may be the number of another one.
    let named = model.replace("name=\"b\"", "name=\"1\"").replace("name=\"m\"", "name=\"2\"");
    let named = named.replace("mat=\"b\"", "mat=\"1\"").replace("mat=\"m\"", "mat=\"2\"");
    assert!(rigid(&named, &["bone"]) && !rigid(&named, &["cartilage"]));

    // Lists of version 2 have their materials, of which there may be two.
    let lists = MODEL.replace("<Mesh>", "<Geometry>").replace("</Mesh>", "</Geometry>");
    let lists = lists.replace("</febio_spec>", &format!("<Material>\n{materials}</febio_spec>"));
    let lists = lists.replace("\"quad4\" name=\"bone\"", "\"quad4\" mat=\"2\" name=\"bone\"");
    assert!(rigid(&lists, &["bone"]));
    let lists = lists.replace("\"tri3\" name=\"bone\"", "\"tri3\" mat=\"1\" name=\"bone\"");
    assert!(!rigid(&lists, &["bone"]), "its triangle is not");

    // Elements of version 1 have them.
    let elements = "<Elements>\n<tet4 id=\"7\" mat=\"2\">51,61,71,91</tet4>\n\
        <tet4 id=\"8\" mat=\"1\">51,71,81,91</tet4>\n</Elements>\n";
    let start = lists.find("<Elements").expect("elements");
    let end = lists.find("<Surface").expect("a surface");
    let first_version = [&lists[..start], elements, &lists[end..]].concat();
    assert!(rigid(&first_version, &["material 2"]) && !rigid(&first_version, &["material 1"]));
}

/// Names are those that a user gave: XML spells some characters otherwise, and so do files of other encodings.
#[test]
fn names_of_parts_are_decoded() {
    let named = |name: &[u8]| {
        let attribute = b"name=\"muscle\"";
        let place = MODEL.as_bytes().windows(attribute.len()).position(|bytes| bytes == attribute);
        let (before, after) = MODEL.as_bytes().split_at(place.expect("a part"));
        [before, b"name=\"", name, b"\"", &after[attribute.len()..]].concat()
    };
    for (spelled, name) in [
        (&b"T &amp; F &lt;&quot;1&quot;&gt;"[..], "T & F <\"1\">"),
        (b"F&#233;mur", "F\u{e9}mur"),
        (b"&patella; &amp; b", "&patella; &amp; b"),
        ("F\u{e9}mur".as_bytes(), "F\u{e9}mur"),
        (b"F\xe9mur", "F\u{e9}mur"),
    ] {
        let file = named(spelled);
        assert_eq!(part_names(&file, "feb").expect(name)[2], name);
        let meshes = parse_parts(&file, "feb", &[&names(&[name])]).expect(name);
        assert_eq!(meshes[0], part(MODEL, &["muscle"]).expect("a mesh"), "{name}");
    }

    // Names that differ in such a character alone are two.
    let mut file = named(b"F\xe9mur");
    let bone = file.windows(4).position(|bytes| bytes == b"bone").expect("a part");
    file.splice(bone..bone + 4, *b"F\xe8mur");
    let known = part_names(&file, "feb").expect("a model");
    assert_eq!(known[1..4], ["F\u{e8}mur", "bone", "F\u{e9}mur"]);
}

#[test]
fn ties_are_named_and_other_contacts_are_not() {
    let contacts = "<Contact>\n<contact type=\"tied-elastic\" name=\"glue\" surface_pair=\"p\">\n<penalty>1</penalty>\n\
                    </contact>\n<contact type=\"sliding-elastic\" name=\"s\"/>\n<contact type=\"tied-biphasic\"/>\n\
                    </Contact>\n</febio_spec>";
    let model = MODEL.replace("</febio_spec>", contacts);
    assert_eq!(tie_names(model.as_bytes(), "feb").expect("a model"), ["glue", "contact 2"]);
    assert!(tie_names(MODEL.as_bytes(), "feb").expect("a model").is_empty(), "none");
}

#[test]
fn nodes_are_listed_by_part_whatever_the_elements_are() {
    let nodes = nodes_by_part(MODEL.as_bytes(), "feb").expect("a model");
    let expected: [(&str, &[u32]); 5] = [
        ("bone", &[0, 1, 2, 3, 5]),
        ("cartilage", &[0, 1, 2, 3, 4, 5, 6, 7]),
        ("muscle", &[4, 5, 6, 7, 9]),
        ("pyramid", &[4, 5, 6, 7, 9]),
        ("spring", &[4, 5]),
    ];
    for (part, expected) in expected {
        assert_eq!(nodes[part].nodes, expected, "{part}");
        let is_solid = !["bone", "skin", "spring"].contains(&part);
        assert_eq!(nodes[part].are_of_solids, is_solid, "{part}");
    }
    assert_eq!(nodes.len(), expected.len(), "{:?}", nodes.keys());
}

/// A model of one part is a mesh as any file, whatever else it has.
#[test]
fn the_only_part_needs_no_name() {
    let start = MODEL.find("<Elements type=\"quad4\"").expect("a bone");
    let end = MODEL.find("<Elements type=\"truss2\"").expect("a spring");
    let single = [&MODEL[..start], &MODEL[end..]].concat();
    let mesh = parse_mesh(single.as_bytes(), "feb").expect("one part");
    assert_eq!(mesh, part(&single, &["cartilage"]).expect("one part"));
    assert_eq!(mesh.faces.len(), 12);

    // Content tells the format, whatever the file is called, and whatever editors write before it.
    let marked = format!("\u{feff}{single}");
    assert_eq!(parse_mesh(marked.as_bytes(), "xml").expect("a model"), mesh);
    let mut latin = single.replace("a corner", "a corner \u{1}").into_bytes();
    for byte in &mut latin {
        *byte = if *byte == 1 { 0xfc } else { *byte };
    }
    assert_eq!(parse_mesh(&latin, "feb").expect("other characters in a comment"), mesh);
}

#[test]
fn only_coordinates_of_moved_nodes_change() {
    let moves = BTreeMap::from([(1, DVec3::new(1.0, 0.25, 0.0)), (9, DVec3::splat(0.5))]);
    let written = move_nodes(MODEL.as_bytes(), "feb", &moves).expect("a model");
    let expected =
        MODEL.replace("1.000,0,0", "1.000,0.25,0").replace("5e-1, 0.5,1.75", "5e-1, 0.5,0.5");
    assert_eq!(String::from_utf8(written).expect("text"), expected);
    let none = BTreeMap::new();
    assert_eq!(move_nodes(MODEL.as_bytes(), "feb", &none).expect("a model"), MODEL.as_bytes());

    // All nodes, as of any file.
    let mut nodes = part(MODEL, &["muscle"]).expect("a mesh").volume.expect("a volume mesh").nodes;
    for (&node, x) in &moves {
        nodes[node as usize] = *x;
    }
    let replaced = replace_positions(MODEL.as_bytes(), "feb", &nodes).expect("a model");
    assert_eq!(String::from_utf8(replaced).expect("text"), expected);

    for (node, x) in [(10, DVec3::ZERO), (0, DVec3::NAN), (0, DVec3::INFINITY)] {
        let moves = BTreeMap::from([(node, x)]);
        assert!(move_nodes(MODEL.as_bytes(), "feb", &moves).is_err(), "{node} to {x}");
    }
    let other = move_nodes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj", &none);
    assert!(matches!(other, Err(ReadError::NoParts)), "{other:?}");
}

#[test]
fn refusals_name_parts_and_places() {
    let refusal =
        |content: String, parts: &[&str]| part(&content, parts).expect_err(&content).to_string();
    let muscle = |from: &str, to: &str| {
        assert!(MODEL.contains(from), "{from}");
        refusal(MODEL.replacen(from, to, 1), &["muscle"])
    };
    let byte = |of: &str| format!("FEB file: byte {}: ", MODEL.find(of).expect("a place"));
    let cases = [
        (
            refusal(MODEL.to_owned(), &[]),
            "has the parts 'cartilage', 'bone', 'muscle', 'pyramid': name those".to_owned(),
        ),
        (
            refusal(MODEL.to_owned(), &["bone", "spring"]),
            "has no part 'spring'; its parts are 'cartilage'".to_owned(),
        ),
        (
            refusal(MODEL.to_owned(), &["muscle", "pyramid"]),
            "elements of type 'pyra5', which a scene file may leave out, cannot be read".to_owned(),
        ),
        (
            refusal(MODEL.to_owned(), &["muscle", "pyramid"]),
            "FEB file: the part 'pyramid' with elements of type 'pyra5', which a scene file may \
             leave out, cannot be read"
                .to_owned(),
        ),
        (muscle("1,1,0<", "1,1<"), byte("1,1,0<") + "a node needs three coordinates"),
        (muscle("1,1,0<", "1,x,0<"), byte("1,1,0<") + "'x' is not a number"),
        (muscle("id=\"31\"", "id=\"21\""), byte("1,1,0<") + "node 21 is defined again"),
        (muscle("id=\"31\"", "name=\"31\""), byte("<node id=\"31\"") + "<node> has no number"),
        (muscle(">1,1,0<", "><"), "node 31 is empty".to_owned()),
        (
            muscle("51,61,71,91", "51,61,71,92"),
            byte("51,61,71,91") + "node 92 is not defined above",
        ),
        (muscle("51,61,71,91", "51,61,71"), byte("51,61,71,91") + "an element of 4 nodes has 3"),
        (muscle("51,61,71,91", "51,61,51,91"), "element 7 has node 51 twice".to_owned()),
        (muscle("51,71,81,91", "71,51,61,91"), "elements 7 and 8 have the same nodes".to_owned()),
        (muscle("51,61,71,91", "51,61,y,91"), byte("51,61,71,91") + "'y' is not a whole number"),
        (
            muscle("<Mesh>", "<Mesh from=\"mesh.feb\">"),
            "<Mesh> with the content of another file".to_owned(),
        ),
        (
            muscle("<Mesh>", "<Include>mesh.feb</Include><Mesh>"),
            "<Include> with the content of".to_owned(),
        ),
        (
            muscle("<Mesh>", "<Geometry><Part name=\"a\"><Nodes/></Part></Geometry><Mesh>"),
            "<Part>, a mesh that is placed by the model, cannot be read".to_owned(),
        ),
        (muscle("</febio_spec>", ""), "the file ends before its tags do".to_owned()),
        (muscle("</Nodes>", "</Node>"), "FEB file: byte ".to_owned()),
        (
            refusal("<febio_spec version=\"4.0\"></febio_spec>".to_owned(), &[]),
            "has 0 nodes and no tetrahedra, wedges or hexahedra".to_owned(),
        ),
    ];
    for (message, expected) in cases {
        assert!(message.contains(&expected), "{expected}: {message}");
    }
    let other = parse_parts(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj", &[&names(&["bone"])]);
    assert!(matches!(other, Err(ReadError::NoParts)), "{other:?}");
}

#[test]
fn damaged_models_never_panic() {
    let mut random = Random(21);
    for round in 0..ROUNDS {
        let file = damaged(MODEL.as_bytes(), &mut random);
        let parts: &[&str] = [&["muscle"][..], &["bone"], &[]][round % 3];
        let Ok(meshes) = parse_parts(&file, "feb", &[&names(parts)]) else { continue };
        let in_range = |&vertex: &u32| (vertex as usize) < meshes[0].positions.len();
        assert!(meshes[0].faces.iter().flatten().all(in_range), "round {round}");
    }
}
