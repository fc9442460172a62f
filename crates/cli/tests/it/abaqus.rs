//! Abaqus models: bodies are instances of parts, or element sets, of one file, which is written as one.

use std::fmt::Write as _;

use fixtures::volume::Block;
use glam::{DMat3, DVec3};
use serde_json::Value;

use crate::support::{HEXAHEDRON_EDGES, Workshop};

/// Placement of an instance, as a model has it.
#[derive(Clone, Copy)]
struct Place {
    translation: [f64; 3],
    /// Two points of the axis, and degrees.
    rotation: [f64; 7],
}

impl Place {
    /// Returns where the assembly has a position of the part, by columns of the rotation.
    fn place(&self, x: DVec3) -> DVec3 {
        let [ax, ay, az, bx, by, bz, degrees] = self.rotation;
        let (a, b) = (DVec3::new(ax, ay, az), DVec3::new(bx, by, bz));
        let turn = DMat3::from_axis_angle((b - a).normalize(), degrees.to_radians());
        a + turn * (x + DVec3::from_array(self.translation) - a)
    }

    /// Returns the position in the part of one in the assembly.
    fn undo(&self, x: DVec3) -> DVec3 {
        let [ax, ay, az, bx, by, bz, degrees] = self.rotation;
        let (a, b) = (DVec3::new(ax, ay, az), DVec3::new(bx, by, bz));
        let back = DMat3::from_axis_angle((b - a).normalize(), -degrees.to_radians());
        a + back * (x - a) - DVec3::from_array(self.translation)
    }

    /// Returns both data lines.
    fn lines(&self) -> String {
        let join = |numbers: &[f64]| {
            numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ")
        };
        format!("{}\n{}\n", join(&self.translation), join(&self.rotation))
    }
}

/// A turn about an oblique axis, far from the part.
const TURN: Place =
    Place { translation: [300.0, -20.0, 7.0], rotation: [1.0, 2.0, 3.0, 3.0, 1.0, 7.0, 40.0] };

/// A part so far from its place that coordinates are rounded by a tenth of the gap.
const FAR: Place =
    Place { translation: [-3e13, 1e13, 2e13], rotation: [0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 25.0] };

/// Returns nodes from 1 on, and hexahedra of an element set.
fn mesh(nodes: &[DVec3], block: &Block, set: &str) -> String {
    let mut text = "*Node\n".to_owned();
    for (number, x) in (1..).zip(nodes) {
        let [x, y, z] = x.to_array().map(|x| {
            // An input file allows 20 characters.
            let text = format!("{x:?}");
            if text.len() > 20 { format!("{x:.12e}") } else { text }
        });
        writeln!(text, "{number}, {x}, {y}, {z}").expect("text");
    }
    text + &elements(&block.hexahedra, 0, set)
}

/// Returns hexahedra of an element set, whose nodes are numbered from 1 on.
fn elements(hexahedra: &[[u32; 8]], first: u32, set: &str) -> String {
    let mut text = format!("*Element, type=C3D8R, elset={set}\n");
    for (number, nodes) in (first + 1..).zip(hexahedra) {
        let nodes = nodes.map(|node| (node + 1).to_string()).join(", ");
        writeln!(text, "{number}, {nodes}").expect("text");
    }
    text
}

fn part(name: &str, content: &str) -> String {
    format!("*Part, name={name}\n{content}*Solid Section, elset=all, material=m\n,\n*End Part\n")
}

fn instance(name: &str, part: &str, lines: &str) -> String {
    format!("*Instance, name={name}, part={part}\n{lines}*End Instance\n")
}

fn bone_block() -> Block {
    Block::new(DVec3::new(8.0, 8.0, 2.0), [8, 8, 2])
}

/// Soft tissue that is 0.1 in the bone, in the assembly.
fn tissue_block() -> Block {
    Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]).translated(DVec3::new(2.13, 1.97, 1.9))
}

