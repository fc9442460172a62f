//! Physical groups of an MSH file: those of solids are parts, and so are those of surfaces apart from these.

use std::collections::BTreeMap;

use crate::mesh::Polygons;
use crate::msh_elements::{
    CURVED_SURFACES, MSH, MshElement, QUADRILATERAL, TRIANGLE, WITHOUT_VOLUME, solid,
};
use crate::parts::{FileParts, Part};
use crate::text_nodes::TextNodes;
use crate::{ReadError, SkippedElements};

/// Name of the part whose elements are in no group.
const WITHOUT_GROUP: &str = "without group";

/// Dimension and number of a group, or of an entity of the geometry.
type Key = (u64, u64);

/// Dimension of solids.
const SOLIDS: u64 = 3;

/// Dimension of surfaces.
const SURFACES: u64 = 2;

/// Elements of a file by their groups.
#[derive(Debug)]
pub(crate) struct MshGroups {
    names: BTreeMap<Key, String>,
    /// Numbers of the groups that an entity is in.
    of_entity: BTreeMap<Key, Vec<u64>>,
    solids: GroupedElements,
    surfaces: GroupedElements,
    /// Elements of curved surfaces, which are no part, per type.
    curved: BTreeMap<String, Polygons>,
}

/// Elements of one dimension.
#[derive(Debug)]
struct GroupedElements {
    dimension: u64,
    /// Groups in the order of the file.
    groups: Vec<Group>,
    /// Place of each group among them, by its number.
    place_of: BTreeMap<u64, usize>,
    /// Number of elements, each of which may be in several groups.
    count: usize,
}

#[derive(Debug)]
struct Group {
    part: Part,
    /// Number of elements.
    count: usize,
}

/// Parts of a file.
#[derive(Debug)]
pub(crate) struct MshParts {
    pub(crate) parts: FileParts,
    /// Names of groups that have all solids, or all surfaces.
    of_all: Vec<String>,
    /// True if no element is in two of the others, and no two surfaces are patches of one.
    are_disjoint: bool,
}

impl MshGroups {
    pub(crate) fn new() -> Self {
        Self {
            names: BTreeMap::new(),
            of_entity: BTreeMap::new(),
            solids: GroupedElements::new(SOLIDS),
            surfaces: GroupedElements::new(SURFACES),
            curved: BTreeMap::new(),
        }
    }

    /// Names a group.
    pub(crate) fn set_name(&mut self, group: Key, name: &str) {
        self.names.insert(group, name.to_owned());
    }

    /// Adds an entity with the numbers of its groups.
    pub(crate) fn add_entity(&mut self, entity: Key, groups: Vec<u64>) {
        self.of_entity.insert(entity, groups);
    }

    /// Returns the numbers of the groups that an entity is in.
    pub(crate) fn of_entity(&self, entity: Key) -> Vec<u64> {
        self.of_entity.get(&entity).cloned().unwrap_or_default()
    }

    /// Adds an element to its groups.
    pub(crate) fn push(
        &mut self,
        element: &MshElement<'_>,
        known: &TextNodes,
    ) -> Result<(), ReadError> {
        let Self { names, solids, surfaces, curved, .. } = self;
        let MshElement { number, is_copy, kind, nodes, .. } = *element;
        let corner_count = match kind {
            _ if let Some(solid) = solid(kind) => {
                let nodes = element.indices(known, solid.node_count())?;
                solids.push(names, element, |part| {
                    part.cells.push(number, solid, &nodes);
                });
                return Ok(());
            }
            TRIANGLE => 3,
            QUADRILATERAL => 4,
            _ if CURVED_SURFACES.contains(&kind) && !is_copy => {
                let curved = curved.entry(format!("element type {kind}")).or_default();
                curved.push(known.known_indices(nodes));
                return Ok(());
            }
            _ if WITHOUT_VOLUME.contains(&kind) => return Ok(()),
            _ => {
                let nodes = element.indices(known, nodes.len())?;
                solids.push(names, element, |part| {
                    part.refuse(&kind.to_string(), true);
                    part.other_nodes.extend(&nodes);
                });
                return Ok(());
            }
        };
        let nodes = element.indices(known, corner_count)?;
        surfaces.push(names, element, |part| part.push_surface_element(number, &nodes));
        Ok(())
    }

