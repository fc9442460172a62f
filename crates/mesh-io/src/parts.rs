//! Parts of files with several bodies over one list of nodes.

use std::collections::BTreeMap;
use std::ops::Range;

use volume_mesh::Cell;

use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::shared_elements::KnownElements;
use crate::solid::NumberedCells;
use crate::text::quoted;
use crate::text_nodes::TextNodes;
use crate::volume::NumberedNodes;
use crate::{ReadError, SkippedElements};

/// Nodes of a file, and the parts that its elements are.
#[derive(Debug)]
pub(crate) struct FileParts {
    format: &'static Format,
    pub(crate) nodes: TextNodes,
    /// Parts in the order of the file.
    parts: Vec<Part>,
    /// Name of the part that has the elements of all others, where there is one.
    pub(crate) whole: Option<String>,
    /// True if an element may be in several parts, by its number.
    pub(crate) share_elements: bool,
}

/// Nodes of a part of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartNodes {
    /// Indices among all nodes of the file, ascending.
    pub nodes: Vec<u32>,
    /// True if some are of solids, or rigid: they spoil elements where they move by themselves.
    /// Those of surfaces, springs and such follow what they are on.
    pub are_of_solids: bool,
    /// True if the part has all elements of the file, those of its sets among them.
    pub is_whole: bool,
}

/// Elements of a part.
#[derive(Debug, Default)]
pub(crate) struct Part {
    name: String,
    pub(crate) cells: NumberedCells,
    pub(crate) polygons: Polygons,
    /// Number of each polygon, where parts may share elements.
    polygon_numbers: Vec<u64>,
    /// True if lists of its elements are rigid, false if one of them is not; `None` where nothing says so.
    is_rigid: Option<bool>,
    /// Elements that are no part of a mesh.
    pub(crate) skipped: SkippedElements,
    /// Nodes of these, and of elements that cannot be read.
    pub(crate) other_nodes: Vec<u32>,
    /// True if some of them are of solids.
    has_other_solids: bool,
    /// Description of the first elements that cannot be read.
    unsupported: Option<String>,
    /// Range of the file's nodes that the part has to itself, from whose first one on its elements count them;
    /// `None` where it shares all of them with others.
    own_nodes: Option<Range<usize>>,
}

impl FileParts {
    pub(crate) fn new(format: &'static Format) -> Self {
        Self {
            format,
            nodes: TextNodes::default(),
            parts: Vec::new(),
            whole: None,
            share_elements: false,
        }
    }

    /// Returns the number of the part of a name.
    pub(crate) fn known_number(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|part| part.name == name)
    }

    /// Returns the number of the part of a name, a new one where there is none.
    pub(crate) fn part_number(&mut self, name: &str) -> usize {
        self.known_number(name).unwrap_or_else(|| {
            self.parts.push(Part { name: name.to_owned(), ..Part::default() });
            self.parts.len() - 1
        })
    }

    /// Adds a part.
    pub(crate) fn push(&mut self, part: Part) {
        self.parts.push(part);
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
        let is_named = |part: &&Part| part.is_mesh() && Some(&part.name) != self.whole.as_ref();
        let meshes = self.parts.iter().filter(is_named);
        self.whole.iter().chain(meshes.map(|part| &part.name)).cloned().collect()
    }

    /// Returns the names of all parts, whatever their elements are.
    pub(crate) fn all_names(&self) -> impl Iterator<Item = &str> + Clone {
        self.parts.iter().map(|part| part.name.as_str())
    }

    /// Returns the nodes of each part by its name, ascending, whatever its elements are.
    pub(crate) fn nodes_by_part(&self) -> BTreeMap<String, PartNodes> {
        let nodes = |part: &Part| PartNodes {
            nodes: part.nodes(),
            are_of_solids: part.has_solids(),
            is_whole: false,
        };
        let mut parts: BTreeMap<_, _> =
            self.parts.iter().map(|part| (part.name.clone(), nodes(part))).collect();
        if let Some(name) = &self.whole {
            let mut all = PartNodes { is_whole: true, ..PartNodes::default() };
            for part in parts.values() {
                all.nodes.extend(&part.nodes);
                all.are_of_solids |= part.are_of_solids;
            }
            all.nodes.sort_unstable();
            all.nodes.dedup();
            parts.insert(name.clone(), all);
        }
        parts
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
        let parts = || self.parts.iter().filter(|part| wanted.contains(&part.name));
        let all = 0..self.nodes.places.len();
        let of_part = |part: &Part| part.own_nodes.clone().unwrap_or_else(|| all.clone());
        let nodes = parts().map(of_part).reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
        let nodes = nodes.unwrap_or_else(|| all.clone());

        let (mut whole, mut known) = (Part::default(), KnownElements::default());
        for part in parts() {
            if let Some(feature) = &part.unsupported {
                let part = quoted(&part.name);
                let unread =
                    format!("the part {part} with {feature}, which a scene file may leave out,");
                return Err(self.format.unsupported(unread));
            }
            let shift = index(of_part(part).start - nodes.start)?;
            if self.share_elements && wanted.len() > 1 {
                whole.add(&part.beside(&mut known), shift);
            } else {
                whole.add(part, shift);
            }
        }
        whole.into_mesh(self.nodes.numbered.within(nodes.clone()), index(nodes.start)?)
    }
}