/// A bone, and soft tissue that is placed upon it.
fn knee(place: &Place) -> String {
    let (bone, tissue) = (bone_block(), tissue_block());
    let own: Vec<DVec3> = tissue.nodes.iter().map(|x| place.undo(*x)).collect();
    let parts = part("Tissue", &mesh(&own, &tissue, "all"))
        + &part("Bone", &mesh(&bone.nodes, &bone, "all"));
    let instances = instance("femur", "Bone", "") + &instance("meniscus", "Tissue", &place.lines());
    format!(
        "*Heading\n{parts}*Assembly, name=Assembly\n{instances}*Node\n1, 0., 0., 9.\n\
         *Nset, nset=point\n1,\n*End Assembly\n*Material, name=m\n*Elastic\n1., 0.3\n"
    )
}

/// Returns the coordinates of a part's nodes, read from the text of a model.
fn nodes_of(text: &str, part: &str) -> Vec<DVec3> {
    let start = text.find(&format!("*Part, name={part}\n*Node\n")).expect("a part");
    let lines = text[start..].lines().skip(2).take_while(|line| !line.starts_with('*'));
    let number = |word: &str| {
        assert!(word.trim().len() <= 20, "{word} is too long");
        word.trim().parse::<f64>().expect("a number")
    };
    lines
        .map(|line| {
            let words: Vec<f64> = line.split(',').skip(1).map(number).collect();
            DVec3::from_slice(&words)
        })
        .collect()
}

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("JSON")
}

fn body_names(document: &Value) -> Vec<&str> {
    let bodies = document["bodies"].as_array().expect("bodies");
    bodies.iter().map(|body| body["name"].as_str().expect("a name")).collect()
}

