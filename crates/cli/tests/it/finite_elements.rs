//! The way of `docs/finite-elements.md`: mesh files in, gap proved, files out.

use std::collections::BTreeMap;

use fixtures::Mesh;
use fixtures::shapes::icosphere;
use fixtures::volume::Block;
use glam::DVec3;
use serde_json::Value;

use crate::support::Workshop;

/// Page whose commands are run.
const PAGE: &str = include_str!("../../../../docs/finite-elements.md");

/// Returns the commands of the first block of the page, as lists of arguments.
fn commands() -> Vec<Vec<&'static str>> {
    let block = PAGE.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next());
    let lines = block.expect("a block of commands").lines();
    lines.map(|line| line.split_whitespace().skip(1).collect()).collect()
}

/// A block of hexahedra whose top is domed, so that it presses into what lies above its middle.
fn bone() -> Block {
    let mut block = Block::new(DVec3::new(10.0, 10.0, 4.0), [8, 8, 3]);
    for x in &mut block.nodes {
        let share = DVec3::new(x.x / 10.0, x.y / 10.0, x.z / 4.0);
        let [along, across] = [share.x, share.y].map(|share| (std::f64::consts::PI * share).sin());
        x.z += 0.6 * share.z * along * across;
    }
    block
}

/// A block above, whose middle the dome enters by a third of a millimeter.
fn muscle() -> Block {
    let size = DVec3::new(9.0, 9.0, 6.0);
    Block::new(size, [9, 9, 6]).with_noise(size, 0.1).translated(DVec3::new(0.53, 0.47, 4.27))
}

/// Returns a block as an Abaqus input file of elements of a type, numbered from 101.
fn inp(block: &Block, kind: &str) -> String {
    let mut text = "*Heading\n a block\n*Node\n".to_owned();
    let (mut nodes, mut elements) = (block.nodes.clone(), elements(block, kind));
    if kind == "C3D10" {
        add_middle_nodes(&mut nodes, &mut elements);
    }
    for (number, x) in (101..).zip(&nodes) {
        text += &format!("{number}, {:.4}, {:.4}, {:.4}\n", x.x, x.y, x.z);
    }
    text += &format!("*Element, type={kind}\n");
    for (number, nodes) in (1..).zip(elements) {
        let nodes: Vec<String> = nodes.into_iter().map(|node| (node + 101).to_string()).collect();
        text += &format!("{number}, {}\n", nodes.join(", "));
    }
    text + "*Nset, nset=attachment\n101, 102\n*Material, name=muscle\n*Elastic\n 0.1, 0.45\n"
}

/// Returns the corners of a block's elements.
fn elements(block: &Block, kind: &str) -> Vec<Vec<u32>> {
    match kind {
        "C3D4" | "C3D10" => block.tetrahedra().into_iter().map(Vec::from).collect(),
        "C3D6" => block.wedges().into_iter().map(Vec::from).collect(),
        _ => block.hexahedra.iter().map(|nodes| nodes.to_vec()).collect(),
    }
}

/// Adds a node in the middle of each edge of tetrahedra, in the order of Abaqus.
fn add_middle_nodes(nodes: &mut Vec<DVec3>, elements: &mut [Vec<u32>]) {
    let mut known = BTreeMap::new();
    for element in elements {
        for [a, b] in [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]] {
            let ends = [element[a].min(element[b]), element[a].max(element[b])];
            let node = *known.entry(ends).or_insert_with(|| {
                nodes.push(0.5 * (nodes[ends[0] as usize] + nodes[ends[1] as usize]));
                u32::try_from(nodes.len() - 1).expect("few nodes")
            });
            element.push(node);
        }
    }
}

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_str(&workshop.read(name)).expect("JSON")
}

