//! Element types and keywords of Abaqus input files that are read, skipped or refused.

use glam::DVec3;

use crate::inp_model::{InpModel, parse};

fn node_places(file: &[u8]) -> usize {
    InpModel::read_nodes(file).expect("nodes").node_count()
}

#[test]
fn coordinates_and_elements_that_stand_elsewhere_are_refused() {
    let file = |node: &str, element: &str| {
        let nodes = "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n";
        format!("{node}\n{nodes}*Element, type=C3D4\n7, 1, 2, 3, 4\n{element}\n")
    };
    for node in ["*Node", "*NODE, SYSTEM=R, NSET=all", "*System\n** global\n*Node"] {
        assert!(parse(file(node, "").as_bytes()).is_ok(), "{node}");
    }
    for (node, element, feature) in [
        ("*Node, system = c", "", "the parameter 'SYSTEM=C' cannot be read"),
        ("*System\n0, 0, 1\n*Node", "", "line 2: the axes of the keyword 'SYSTEM' cannot be read"),
        ("*Node", "*Node, input=more.txt", "the parameter 'INPUT=MORE.TXT' cannot be read"),
        ("*Node", "*Element, type=C3D4, input=a", "the parameter 'INPUT=A' cannot be read"),
        ("*Node", "*Element, elset=a\n", "line 8: a line *ELEMENT without a type cannot be read"),
        // Abbreviated, and on two lines.
        ("*Node, sys=c", "", "line 1: the parameter 'SYSTEM=C' cannot be read"),
        ("*Node", "*Elem,\nelset=e,\n in=a", "line 8: the parameter 'INPUT=A' cannot be read"),
        ("*Node", "*Nfil\n", "line 8: the keyword 'NFIL' cannot be read"),
    ] {
        let refusal = parse(file(node, element).as_bytes()).expect_err(feature).to_string();
        assert!(refusal.contains(feature), "{refusal}");
    }
}

/// Coordinates that are left out are 0, as those of plane models are.
#[test]
fn coordinates_may_be_left_out() {
    let file = |nodes: [&str; 4]| {
        let [a, b, c, d] = nodes;
        format!("*Node\n{a}\n{b}\n{c}\n{d}\n*Element, type=CPE3\n5, 1, 2, 3\n6, 2, 4, 3\n")
    };
    let plane = ["1", "2, 2.", "3, 0., 1.", "4, 2., 1.5,"];
    let x = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.5]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let out_of_plane = ["1, 0.0, 0.0, 0.5", "2, 2., 0.0, 0.5", "3, 0., 1., 0.5", "4, 2., 1.5,0.5"];
    let turned = ["1", "2, 0.0, 2.0", "3, 1.0, 0.0", "4, 1.5, 2.0,"];
    for (moved, expected) in [
        (x, plane),
        (x.map(|x| x + 0.5 * DVec3::Z), out_of_plane),
        (x.map(|x| DVec3::new(x.y, x.x, 0.0)), turned),
    ] {
        for end in ["\n", "\r\n", " \r\n", "\r"] {
            let [content, expected] = [plane, expected].map(|nodes| file(nodes).replace('\n', end));
            let mesh = parse(content.as_bytes()).expect(&content);
            assert_eq!((&mesh.positions[..], mesh.faces.len()), (&x[..], 2), "{content}");
            let written = crate::replace_positions(content.as_bytes(), "inp", &moved);
            let written = written.expect(&content);
            assert_eq!(String::from_utf8(written).expect("text"), expected);
            let read = parse(expected.as_bytes()).expect(&expected);
            assert_eq!(read.positions, moved, "{expected}");
        }
    }
}

#[test]
fn coordinates_have_exponents_of_fortran_and_may_be_blank() {
    let file = |first: &str, second: &str| {
        format!(
            "*Node\n1, {first}\n2, {second}\n3, 0, 1, 0\n4, 0, 0, 1\n*Element, type=C3D4\n7, 1, 2, 3, 4\n"
        )
    };
    let content = file("-1234.5D-2, , -12345d-3", "1.,0.,");
    let nodes =
        |content: &str| parse(content.as_bytes()).map(|read| read.volume.expect("a volume").nodes);
    let read = nodes(&content).expect("a mesh");
    assert_eq!(read[..2], [DVec3::new(-12.345, 0.0, -12.345), DVec3::X]);

    // What is written stands in its place, also where that was blank.
    let mut moved = read.clone();
    (moved[0], moved[1]) = (DVec3::new(0.5, 0.25, -12.345), DVec3::new(1.0, 0.0, 8.0));
    let written = crate::replace_positions(content.as_bytes(), "inp", &moved).expect("a copy");
    let written = String::from_utf8(written).expect("text");
    assert_eq!(nodes(&written).expect(&written), moved, "{written}");

    // Where only one coordinate moves, blanks stay, and lines end as they did.
    let content = file(" , ,0.", "1.,0., ").replace('\n', "\r\n");
    let moved = [DVec3::Z, DVec3::new(1.0, 0.0, 8.0), DVec3::Y, DVec3::Z];
    let written = crate::replace_positions(content.as_bytes(), "inp", &moved).expect("a copy");
    let expected = file(" , ,1.0", "1.,0.,8.0 ").replace('\n', "\r\n");
    assert_eq!(String::from_utf8(written).expect("text"), expected);

    for wrong in ["1.D, 0, 0", "1.D0D0, 0, 0", "D, 0, 0", "1.F0, 0, 0", "1 D0, 0, 0"] {
        let error = parse(file(wrong, "1, 0, 0").as_bytes()).expect_err(wrong).to_string();
        assert!(error.contains("line 2") && error.contains("is not a number"), "{error}");
    }
}

