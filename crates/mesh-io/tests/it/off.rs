//! OFF files as other programs write them, and refusals with their lines.

use glam::DVec3;
use mesh_io::{FilePlace, Mesh, Unread, parse_mesh, replace_positions};

const CORNERS: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.5, 0.0), DVec3::Y];

/// Checks that a file has the planted quadrilateral, and keeps all but coordinates when it is written.
fn check_planted(file: &str, extension: &str) {
    let mesh = parse_mesh(file.as_bytes(), extension).expect(file);
    assert_eq!((&mesh.positions[..], mesh.unread), (&CORNERS[..], None), "{file}");
    assert_eq!((&mesh.faces[..], mesh.polygons_fanned), (&[[0, 1, 2], [0, 2, 3]][..], 1), "{file}");

    let same = replace_positions(file.as_bytes(), extension, &CORNERS).expect(file);
    assert!(same == file.as_bytes(), "{file}");
    let mut moved = CORNERS;
    moved[2].y = 0.25;
    let written = replace_positions(file.as_bytes(), extension, &moved).expect(file);
    let written = String::from_utf8(written).expect("text");
    assert_eq!(written, file.replacen("0.50", "0.25", 1), "all else stays");
}

#[test]
fn vertices_and_faces_may_have_more_than_positions_and_corners() {
    let file = |header: &str, vertex: &str, face: &str| {
        format!(
            "{header}\n0 0 0{vertex}\n1 0 0{vertex}\n1e0 0.50 -0{vertex}\n# below\n\n0 1 0{vertex} # last\n\
             4 0 1 2 3{face}\n"
        )
    };
    let color = " 255 128 0";
    for (header, vertex, face) in [
        ("OFF\n4 1 5", "", ""),
        ("# first\n\nOFF # of a program\n# counts\n4 1", "", " 7"),
        ("OFF 4 1 5", color, color),
        ("OFF4 1 0", "", " 0.5 0.5 0.5 1"),
        ("COFF\n4 1 5", " 255 128 0 255", ""),
        ("COFF\n4 1 5", color, ""),
        ("NOFF\n4 1 5", " 0 0 1", ""),
        ("STOFF\n4 1 5", " 0.5 0.5", ""),
        ("CNOFF\n4 1 5", " 0 0 1 255 128 0 255", ""),
        ("STCNOFF\n4 1 5", " 0 0 1 255 128 0 255 .5 .5", ""),
        ("NCSTOFF\n4 1 5", " 255 128 0 255 0 0 1 .5 .5", ""),
    ] {
        for extension in ["off", "OFF", "obj", ""] {
            check_planted(&file(header, vertex, face), extension);
        }
    }
}

#[test]
fn refusals_name_the_line() {
    let body = "0 0 0\n1 0 0\n0 1 0\n";
    for (text, expected) in [
        ("off\n".to_owned() + body, "OFF file: line 1: 'off' is not OFF, COFF, NOFF or such"),
        ("3 1 0\n".to_owned() + body, "OFF file: line 1: '3' is not OFF, COFF, NOFF or such"),
        ("# all\n".to_owned(), "OFF file: line 1: the file ends before the first word"),
        ("OFF\n#\n".to_owned(), "OFF file: line 2: the file ends before the counts"),
        (
            "OFF\n3\n".to_owned() + body,
            "OFF file: line 2: the numbers of vertices, of faces and of edges are expected",
        ),
        ("OFF\n3 -1 0\n".to_owned() + body, "OFF file: line 2: '-1' is not a count"),
        ("OFF\n\n3 1.5 0\n".to_owned() + body, "OFF file: line 3: '1.5' is not a count"),
        (
            "OFF\n3 1 0\n0 0 0\n1 0\n".to_owned(),
            "OFF file: line 4: a vertex has 3 numbers, and 3 or 4 more of a color, but here are 2",
        ),
        (
            "NOFF\n3 1 0\n0 0 0\n".to_owned(),
            "OFF file: line 3: a vertex has 6 numbers, and 3 or 4 more of a color, but here are 3",
        ),
        ("OFF\n3 1 0\n0 0 zero\n".to_owned(), "OFF file: line 3: 'zero' is not a number"),
        (
            format!("OFF\n3 1 0\n{body}"),
            "OFF file: line 5: the file ends here, behind 0 of 1 faces",
        ),
        (
            "OFF\n99999999999999 1 0\n0 0 0\n".to_owned(),
            "OFF file: line 3: the file ends here, behind 1 of 99999999999999 vertices",
        ),
        (
            // Vertices that share lines are not read as others.
            "OFF\n4 2 0\n0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2\n3 0 2 3\n".to_owned(),
            "OFF file: line 5: a vertex has 3 numbers, and 3 or 4 more of a color, but here are 4",
        ),
        (format!("OFF\n3 1 0\n{body}3 0 1\n"), "OFF file: line 6: a face of 3 corners lists 2"),
        (
            format!("OFF\n3 1 0\n{body}3 0 1 2.0\n"),
            "OFF file: line 6: '2.0' is not the number of a vertex",
        ),
        (
            format!("OFF\n3 1 0\n{body}3 0 1 2 5 6\n"),
            "OFF file: line 6: 2 numbers behind 3 corners are no color",
        ),
        (format!("OFF\n3 1 0\n{body}3 0 1 2 red\n"), "OFF file: line 6: 'red' is not a number"),
        (
            format!("OFF\n3 1 0\n{body}3 0 1 3\n"),
            "face 0 refers to vertex 3, but there are 3 vertices (counted from 0)",
        ),
        (
            format!("OFF\n3 1 0\n{body}3 0 1 -1\n"),
            "face 0 refers to vertex -1, but there are 3 vertices (counted from 0)",
        ),
        (format!("OFF\n3 1 0\n{body}2 0 1\n"), "face 0 has 2 corners, fewer than a triangle"),
        (format!("OFF\n3 0 0\n{body}"), "has 3 vertices and no faces"),
        (
            "OFF\n3 1 0\n0 0 inf\n1 0 0\n0 1 0\n3 0 1 2\n".to_owned(),
            "vertex 0 is at (0, 0, inf), which is not finite",
        ),
        (
            format!("4OFF\n3 1 0\n{body}"),
            "OFF file: a file that begins with '4OFF' cannot be read; save it as text with three \
             coordinates per vertex",
        ),
        (
            "OFF BINARY\n\0\0\0\x03".to_owned(),
            "OFF file: binary data cannot be read; save it as text with three coordinates per vertex",
        ),
    ] {
        let error = parse_mesh(text.as_bytes(), "off").expect_err(&text);
        assert_eq!(error.to_string(), expected, "{text}");
    }
}

#[test]
fn lines_behind_the_last_face_are_reported() {
    let text = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n# end\n\n";
    let unread = |more: &str| -> Option<Unread> {
        let mesh: Mesh = parse_mesh((text.to_owned() + more).as_bytes(), "off").expect(more);
        mesh.unread
    };
    assert_eq!(unread("# end of all\n"), None);
    let expected = Unread { place: FilePlace::Line(9), bytes: 15 };
    assert_eq!(unread("3 0 1 2\n3 0 2 1\n\n"), Some(expected));
}
