//! Files of bodies that are parts of one file, after overlap removal.
//!
//! A model is written once, with the nodes of all of its parts where their bodies are. What was written is
//! read again, part by part, as other files are.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use mesh_io::{PartNodes, Volume};
use musculo_collide::surface::{UnionFind, parallel};
use musculo_collide::volume_mesh::{Followed, MiddleNode};
use musculo_collide::{BodyId, Progress};

use super::body_file::{BodyFile, NO_TRIANGLES, elements, follow};
use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::report::counted;
use crate::shared_nodes::other_parts;
use crate::terminal;

/// Part of a file at the end, before it is written.
struct MovedPart {
    body: BodyId,
    /// Positions of the vertices, each where the first body that has it is.
    positions: Vec<DVec3>,
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

    // Vertices of several bodies are in one place before volume meshes follow.
    let ends = vertex_ends(loaded, bodies);
    let scene = &*loaded;
    let cells = |body: &BodyId| scene.volumes[body.index()].as_ref().map_or(0.0, cell_count);
    let of_part = |body: &BodyId| following_steps(scene, *body, start);
    let steps = progress.steps(bodies.iter().map(of_part).sum());
    let parts = parallel::map_costly_first(
        bodies,
        cells,
        || (),
        |(), body| {
            // Of several parts, each counts at its end.
            let progress = if bodies.len() == 1 { progress } else { steps.within() };
            let part = MovedPart::new(scene, *body, &ends, &start[body.index()], progress)?;
            steps.advance(of_part(body))?;
            Ok(part)
        },
    );
    let mut parts = parts.into_iter().collect::<Result<Vec<_>, Failure>>()?;
    shorten_together(loaded, &mut parts, start, progress)?;
    let mut nodes = MovedNodes::default();
    let (rigid, soft): (Vec<_>, Vec<_>) =
        parts.iter().partition(|part| loaded.scene.body(part.body).is_rigid());
    for parts in [rigid, soft] {
        for part in &parts {
            nodes.add(loaded, part, &start[part.body.index()], &path)?;
        }
        for part in &parts {
            nodes.add_middle_nodes(loaded, part.body);
        }
    }
    let moves = nodes.moves();
    let content =
        mesh_io::move_nodes(&original, &mesh_io::extension(&path), &moves).map_err(refused)?;
    let of_parts =
        mesh_io::nodes_by_part(&original, &mesh_io::extension(&path)).map_err(refused)?;
    warn_of_other_parts(loaded, bodies, &of_parts, &moves);