/// A tetrahedron, a file with `before` it, and `behind` it.
fn around(before: &str, behind: &str) -> String {
    let nodes = "*Node\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n";
    format!("{before}{nodes}*Element, type=C3D4\n7, 1, 2, 3, 4\n{behind}")
}

#[test]
fn solids_of_other_families_are_read_or_refused() {
    let cells = |behind: &str| {
        let mesh = parse(around("", behind).as_bytes());
        mesh.map(|mesh| mesh.volume.map_or(0, |volume| volume.mesh.cells().len()))
    };
    for kind in ["C3D8P", "C3D8RPHT", "DC3D8E", "DCC3D8", "AC3D8R", "Q3D8", "SC8R", "CSS8"] {
        let nodes = "*Node\n11,0,0,2\n12,1,0,2\n13,1,1,2\n14,0,1,2\n15,0,0,3\n16,1,0,3\n\
                     17,1,1,3\n18,0,1,3\n";
        let hexahedron =
            format!("{nodes}*Element, type={kind}\n8, 11, 12, 13, 14, 15, 16, 17, 18\n");
        assert_eq!(cells(&hexahedron).expect(kind), 2, "{kind}");
    }
    for kind in ["C3D6", "C3D6H", "AC3D6", "DC3D6", "Q3D6", "SC6R", "CSS6"] {
        let nodes = "*Node\n11,0,0,2\n12,1,0,2\n13,1,1,2\n15,0,0,3\n16,1,0,3\n17,1,1,3\n";
        let wedge = format!("{nodes}*Element, type={kind}\n8, 11, 12, 13, 15, 16, 17\n");
        assert_eq!(cells(&wedge).expect(kind), 2, "{kind}");
    }
    for kind in ["AC3D4", "DC3D4", "Q3D4T"] {
        let tetrahedron = format!("*Node\n9, 1, 1, 1\n*Element, type={kind}\n8, 2, 4, 3, 9\n");
        assert_eq!(cells(&tetrahedron).expect(kind), 2, "{kind}");
    }
    for kind in [
        "C3D5", "C3D27R", "AC3D5", "EC3D8R", "EMC3D8", "FC3D8", "CIN3D8", "ACIN3D4", "COH3D8",
        "COH3D6", "GK3D8", "CCL12", "CSS12", "C3D",
    ] {
        let error = cells(&format!("*Element, type={kind}\n8, 1, 2, 3\n")).expect_err(kind);
        assert!(error.to_string().contains(&format!("elements of type '{kind}'")), "{error}");
    }
    for kind in ["S4R", "M3D4", "R3D3", "SFM3D4", "T3D2", "B31", "CONN3D2", "DCOUP3D", "CPE4", "U1"]
    {
        let behind = format!("*Element, type={kind}\n8, 1, 2,\n3\n9, 1, 2\n");
        assert_eq!(cells(&behind).expect(kind), 1, "{kind}");
        let skipped = parse(around("", &behind).as_bytes()).expect(kind).skipped;
        let counts = skipped.expect(kind).counts;
        assert_eq!(counts.into_iter().collect::<Vec<_>>(), [(kind.to_owned(), 2)]);
    }
    assert_eq!(parse(around("", "").as_bytes()).expect("a mesh").skipped, None);
}

/// An assembly numbers its reference points by itself.
#[test]
fn reference_points_of_an_assembly_are_left_out() {
    let assembly = |inside: &str| {
        let behind = format!(
            "*End Part\n*Assembly, name=a\n*Instance, name=i, part=p\n*End Instance\n{inside}\
             *End Assembly\n*Nset, nset=late\n1,\n"
        );
        around("*Part, name=p\n", &behind)
    };
    let points = "*Node\n1, 5, 6, 7\n*Node, nset=point\n900, 5, 6, 7\n*Nset, nset=r\n1,\n\
                  *Element, type=CONN3D2\n1, 1, i.3\n";
    let content = assembly(points);
    let volume = parse(content.as_bytes()).expect("a mesh").volume.expect("a volume");
    assert_eq!(volume.node_numbers, [1, 2, 3, 4]);
    assert_eq!(node_places(content.as_bytes()), 4);

    // Of an instance that has nodes of its own they are the mesh.
    let own = around("*Part, name=p\n*End Part\n*Assembly\n*Instance, name=i, part=p\n", "");
    let own = format!("{own}*End Instance\n*Node\n1, 5, 6, 7\n*End Assembly\n");
    let volume = parse(own.as_bytes()).expect("a mesh").volume.expect("a volume");
    assert_eq!(volume.nodes[0], DVec3::ZERO);

    let solid = assembly("*Element, type=C3D4\n8, 1, 2, 3, 4\n");
    let error = parse(solid.as_bytes()).expect_err("elements without a part").to_string();
    assert!(error.contains("solid elements of an assembly"), "{error}");
}
