//! Conditions on overlap removal: ties and fixed vertices of a scene, by the numbers of its bodies.

use std::collections::HashMap;
use std::path::Path;

use mesh_io::{MeshFormat, Volume};
use musculo_collide::kdop::Workspace;
use musculo_collide::volume_mesh::{FollowParams, MiddleNode};
use musculo_collide::{BodyId, BodyStiffness, CellCorners, Conditions, FixedVertices, Scene, Tie};

use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::scene::{Selection, TieDescription};

impl LoadedScene {
    /// Finds the bodies and vertices that the conditions of the scene name.
    pub(crate) fn conditions(&mut self) -> Result<Conditions, Failure> {
        // Distances between surfaces need trees.
        self.scene.fit_all()?;
        let mut conditions = Conditions::default();
        for tie in &self.description.ties {
            let TieDescription { a, b, within } = tie.get_ref();
            let bodies = [self.body_id(a)?, self.body_id(b)?];
            conditions.ties.push(Tie { bodies, distance: *within });
        }

        for description in &self.description.bodies {
            if let Some(stiffness) = &description.stiffness {
                let (body, factor) = (self.body_id(&description.name)?, *stiffness.get_ref());
                conditions.stiffnesses.push(BodyStiffness { body, factor });
            }
        }

        for description in self.description.bodies.iter().filter(|body| body.uncross) {
            conditions.uncrossed.push(self.body_id(&description.name)?);
        }

        // A selection of no vertex would hold nothing: it is an error, not an empty condition.
        for fixed in &self.description.fixed {
            let fixed = fixed.get_ref();
            let body = self.body_id(&fixed.body)?;
            if self.scene.body(body).is_rigid() {
                let name = &fixed.body;
                let problem = format!("[[fixed]]: '{name}' is rigid and never moves: leave it out");
                return Err(Failure::new(problem));
            }
            let vertices = match fixed.selection().map_err(Failure::new)? {
                Selection::File(file) => self.listed_vertices(body, file)?,
                Selection::Box { min, max } => {
                    vertices_where(&self.scene, body, |x| x.cmpge(min).all() && x.cmple(max).all())
                }
                Selection::Near { other, distance } => {
                    let other = self.scene.body(self.body_id(other)?).tree();
                    let mut workspace = Workspace::default();
                    vertices_where(&self.scene, body, |x| {
                        other.is_some_and(|tree| {
                            tree.closest_point(x, distance, None, &mut workspace).is_some()
                        })
                    })
                }
            };
            if vertices.is_empty() {
                let place = match fixed.selection().map_err(Failure::new)? {
                    Selection::File(file) => format!("listed in {}", file.display()),
                    Selection::Box { min, max } => format!("in the box from {min} to {max}"),
                    Selection::Near { other, distance } => {
                        format!("within {distance} of '{other}'")
                    }
                };
                let problem = format!("[[fixed]]: no vertex of '{}' is {place}", fixed.body);
                return Err(Failure::new(problem));
            }
            conditions.fixed.push(FixedVertices { body, vertices });
        }
        self.tie_shared_nodes(&mut conditions);
        self.hold_other_parts(&mut conditions)?;
        self.note_ties_of_models()?;
        self.keep_cell_corners(&mut conditions);
        Ok(conditions)
    }

    /// Adds the corners of soft volume meshes that their surfaces hold by themselves.
    fn keep_cell_corners(&self, conditions: &mut Conditions) {
        let FollowParams { min_jacobian_share, .. } = FollowParams::default();
        for (body, volume) in self.scene.ids().zip(&self.volumes) {
            let Some(Volume { mesh, boundary, .. }) = volume else { continue };
            if !self.scene.body(body).is_rigid() {
                let corners = boundary.corners(mesh);
                conditions.cell_corners.push(CellCorners { body, corners, min_jacobian_share });
            }
        }
    }

    fn body_id(&self, name: &str) -> Result<BodyId, Failure> {
        // Descriptions are checked against their bodies before these are read.
        self.scene.find(name).ok_or_else(|| Failure::new(format!("no body is named '{name}'")))
    }

    /// Reads a file of vertex numbers, apart by blanks, commas and lines; `#` begins a comment.
    fn listed_vertices(&self, body: BodyId, file: &Path) -> Result<Vec<u32>, Failure> {
        let described = &self.description.bodies[body.index()];
        if MeshFormat::of(&described.path) == Some(MeshFormat::Stl) {
            let problem = format!(
                "'{}' is of an STL file, whose vertices have no numbers: select them by a box, or within a \
                 distance of a body",
                described.name
            );
            return Err(Failure::in_file(file, problem));
        }
        let text = mesh_io::read_text(file);
        let text =
            text.map_err(|error| Failure::in_file(file, format!("cannot be read: {error}")))?;
        let known = self.vertices_by_number(body);
        let mut vertices = Vec::new();

        for (line, text) in (1..).zip(text.lines()) {
            let content = text.split('#').next().unwrap_or_default();
            let is_separator = |c: char| c == ',' || c.is_whitespace();
            for word in content.split(is_separator).filter(|word| !word.is_empty()) {
                let vertex = word.parse::<u64>().ok().and_then(|number| known.get(&number));
                let name = self.scene.body(body).name();
                let problem = match vertex {
                    Some(Some(found)) => {
                        vertices.extend(found);
                        continue;
                    }
                    Some(None) => format!(
                        "line {line}: '{word}' is the number of several vertices of '{name}', whose instances \
                         number their nodes alike: select them by a box, or within a distance of a body"
                    ),
                    None => {
                        format!("line {line}: '{word}' is no vertex on the surface of '{name}'")
                    }
                };
                return Err(Failure::in_file(file, problem));
            }
        }

        // A vertex may be in the list more than once.
        vertices.sort_unstable();
        vertices.dedup();
        Ok(vertices)
    }

    /// Returns the vertices of a body by the numbers in its file: those of nodes, or else counted from 0. A
    /// node in the middle of an edge stands for both ends; `None` for a number of several vertices.
    fn vertices_by_number(&self, body: BodyId) -> HashMap<u64, Option<[u32; 2]>> {
        let count = self.scene.body(body).positions().len();
        let mut vertices = HashMap::new();
        let mut insert = |number: u64, ends: [u32; 2]| {
            vertices.entry(number).and_modify(|known| *known = None).or_insert(Some(ends));
        };
        let numbers = self.vertex_numbers[body.index()].clone();
        let numbers = numbers.unwrap_or_else(|| (0..count as u64).collect());
        for (vertex, number) in (0..).zip(numbers) {
            insert(number, [vertex; 2]);
        }

        if let Some(Volume { mesh, boundary, node_numbers, .. }) = &self.volumes[body.index()] {
            let vertex = |node: u32| {
                let place = boundary.nodes.binary_search(&node).ok();
                place.and_then(|place| u32::try_from(place).ok())
            };
            for &MiddleNode { node, ends: [a, b] } in mesh.middle_nodes() {
                if let (Some(a), Some(b)) = (vertex(a), vertex(b)) {
                    insert(node_numbers[node as usize], [a, b]);
                }
            }
        }
        vertices
    }
}

/// Lists the vertices of a body whose positions have a property.
fn vertices_where(
    scene: &Scene,
    body: BodyId,
    mut is_selected: impl FnMut(glam::DVec3) -> bool,
) -> Vec<u32> {
    let mut vertices = Vec::new();
    for (vertex, x) in (0..).zip(scene.body(body).positions()) {
        if is_selected(*x) {
            vertices.push(vertex);
        }
    }
    vertices
}
