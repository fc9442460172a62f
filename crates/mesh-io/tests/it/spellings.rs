//! Text files as other programs spell them.

use glam::DVec3;
use mesh_io::{Mesh, MeshFormat, ReadError, Space, parse_mesh, replace_positions};

const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, 0.5, 0.0)];

/// Returns the refusal of a file.
fn refusal(mesh: Result<Mesh, ReadError>) -> String {
    mesh.expect_err("a refusal").to_string()
}

#[test]
fn stl_keywords_are_read_in_any_case() {
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                vertex 0 .5 0\nendloop\nendfacet\nendsolid a\n";
    for spelled in [text.to_owned(), text.to_uppercase(), text.replace('\n', "\r\n")] {
        for extension in ["stl", "dat"] {
            let mesh = parse_mesh(spelled.as_bytes(), extension).expect(&spelled);
            assert_eq!((&mesh.positions[..], &mesh.faces[..]), (&CORNERS[..], &[[0, 1, 2]][..]));
        }
        let moved = CORNERS.map(|x| x + DVec3::Z);
        let written = replace_positions(spelled.as_bytes(), "stl", &moved).expect("a file");
        assert_eq!(parse_mesh(&written, "stl").expect("a mesh").positions, moved);
    }
    let error = refusal(parse_mesh(text.replace(".5", "0.5f").as_bytes(), "stl"));
    assert!(error.contains("line 6: a vertex needs three coordinates"), "{error}");
}

/// Returns a file in which lines end with a carriage return alone.
fn with_returns(file: &[u8]) -> Vec<u8> {
    file.iter().map(|&byte| if byte == b'\n' { b'\r' } else { byte }).collect()
}

/// As on Macs of the last century, and by some exporters since.
#[test]
fn lines_may_end_with_a_carriage_return() {
    let mesh = [&CORNERS[..], &[DVec3::Z]].concat();
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let nodes = "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 0.5, 0\n4, 0, 0, 1\n";
    let inp = format!("*Heading\n** a\n*Node\n{nodes}*Element, type=C3D4\n7, 1,\n2, 3, 4\n");
    let msh = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n{}$EndNodes\n$Elements\n1\n\
         1 4 0 1 2 3 4\n$EndElements\n",
        nodes.replace(',', "")
    );
    let comment = |format: MeshFormat| {
        let file = String::from_utf8(format.encode(&mesh, &tetrahedron, None)).expect("text");
        let has_comments = matches!(format, MeshFormat::Obj | MeshFormat::Off);
        if has_comments { format!("# SPACE=RAS\n\n{file}") } else { file }
    };
    let ply = "ply\nformat ascii 1.0\ncomment a[\nelement vertex 4\nproperty double x\n\
               property double y\nproperty double z\nelement face 4\n\
               property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 .5 0\n0 0 1\n\
               3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    for (extension, file) in [
        ("obj", comment(MeshFormat::Obj)),
        ("off", comment(MeshFormat::Off)),
        ("stl", comment(MeshFormat::Stl).replacen("surface", "SPACE=RAS", 1)),
        ("vtp", comment(MeshFormat::Vtp)),
        ("ply", ply.to_owned()),
        ("ply", format!("{ply}\n\n")),
        ("inp", inp),
        ("msh", msh),
    ] {
        let plain = parse_mesh(file.as_bytes(), extension).expect(extension);
        let moved: Vec<_> = plain.positions.iter().map(|x| *x + DVec3::Z).collect();
        let written = replace_positions(file.as_bytes(), extension, &moved).expect(extension);
        let returns = with_returns(file.as_bytes());
        assert_eq!(parse_mesh(&returns, extension).expect(extension), plain, "{extension}");
        let replaced = replace_positions(&returns, extension, &moved).expect(extension);
        assert_eq!(replaced, with_returns(&written), "{extension}");

        // One line that ends otherwise, as of files that are put together, changes nothing.
        let mut mixed = returns.clone();
        let last = mixed.iter().rposition(|&byte| byte == b'\r').expect("a line");
        mixed[last] = b'\n';
        assert_eq!(parse_mesh(&mixed, extension).expect(extension), plain, "{extension}");
    }

    // Lines are counted, and two returns before a line feed are one end of a line.
    let refused = with_returns(b"v 0 0 0\n\nv 1 0 0\nv 0 1\nf 1 2 3\n");
    assert!(refusal(parse_mesh(&refused, "obj")).contains("line 4: a vertex needs three"));
    let doubled = b"v 0 0 0\r\r\nv 1 0 0\r\nv 0 1\r\r\nf 1 2 3\r\r\n";
    assert!(refusal(parse_mesh(doubled, "obj")).contains("line 3: a vertex needs three"));
    let longer = with_returns(format!("{ply}\n  more\n").as_bytes());
    let unread = parse_mesh(&longer, "ply").expect("a mesh").unread.expect("more");
    assert_eq!(unread.to_string(), "5 bytes from line 20 on, behind the declared end, not read");
}

