//! Nodes that parts of one file have in common: they are attached to each other.

use std::collections::BTreeMap;

use mesh_io::PartNodes;
use musculo_collide::{BodyId, Conditions, FixedVertices, Tie};

use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::motion::{Attached, AttachedBody, Replay};
use crate::report::counted;
use crate::scene::{BodyDescription, TieDescription};
use crate::terminal;

/// Returns the parts of a file with their nodes, none of which is of a body among those of the file: none, where a body
/// is all of it.
pub(crate) fn other_parts<'a>(
    parts: &'a BTreeMap<String, PartNodes>,
    bodies: impl Iterator<Item = &'a BodyDescription> + Clone,
) -> Vec<(&'a String, &'a PartNodes)> {
    let is_body =
        |part: &str| bodies.clone().any(|body| body.parts.is_empty() || body.has_part(part));
    if parts.iter().any(|(part, nodes)| nodes.is_whole && is_body(part)) {
        return Vec::new();
    }
    parts.iter().filter(|(part, nodes)| !nodes.is_whole && !is_body(part)).collect()
}

impl LoadedScene {
    /// Ties bodies where they share nodes, unless the scene ties them; nodes of rigid bodies stay.
    pub(crate) fn tie_shared_nodes(&self, conditions: &mut Conditions) {
        for (bodies, shared) in self.bodies_with_shared_nodes() {
            self.tie_vertices(bodies, &shared, conditions);
        }
    }

    /// Lets soft bodies that nothing else moves go with those that they are tied to, or share nodes with, and says which.
    pub(crate) fn follow_attached(&mut self, replay: &mut Replay) -> Result<(), Failure> {
        let mut attached = Vec::new();
        for tie in &self.description.ties {
            let TieDescription { a, b, within } = tie.get_ref();
            let bodies = [a, b].map(|name| self.scene.find(name));
            if let [Some(a), Some(b)] = bodies {
                attached.push(Attached { bodies: [a, b], within: *within });
            }
        }
        for (bodies, _) in self.bodies_with_shared_nodes() {
            attached.push(Attached { bodies, within: 0.0 });
        }
        if attached.is_empty() {
            return Ok(());
        }
        self.scene.fit_all()?;
        for AttachedBody { body, to } in replay.follow_attached(&self.scene, &attached) {
            let to: Vec<String> = to.iter().map(|name| format!("'{name}'")).collect();
            let note = format!("'{body}' moves with {}, to which it is attached", to.join(" and "));
            terminal::print_line("note", &note);
        }
        Ok(())
    }

    /// Lists pairs of bodies that share nodes, with their vertices.
    fn bodies_with_shared_nodes(&self) -> Vec<([BodyId; 2], Vec<[u32; 2]>)> {
        let ids: Vec<BodyId> = self.scene.ids().collect();
        let mut pairs = Vec::new();
        for file in self.description.bodies_by_file() {
            for (place, &a) in file.iter().enumerate() {
                for &b in &file[place + 1..] {
                    let bodies = [ids[a], ids[b]];
                    let shared = self.shared_vertices(bodies);
                    if !shared.is_empty() {
                        pairs.push((bodies, shared));
                    }
                }
            }
        }
        pairs
    }

    /// Holds the vertices that soft bodies share with solids and rigid parts of their file that are no bodies of the
    /// scene: these stay as they are.
    pub(crate) fn hold_other_parts(&self, conditions: &mut Conditions) -> Result<(), Failure> {
        let ids: Vec<BodyId> = self.scene.ids().collect();
        for file in self.description.bodies_by_file() {
            let bodies = file.iter().map(|&number| &self.description.bodies[number]);
            if bodies.clone().any(|body| body.parts.is_empty()) {
                // All of the file is in the scene.
                continue;
            }
            let path = &self.description.bodies[file[0]].path;
            let content = mesh_io::read_file(path)?;
            let parts = mesh_io::nodes_by_part(&content, &mesh_io::extension(path));
            let parts = parts.map_err(|error| Failure::in_file(path, error))?;
            for (part, nodes) in other_parts(&parts, bodies) {
                if nodes.are_of_solids {
                    for &body in &file {
                        self.hold_nodes(ids[body], part, &nodes.nodes, conditions);
                    }
                }
            }
        }
        Ok(())
    }