impl Part {
    /// Returns a part without elements.
    pub(crate) fn named(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    /// Returns a part of another name with the same elements, over nodes of its own.
    pub(crate) fn with_nodes(&self, name: &str, nodes: Range<usize>) -> Self {
        let mut part = Self::named(name);
        part.add(self, 0);
        part.other_nodes.clone_from(&self.other_nodes);
        part.unsupported.clone_from(&self.unsupported);
        part.has_other_solids = self.has_other_solids;
        Self { own_nodes: Some(nodes), ..part }
    }

    /// Returns the part without elements of other parts, which are known, and takes note of its own.
    fn beside(&self, known: &mut KnownElements) -> Self {
        Self {
            cells: known.other_solids(&self.cells),
            polygons: known.other_surfaces(&self.polygons, &self.polygon_numbers),
            is_rigid: self.is_rigid,
            skipped: self.skipped.clone(),
            ..Self::named(&self.name)
        }
    }

    /// Adds a polygon that is an element with a number.
    pub(crate) fn push_surface_element(&mut self, number: u64, nodes: &[u32]) {
        self.polygons.push_nodes(nodes);
        self.polygon_numbers.push(number);
    }

    /// Returns a part of another name with the same nodes, but without a mesh, where there are nodes.
    pub(crate) fn without_mesh(&self, name: &str) -> Option<Self> {
        let (other_nodes, has_other_solids) = (self.nodes(), self.has_solids());
        (!other_nodes.is_empty()).then(|| Self {
            other_nodes,
            has_other_solids,
            ..Self::named(name)
        })
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn set_name(&mut self, name: &str) {
        name.clone_into(&mut self.name);
    }

    /// Returns the number of elements, and of nodes of those that are no part of a mesh.
    pub(crate) fn len(&self) -> usize {
        self.cells.cells.len() + self.polygons.len() + self.other_nodes.len()
    }

    /// Adds a list of its elements that is rigid, or is not: a part is rigid if all are.
    pub(crate) fn add_rigidity(&mut self, is_rigid: bool) {
        self.is_rigid = Some(is_rigid && self.is_rigid != Some(false));
    }

    /// Returns true if all of its elements are rigid.
    pub(crate) fn is_rigid(&self) -> bool {
        self.is_rigid == Some(true)
    }

    pub(crate) fn set_rigid(&mut self, is_rigid: bool) {
        self.is_rigid = Some(is_rigid);
    }

    /// Refuses elements of a type, of solids or not, where they are wanted.
    pub(crate) fn refuse(&mut self, kind: &str, are_solids: bool) {
        self.unsupported.get_or_insert_with(|| unsupported_elements(kind));
        self.has_other_solids |= are_solids;
    }

    /// Returns true if it has solids, also of types that cannot be read, or is rigid.
    fn has_solids(&self) -> bool {
        !self.cells.is_empty() || self.is_rigid() || self.has_other_solids
    }

    fn is_mesh(&self) -> bool {
        !self.cells.is_empty() || !self.polygons.is_empty() || self.unsupported.is_some()
    }

    /// Returns all nodes of its elements by their indices in the file, ascending.
    pub(crate) fn nodes(&self) -> Vec<u32> {
        let mut nodes = self.other_nodes.clone();
        nodes.extend(self.cells.cells.iter().flat_map(Cell::nodes));
        nodes.extend(self.cells.middle_nodes.iter().map(|middle| middle.node));
        nodes.extend(self.polygons.corners().filter_map(|corner| u32::try_from(corner).ok()));
        nodes.sort_unstable();
        nodes.dedup();

        let first = self.own_nodes.as_ref().map_or(0, |nodes| nodes.start);
        nodes.into_iter().filter_map(|node| u32::try_from(first + node as usize).ok()).collect()
    }

    /// Adds the elements of another part, with `shift` added to the indices of their nodes.
    fn add(&mut self, other: &Self, shift: u32) {
        self.cells.append(&other.cells, shift);
        self.polygons.append(&other.polygons, shift);
        self.skipped.append(&other.skipped);
        self.add_rigidity(other.is_rigid());
    }

    /// Returns the cells with the surface around them, or else the surface, over the nodes that it uses. `first` is
    /// the index of the first node in the file.
    fn into_mesh(mut self, nodes: NumberedNodes, first: u32) -> Result<Mesh, ReadError> {
        let is_rigid = self.is_rigid();
        let cells = std::mem::take(&mut self.cells);
        let others = BTreeMap::new();
        let (mut mesh, mut used) = if cells.is_empty() {
            let used = self.polygons.renumber(nodes.positions.len());
            let mesh = Mesh::of_elements(nodes.of(&used), cells, &self.polygons, &others)?;
            (mesh, used)
        } else {
            let mesh = Mesh::of_elements(nodes, cells, &self.polygons, &others)?;
            let used = mesh.volume.as_ref().map(|volume| volume.boundary.nodes.clone());
            (mesh, used.unwrap_or_default())
        };

        // Indices among all nodes of the file.
        used.iter_mut().for_each(|node| *node += first);
        if let Some(volume) = &mut mesh.volume {
            volume.first_node = first;
        }
        let mut skipped = mesh.skipped.unwrap_or_default();
        skipped.append(&self.skipped);
        Ok(Mesh { skipped: skipped.if_any(), nodes: Some(used), is_rigid, ..mesh })
    }
}

/// Returns the name of elements that cannot be read, by their type.
pub(crate) fn unsupported_elements(kind: &str) -> String {
    format!("elements of type {}", quoted(kind))
}

/// Returns the index of a node, which 32 bits hold.
fn index(node: usize) -> Result<u32, ReadError> {
    u32::try_from(node).map_err(|_| ReadError::TooManyVertices(node))
}