/// Bytes behind a header are no lines, whatever they are.
#[test]
fn binary_content_has_no_lines() {
    let corners = CORNERS.map(|x| x + DVec3::X * f64::from_le_bytes(*b"\n\r\n\r\r\n\0\x40"));
    let file = MeshFormat::Ply.encode(&corners, &[[0, 1, 2]], None);
    let header = file.windows(11).position(|window| window == b"end_header\n").expect("an end");
    let returns = [with_returns(&file[..header + 11]), file[header + 11..].to_vec()].concat();
    for file in [&file, &returns] {
        let mesh = parse_mesh(file, "ply").expect("a mesh");
        assert_eq!((&mesh.positions[..], mesh.unread), (&corners[..], None));
        let moved = replace_positions(file, "ply", &CORNERS).expect("a file");
        assert_eq!(parse_mesh(&moved, "ply").expect("a mesh").positions, CORNERS);
        assert_eq!(moved[..header + 11], file[..header + 11]);
    }
}

/// Shells of Windows write it where a program's output goes to a file.
#[test]
fn text_in_utf_16_is_refused_by_name() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for extension in ["obj", "ply", "off", "inp", "feb", "msh", "vtk", "vtu", "stl", "txt"] {
        for [mark, swapped] in [[0xff, 0xfe], [0xfe, 0xff]] {
            let mut file = vec![mark, swapped];
            for unit in triangle.encode_utf16() {
                let bytes = unit.to_le_bytes();
                file.extend(if mark == 0xff { bytes } else { [bytes[1], bytes[0]] });
            }
            let message = refusal(parse_mesh(&file, extension));
            assert_eq!(message, "is text in UTF-16: save it in UTF-8", "{extension}");
        }
    }

    // The header of a binary STL file is any bytes.
    let mut stl = [vec![b' '; 80], vec![1, 0, 0, 0], vec![0; 50]].concat();
    for (corner, axis) in [(1, 0), (2, 1)] {
        let at = 84 + 12 + 12 * corner + 4 * axis;
        stl[at..at + 4].copy_from_slice(&1.0_f32.to_le_bytes());
    }
    stl[..2].copy_from_slice(b"\xff\xfe");
    assert_eq!(parse_mesh(&stl, "stl").expect("a triangle").faces.len(), 1);
}

/// Returns a text file with a list of properties and the values of the vertices.
fn ply(properties: &str, vertices: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{properties}element face 1\n\
         property list uchar int vertex_indices\nend_header\n{vertices}3 0 1 2\n"
    )
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

#[test]
fn ply_numbers_are_read_as_c_writes_them() {
    let properties = format!("{XYZ}property float nx\nproperty uchar red\n");
    let vertices = ["0. +0 0.e0 nan 255\n\t1 0 -0. -nan +7\n0 .5 0 inf 0\n"];
    for vertices in vertices {
        let file = ply(&properties, vertices);
        for file in [file.clone(), file.replace('\n', "\r\n")] {
            let mesh = parse_mesh(file.as_bytes(), "ply").expect(&file);
            assert_eq!((&mesh.positions[..], &mesh.faces[..]), (&CORNERS[..], &[[0, 1, 2]][..]));
            assert_eq!(mesh.unread, None);
        }
    }

    // Others are refused by their line, and so are coordinates that are not finite.
    for number in ["0 # c", "1.0f", "1d0", "1,0", "0x1", "nan", "inf", "-", "1.#QNAN"] {
        let file = ply(XYZ, &format!("0 0 0\n1 0 {number}\n0 1 0\n"));
        let error = refusal(parse_mesh(file.as_bytes(), "ply"));
        let expected = format!("line 11: Couldn't read element line: '1 0 {number}'");
        assert!(error.contains(&expected), "{error}");
    }
    let file = ply(XYZ, ".0 0 0\n1 0 0\n0 1\n");
    let error = refusal(parse_mesh(file.as_bytes(), "ply"));
    assert!(error.contains("line 12: Couldn't read element line: '0 1'"), "{error}");
}

