//! Files of bodies that are parts of one file, after overlap removal.
//!
//! A model is written once, with the nodes of all of its parts where their bodies are. What was written is
//! read again, part by part, as other files are.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use musculo_collide::volume_mesh::Followed;
use musculo_collide::{BodyId, Progress};

use super::body_file::{BodyFile, NO_TRIANGLES, elements, extension, follow};
use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::report::counted;
use crate::scene::BodyDescription;
use crate::terminal;

/// Part of a file at the end, before it is written.
struct MovedPart {
    body: BodyId,
    /// Volume mesh behind its surface, where there is one that has moved.
    followed: Option<Followed>,
}

/// Completes a file of which bodies are parts, and moves these to what it holds. Returns a body file for each; the
/// first one has the content.
pub(super) fn complete_parts(
    loaded: &mut LoadedScene,
    bodies: &[BodyId],
    start: &[Vec<DVec3>],
    progress: Progress<'_>,
) -> Result<Vec<BodyFile>, Failure> {
    let Some(first) = bodies.first() else { return Ok(Vec::new()) };
    let path = loaded.description.bodies[first.index()].path.clone();
    let refused = |error| Failure::in_file(&path, error);
    let original = mesh_io::read_file(&path)?;

    // Volume meshes follow their surfaces, and each node goes where the bodies have it.
    let (mut parts, mut nodes) = (Vec::new(), MovedNodes::default());
    for &body in bodies {
        let part = MovedPart::new(loaded, body, &start[body.index()], progress)?;
        nodes.add(loaded, &part, &start[body.index()], &path)?;
        parts.push(part);
    }
    let moves = nodes.moves();
    let content = mesh_io::move_nodes(&original, &extension(&path), &moves).map_err(refused)?;
    let of_parts = mesh_io::nodes_by_part(&original, &extension(&path)).map_err(refused)?;
    warn_of_other_parts(loaded, bodies, &of_parts, &moves);

    // Parsed as others will read it.
    let described = |body: &BodyId| &*loaded.description.bodies[body.index()].parts;
    let names: Vec<&[String]> = bodies.iter().map(described).collect();
    let meshes = mesh_io::parse_parts(&content, &extension(&path), &names).map_err(refused)?;
    let mut files = Vec::new();
    for (part, mesh) in parts.into_iter().zip(meshes) {
        let number = part.body.index();
        if mesh.faces != loaded.scene.body(part.body).surface().faces() {
            return Err(Failure::in_file(&path, NO_TRIANGLES));
        }
        let content = files.is_empty().then(|| content.clone());
        let mut file = BodyFile::new(content, &start[number], &mesh.positions);
        if let (Some(volume), Some(written)) = (&loaded.volumes[number], mesh.volume) {
            file.elements = part.followed.map(|moved| elements(volume, &moved, &written.nodes));
            file.set_nodes(&volume.nodes, written.nodes);
        }
        loaded.scene.move_body(part.body, &mesh.positions)?;
        files.push(file);
    }
    Ok(files)
}

/// Warns of parts that are no bodies of the scene, where nodes of theirs move with those of bodies.
fn warn_of_other_parts(
    loaded: &LoadedScene,
    bodies: &[BodyId],
    of_parts: &BTreeMap<String, Vec<u32>>,
    moves: &BTreeMap<u32, DVec3>,
) {
    let described: Vec<&BodyDescription> =
        bodies.iter().map(|body| &loaded.description.bodies[body.index()]).collect();
    let Some(path) = described.first().map(|body| body.path.display()) else { return };
    let is_body = |part: &String| {
        described.iter().any(|body| body.parts.is_empty() || body.parts.contains(part))
    };
    for (part, nodes) in of_parts.iter().filter(|(part, _)| !is_body(part)) {
        let moved = nodes.iter().filter(|node| moves.contains_key(node)).count();
        if moved > 0 {
            let nodes = counted(moved, "node");
            let part = mesh_io::escaped(part);
            let problem =
                format!("{path}: {nodes} of '{part}' move, which is no body of the scene");
            terminal::print_line("warning", &problem);
        }
    }
}