#[test]
fn instances_on_the_command_line_are_bodies_by_their_names() {
    let workshop = Workshop::new();
    workshop.write("knee.inp", knee(&TURN));
    let run = workshop.check(&["knee.inp", "--rigid", "femur", "--json", "o.json"]);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let document = json(&workshop, "o.json");
    assert_eq!(body_names(&document), ["femur", "meniscus"]);
    let volume = document["pairs"][0]["overlap"]["volume"].as_f64().expect("a volume");
    assert!((volume - 1.6).abs() < 1e-9, "{volume}");

    // One instance, placed or not, is a body by the name of its file.
    let single = part("p", &mesh(&tissue_block().nodes, &tissue_block(), "all"));
    let placed = instance("i", "p", &TURN.lines());
    workshop.write("disc.inp", format!("{single}*Assembly\n{placed}*End Assembly\n"));
    let run = workshop.check(&["disc.inp", "--json", "o.json"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(body_names(&json(&workshop, "o.json")), ["disc"]);
}

/// The gap holds where a reader of its own places the nodes that are written.
#[test]
fn placed_instances_are_written_in_their_own_axes() {
    // The last gap is smaller than the rounding.
    for (place, gap) in [(TURN, "0.05"), (FAR, "0.05"), (FAR, "0.0002")] {
        let workshop = Workshop::new();
        workshop.write("knee.inp", knee(&place));
        let arguments = ["--gap", gap, "--no-report", "--out", "apart", "--json", "gap.json"];
        let run =
            workshop.run("resolve", &[&["knee.inp", "--rigid", "femur"], &arguments[..]].concat());
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        assert_eq!(json(&workshop, "gap.json")["resolved"], true);
        let mut files = workshop.listing();
        files.retain(|name| name.starts_with("apart/"));
        assert_eq!(files, ["apart/knee.inp", "apart/meniscus_displacement.vtu"]);

        // Lines of nodes of the tissue differ alone.
        let [before, after] = ["knee.inp", "apart/knee.inp"].map(|name| workshop.read(name));
        assert_eq!(nodes_of(&before, "Bone"), nodes_of(&after, "Bone"));
        let count = tissue_block().nodes.len();
        let differing: Vec<usize> = before
            .lines()
            .zip(after.lines())
            .enumerate()
            .filter_map(|(line, (before, after))| (before != after).then_some(line))
            .collect();
        assert!(differing.len() > 30, "{differing:?}");
        assert!(differing.iter().all(|line| (3..3 + count).contains(line)), "{differing:?}");
        assert_eq!(before.lines().count(), after.lines().count());

        // Placed by hand, in files of their own, both keep the distance.
        let tissue: Vec<DVec3> =
            nodes_of(&after, "Tissue").iter().map(|x| place.place(*x)).collect();
        workshop.write("tissue.inp", mesh_in_full(&tissue, &tissue_block()));
        workshop.write("bone.inp", mesh_in_full(&bone_block().nodes, &bone_block()));
        let check = ["bone.inp", "tissue.inp", "--rigid", "bone", "--margin", "2"];
        let run = workshop.check(&[&check[..], &["--json", "after.json"]].concat());
        assert_eq!(run.status, 0, "{}", run.stdout);
        let after = json(&workshop, "after.json");
        let distance = after["pairs"][0]["distance"].as_f64().expect("a distance");
        let rounding = 1e-15 * place.translation.map(f64::abs).iter().sum::<f64>();
        let least = gap.parse::<f64>().expect("a number") - rounding - 1e-14;
        assert!(distance >= least, "{distance} for {gap}");
        assert!(distance < 2.0, "{distance}");

        // As the program reads them.
        let parts = ["meniscus".to_owned()];
        let meshes = mesh_io::read_parts(&workshop.path("apart/knee.inp"), &[&parts]);
        let volume = meshes.expect("a model").remove(0).volume.expect("a volume mesh");
        let own = &volume.nodes[..];
        assert_eq!(own.len(), count);
        for (own, by_hand) in own.iter().zip(&tissue) {
            assert!(own.distance(*by_hand) <= rounding + 1e-13, "{own} {by_hand}");
        }
    }
}

/// Returns a file of a mesh with all digits of its coordinates.
fn mesh_in_full(nodes: &[DVec3], block: &Block) -> String {
    let mut text = "*Node\n".to_owned();
    for (number, x) in (1..).zip(nodes) {
        writeln!(text, "{number}, {:?}, {:?}, {:?}", x.x, x.y, x.z).expect("text");
    }
    text + &elements(&block.hexahedra, 0, "all")
}

/// A file of one instance, beside one of another format.
#[test]
fn a_placed_part_of_its_own_file_is_written_likewise() {
    let workshop = Workshop::new();
    let (bone, tissue) = (bone_block(), tissue_block());
    workshop.write("bone.inp", mesh_in_full(&bone.nodes, &bone));
    let own: Vec<DVec3> = tissue.nodes.iter().map(|x| TURN.undo(*x)).collect();
    let file = |lines: &str| {
        let part = part("Tissue", &mesh(&own, &tissue, "all"));
        format!("{part}*Assembly, name=a\n{}*End Assembly\n", instance("i", "Tissue", lines))
    };
    workshop.write("disc.inp", file(&TURN.lines()));
    let run = workshop.run(
        "resolve",
        &["bone.inp", "disc.inp", "--rigid", "bone", "--gap", "0.05", "--no-report", "--out", "o"],
    );
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let after = workshop.read("o/disc.inp");
    assert_ne!(nodes_of(&after, "Tissue"), own);
    let behind_nodes = |text: &str| text.split("*Element").nth(1).map(str::to_owned);
    assert_eq!(behind_nodes(&after), behind_nodes(&file(&TURN.lines())));
    let scene = "[[body]]\nfile = \"bone.inp\"\nkind = \"rigid\"\n\
        [[body]]\nname = \"disc\"\nfile = \"disc.inp\"\nparts = [\"I\"]\n";
    workshop.write("scene.toml", scene);
    let run =
        workshop.run("resolve", &["scene.toml", "--gap", "0.05", "--no-report", "--out", "named"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(workshop.read("named/disc.inp"), after, "its name changes nothing");
    let run = workshop.check(&["o/bone.inp", "o/disc.inp", "--margin", "0.1", "--json", "o.json"]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let distance = json(&workshop, "o.json")["pairs"][0]["distance"].as_f64().expect("a distance");
    assert!(distance >= 0.05, "{distance}");
}

/// Nodes in the middle of edges are those of the instance, not of one before it.
#[test]
fn quadratic_elements_of_instances_stay_straight() {
    let workshop = Workshop::new();
    let tissue = tissue_block();
    let (mut nodes, mut cells) = (tissue.nodes.clone(), String::new());
    for (number, corners) in (1..).zip(&tissue.hexahedra) {
        let mut all = corners.map(|node| node as usize).to_vec();
        for [a, b] in HEXAHEDRON_EDGES {
            let middle = nodes[all[a]].midpoint(nodes[all[b]]);
            let known = nodes.iter().position(|x| *x == middle);
            all.push(known.unwrap_or(nodes.len()));
            if known.is_none() {
                nodes.push(middle);
            }
        }
        let all: Vec<String> = all.iter().map(|node| (node + 1).to_string()).collect();
        writeln!(cells, "{number}, {},\n{}", all[..10].join(", "), all[10..].join(", "))
            .expect("text");
    }
    let own: Vec<DVec3> = nodes.iter().map(|x| TURN.undo(*x)).collect();
    let none = Block { nodes: Vec::new(), hexahedra: Vec::new() };
    let quadratic = mesh(&own, &none, "none") + "*Element, type=C3D20R\n" + &cells;
    let bone = bone_block();
    let parts = part("Tissue", &quadratic) + &part("Bone", &mesh(&bone.nodes, &bone, "all"));
    let instances = instance("femur", "Bone", "") + &instance("disc", "Tissue", &TURN.lines());
    workshop.write("knee.inp", format!("{parts}*Assembly\n{instances}*End Assembly\n"));
    let options = ["knee.inp", "--rigid", "femur", "--gap", "0.05", "--no-report", "--out", "o"];
    let run = workshop.run("resolve", &options);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);

    let read = |file: &str| {
        let meshes = mesh_io::read_parts(&workshop.path(file), &[&["disc".to_owned()]]);
        meshes.expect("a model").remove(0).volume.expect("a volume mesh")
    };
    let [before, after] = ["knee.inp", "o/knee.inp"].map(read);
    let mut moved = 0;
    for middle in after.mesh.middle_nodes() {
        let [a, b] = middle.ends.map(|end| after.nodes[end as usize]);
        let x = after.nodes[middle.node as usize];
        assert!(x.distance(a.midpoint(b)) < 1e-10, "{x}");
        moved += usize::from(x != before.nodes[middle.node as usize]);
    }
    assert!(moved > 30, "{moved} nodes moved");
}

/// Two screws of one part, of which a soft body would move both.
#[test]
fn a_part_of_several_instances_cannot_move() {
    let workshop = Workshop::new();
    let screw = Block::new(DVec3::ONE, [2; 3]);
    let parts = part("Screw", &mesh(&screw.nodes, &screw, "all"));
    let instances =
        instance("left", "Screw", "0., 0., 0.\n") + &instance("right", "SCREW", "0.9, 0., 0.\n");
    workshop.write("screws.inp", format!("{parts}*Assembly\n{instances}*End Assembly\n"));
    let run = workshop.check(&["screws.inp", "--json", "o.json"]);
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let volume = json(&workshop, "o.json")["pairs"][0]["overlap"]["volume"].as_f64();
    assert!((volume.expect("a volume") - 0.1).abs() < 1e-9, "{volume:?}");

    let options = ["--gap", "0.05", "--no-report", "--out", "apart"];
    for rigid in [&[][..], &["--rigid", "left"]] {
        let run = workshop.run("resolve", &[&["screws.inp"], rigid, &options[..]].concat());
        assert_eq!(run.status, 2, "{}", run.stdout);
        let own = if rigid.is_empty() { "left" } else { "right" };
        let refusal = format!("screws.inp: '{own}' can move, but its part 'Screw' has one set of");
        assert!(run.stderr.contains(&refusal), "{}", run.stderr);
        assert_eq!(workshop.listing(), ["o.json", "screws.inp"]);
    }

    // The other instance need not be a body of the scene.
    workshop.write("scene.toml", "[[body]]\nfile = \"screws.inp\"\nparts = [\"Right\"]\n");
    let run = workshop.run("resolve", &[&["scene.toml"], &options[..]].concat());
    assert!(run.stderr.contains("'right' can move, but its part 'Screw'"), "{}", run.stderr);

    // Rigid ones stay, and soft tissue beside them moves.
    let tissue = Block::new(DVec3::new(2.0, 2.0, 1.0), [3, 3, 2]);
    let parts = parts + &part("Tissue", &mesh(&tissue.nodes, &tissue, "all"));
    let instances = instance("left", "Screw", "-0.91, 0.13, 0.1\n")
        + &instance("right", "Screw", "1.91, 0.13, 0.1\n")
        + &instance("tissue", "Tissue", "");
    workshop.write("screws.inp", format!("{parts}*Assembly\n{instances}*End Assembly\n"));
    let rigid = ["screws.inp", "--rigid", "left", "--rigid", "right"];
    let run = workshop.run("resolve", &[&rigid[..], &options[..]].concat());
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let [before, after] = ["screws.inp", "apart/screws.inp"].map(|name| workshop.read(name));
    assert_eq!(nodes_of(&before, "Screw"), nodes_of(&after, "Screw"));
    assert_ne!(nodes_of(&before, "Tissue"), nodes_of(&after, "Tissue"));
}

/// Two layers that share their nodes and a bone in the upper one, without parts.
fn layers() -> String {
    let size = DVec3::new(8.0, 8.0, 2.0);
    let layers = Block::new(size, [8, 8, 4]);
    let bone = Block::new(DVec3::new(4.0, 4.0, 2.0), [5, 5, 3]);
    let bone = bone.translated(DVec3::new(2.13, 1.97, 1.8));
    let (lower, upper) = layers.hexahedra.split_at(2 * 64);
    let first = u32::try_from(layers.nodes.len()).expect("few nodes");
    let nodes = [&layers.nodes[..], &bone.nodes].concat();
    let bone: Vec<[u32; 8]> =
        bone.hexahedra.iter().map(|nodes| nodes.map(|node| node + first)).collect();
    let all = mesh(&nodes, &Block { nodes: nodes.clone(), hexahedra: Vec::new() }, "none");
    all + &elements(lower, 0, "\"lower layer\"")
        + &elements(upper, 1000, "Upper")
        + &elements(&bone, 2000, "BONE")
}

#[test]
fn element_sets_of_a_flat_file_are_bodies_where_they_are_named() {
    let workshop = Workshop::new();
    workshop.write("layers.inp", layers());
    let run = workshop.check(&["layers.inp", "--json", "o.json"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(body_names(&json(&workshop, "o.json")), ["layers"]);
    let note = "note: layers.inp is one body of 3 element sets, the first 'lower layer': a scene file takes them as \
                bodies by their names (parts = [\"lower layer\"])\n";
    assert_eq!(run.stderr, note);
    assert!(run.stdout.contains("The scene has one body: there are no pairs."), "{}", run.stdout);
    let run =
        workshop.run("resolve", &["layers.inp", "--gap", "0.05", "--no-report", "--out", "one"]);
    assert!(run.stdout.contains("The scene has one body: there is no gap"), "{}", run.stdout);

    let body = |part: &str| format!("[[body]]\nfile = \"layers.inp\"\nparts = [\"{part}\"]\n");
    let bodies = body("bone") + "kind = \"rigid\"\n" + &body("upper") + &body("lower layer");
    workshop.write("scene.toml", &bodies);
    let options = ["scene.toml", "--gap", "0.05", "--no-report", "--out", "apart"];
    let run = workshop.run("resolve", &options);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let note = "note: 'upper' and 'lower layer' share 81 nodes: they are tied there\n";
    assert_eq!(run.stderr, note);
    workshop.write("after.toml", bodies.replace("layers.inp", "apart/layers.inp"));
    let run = workshop.check(&["after.toml", "--margin", "0.1", "--json", "o.json"]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    assert_eq!(workshop.read("apart/layers.inp").lines().count(), layers().lines().count());

    // Elements of no body are named, whether they have a set or not.
    for (set, name) in [("\"lower layer\"", "lower layer"), ("", "elements without a set")] {
        let file = layers().replace(", elset=\"lower layer\"", &format!(", elset={set}"));
        workshop.write("layers.inp", file.replace(", elset=\n", "\n"));
        workshop.write("two.toml", body("Bone") + "kind = \"rigid\"\n" + &body("UPPER"));
        let options = ["two.toml", "--gap", "0.05", "--no-report", "--out", "two"];
        let run = workshop.run("resolve", &options);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        let note = format!(
            "note: 'UPPER' shares 81 nodes with '{name}', which is no body of the scene: they stay\n"
        );
        assert_eq!(run.stderr, note);
    }

    let run = workshop.run("field", &["layers.inp", "--part", "bone", "--json", "o.json"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(json(&workshop, "o.json")["built"]["faces"], 2 * 2 * (5 * 5 + 2 * 5 * 3));
}

#[test]
fn numbers_of_nodes_are_those_of_the_part() {
    let workshop = Workshop::new();
    workshop.write("knee.inp", knee(&TURN));
    let scene = "[[body]]\nfile = \"knee.inp\"\nparts = [\"femur\"]\nkind = \"rigid\"\n\
        [[body]]\nfile = \"knee.inp\"\nparts = [\"MENISCUS\"]\n\
        [[fixed]]\nbody = \"MENISCUS\"\nvertices = \"nodes.txt\"\n";
    workshop.write("scene.toml", scene);
    // The last node, at the top.
    workshop.write("nodes.txt", "144\n");
    let options = ["scene.toml", "--gap", "0.05", "--no-report", "--out", "apart"];
    let run = workshop.run("resolve", &options);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let [before, after] = ["knee.inp", "apart/knee.inp"].map(|name| workshop.read(name));
    let line = |text: &str| text.lines().nth(3 + 143).map(str::to_owned);
    assert!(line(&before).is_some_and(|line| line.starts_with("144, ")), "{:?}", line(&before));
    assert_eq!(line(&before), line(&after));

    // Both instances have such a node.
    workshop.write(
        "scene.toml",
        "[[body]]\nname = \"all\"\nfile = \"knee.inp\"\nparts = [\"femur\", \"meniscus\"]\n\
         [[fixed]]\nbody = \"all\"\nvertices = \"nodes.txt\"\n",
    );
    workshop.write("nodes.txt", "144\n");
    let run = workshop.run("resolve", &options);
    assert_eq!(run.status, 2, "{}", run.stdout);
    let refusal = "nodes.txt: line 1: '144' is the number of several vertices of 'all'";
    assert!(run.stderr.contains(refusal), "{}", run.stderr);
}

#[test]
fn names_of_instances_are_checked() {
    let workshop = Workshop::new();
    workshop.write("knee.inp", knee(&TURN));
    let body = "[[body]]\nfile = \"knee.inp\"\n";
    let cases = [
        (body.to_owned(), "knee.inp: has the parts 'femur', 'meniscus': name those of the body"),
        (
            format!("{body}parts = [\"Bone\"]\n"),
            "knee.inp: has no part 'Bone'; its parts are 'femur', 'meniscus'",
        ),
        (
            format!("{body}parts = [\"femur\"]\n{body}name = \"again\"\nparts = [\"Femur\"]\n"),
            "part 'femur' is of 'femur' and of 'again': a part is of one body",
        ),
    ];
    for (scene, expected) in cases {
        workshop.write("scene.toml", scene);
        let run = workshop.check(&["scene.toml"]);
        assert_eq!(run.status, 2, "{expected}: {}", run.stdout);
        assert!(run.stderr.contains(expected), "{expected}: {}", run.stderr);
    }

    // Of a wrong model the fault is named, not the body that is missing; of several files, all that are missing.
    workshop.write("knee.inp", knee(&TURN).replace("part=Tissue", "part=Tibia"));
    let run = workshop.check(&["knee.inp", "--rigid", "femur"]);
    assert!(run.stderr.contains("is of the part 'Tibia', which is not defined"), "{}", run.stderr);
    let run = workshop.check(&["none.inp", "no.inp"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    for name in ["none.inp", "no.inp"] {
        assert!(run.stderr.contains(&format!("{name}: cannot be read: ")), "{}", run.stderr);
    }
}
