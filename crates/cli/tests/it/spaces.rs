//! Spaces that files of 3D Slicer state: one for all bodies of a scene, and for all files that it becomes.

use std::path::Path;

use fixtures::shapes::icosphere;
use glam::DVec3;
use mesh_io::{MeshFormat, Space};

use crate::support::{Workshop, tetrahedron};

/// 3D Slicer states the axes of a mesh in its file: the same place has other coordinates in each.
#[test]
fn meshes_of_two_stated_spaces_are_refused() {
    let workshop = Workshop::new();
    let file =
        |space: &str, x| format!("# 3D Slicer output. SPACE={space}\n{}", tetrahedron(x, 1.0));
    workshop.write("femur.obj", file("LPS", 0.0));
    workshop.write("tibia.obj", file("RAS", 5.0));
    workshop.write("fibula.obj", file("LPS", 9.0));
    workshop.write("plain.obj", tetrahedron(15.0, 1.0));
    assert_eq!(workshop.check(&["femur.obj", "fibula.obj", "plain.obj"]).status, 0);
    assert_eq!(workshop.check(&["tibia.obj", "plain.obj"]).status, 0);

    // A file that states none may be in another.
    workshop.write("patella.obj", tetrahedron(20.0, 1.0));
    for (files, stating, others) in [
        (
            &["plain.obj", "tibia.obj"][..],
            "tibia.obj states the space RAS",
            "plain.obj states none",
        ),
        (
            &["plain.obj", "femur.obj", "patella.obj", "fibula.obj"],
            "femur.obj states the space LPS",
            "plain.obj and 1 more state none",
        ),
    ] {
        let expected =
            format!("warning: {stating}, but {others}: they are taken to be in the same\n");
        assert_eq!(workshop.check(files).stderr, expected);
    }
    for files in [&["femur.obj", "fibula.obj"][..], &["plain.obj", "patella.obj"], &["tibia.obj"]] {
        assert_eq!(workshop.check(files).stderr, "", "{files:?}");
    }

    let run = workshop.check(&["plain.obj", "femur.obj", "fibula.obj", "tibia.obj"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    let problem = "femur.obj states the space LPS, but tibia.obj the space RAS: save both in one";
    assert!(run.stderr.contains(problem), "{}", run.stderr);

    // Fields in NRRD files are in LPS, those of VTK in the axes of the mesh.
    for (mesh, field, status) in
        [("tibia.obj", "a.nrrd", 2), ("tibia.obj", "a.vti", 0), ("femur.obj", "b.nrrd", 0)]
    {
        let run = workshop.run("field", &[mesh, "--out", field]);
        assert_eq!(run.status, status, "{mesh} {field}: {}", run.stderr);
        let says = run.stderr.contains("tibia.obj: a mesh in the space RAS has no field in NRRD");
        assert_eq!(says, status == 2, "{}", run.stderr);
    }
}

/// Returns the spaces that the meshes of a folder state, by the names of their files.
fn spaces_in(folder: &Path) -> Vec<(String, Option<Space>)> {
    let mut spaces = Vec::new();
    for file in std::fs::read_dir(folder).expect("a folder") {
        let path = file.expect("a file").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let extension = path.extension().expect("an extension").to_string_lossy().into_owned();

        // Curves are no meshes.
        if matches!(&*extension, "obj" | "vtp") && !name.ends_with("_curve.vtp") {
            let content = std::fs::read(&path).expect("content");
            spaces.push((name, mesh_io::parse_mesh(&content, &extension).expect("a mesh").space));
        }
    }
    spaces.sort_by(|a, b| a.0.cmp(&b.0));
    spaces
}

/// A viewer that takes another space for granted would show them mirrored.
#[test]
fn written_surfaces_state_the_space_of_the_scene() {
    let bone = icosphere(4.0, 2);
    let muscle = icosphere(5.0, 2).translated(DVec3::X * 8.5);
    let joint = ["--joint-contact", "1", "--foundation", "1,0.45,1"];
    for space in [None, Some(Space::RightAnteriorSuperior)] {
        let workshop = Workshop::new();
        workshop.write("bone.obj", MeshFormat::Obj.encode(&bone.positions, &bone.faces, space));
        let content = MeshFormat::Obj.encode(&muscle.positions, &muscle.faces, space);
        workshop.write("muscle.obj", content);
        let bodies = "[[body]]\nfile = \"bone.obj\"\nkind = \"rigid\"\n\
                      [[body]]\nfile = \"muscle.obj\"\nkind = \"deformable\"\n";
        workshop.write("scene.toml", format!("motion = \"still.json\"\n{bodies}"));
        let still = "{\"bone\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}";
        workshop.write("still.json", format!("{{\"frames\": [{still}, {still}]}}"));

        let scene = ["scene.toml"];
        let resolve = ["--resolve", "resolved", "--gap", "0.05"];
        for (command, arguments, files) in [
            ("check", [&scene[..], &["--vtp", "check"], &joint].concat(), 6),
            ("motion", [&scene[..], &["--vtp", "motion"], &joint].concat(), 8),
            ("motion", [&scene[..], &resolve].concat(), 4),
            ("resolve", vec!["bone.obj", "muscle.obj", "--rigid", "bone", "--out", "out"], 3),
        ] {
            let run = workshop.run(command, &arguments);
            assert!(run.status < 2, "{}", run.stderr);
            let folder = ["check", "motion", "resolved", "out"];
            let folder = folder.into_iter().find(|folder| arguments.contains(folder));
            let stated = spaces_in(&workshop.path(folder.expect("a folder")));
            assert_eq!(stated.len(), files, "{arguments:?}: {stated:?}");
            assert!(stated.iter().all(|(_, stated)| *stated == space), "{stated:?}");
        }
        let curve = workshop.read("check/bone_muscle_curve.vtp");
        assert_eq!(curve.contains("82 65 83 0"), space.is_some(), "the letters RAS");

        std::fs::create_dir(workshop.path("medial")).expect("a folder");
        let run = workshop.run("medial", &["bone.obj", "--balls", "8", "--vtp", "medial/bone.vtp"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        assert_eq!(spaces_in(&workshop.path("medial")), [("bone.vtp".to_owned(), space)]);
    }
}