#[test]
fn the_commands_of_the_page_give_files_with_a_gap() {
    for kind in ["C3D8R", "C3D4", "C3D6"] {
        let workshop = Workshop::new();
        workshop.write("bone.inp", inp(&bone(), "C3D8R"));
        workshop.write("muscle.inp", inp(&muscle(), kind));
        let [seen, resolved, checked] = &commands()[..] else { panic!("three commands") };
        let run = |command: &[&str]| workshop.run(command[0], &command[1..]);

        assert_eq!(run(seen).status, 1, "they overlap at first");
        let resolve = run(resolved);
        assert_eq!(resolve.status, 0, "{}{}", resolve.stdout, resolve.stderr);
        assert!(resolve.stdout.contains("The gap of 0.05"), "{}", resolve.stdout);
        assert!(resolve.stdout.contains("elements follow, least scaled"), "{}", resolve.stdout);
        let apart = workshop.run(checked[0], &[&checked[1..], &["--json", "apart.json"]].concat());
        assert_eq!(apart.status, 0, "{}", apart.stdout);
        let distance = json(&workshop, "apart.json")["pairs"][0]["distance"].as_f64();
        assert!(distance.expect("they are near") >= 0.05 - 1e-12, "{distance:?}");

        // The bone is the file that was given; of the muscle, only coordinates of nodes differ.
        assert_eq!(workshop.read("apart/bone.inp"), workshop.read("bone.inp"));
        let [before, after] = ["muscle.inp", "apart/muscle.inp"].map(|name| workshop.read(name));
        let [before, after]: [Vec<&str>; 2] = [before.lines().collect(), after.lines().collect()];
        assert_eq!(before.len(), after.len());
        let nodes =
            3..before.iter().position(|line| line.starts_with("*Element")).expect("elements");
        let mut moved = 0;
        for (line, (before, after)) in before.iter().zip(&after).enumerate() {
            let number = |text: &str| text.split(',').next().map(str::to_owned);
            assert!(before == after || nodes.contains(&line), "line {line}: {after}");
            assert_eq!(number(before), number(after), "line {line}");
            moved += usize::from(before != after);
        }
        assert!(moved > 20, "{moved} nodes moved");

        let gate = json(&workshop, "gap.json");
        assert_eq!((&gate["resolved"], &gate["gap"]), (&Value::Bool(true), &Value::from(0.05)));
        let pair = &gate["pairs"][0];
        assert_eq!((&pair["status"], &pair["proved"]), (&"apart".into(), &true.into()));
        let elements = &gate["bodies"][1]["elements"];
        assert_eq!(elements["after"]["inverted_elements"], 0);
        assert_eq!(elements["followed_share"], 1.0);
        assert!(workshop.read("apart/muscle_displacement.vtu").contains("displacement_length"));
    }
}