/// Names of properties are words, whatever they consist of; comments are any text.
#[test]
fn ply_names_are_any_words() {
    let comments = "comment f\u{fc}r dich\nobj_info num_cols 5\ncomment\nobj_info\n";
    for name in ["scalar_C2C[<0.1]", "0", "confidence(%)", "Z\u{e9}ro", "vertex.indices", "-"] {
        let properties = format!("{comments}property uchar {name}\n{XYZ}");
        let text = ply(&properties, "9 0 0 0\n9 1 0 0\n9 0 0.5 0\n");
        for text in [text.clone(), text.replace("element face", "element odd+name 0\nelement face")]
        {
            let mut latin = text.clone().into_bytes();
            latin.splice(..text.len(), text.chars().map(|c| u8::try_from(c).expect("Latin 1")));
            for file in [text.into_bytes(), latin] {
                let mesh = parse_mesh(&file, "ply").expect(name);
                assert_eq!(mesh.positions, CORNERS, "{name}");
                let moved = CORNERS.map(|x| x + DVec3::Z);
                let written = replace_positions(&file, "ply", &moved).expect(name);
                assert_eq!(parse_mesh(&written, "ply").expect(name).positions, moved, "{name}");
                let again = replace_positions(&written, "ply", &CORNERS).expect(name);
                assert_eq!(again.len(), written.len(), "{name}");
            }
        }
    }

    // One letter takes the place of another, but of none that has a meaning.
    let names_of = |count: usize| {
        let names = "0123456789!#$%&'()*+,./:;".chars().take(count);
        names.map(|name| format!("property uchar {name}\n")).collect::<String>()
    };
    for (count, is_read) in [(24, true), (25, false)] {
        let vertices = CORNERS.map(|x| format!("{}{} {} {}\n", "7 ".repeat(count), x.x, x.y, x.z));
        let mesh = parse_mesh(ply(&(names_of(count) + XYZ), &vertices.concat()).as_bytes(), "ply");
        assert_eq!(mesh.is_ok_and(|mesh| mesh.positions == CORNERS), is_read, "{count}");

        let without_x = XYZ.replace("property float x\n", "");
        let names = names_of(count) + &without_x;
        assert!(parse_mesh(ply(&names, &vertices.concat()).as_bytes(), "ply").is_err(), "{count}");
    }

    let file = ply(&format!("{XYZ}property odd w\n"), "0 0 0 0\n1 0 0 0\n0 1 0 0\n");
    let error = refusal(parse_mesh(file.as_bytes(), "ply"));
    assert!(error.contains("Couldn't parse line: 'property odd w'"), "{error}");
}

/// A name that is declared twice would leave out values, and shift those behind them.
#[test]
fn ply_names_that_are_declared_twice_are_refused() {
    for (properties, expected) in [
        (format!("property float s\n{XYZ}property float s\n"), "line 8: 's' is declared twice"),
        (format!("{XYZ}property double x\n"), "line 7: 'x' is declared twice"),
        (format!("{XYZ}element vertex 1\n{XYZ}"), "line 7: 'vertex' is declared twice"),
        (format!("property float a[\n{XYZ}property float a[\n"), "line 8: 'a[' is declared twice"),
    ] {
        let file = ply(&properties, "7 0 0 0 7\n7 1 0 0 7\n7 0 1 0 7\n");
        let error = refusal(parse_mesh(file.as_bytes(), "ply"));
        assert!(error.contains(expected), "{error}, not {expected}");
        let written = replace_positions(file.as_bytes(), "ply", &CORNERS);
        assert!(written.expect_err("no file").to_string().contains(expected));
    }
    let lists = "element face 1\nproperty list uchar int vertex_index\n";
    let two = ply(XYZ, "0 0 0\n1 0 0\n0 1 0\n3 2 1 0 ").replace("element face 1\n", lists);
    let error = refusal(parse_mesh(two.as_bytes(), "ply"));
    assert!(error.contains("element 'face' has two lists of corners"), "{error}");

    // Names that differ in letters that the parser does not know are two.
    let properties = format!("property uchar a[\nproperty uchar a]\n{XYZ}");
    let file = ply(&properties, "7 8 0 0 0\n7 8 1 0 0\n7 8 0 0.5 0\n");
    assert_eq!(parse_mesh(file.as_bytes(), "ply").expect("a mesh").positions, CORNERS);
}

