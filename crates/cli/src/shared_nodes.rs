//! Nodes that bodies of one file have in common: parts of a model that are attached to each other.

use musculo_collide::{BodyId, Conditions, FixedVertices, Tie};

use crate::load::LoadedScene;
use crate::report::counted;
use crate::terminal;

impl LoadedScene {
    /// Ties bodies where they share nodes, unless the scene ties them; nodes of rigid bodies stay.
    pub(crate) fn tie_shared_nodes(&self, conditions: &mut Conditions) {
        let ids: Vec<BodyId> = self.scene.ids().collect();
        for file in self.description.bodies_by_file() {
            for (place, &a) in file.iter().enumerate() {
                for &b in &file[place + 1..] {
                    let bodies = [ids[a], ids[b]];
                    let shared = self.shared_vertices(bodies);
                    if !shared.is_empty() {
                        self.tie_vertices(bodies, &shared, conditions);
                    }
                }
            }
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