/// Sets of nodes have those in the middle of edges, too; what is written is as straight as what was read.
#[test]
fn quadratic_elements_stay_straight_and_attached() {
    let workshop = Workshop::new();
    workshop.write("bone.inp", inp(&bone(), "C3D8R"));
    workshop.write("muscle.inp", inp(&muscle(), "C3D10"));
    let before = mesh_io::read_mesh(&workshop.path("muscle.inp")).expect("a mesh");
    let before = before.volume.expect("a volume mesh");

    // One node in the middle of an edge of the flank, by its number, stands for both ends.
    let from_flank = |node: u32| before.nodes[node as usize].distance(DVec3::new(0.53, 5.0, 4.8));
    let on_surface = |node: u32| before.boundary.nodes.binary_search(&node).is_ok();
    let middle = before
        .mesh
        .middle_nodes()
        .iter()
        .filter(|middle| middle.ends.iter().all(|&end| on_surface(end)));
    let middle =
        middle.min_by(|a, b| from_flank(a.node).total_cmp(&from_flank(b.node))).expect("an edge");
    workshop.write("attachment.txt", before.node_numbers[middle.node as usize].to_string());
    let bodies = "[[body]]\nfile = \"bone.inp\"\nkind = \"rigid\"\n\
                  [[body]]\nfile = \"muscle.inp\"\nkind = \"deformable\"\n";
    let resolved = |scene: &str, folder: &str| {
        workshop.write("scene.toml", scene);
        let run = workshop
            .run("resolve", &["scene.toml", "--gap", "0.02", "--no-report", "--out", folder]);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        let path = workshop.path(&format!("{folder}/muscle.inp"));
        mesh_io::read_mesh(&path).expect("straight edges").volume.expect("a volume mesh")
    };
    let free = resolved(bodies, "free");
    assert_ne!(
        free.nodes[middle.node as usize], before.nodes[middle.node as usize],
        "it would move"
    );
    let fixed = "[[fixed]]\nbody = \"muscle\"\nvertices = \"attachment.txt\"\n";
    let after = resolved(&format!("{bodies}{fixed}"), "apart");
    let moves = |node: u32| before.nodes[node as usize] != after.nodes[node as usize];
    assert!(!middle.ends.iter().copied().any(moves) && !moves(middle.node), "{middle:?}");
    let mut moved = 0;
    for edge in after.mesh.middle_nodes() {
        let [a, b] = edge.ends.map(|end| after.nodes[end as usize]);
        let x = after.nodes[edge.node as usize];
        if edge.ends.iter().copied().any(moves) {
            moved += 1;
            assert!(x.distance(0.5 * (a + b)) < 1e-11, "{edge:?}");
        } else {
            assert!(!moves(edge.node), "{edge:?}");
        }
    }
    assert!(moved > 20, "{moved}");
}

/// A muscle one element thin, in which a deep dent would invert elements.
#[test]
fn elements_in_the_way_are_named() {
    let workshop = Workshop::new();
    let scene = "[[body]]\nfile = \"bone.inp\"\nkind = \"rigid\"\n[[body]]\nfile = \"muscle.inp\"\n\
        [[fixed]]\nbody = \"muscle\"\nbox = [[-1, -1, 4.6], [11, 11, 9]]\n";
    let thin = Block::new(DVec3::new(9.0, 9.0, 0.5), [9, 9, 1]);
    workshop.write("bone.inp", inp(&bone(), "C3D8R"));
    workshop.write("muscle.inp", inp(&thin.translated(DVec3::new(0.53, 0.47, 4.2)), "C3D8R"));
    workshop.write("scene.toml", scene);
    let arguments = ["scene.toml", "--gap", "0.08", "--out", "apart", "--no-report"];
    let before = workshop.listing();
    let run = workshop.run("resolve", &[&arguments[..], &["--json", "-"]].concat());
    assert_eq!(run.status, 1, "{}{}", run.stdout, run.stderr);
    let document: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(document["written"], false);
    assert_eq!(workshop.listing(), before);

    // Marked where it is written on request.
    let keep = ["--keep-going", "--json", "kept.json"];
    let kept = workshop.run("resolve", &[&arguments[..], &keep].concat());
    assert_eq!(kept.status, 1);
    let mut files = workshop.listing();
    files.retain(|name| name.starts_with("apart/") && name.ends_with(".inp"));
    assert_eq!(files, ["apart/bone_unproved.inp", "apart/muscle_unproved.inp"]);
    let after = mesh_io::read_mesh(&workshop.path("apart/muscle_unproved.inp")).expect("a mesh");
    let volume = after.volume.expect("a volume mesh");
    assert_eq!(volume.mesh.quality(&volume.nodes).inverted, 0, "no element is inverted");

    // What is said is of the files, which hold a part of the displacement.
    let before = mesh_io::read_mesh(&workshop.path("muscle.inp")).expect("a mesh");
    let mut longest: f64 = 0.0;
    for (x, start) in after.positions.iter().zip(&before.positions) {
        longest = longest.max(x.distance(*start));
    }
    let document = json(&workshop, "kept.json");
    let [said, share] = [
        &document["bodies"][1]["max_displacement"],
        &document["bodies"][1]["elements"]["followed_share"],
    ]
    .map(|value| value.as_f64().expect("a number"));
    assert!(longest > 0.0 && share < 1.0, "{longest} {share}");
    assert!((said - longest).abs() <= 1e-12 * longest, "{said}, the file has {longest}");
    let check = workshop.check(&["apart/bone_unproved.inp", "apart/muscle_unproved.inp"]);
    assert_eq!(check.status, 1, "they overlap in the files");
    assert!(!kept.stdout.contains("Nothing overlaps"), "{}", kept.stdout);
    assert!(kept.stdout.contains("1 pair overlaps in the files."), "{}", kept.stdout);
}

