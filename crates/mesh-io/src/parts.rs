//! Parts of files with several bodies over one list of nodes.

use std::collections::BTreeMap;

use volume_mesh::Cell;

use crate::ReadError;
use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::solid::NumberedCells;
use crate::text::quoted;
use crate::text_nodes::TextNodes;
use crate::volume::NumberedNodes;

/// Nodes of a file, and the parts that its elements are.
#[derive(Debug)]
pub(crate) struct FileParts {
    format: &'static Format,
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
    /// Number of elements without an area.
    pub(crate) lines: usize,
    /// Nodes of these, and of elements that cannot be read.
    pub(crate) other_nodes: Vec<u32>,
    /// Description of the first elements that cannot be read.
    pub(crate) unsupported: Option<String>,
}

impl FileParts {
    pub(crate) fn new(format: &'static Format) -> Self {
        Self { format, nodes: TextNodes::default(), parts: Vec::new() }
    }

    /// Returns the number of the part of a name, a new one where there is none.
    pub(crate) fn part_number(&mut self, name: &str) -> usize {
        let number = self.parts.iter().position(|part| part.name == name);
        number.unwrap_or_else(|| {
            self.parts.push(Part { name: name.to_owned(), ..Part::default() });
            self.parts.len() - 1
        })
    }

    /// Returns a part by its number.
    pub(crate) fn part(&mut self, number: usize) -> &mut Part {
        &mut self.parts[number]
    }

    /// Returns the number of parts.
    pub(crate) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Returns the names of all parts that are meshes.
    pub(crate) fn names(&self) -> Vec<String> {
        self.parts.iter().filter(|part| part.is_mesh()).map(|part| part.name.clone()).collect()
    }

    /// Returns the nodes of each part by its name, ascending, whatever its elements are.
    pub(crate) fn nodes_by_part(&self) -> BTreeMap<String, Vec<u32>> {
        self.parts.iter().map(|part| (part.name.clone(), part.nodes())).collect()
    }

    /// Returns the mesh of some parts together; without names, that of the only part.
    pub(crate) fn mesh(&self, names: &[String]) -> Result<Mesh, ReadError> {
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
        for part in self.parts.iter().filter(|part| wanted.contains(&part.name)) {
            if let Some(feature) = &part.unsupported {
                let part = quoted(&part.name);
                return Err(self.format.unsupported(format!("the part {part} with {feature}")));
            }
            whole.add(part);
        }
        whole.into_mesh(&self.nodes.numbered)
    }
}

impl Part {
    fn is_mesh(&self) -> bool {
        !self.cells.is_empty() || !self.polygons.is_empty() || self.unsupported.is_some()
    }

    /// Returns all nodes of its elements, ascending.
    fn nodes(&self) -> Vec<u32> {
        let mut nodes = self.other_nodes.clone();
        nodes.extend(self.cells.cells.iter().flat_map(Cell::nodes));
        nodes.extend(self.cells.middle_nodes.iter().map(|middle| middle.node));
        nodes.extend(self.polygons.corners().filter_map(|corner| u32::try_from(corner).ok()));
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    fn add(&mut self, other: &Self) {
        self.cells.append(&other.cells);
        self.polygons.append(&other.polygons);
        self.lines += other.lines;
    }

    /// Returns the cells with the surface around them, or else the surface, over the nodes that it uses.
    fn into_mesh(mut self, nodes: &NumberedNodes) -> Result<Mesh, ReadError> {
        let (cells, lines) = (std::mem::take(&mut self.cells), self.lines);
        let others = BTreeMap::new();
        let (mesh, nodes) = if cells.is_empty() {
            let used = self.polygons.renumber(nodes.positions.len());
            let mesh = Mesh::of_elements(nodes.of(&used), cells, &self.polygons, &others)?;
            (mesh, Some(used))
        } else {
            let mesh = Mesh::of_elements(nodes.clone(), cells, &self.polygons, &others)?;
            let nodes = mesh.volume.as_ref().map(|volume| volume.boundary.nodes.clone());
            (mesh, nodes)
        };
        let mut skipped = mesh.skipped.unwrap_or_default();
        if lines > 0 {
            skipped.add_all("line", lines);
        }
        Ok(Mesh { skipped: skipped.if_any(), nodes, ..mesh })
    }
}