impl MovedPart {
    fn new(
        loaded: &LoadedScene,
        body: BodyId,
        start: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Self, Failure> {
        let positions = loaded.scene.body(body).positions();
        let followed = match &loaded.volumes[body.index()] {
            Some(volume) if positions != start => Some(follow(volume, positions, progress)?),
            _ => None,
        };
        Ok(Self { body, followed })
    }
}

/// Distance within which bodies have a shared node in one place \[mean edge length of soft bodies\]: below, ties
/// do not hold as closely; above, elements are torn.
const ONE_PLACE: f64 = 1e-3;

/// Nodes of a file, each where the bodies that have it are at the end.
#[derive(Debug, Default)]
struct MovedNodes {
    /// Start and end of each node of a body, and the first body that has it.
    nodes: BTreeMap<u32, ([DVec3; 2], BodyId)>,
}

impl MovedNodes {
    /// Adds the nodes of a part. One that another part has goes where the first one has it, and is refused where
    /// the two are apart.
    fn add(
        &mut self,
        loaded: &LoadedScene,
        part: &MovedPart,
        start: &[DVec3],
        path: &Path,
    ) -> Result<(), Failure> {
        let body = part.body;
        for (node, from, to) in part.moves(loaded, start) {
            let (known, first) = self.put(node, [from, to], body);
            if !known.abs_diff_eq(to, ONE_PLACE * loaded.soft_edge()) {
                let [first, second] = [first, body].map(|body| loaded.scene.body(body).name());
                let number = loaded.node_number(body, node);
                let problem = format!(
                    "node {number} is of '{first}' and of '{second}', which would be at {known} and at {to}: \
                     tie them where they share nodes, or give each its own"
                );
                return Err(Failure::in_file(path, problem));
            }
        }
        Ok(())
    }

    /// Adds a node of a body with its start and end. Returns the end by the first body that has it.
    fn put(&mut self, node: u32, ends: [DVec3; 2], body: BodyId) -> (DVec3, BodyId) {
        let ([_, to], first) = self.nodes.entry(node).or_insert((ends, body));
        (*to, *first)
    }

    /// Returns the positions of nodes that are elsewhere than at the start.
    fn moves(&self) -> BTreeMap<u32, DVec3> {
        let moved = self.nodes.iter().filter(|(_, ([from, to], _))| from != to);
        moved.map(|(&node, &([_, to], _))| (node, to)).collect()
    }
}

impl MovedPart {
    /// Returns start and end of every node of the part.
    fn moves(&self, loaded: &LoadedScene, start: &[DVec3]) -> Vec<(u32, DVec3, DVec3)> {
        let mut moves = Vec::new();
        let number = self.body.index();
        match &loaded.volumes[number] {
            Some(volume) => {
                let ends = self.followed.as_ref().map_or(&volume.nodes, |moved| &moved.positions);
                for node in volume.mesh.used_nodes() {
                    moves.push((node, volume.nodes[node as usize], ends[node as usize]));
                }
            }
            None => {
                let ends = loaded.scene.body(self.body).positions();
                let nodes = loaded.nodes[number].iter().flatten();
                for ((&node, from), to) in nodes.zip(start).zip(ends) {
                    moves.push((node, *from, *to));
                }
            }
        }
        moves
    }
}

#[cfg(test)]
mod tests {
    use musculo_collide::surface::TriangleSurface;
    use musculo_collide::{BodyKind, Scene};

    use super::*;

    #[test]
    fn a_node_of_two_bodies_goes_where_the_first_has_it() {
        let mut scene = Scene::new();
        let [first, second] = ["a", "b"].map(|name| {
            let x = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
            let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("a surface");
            scene.add(name, BodyKind::Open, surface, x).expect("a body")
        });
        let mut nodes = MovedNodes::default();
        assert_eq!(nodes.put(4, [DVec3::ZERO, DVec3::X], first), (DVec3::X, first));
        assert_eq!(nodes.put(4, [DVec3::ZERO, DVec3::Y], second), (DVec3::X, first));
        assert_eq!(nodes.put(5, [DVec3::Z, DVec3::Z], second), (DVec3::Z, second));
        assert_eq!(nodes.moves(), BTreeMap::from([(4, DVec3::X)]));
    }
}