/// As 3D Slicer writes them; a file that is written again keeps what it states.
#[test]
fn stated_spaces_are_read() {
    let plain = MeshFormat::Ply.encode(&CORNERS, &[[0, 1, 2]], None);
    let spliced = |file: &[u8], at: &str, more: String| {
        let place = file.windows(at.len()).position(|window| window == at.as_bytes());
        let end = place.expect("a place") + at.len();
        [&file[..end], more.as_bytes(), &file[end..]].concat()
    };
    for (name, space) in
        [("LPS", Space::LeftPosteriorSuperior), ("RAS", Space::RightAnteriorSuperior)]
    {
        let header = format!("3D Slicer output. SPACE={name}");
        let mut binary = format!("{header:80}").into_bytes();
        binary.extend(1_u32.to_le_bytes());
        binary.extend([0; 12]);
        binary.extend(
            [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.0].map(f32::to_le_bytes).concat(),
        );
        binary.extend([0; 2]);
        let text = MeshFormat::Stl.encode(&CORNERS, &[[0, 1, 2]], None);
        let obj = MeshFormat::Obj.encode(&CORNERS, &[[0, 1, 2]], None);
        let off = MeshFormat::Off.encode(&CORNERS, &[[0, 1, 2]], None);
        let codes = name.bytes().map(|byte| format!("{byte} ")).collect::<String>() + "0";
        let vtp = MeshFormat::Vtp.encode(&CORNERS, &[[0, 1, 2]], None);
        let field = |content: &str| {
            let array = format!("<Array type=\"String\" Name=\"SPACE\" {content}</Array>");
            spliced(&vtp, "<PolyData>", format!("<FieldData>{array}</FieldData>"))
        };
        let base64 = if name == "LPS" { "BAAAAAAAAABMUFMA" } else { "BAAAAAAAAABSQVMA" };
        for (extension, file) in [
            ("stl", binary),
            ("stl", spliced(&text, "solid ", format!("{header} "))),
            ("obj", [format!("# {header}\n\n").as_bytes(), &obj].concat()),
            ("off", [format!("# {header}\n\n").as_bytes(), &off].concat()),
            ("off", spliced(&off, "OFF\n", format!("# {header}\n"))),
            ("ply", spliced(&plain, "endian 1.0\n", format!("comment SPACE={name}\n"))),
            ("vtp", field(&format!("NumberOfTuples=\"1\" format=\"ascii\">{codes}"))),
            ("vtp", field(&format!("NumberOfTuples=\"1\" format=\"binary\">{base64}"))),
        ] {
            let mesh = parse_mesh(&file, extension).expect(extension);
            assert_eq!(mesh.space, Some(space), "{extension}");
            assert_eq!(mesh.positions, CORNERS, "as the file has them");
            let moved = CORNERS.map(|x| x + DVec3::Z);
            let written = replace_positions(&file, extension, &moved).expect(extension);
            let written = parse_mesh(&written, extension).expect(extension);
            assert_eq!((written.space, &written.positions[..]), (Some(space), &moved[..]));
        }
    }

    let late = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n# SPACE=RAS\nf 1 2 3\n";
    for (extension, file) in [("ply", &plain[..]), ("obj", &late[..])] {
        assert_eq!(parse_mesh(file, extension).expect("a mesh").space, None);
    }
}

/// A statement of OBJ goes on behind a backslash, and ends at a comment.
#[test]
fn statements_of_obj_go_on_in_the_next_line() {
    let text = "v 0 0 0 # a \\\nv 1 0 \\\n0.0\nv 0 \\\r\n 0.5 \\\n0 1 # b\nf 1 \\\n\\\n 2 # c\nf 1 2 3#d\n";
    let expected = text.replacen("f 1 \\\n\\\n 2 # c\n", "", 1);
    let mesh = parse_mesh(expected.as_bytes(), "obj").expect("a mesh");
    assert_eq!((&mesh.positions[..], &mesh.faces[..]), (&CORNERS[..], &[[0, 1, 2]][..]));
    let same = replace_positions(expected.as_bytes(), "obj", &CORNERS).expect("a file");
    assert!(same == expected.as_bytes(), "{same:?}");
    let moved = CORNERS.map(|x| x * 0.5);
    let written = replace_positions(expected.as_bytes(), "obj", &moved).expect("a file");
    assert_eq!(parse_mesh(&written, "obj").expect("a mesh").positions, moved);

    // A refusal names the line at which the statement begins.
    let refused = refusal(parse_mesh(text.as_bytes(), "obj"));
    assert_eq!(refused, "face 0 has 2 corners, fewer than a triangle");
    let refused = refusal(parse_mesh(text.replace(" 2 # c", " two").as_bytes(), "obj"));
    assert_eq!(refused, "OBJ file: line 7: 'two' is not a number");
    let cut = refusal(parse_mesh(b"v 0 0 \\\n", "obj"));
    assert_eq!(cut, "OBJ file: line 1: a vertex needs three coordinates");
}
