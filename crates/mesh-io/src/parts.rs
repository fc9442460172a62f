//! Parts of files with several bodies over one list of nodes.

use std::collections::BTreeMap;

use crate::mesh::{Mesh, Polygons};
use crate::solid::NumberedCells;
use crate::text_nodes::TextNodes;
use crate::volume::NumberedNodes;
use crate::{ReadError, SkippedElements};

/// Nodes of a file, and the parts that its elements are.
#[derive(Debug, Default)]
pub(crate) struct FileParts {
    pub(crate) nodes: TextNodes,
    /// Parts in the order of the file.
    parts: Vec<Part>,
}

/// Elements of a part.
#[derive(Debug, Default)]
pub(crate) struct Part {
    name: String,
    pub(crate) cells: NumberedCells,
    pub(crate) polygons: Polygons,
    pub(crate) skipped: SkippedElements,
    /// Refusal of its first elements that cannot be read.
    pub(crate) refusal: Option<ReadError>,
}

impl FileParts {
    /// Returns the part of a name, a new one where there is none.
    pub(crate) fn part(&mut self, name: &str) -> &mut Part {
        let place = self.parts.iter().position(|part| part.name == name);
        let place = place.unwrap_or_else(|| {
            self.parts.push(Part { name: name.to_owned(), ..Part::default() });
            self.parts.len() - 1
        });
        &mut self.parts[place]
    }

    /// Returns the number of parts.
    pub(crate) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Returns the names of all parts that are meshes.
    pub(crate) fn names(&self) -> Vec<String> {
        self.parts.iter().filter(|part| part.is_mesh()).map(|part| part.name.clone()).collect()
    }

    /// Returns the mesh of some parts together; without names, that of the only part.
    pub(crate) fn into_mesh(self, names: &[String]) -> Result<Mesh, ReadError> {
        let known = self.names();
        if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
            return Err(ReadError::UnknownPart { part: unknown.clone(), known });
        }
        if names.is_empty() && known.len() > 1 {
            return Err(ReadError::SeveralParts { known });
        }

        // Elements of all that are wanted, in the order of the file.
        let wanted = if names.is_empty() { &known } else { names };
        let mut whole = Part::default();
        for part in self.parts {
            if wanted.contains(&part.name) {
                whole.add(part)?;
            }
        }
        whole.into_mesh(self.nodes.numbered)
    }
}

impl Part {
    fn is_mesh(&self) -> bool {
        !self.cells.is_empty() || !self.polygons.is_empty() || self.refusal.is_some()
    }

    fn add(&mut self, other: Self) -> Result<(), ReadError> {
        if let Some(refusal) = other.refusal {
            return Err(refusal);
        }
        self.cells.append(other.cells);
        self.polygons.append(&other.polygons);
        self.skipped.append(other.skipped);
        Ok(())
    }

    /// Returns the cells with the surface around them, or else the surface, over the nodes that it uses.
    fn into_mesh(self, nodes: NumberedNodes) -> Result<Mesh, ReadError> {
        let Self { cells, mut polygons, skipped, .. } = self;
        let (mesh, nodes) = if cells.is_empty() {
            let used = polygons.renumber(nodes.positions.len());
            let of_used = nodes.of(&used);
            (Mesh::of_elements(of_used, cells, &polygons, &BTreeMap::new())?, Some(used))
        } else {
            let mesh = Mesh::of_elements(nodes, cells, &polygons, &BTreeMap::new())?;
            let nodes = mesh.volume.as_ref().map(|volume| volume.boundary.nodes.clone());
            (mesh, nodes)
        };
        let mut left_out = mesh.skipped.unwrap_or_default();
        left_out.append(skipped);
        Ok(Mesh { skipped: left_out.if_any(), nodes, ..mesh })
    }
}