#[test]
fn inverted_elements_are_named_by_their_number() {
    let workshop = Workshop::new();
    let text = inp(&Block::new(DVec3::ONE, [1; 3]), "C3D4");
    // The first element with two nodes exchanged.
    let element = text.lines().find(|line| line.starts_with("1, ")).expect("an element");
    let nodes: Vec<&str> = element.split(", ").collect();
    let turned = [nodes[0], nodes[2], nodes[1], nodes[3], nodes[4]].join(", ");
    workshop.write("muscle.inp", text.replace(element, &turned));
    let run = workshop.run("resolve", &["muscle.inp", "--out", "apart"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    let expected =
        "'muscle' has 1 elements that are inverted or flat at the start, the worst is 1 ";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
    let check = workshop.check(&["muscle.inp"]);
    assert!(check.stdout.contains("1 element inverted or flat"), "{}", check.stdout);
}

/// Shells, lines and types that are not known may be what a body lacks.
#[test]
fn elements_that_are_left_out_are_counted_by_type() {
    let workshop = Workshop::new();
    let elements = "*Element, type=S3R\n901, 101, 102, 103\n902, 102, 103, 104\n*Element, type=U7\n\
                    911, 101, 102,\n103, 104\n*Element, type=s3r\n903, 101, 102, 104\n";
    let solid = inp(&Block::new(DVec3::ONE, [1; 3]), "C3D8R");
    workshop.write("bone.inp", solid.replace("*Nset", &format!("{elements}*Nset")));
    workshop.write("plain.inp", solid);
    let text =
        "3 elements of type 'S3R', 1 element of type 'U7' left out, which are no part of the mesh";
    let run = workshop.check(&["bone.inp", "--json", "o.json"]);
    assert_eq!((run.status, run.stderr), (0, format!("warning: bone.inp: {text}\n")));
    for content in [run.stdout, workshop.read("o.json")] {
        assert!(content.contains(text), "{content}");
    }
    let run = workshop.run("field", &["bone.inp"]);
    assert!(run.stderr.starts_with(&format!("warning: bone.inp: {text}\n")), "{}", run.stderr);
    assert_eq!(workshop.check(&["plain.inp"]).stderr, "");
}

/// Returns a surface as an Abaqus file of triangles, numbered from 101, with a reference point.
fn shells(mesh: &Mesh, kind: &str) -> String {
    let mut text = "*Node\n7, 0., 0., 0.\n".to_owned();
    for (number, x) in (101..).zip(&mesh.positions) {
        text += &format!("{number}, {:?}, {:?}, {:?}\n", x.x, x.y, x.z);
    }
    text += &format!("*Element, type={kind}\n");
    for (number, corners) in (1..).zip(&mesh.faces) {
        let [a, b, c] = corners.map(|corner| corner + 101);
        text += &format!("{number}, {a}, {b}, {c}\n");
    }
    text + "*Rigid Body, ref node=7\n"
}

/// A bone of deformable elements is rigid by a set of the assembly, and a muscle beside it is not.
#[test]
fn bones_of_abaqus_are_rigid_by_their_constraints() {
    let solid = |body: &Block| inp(body, "C3D8R");
    let part = |name: &str, body: &Block| format!("*Part, name={name}\n{}*End Part\n", solid(body));
    let model = format!(
        "{}{}*Assembly, name=knee\n*Instance, name=femur-1, part=femur\n*End Instance\n\
         *Instance, name=muscle-1, part=muscle\n*End Instance\n\
         *Elset, elset=_bone, internal, instance=femur-1, generate\n1, 100000, 1\n\
         *Rigid Body, ref node=_rp, elset=_bone\n*Tie, name=glue\na, b\n*End Assembly\n",
        part("femur", &bone()),
        part("muscle", &muscle()),
    );
    let workshop = Workshop::new();
    workshop.write("knee.inp", &model);
    let run =
        workshop.run("resolve", &["knee.inp", "--gap", "0.05", "--out", "apart", "--no-report"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let note = "note: knee.inp: ties of the model are not read (1 tie, the first 'glue'): [[tie]] in a scene file \
                attaches bodies\n";
    assert_eq!(run.stderr, note);
    let apart = workshop.read("apart/knee.inp");
    let (bone, muscle) = (model.find("*Part, name=muscle"), model.find("*Assembly"));
    let (bone, muscle) = (bone.expect("a part"), muscle.expect("an assembly"));
    assert_eq!(model[..bone], apart[..bone], "the bone moved");
    assert_ne!(model[bone..muscle], apart[bone..muscle], "the muscle stayed");
}

/// Bones are often rigid surfaces, whose reference point may be in another body.
#[test]
fn surfaces_of_abaqus_keep_all_but_their_nodes() {
    let bone = icosphere(4.0, 2);
    let muscle = icosphere(5.0, 2).translated(DVec3::X * 8.5);
    let workshop = Workshop::new();
    workshop.write("bone.inp", shells(&bone, "R3D3"));
    workshop.write("muscle.inp", shells(&muscle, "S3R"));

    // The vertices that are farthest from the bone, by the numbers of their nodes.
    let far = (101..).zip(&muscle.positions).filter(|(_, x)| x.x > 13.0);
    let far: Vec<String> = far.map(|(node, _)| node.to_string()).collect();
    workshop.write("far.txt", far.join("\n"));
    workshop.write(
        "scene.toml",
        "[[body]]\nfile = \"bone.inp\"\nkind = \"rigid\"\n\
         [[body]]\nfile = \"muscle.inp\"\nkind = \"deformable\"\n\
         [[fixed]]\nbody = \"muscle\"\nvertices = \"far.txt\"\n",
    );

    let seen = workshop.check(&["bone.inp", "muscle.inp"]);
    assert!(seen.stdout.contains("1 isolated vertex"), "the reference point: {}", seen.stdout);
    let run = workshop.run("resolve", &["scene.toml", "--gap", "0.05", "--out", "apart"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let apart = workshop.run("check", &["apart/bone.inp", "apart/muscle.inp", "--json", "a.json"]);
    assert_eq!(apart.status, 0, "{}", apart.stdout);
    let distance = json(&workshop, "a.json")["pairs"][0]["distance"].as_f64();
    assert!(distance.expect("they are near") >= 0.05 - 1e-12, "{distance:?}");

    // Lines of nodes that are held, of the reference point, and of elements are as they were.
    assert_eq!(workshop.read("apart/bone.inp"), workshop.read("bone.inp"));
    let [before, after] = ["muscle.inp", "apart/muscle.inp"].map(|name| workshop.read(name));
    let mut moved = 0;
    for (before, after) in before.lines().zip(after.lines()) {
        let node = before.split(',').next().expect("a word").to_owned();
        let stays = far.contains(&node) || node == "7" || before.matches(',').count() != 3;
        assert!(before == after || !stays, "{before}: {after}");
        moved += usize::from(before != after);
    }
    assert!(moved > 0 && before.lines().count() == after.lines().count(), "{moved} moved");

    // A number that no node has.
    workshop.write("far.txt", "3\n");
    let run = workshop.run("resolve", &["scene.toml", "--gap", "0.05", "--out", "new"]);
    assert!(run.stderr.contains("'3' is no vertex on the surface of 'muscle'"), "{}", run.stderr);
}
