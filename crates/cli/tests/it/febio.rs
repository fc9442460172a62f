//! FEBio models: bodies are parts of one file, which is written as one.

use std::fmt::Write as _;

use fixtures::volume::Block;
use glam::DVec3;
use serde_json::Value;

use crate::support::{HEXAHEDRON_EDGES, Workshop};

/// Model of parts over one list of nodes.
#[derive(Default)]
struct Model {
    nodes: Vec<DVec3>,
    elements: String,
    /// True if elements are added with nodes in the middle of their edges.
    is_quadratic: bool,
}

impl Model {
    /// Adds a part of hexahedra, over nodes of its own but for those that others have there.
    fn add(&mut self, name: &str, block: &Block) {
        let places: Vec<usize> = block.nodes.iter().map(|x| self.place(*x)).collect();
        let kind = if self.is_quadratic { "hex20" } else { "hex8" };
        writeln!(self.elements, "<Elements type=\"{kind}\" name=\"{name}\">").expect("text");
        for (number, nodes) in block.hexahedra.iter().enumerate() {
            let mut nodes = nodes.map(|node| places[node as usize]).to_vec();
            let edges = if self.is_quadratic { &HEXAHEDRON_EDGES[..] } else { &[] };
            for &[a, b] in edges {
                let middle = self.nodes[nodes[a]].midpoint(self.nodes[nodes[b]]);
                nodes.push(self.place(middle));
            }
            // Nodes are numbered from 101.
            let nodes: Vec<String> = nodes.iter().map(|node| (node + 101).to_string()).collect();
            writeln!(self.elements, "<elem id=\"{number}\">{}</elem>", nodes.join(","))
                .expect("text");
        }
        self.elements += "</Elements>\n";
    }

    /// Returns the place of the node at a position, a new one where there is none.
    fn place(&mut self, x: DVec3) -> usize {
        let known = self.nodes.iter().position(|known| *known == x);
        known.unwrap_or_else(|| {
            self.nodes.push(x);
            self.nodes.len() - 1
        })
    }

    fn text(&self) -> String {
        let mut text = "<?xml version=\"1.0\"?>\n<febio_spec version=\"4.0\">\n<Mesh>\n\
                        <Nodes name=\"all\">\n"
            .to_owned();
        for (number, x) in (101..).zip(&self.nodes) {
            writeln!(text, "<node id=\"{number}\">{:?},{:?},{:?}</node>", x.x, x.y, x.z)
                .expect("text");
        }
        let rest =
            "<NodeSet name=\"attachment\">101,102</NodeSet>\n</Mesh>\n<LoadData/>\n</febio_spec>\n";
        text + "</Nodes>\n" + &self.elements + rest
    }
}

/// A bone, cartilage upon it that shares its nodes, and a meniscus that is 0.1 in the cartilage.
fn knee() -> Model {
    let mut model = Model::default();
    let block = |height: f64, layers: u32, z: f64| {
        let block = Block::new(DVec3::new(8.0, 8.0, height), [8, 8, layers]);
        block.translated(DVec3::Z * z)
    };
    model.add("bone", &block(2.0, 2, 0.0));
    model.add("cartilage", &block(1.0, 2, 2.0));
    let meniscus = Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]);
    model.add("meniscus", &meniscus.translated(DVec3::new(2.13, 1.97, 2.9)));
    model
}

const SCENE: &str = "[[body]]\nfile = \"knee.feb\"\nparts = [\"bone\"]\nkind = \"rigid\"\n\
    [[body]]\nfile = \"knee.feb\"\nparts = [\"cartilage\"]\n\
    [[body]]\nname = \"disc\"\nfile = \"knee.feb\"\nparts = [\"meniscus\"]\n";

/// Reads one part of a model.
fn mesh_of(workshop: &Workshop, file: &str, part: &str) -> mesh_io::Mesh {
    let meshes = mesh_io::read_parts(&workshop.path(file), &[&[part.to_owned()]]);
    meshes.expect("a model").remove(0)
}

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("JSON")
}