    // Parsed as others will read it.
    let described = |body: &BodyId| &*loaded.description.bodies[body.index()].parts;
    let names: Vec<&[String]> = bodies.iter().map(described).collect();
    let meshes =
        mesh_io::parse_parts(&content, &mesh_io::extension(&path), &names).map_err(refused)?;
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

/// Returns the steps of progress that it takes to complete the file of a body: one, and one for each element that
/// follows.
pub(super) fn following_steps(loaded: &LoadedScene, body: BodyId, start: &[Vec<DVec3>]) -> usize {
    let volume = loaded.volumes[body.index()].as_ref();
    let has_moved = loaded.scene.body(body).positions() != start[body.index()];
    1 + volume.filter(|_| has_moved).map_or(0, |volume| volume.mesh.cells().len())
}

/// Returns the number of cells of a volume mesh.
#[expect(clippy::cast_precision_loss, reason = "an estimate of the time to follow its surface")]
fn cell_count(volume: &Volume) -> f64 {
    volume.mesh.cells().len() as f64
}

/// Returns where the vertices of bodies end, by their nodes: those of several bodies where the first one has them,
/// rigid ones before all others, as their nodes stay.
fn vertex_ends(loaded: &LoadedScene, bodies: &[BodyId]) -> BTreeMap<u32, DVec3> {
    let is_rigid = |body: &&BodyId| loaded.scene.body(**body).is_rigid();
    let (rigid, soft): (Vec<_>, Vec<_>) = bodies.iter().partition(is_rigid);
    let mut ends = BTreeMap::new();
    for &body in rigid.into_iter().chain(soft) {
        let nodes = loaded.nodes[body.index()].iter().flatten();
        for (&node, x) in nodes.zip(loaded.scene.body(body).positions()) {
            ends.entry(node).or_insert(*x);
        }
    }
    ends
}

/// Shortens the ways of soft parts with nodes in common to the share that the elements of each of them can follow.
fn shorten_together(
    loaded: &LoadedScene,
    parts: &mut [MovedPart],
    start: &[Vec<DVec3>],
    progress: Progress<'_>,
) -> Result<(), Failure> {
    let mut groups = UnionFind::new(parts.len());
    let mut first_parts = BTreeMap::new();
    for (number, part) in (0..).zip(&*parts) {
        if !loaded.scene.body(part.body).is_rigid() {
            for &node in loaded.nodes[part.body.index()].iter().flatten() {
                groups.join(*first_parts.entry(node).or_insert(number), number);
            }
        }
    }

    let mut least_shares = vec![1.0_f64; parts.len()];
    for (number, part) in (0..).zip(&*parts) {
        let least = &mut least_shares[groups.find(number) as usize];
        *least = least.min(part.share());
    }
    for (number, part) in (0..).zip(parts) {
        let share = least_shares[groups.find(number) as usize];
        if share < part.share() {
            part.shorten(loaded, share, &start[part.body.index()], progress)?;
        }
    }
    Ok(())
}

/// Warns of parts that are no bodies of the scene, where nodes of theirs move with those of bodies.
fn warn_of_other_parts(
    loaded: &LoadedScene,
    bodies: &[BodyId],
    of_parts: &BTreeMap<String, PartNodes>,
    moves: &BTreeMap<u32, DVec3>,
) {
    let described = bodies.iter().map(|body| &loaded.description.bodies[body.index()]);
    let Some(path) = described.clone().next().map(|body| body.path.display()) else { return };
    for (part, nodes) in other_parts(of_parts, described) {
        let moved = nodes.nodes.iter().filter(|node| moves.contains_key(node)).count();
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
        ends: &BTreeMap<u32, DVec3>,
        start: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Self, Failure> {
        let nodes = loaded.nodes[body.index()].iter().flatten();
        let positions: Vec<DVec3> = nodes.map(|node| ends[node]).collect();
        let followed = match &loaded.volumes[body.index()] {
            Some(volume) if positions != start => Some(follow(volume, &positions, progress)?),
            _ => None,
        };
        Ok(Self { body, positions, followed })
    }

    /// Returns the share of its way that the elements of the part follow.
    fn share(&self) -> f64 {
        self.followed.as_ref().map_or(1.0, |followed| followed.share)
    }

    /// Takes the part a share of its way only.
    fn shorten(
        &mut self,
        loaded: &LoadedScene,
        share: f64,
        start: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<(), Failure> {
        for (x, from) in self.positions.iter_mut().zip(start) {
            *x = *from + share * (*x - *from);
        }
        if let (Some(volume), Some(_)) = (&loaded.volumes[self.body.index()], &self.followed) {
            let followed = follow(volume, &self.positions, progress)?;
            self.followed = Some(Followed { share: share * followed.share, ..followed });
        }
        Ok(())
    }

    /// Returns start and end of every node of the part but those in the middle of edges.
    fn moves(&self, loaded: &LoadedScene, start: &[DVec3]) -> Vec<(u32, DVec3, DVec3)> {
        let mut moves = Vec::new();
        let number = self.body.index();
        match &loaded.volumes[number] {
            Some(volume) => {
                let ends = self.followed.as_ref().map_or(&volume.nodes, |moved| &moved.positions);
                let middle = volume.mesh.middle_nodes();
                let is_corner =
                    |node: &u32| middle.binary_search_by_key(node, |middle| middle.node).is_err();
                for node in volume.mesh.used_nodes().into_iter().filter(is_corner) {
                    let (from, to) = (volume.nodes[node as usize], ends[node as usize]);
                    moves.push((volume.first_node + node, from, to));
                }
            }
            None => {
                let nodes = loaded.nodes[number].iter().flatten();
                for ((&node, from), to) in nodes.zip(start).zip(&self.positions) {
                    moves.push((node, *from, *to));
                }
            }
        }
        moves
    }
}

/// Distance within which a node of two bodies is in one place \[mean edge length of soft bodies\], where it is inside
/// of one or elements keep one from following: above, other elements are torn.
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
                     one cannot follow the other there, give each its own"
                );
                return Err(Failure::in_file(path, problem));
            }
        }
        Ok(())
    }

    /// Adds the nodes in the middle of edges, where these are once corners are in one place.
    fn add_middle_nodes(&mut self, loaded: &LoadedScene, body: BodyId) {
        let Some(volume) = &loaded.volumes[body.index()] else { return };
        for &MiddleNode { node, ends } in volume.mesh.middle_nodes() {
            let first = volume.first_node;
            let corners = ends.map(|end| self.nodes.get(&(first + end)).map(|(ends, _)| *ends));
            let [Some([from_a, to_a]), Some([from_b, to_b])] = corners else { continue };
            let from = volume.nodes[node as usize];
            let moves = from_a != to_a || from_b != to_b;
            self.put(first + node, [from, if moves { to_a.midpoint(to_b) } else { from }], body);
        }
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