    /// Returns the groups as parts over the nodes of the file. A group of surfaces with nodes of solids has faces of
    /// these, as a rule, and is no part: those of its elements that stand apart are counted.
    pub(crate) fn into_parts(self, nodes: TextNodes) -> MshParts {
        let Self { solids, surfaces, curved, .. } = self;
        let mut is_of_solid = vec![false; nodes.places.len()];
        for node in solids.groups.iter().flat_map(|group| group.part.nodes()) {
            is_of_solid[node as usize] = true;
        }

        let is_on_solids = |group: &Group| {
            let nodes = group.part.nodes();
            nodes.iter().any(|&node| is_of_solid[node as usize])
        };
        let (surfaces_are_disjoint, whole_of_surfaces) =
            (surfaces.are_disjoint(), surfaces.whole());
        let (faces, surface_bodies): (Vec<_>, Vec<_>) =
            surfaces.groups.into_iter().partition(is_on_solids);
        let mut apart = SkippedElements::default();
        for Group { part, .. } in faces {
            part.polygons.count_apart(&is_of_solid, None, &mut apart);
        }
        for (kind, polygons) in &curved {
            polygons.count_apart(&is_of_solid, Some(kind), &mut apart);
        }

        // Bodies are the groups beside those that have all solids, or all surfaces.
        let mut are_disjoint = solids.are_disjoint();
        if solids.groups.is_empty() {
            are_disjoint = !share_nodes(&surface_bodies, whole_of_surfaces.as_deref());
        }
        let mut of_all = Vec::from_iter(solids.whole());
        if !surface_bodies.is_empty() {
            are_disjoint &= surfaces_are_disjoint;
            of_all.extend(whole_of_surfaces);
        }
        let are_of_one_kind = solids.groups.is_empty() || surface_bodies.is_empty();
        let whole = of_all.first().filter(|_| are_of_one_kind).cloned();
        let mut parts = FileParts::new(&MSH);
        (parts.nodes, parts.whole, parts.share_elements) = (nodes, whole, true);
        for Group { mut part, .. } in solids.groups.into_iter().chain(surface_bodies) {
            if parts.known_number(part.name()).is_some() {
                part.set_name(&format!("{} (surface)", part.name()));
            }
            part.skipped.append(&std::mem::take(&mut apart));
            parts.push(part);
        }
        MshParts { parts, of_all, are_disjoint }
    }
}

impl MshParts {
    /// Returns the names of the parts that are bodies beside each other, none where there is one at most, or where
    /// elements are in several.
    pub(crate) fn names_of_bodies(&self) -> Vec<String> {
        let names = self.parts.names().into_iter();
        let names: Vec<_> = names.filter(|name| !self.of_all.contains(name)).collect();
        if self.are_disjoint && names.len() > 1 { names } else { Vec::new() }
    }
}

impl GroupedElements {
    fn new(dimension: u64) -> Self {
        Self { dimension, groups: Vec::new(), place_of: BTreeMap::new(), count: 0 }
    }

    /// Returns the name of the group that has all elements, where there are others.
    fn whole(&self) -> Option<String> {
        let has_all = |group: &&Group| group.count == self.count && self.groups.len() > 1;
        self.groups.iter().find(has_all).map(|group| group.part.name().to_owned())
    }

    /// Returns true if no element is in two groups, apart from one that has all.
    fn are_disjoint(&self) -> bool {
        let whole = if self.whole().is_some() { self.count } else { 0 };
        self.groups.iter().map(|group| group.count).sum::<usize>() - whole <= self.count
    }

    /// Adds an element to the parts that its groups are.
    fn push(
        &mut self,
        names: &BTreeMap<Key, String>,
        element: &MshElement<'_>,
        mut add: impl FnMut(&mut Part),
    ) {
        let groups = if element.groups.is_empty() { &[0] } else { element.groups };
        self.count += usize::from(!element.is_copy);
        for number in groups {
            let next = self.groups.len();
            let place = *self.place_of.entry(*number).or_insert(next);
            if place == next {
                let part = Part::named(&group_name(names, (self.dimension, *number)));
                self.groups.push(Group { part, count: 0 });
            }
            let group = &mut self.groups[place];
            group.count += 1;
            add(&mut group.part);
        }
    }
}

/// Returns true if two groups have a node in common, apart from one that has all elements.
fn share_nodes(groups: &[Group], whole: Option<&str>) -> bool {
    let mut nodes = Vec::new();
    for group in groups.iter().filter(|group| Some(group.part.name()) != whole) {
        nodes.extend(group.part.nodes());
    }
    nodes.sort_unstable();
    nodes.windows(2).any(|pair| pair[0] == pair[1])
}

/// Returns the name of a group, made of its number where it has none.
fn group_name(names: &BTreeMap<Key, String>, group: Key) -> String {
    match (names.get(&group), group) {
        (Some(name), _) => name.clone(),
        (None, (_, 0)) => WITHOUT_GROUP.to_owned(),
        (None, (SOLIDS, number)) => format!("volume {number}"),
        (None, (_, number)) => format!("surface {number}"),
    }
}