    /// Notes the ties of models, which are not read, unless the scene has its own.
    pub(crate) fn note_ties_of_models(&self) -> Result<(), Failure> {
        if !self.description.ties.is_empty() {
            return Ok(());
        }
        for file in self.description.bodies_by_file() {
            let path = &self.description.bodies[file[0]].path;
            if !["inp", "feb"].contains(&&*mesh_io::extension(path).to_ascii_lowercase()) {
                continue;
            }
            let ties = mesh_io::tie_names(&mesh_io::read_file(path)?, &mesh_io::extension(path));
            let ties = ties.map_err(|error| Failure::in_file(path, error))?;
            if let Some(first) = ties.first() {
                let (path, count) = (path.display(), counted(ties.len(), "tie"));
                let first = mesh_io::escaped(first);
                let note = format!(
                    "{path}: ties of the model are not read ({count}, the first '{first}'): [[tie]] in a scene \
                     file attaches bodies"
                );
                terminal::print_line("note", &note);
            }
        }
        Ok(())
    }

    /// Holds the vertices of a soft body that are nodes of a part that is no body of the scene.
    fn hold_nodes(&self, body: BodyId, part: &str, nodes: &[u32], conditions: &mut Conditions) {
        let own = self.nodes[body.index()].iter().flatten();
        let shared = (0..).zip(own).filter(|(_, node)| nodes.binary_search(node).is_ok());
        let vertices: Vec<u32> = shared.map(|(vertex, _)| vertex).collect();
        let body_name = self.scene.body(body).name();
        if !vertices.is_empty() && !self.scene.body(body).is_rigid() {
            let (count, part) = (counted(vertices.len(), "node"), mesh_io::escaped(part));
            let note = format!(
                "'{body_name}' shares {count} with '{part}', which is no body of the scene: they stay"
            );
            terminal::print_line("note", &note);
            conditions.fixed.push(FixedVertices { body, vertices });
        }
    }

    /// Attaches two bodies to each other where they share vertices.
    fn tie_vertices(&self, bodies: [BodyId; 2], shared: &[[u32; 2]], conditions: &mut Conditions) {
        let [a, b] = bodies.map(|body| self.scene.body(body));
        if a.is_rigid() && b.is_rigid() {
            return;
        }
        for (place, (other, body)) in [(b, bodies[0]), (a, bodies[1])].into_iter().enumerate() {
            if other.is_rigid() {
                let vertices = shared.iter().map(|vertices| vertices[place]).collect();
                conditions.fixed.push(FixedVertices { body, vertices });
            }
        }

        let is_of_both = |tie: &Tie| bodies.iter().all(|body| tie.bodies.contains(body));
        if !conditions.ties.iter().any(is_of_both) {
            // Shared nodes are at one place, to the bit.
            conditions.ties.push(Tie { bodies, distance: f64::MIN_POSITIVE });
            let nodes = counted(shared.len(), "node");
            let note =
                format!("'{}' and '{}' share {nodes}: they are tied there", a.name(), b.name());
            terminal::print_line("note", &note);
        }
    }

    /// Returns the vertices of two bodies that are one node of their file, ascending.
    fn shared_vertices(&self, [a, b]: [BodyId; 2]) -> Vec<[u32; 2]> {
        // Nodes of both are ascending.
        let mut shared = Vec::new();
        let nodes = [a, b].map(|body| self.nodes[body.index()].as_deref());
        let [Some(nodes_a), Some(nodes_b)] = nodes else { return shared };
        for (vertex, node) in (0..).zip(nodes_a) {
            if let Ok(other) = nodes_b.binary_search(node)
                && let Ok(other) = u32::try_from(other)
            {
                shared.push([vertex, other]);
            }
        }
        shared
    }
}