#[test]
fn parts_on_the_command_line_are_bodies_by_their_names() {
    let workshop = Workshop::new();
    workshop.write("knee.feb", knee().text());
    let run = workshop.check(&["knee.feb", "--rigid", "bone", "--json", "o.json"]);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let document = json(&workshop, "o.json");
    let bodies = document["bodies"].as_array().expect("bodies");
    let names: Vec<&str> =
        bodies.iter().map(|body| body["name"].as_str().expect("a name")).collect();
    assert_eq!(names, ["bone", "cartilage", "meniscus"]);
    let elements: Vec<u64> = bodies
        .iter()
        .map(|body| body["volume_mesh"]["elements"].as_u64().expect("a number"))
        .collect();
    assert_eq!(elements, [128, 128, 75]);
    assert_eq!(bodies[0]["kind"], "rigid");
    let pairs = document["pairs"].as_array().expect("pairs");
    let overlap = pairs.iter().find(|pair| pair["b"] == "meniscus" && pair["a"] == "cartilage");
    let volume = overlap.expect("a pair")["overlap"]["volume"].as_f64().expect("a volume");
    assert!((volume - 1.6).abs() < 1e-9, "{volume}");

    // Rigid by its material without being named, unless the scene says otherwise.
    let rigid = "<Material><material id=\"1\" name=\"m\" type=\"rigid body\"/></Material>\n\
                 <MeshDomains><SolidDomain name=\"bone\" mat=\"m\"/></MeshDomains>\n<LoadData/>";
    workshop.write("knee.feb", knee().text().replace("<LoadData/>", rigid));
    let kinds = |scene: &str| {
        let run = workshop.check(&[scene, "--json", "o.json"]);
        assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
        let bodies = json(&workshop, "o.json")["bodies"].take();
        let bodies = bodies.as_array().expect("bodies");
        bodies.iter().map(|body| body["kind"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(kinds("knee.feb"), ["rigid", "deformable", "deformable"]);
    workshop.write("scene.toml", SCENE.replace("kind = \"rigid\"\n", ""));
    assert_eq!(kinds("scene.toml"), ["rigid", "deformable", "deformable"]);
    workshop.write("scene.toml", SCENE.replace("\"rigid\"", "\"deformable\""));
    assert_eq!(kinds("scene.toml"), ["deformable"; 3]);

    // A model of one part has the name of its file.
    let mut single = Model::default();
    single.add("Part1", &Block::new(DVec3::ONE, [1; 3]));
    workshop.write("meniscus.feb", single.text());
    let run = workshop.check(&["meniscus.feb", "--json", "o.json"]);
    assert_eq!(
        (run.status, &json(&workshop, "o.json")["bodies"][0]["name"]),
        (0, &"meniscus".into())
    );
}

/// Shared nodes stay with the bone, all others of soft parts follow; nothing else of the model changes.
#[test]
fn a_model_is_written_as_one_file_with_all_of_its_parts() {
    let workshop = Workshop::new();
    workshop.write("knee.feb", knee().text());
    workshop.write("scene.toml", SCENE);
    let arguments =
        ["scene.toml", "--gap", "0.05", "--no-report", "--out", "apart", "--json", "gap.json"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let mut files = workshop.listing();
    files.retain(|name| name.starts_with("apart/") && !name.ends_with(".html"));
    let displacements = ["apart/cartilage_displacement.vtu", "apart/disc_displacement.vtu"];
    assert_eq!(files, [&displacements[..], &["apart/knee.feb"]].concat());

    // Lines of nodes differ, none of the bone's among them.
    let [before, after] = ["knee.feb", "apart/knee.feb"].map(|name| workshop.read(name));
    assert_eq!(before.lines().count(), after.lines().count());
    let bone_nodes = 9 * 9 * 3;
    let mut moved = 0;
    for (line, (before, after)) in before.lines().zip(after.lines()).enumerate() {
        let is_same = before == after;
        assert!(
            is_same || line >= 4 + bone_nodes && after.starts_with("<node "),
            "{line}: {after}"
        );
        moved += usize::from(!is_same);
    }
    assert!(moved > 30, "{moved} nodes moved");

    // What is stated is of the file.
    workshop.write("after.toml", SCENE.replace("knee.feb", "apart/knee.feb"));
    let check = workshop.check(&["after.toml", "--margin", "0.1", "--json", "after.json"]);
    assert_eq!(check.status, 0, "{}", check.stdout);
    let after = json(&workshop, "after.json");
    let pairs = after["pairs"].as_array().expect("pairs");
    let near = pairs.iter().find(|pair| pair["b"] == "disc").expect("they are near");
    assert!(near["distance"].as_f64().expect("a distance") >= 0.05 - 1e-12, "{near}");
    let gate = json(&workshop, "gap.json");
    assert_eq!(gate["resolved"], true);
    for body in [1, 2] {
        let elements = &gate["bodies"][body]["elements"];
        assert_eq!(elements["after"]["inverted_elements"], 0);
        let read = &after["bodies"][body]["volume_mesh"]["min_scaled_jacobian"];
        assert_eq!(&elements["after"]["min_scaled_jacobian"], read);
    }
}

/// Two layers of soft tissue that share their nodes, the upper one pressed down by a bone.
#[test]
fn parts_that_share_nodes_stay_attached() {
    let workshop = Workshop::new();
    let mut model = Model::default();
    let layer = Block::new(DVec3::new(8.0, 8.0, 1.0), [8, 8, 2]);
    model.add("lower", &layer);
    model.add("upper", &layer.translated(DVec3::Z));
    let bone = Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]);
    model.add("bone", &bone.translated(DVec3::new(2.13, 1.97, 1.8)));
    workshop.write("layers.feb", model.text());
    let arguments =
        ["layers.feb", "--rigid", "bone", "--gap", "0.05", "--no-report", "--out", "apart"];
    let run = workshop.run("resolve", &arguments);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(run.stderr, "note: 'lower' and 'upper' share 81 nodes: they are tied there\n");

    // Nodes of both have moved, and are of both as before.
    let parts = |file: &str| {
        ["lower", "upper"].map(|part| mesh_of(&workshop, file, part).volume.expect("a volume mesh"))
    };
    let (before, after) = (parts("layers.feb"), parts("apart/layers.feb"));
    let [lower, upper] = after.each_ref().map(|volume| volume.mesh.used_nodes());
    let shared = lower.iter().filter(|node| upper.contains(node));
    let moved = shared.filter(|&&node| {
        before[0].nodes[node as usize].distance(after[0].nodes[node as usize]) > 0.05
    });
    assert!(moved.count() > 4, "the lower layer gives way with the upper one");
    for volume in &after {
        assert_eq!(volume.mesh.quality(&volume.nodes).inverted, 0);
    }
    let check = workshop.check(&["apart/layers.feb", "--rigid", "bone"]);
    assert_eq!(check.status, 0, "{}", check.stdout);

    // A part that the scene has not may be attached, too: it stays as it is, with the nodes that it shares.
    let body = |part: &str| format!("[[body]]\nfile = \"layers.feb\"\nparts = [\"{part}\"]\n");
    workshop.write("scene.toml", format!("{}kind = \"rigid\"\n{}", body("bone"), body("upper")));
    let run =
        workshop.run("resolve", &["scene.toml", "--gap", "0.05", "--no-report", "--out", "again"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let note =
        "note: 'upper' shares 81 nodes with 'lower', which is no body of the scene: they stay\n";
    assert_eq!(run.stderr, note);
    let stays = |part: &str| {
        let [before, after] =
            ["layers.feb", "again/layers.feb"].map(|file| mesh_of(&workshop, file, part).positions);
        before == after
    };
    assert!(stays("lower") && !stays("upper"), "the lower layer is no body");
}

/// Soft tissue with a rigid pin in it, over common nodes, and a bone that is 0.03 in it from above.
#[test]
fn nodes_of_rigid_parts_stay_in_soft_ones() {
    let workshop = Workshop::new();
    let mut model = Model::default();
    model.add("tissue", &Block::new(DVec3::new(8.0, 8.0, 12.0), [8, 8, 12]));
    let pin = Block::new(DVec3::new(2.0, 2.0, 1.0), [2, 2, 1]);
    model.add("pin", &pin.translated(DVec3::new(3.0, 3.0, 2.0)));
    let bone = Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]);
    model.add("bone", &bone.translated(DVec3::new(2.13, 1.97, 11.97)));
    workshop.write("pin.feb", model.text());
    let body = |part: &str| format!("[[body]]\nfile = \"pin.feb\"\nparts = [\"{part}\"]\n");
    let [tissue, pin, bone] = ["tissue", "pin", "bone"].map(body);
    let rigid = "kind = \"rigid\"\n";
    let ignored = "[[ignore]]\na = \"tissue\"\nb = \"pin\"\n";
    workshop.write("scene.toml", format!("{tissue}{pin}{rigid}{bone}{rigid}{ignored}"));
    let run =
        workshop.run("resolve", &["scene.toml", "--gap", "0.005", "--no-report", "--out", "apart"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);

    let nodes = |file: &str, part: &str| mesh_of(&workshop, file, part).positions;
    for (part, stays) in [("pin", true), ("bone", true), ("tissue", false)] {
        let is_same = nodes("pin.feb", part) == nodes("apart/pin.feb", part);
        assert_eq!(is_same, stays, "{part}");
    }
}

/// Bodies of one file are such whatever path leads to it.
#[test]
fn a_file_is_one_by_any_path() {
    let workshop = Workshop::new();
    workshop.write("knee.feb", knee().text());
    std::fs::create_dir(workshop.path("sub")).expect("a folder");
    let paths = ["./knee.feb", "sub/../knee.feb"].map(str::to_owned).into_iter();
    #[cfg(unix)]
    let paths = paths.chain({
        std::os::unix::fs::symlink("knee.feb", workshop.path("link.feb")).expect("a link");
        ["link.feb".to_owned()]
    });
    for path in paths {
        let scene =
            SCENE.replacen("\"knee.feb\"\nparts = [\"c", &format!("\"{path}\"\nparts = [\"c"), 1);
        assert_ne!(scene, SCENE);
        workshop.write("scene.toml", &scene);
        let run = workshop
            .run("resolve", &["scene.toml", "--gap", "0.05", "--no-report", "--out", "apart"]);
        assert_eq!(run.status, 0, "{path}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("'bone' and 'cartilage' share 81 nodes"), "{}", run.stderr);
        let mut files = workshop.listing();
        files.retain(|name| name.starts_with("apart/") && name.ends_with(".feb"));
        assert_eq!(files, ["apart/knee.feb"], "{path}");

        let again =
            format!("{scene}[[body]]\nname = \"twice\"\nfile = \"{path}\"\nparts = [\"bone\"]\n");
        workshop.write("scene.toml", again);
        let run = workshop.check(&["scene.toml"]);
        assert!(run.stderr.contains("part 'bone' is of 'bone' and of 'twice'"), "{}", run.stderr);
    }
}

/// Fields and medial surfaces are of one body, which may be some parts of a model.
#[test]
fn parts_are_chosen_for_fields_and_medial_surfaces() {
    let workshop = Workshop::new();
    workshop.write("knee.feb", knee().text());
    for command in ["field", "medial"] {
        let run = workshop.run(command, &["knee.feb"]);
        assert_eq!(run.status, 2, "{command}: {}", run.stdout);
        assert!(run.stderr.contains("'meniscus': name those of the body"), "{}", run.stderr);
        let run = workshop.run(command, &["knee.feb", "--part", "tibia"]);
        assert!(run.stderr.contains("knee.feb: has no part 'tibia'"), "{command}: {}", run.stderr);
    }
    let parts = ["--part", "cartilage", "--part", "bone"];
    let run = workshop.run("field", &[&["knee.feb", "--json", "o.json"], &parts[..]].concat());
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(json(&workshop, "o.json")["built"]["faces"], 2 * 2 * (8 * 8 + 2 * 8 * 4));
    // Both are one block, whose edges have no balls.
    let run = workshop.run("medial", &[&["knee.feb"], &parts[..]].concat());
    assert!(run.stderr.contains("knee.feb: the surface is too thin"), "{}", run.stderr);

    let run = workshop.run("field", &["knee.feb", "--part", "bone", "--out", "bone.nrrd"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let run = workshop.run("field", &["bone.nrrd", "--part", "bone"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    assert!(run.stderr.contains("is a field already: --part, "), "{}", run.stderr);
}

/// Three soft parts of which each shares nodes with the others: ties alone leave these apart by more than is lost
/// without a trace.
#[test]
fn nodes_of_several_soft_parts_stay_in_one_place() {
    for is_quadratic in [false, true] {
        let workshop = Workshop::new();
        let mut model = Model { is_quadratic, ..Model::default() };
        let layer = Block::new(DVec3::new(8.0, 8.0, 1.0), [5, 5, 2]);
        model.add("lower", &layer);
        model.add("upper", &layer.translated(DVec3::Z));
        let side = Block::new(DVec3::new(2.0, 8.0, 2.0), [2, 5, 4]);
        model.add("side", &side.translated(DVec3::X * 8.0));
        let bone = Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]);
        model.add("bone", &bone.translated(DVec3::new(2.13, 1.97, 1.8)));
        workshop.write("layers.feb", model.text());
        let options =
            ["layers.feb", "--rigid", "bone", "--gap", "0.05", "--no-report", "--out", "apart"];
        let run = workshop.run("resolve", &options);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        let check = workshop.check(&["apart/layers.feb", "--rigid", "bone"]);
        assert_eq!(check.status, 0, "{}", check.stdout);

        // Nodes of the file, and the ends of edges around those in the middle.
        for part in ["lower", "upper", "side"] {
            let read = |file: &str| mesh_of(&workshop, file, part).volume.expect("a volume mesh");
            let [before, after] = ["layers.feb", "apart/layers.feb"].map(read);
            assert_eq!(after.mesh.quality(&after.nodes).inverted, 0, "{part}");
            assert_eq!(after.mesh.middle_nodes().is_empty(), !is_quadratic, "{part}");
            for middle in after.mesh.middle_nodes() {
                let [a, b] = middle.ends.map(|end| after.nodes[end as usize]);
                let x = after.nodes[middle.node as usize];
                assert!(x == a.midpoint(b) || x == before.nodes[middle.node as usize], "{part}");
                assert!(x.distance(a.midpoint(b)) < 1e-14, "{part}: {x}");
            }
        }
    }
}

/// Two soft parts side by side, and a bone that is in both across the nodes that they share.
#[test]
fn bone_across_shared_nodes_is_taken_off_both_parts() {
    for (depth, parts) in [(0.3, [5, 5, 3]), (0.8, [4, 4, 2])] {
        let workshop = Workshop::new();
        let mut model = Model::default();
        let side = Block::new(DVec3::new(8.0, 8.0, 4.0), [8, 8, 4]);
        model.add("left", &side);
        model.add("right", &side.translated(DVec3::X * 8.0));
        let bone = Block::new(DVec3::new(4.0, 4.0, 2.0), parts);
        model.add("bone", &bone.translated(DVec3::new(6.1, 1.9, 4.0 - depth)));
        workshop.write("sides.feb", model.text());
        let options =
            ["sides.feb", "--rigid", "bone", "--gap", "0.05", "--no-report", "--out", "apart"];
        let run = workshop.run("resolve", &options);
        assert_eq!(run.status, 0, "{depth}: {}{}", run.stdout, run.stderr);
        let check = workshop.check(&["apart/sides.feb", "--rigid", "bone"]);
        assert_eq!(check.status, 0, "{depth}: {}", check.stdout);
    }
}

/// A post is wider than three elements and deeper than two: those of one part would be inverted, and hold back all that
/// share nodes.
#[test]
fn parts_that_share_nodes_are_cut_at_one_share() {
    let mut model = Model::default();
    for (name, x, z) in [("a", -4.0, -4.0), ("b", -4.0, -2.0), ("c", 0.0, -4.0), ("d", 0.0, -2.0)] {
        let block = Block::new(DVec3::new(4.0, 6.0, 2.0), [4, 6, 2]);
        model.add(name, &block.translated(DVec3::new(x, -3.0, z)));
    }
    let post = Block::new(DVec3::new(3.2, 3.2, 4.4), [1, 1, 1]);
    model.add("post", &post.translated(DVec3::new(-1.58, -1.4, -2.3)));
    let apart = Block::new(DVec3::splat(2.0), [2; 3]).translated(DVec3::new(0.0, 9.0, 2.9));
    model.add("apart", &apart);
    model
        .add("below", &Block::new(DVec3::splat(3.0), [1; 3]).translated(DVec3::new(0.0, 9.0, 0.0)));
    let workshop = Workshop::new();
    workshop.write("m.feb", model.text());
    let options = [
        "m.feb",
        "--rigid",
        "post",
        "--rigid",
        "below",
        "--gap",
        "0.05",
        "--out",
        "out",
        "--json",
        "o.json",
        "--smooth",
        "2.1",
        "--no-report",
        "--keep-going",
    ];
    let run = workshop.run("resolve", &options);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let document = json(&workshop, "o.json");
    let share = |name: &str| {
        let bodies = document["bodies"].as_array().expect("bodies");
        let body = bodies.iter().find(|body| body["name"] == name).expect(name);
        body["elements"]["followed_share"].as_f64().expect("a share")
    };
    let cut = share("a");
    assert!(cut > 0.1 && cut < 0.95, "{cut}");
    for name in ["b", "c", "d"] {
        assert!((share(name) - cut).abs() < 1e-12, "{name}: {} and {cut}", share(name));
    }
    assert!(share("apart") >= 1.0, "what shares no node goes all the way");
}

#[test]
fn names_of_parts_are_checked() {
    let workshop = Workshop::new();
    workshop.write("knee.feb", knee().text());
    let body = "[[body]]\nfile = \"knee.feb\"\n";
    let cases = [
        (
            body.to_owned(),
            "knee.feb: has the parts 'bone', 'cartilage', 'meniscus': name those of the body",
        ),
        (
            format!("{body}parts = [\"tibia\"]\n"),
            "knee.feb: has no part 'tibia'; its parts are 'bone', 'cart",
        ),
        (
            format!("{SCENE}{body}name = \"again\"\nparts = [\"bone\"]\n"),
            "part 'bone' is of 'bone' and of 'again': a part is of one body",
        ),
        (
            "[[body]]\nfile = \"bone.obj\"\nparts = [\"bone\"]\n".to_owned(),
            "bone.obj: has no parts that can be named: only FEBio models and Abaqus input",
        ),
    ];
    let run = workshop.check(&["none.feb", "--rigid", "bone"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    assert!(run.stderr.contains("none.feb: cannot be read: "), "{}", run.stderr);
    workshop.write("bone.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (scene, expected) in cases {
        workshop.write("scene.toml", scene);
        let run = workshop.check(&["scene.toml"]);
        assert_eq!(run.status, 2, "{expected}: {}", run.stdout);
        assert!(run.stderr.contains(expected), "{expected}: {}", run.stderr);
    }
}
