//! Gmsh MSH, versions 2 and 4.1, as text: nodes, tetrahedra, wedges and hexahedra, linear or with straight
//! edges, or linear triangles and quadrilaterals.
//!
//! This reader is not a crate's, because places matter: nodes keep their order, and a file is
//! written again with other coordinates and all else as it was. Points and lines are skipped, and so are
//! surface elements where there are solids, which are counted where they stand apart from these; other
//! elements are refused. Physical groups are parts, in a module of their own, and so are elements that a file has once
//! per group.
//!
//! Source: C. Geuzaine and J.-F. Remacle, "Gmsh reference manual", section "MSH file format".

use std::collections::BTreeMap;

use crate::mesh::{Mesh, Polygons};
use crate::msh_copies::{GroupCopies, TaggedElement};
use crate::msh_elements::{
    CURVED_SURFACES, MSH, MshElement, QUADRILATERAL, TRIANGLE, WITHOUT_VOLUME, solid,
};
use crate::msh_groups::{MshGroups, MshParts};
use crate::solid::NumberedCells;
use crate::text::{Line, Lines, number, placed_words, quoted};
use crate::text_nodes::TextNodes;
use crate::volume::MeshElements;
use crate::{FilePlace, ReadError};

/// Reads the nodes and elements of an MSH file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut content = MshContent::default().read(bytes)?;
    if content.cells.is_empty() {
        let elements = MeshElements::Polygons;
        content = MshContent { elements, ..MshContent::default() }.read(bytes)?;
    }
    let MshContent { nodes, cells, polygons, curved, .. } = content;
    Mesh::of_elements(nodes.numbered, cells, &polygons, &curved)
}

/// Reads the nodes and the physical groups.
pub(crate) fn parse_groups(bytes: &[u8]) -> Result<MshParts, ReadError> {
    let content = MshContent { groups: Some(MshGroups::new()), ..MshContent::default() };
    let MshContent { nodes, groups, .. } = content.read(bytes)?;
    Ok(groups.unwrap_or_else(MshGroups::new).into_parts(nodes))
}

/// Reads the nodes with the places of their coordinates.
pub(crate) fn parse_nodes(bytes: &[u8]) -> Result<TextNodes, ReadError> {
    Ok(MshContent::default().read(bytes)?.nodes)
}

/// Nodes and elements of a file.
#[derive(Debug, Default)]
struct MshContent {
    elements: MeshElements,
    nodes: TextNodes,
    cells: NumberedCells,
    polygons: Polygons,
    /// Elements of curved surfaces beside cells, per type.
    curved: BTreeMap<String, Polygons>,
    /// Physical groups that have the elements instead, where they are wanted.
    groups: Option<MshGroups>,
}

/// Reads version and kind; true stands for version 4.1, whose nodes and elements are in blocks.
fn read_format(lines: &mut Lines<'_>) -> Result<bool, ReadError> {
    let line = needed(lines)?;
    let mut words = placed_words(line.text, line.start);
    let (version, kind) = (words.next(), words.next());
    if kind.is_some_and(|kind| kind.text != b"0") {
        return Err(MSH.unsupported("binary data"));
    }
    match version.map(|version| version.text).unwrap_or_default() {
        b"2" | b"2.0" | b"2.1" | b"2.2" => Ok(false),
        b"4.1" => Ok(true),
        other => Err(MSH.unsupported(format!("version {}", quoted(other)))),
    }
}

impl MshContent {
    /// Reads the sections in the order of the file; those without nodes or elements are skipped.
    fn read(mut self, bytes: &[u8]) -> Result<Self, ReadError> {
        let mut lines = Lines::new(bytes);
        let mut is_blocked = false;
        while let Some(line) = lines.next() {
            match line.text.trim_ascii() {
                b"$MeshFormat" => is_blocked = read_format(&mut lines)?,
                b"$PhysicalNames" => self.read_group_names(&mut lines)?,
                b"$Entities" => self.read_entities(&mut lines)?,
                b"$Nodes" if is_blocked => self.read_node_blocks(&mut lines)?,
                b"$Nodes" => self.read_nodes(&mut lines)?,
                b"$Elements" if is_blocked => self.read_element_blocks(&mut lines)?,
                b"$Elements" => self.read_elements(&mut lines)?,
                b"$NOD" | b"$ELM" => return Err(MSH.unsupported("version '1'")),
                b"$ParametricNodes" => return Err(MSH.unsupported("parametric nodes")),
                _ => {}
            }
        }
        Ok(self)
    }

    /// Reads the names of physical groups, where these are wanted.
    fn read_group_names(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let Some(groups) = &mut self.groups else { return Ok(()) };
        let [count] = counts(&needed(lines)?)?;
        for _ in 0..count {
            let line = needed(lines)?;
            let text = String::from_utf8_lossy(line.text);
            let parts = text.split_once('"').zip(text.rsplit_once('"'));
            let Some(((key, _), (named, _))) =
                parts.filter(|((key, _), (named, _))| named.len() > key.len())
            else {
                return Err(MSH.on_line(line.number, "a physical name stands in quotation marks"));
            };
            let mut words = key.split_ascii_whitespace().map(str::parse);
            let (Some(Ok(dimension)), Some(Ok(group))) = (words.next(), words.next()) else {
                return Err(
                    MSH.on_line(line.number, "a physical name has a dimension and a number")
                );
            };
            groups.set_name((dimension, group), &named[key.len() + 1..]);
        }
        Ok(())
    }

    /// Reads the groups of the entities of version 4.1, where these are wanted.
    fn read_entities(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let Some(groups) = &mut self.groups else { return Ok(()) };
        let of_dimension: [u64; 4] = counts(&needed(lines)?)?;
        for (dimension, count) in (0..).zip(of_dimension) {
            // Behind its number, an entity has a point or a box.
            let before = if dimension == 0 { 4 } else { 7 };
            for _ in 0..count {
                let line = needed(lines)?;
                let mut words = placed_words(line.text, line.start);
                let entity = words.next().and_then(|word| number::<i64>(word.text));
                let mut tags = words.skip(before - 1).map(|word| number::<i64>(word.text));
                let (Some(entity), Some(Some(tag_count))) = (entity, tags.next()) else {
                    return Err(
                        MSH.on_line(line.number, "an entity has a number, a box and groups")
                    );
                };
                let tag_count = usize::try_from(tag_count).unwrap_or_default();
                let tags = tags.take(tag_count).flatten().map(i64::unsigned_abs).collect();
                groups.add_entity((dimension, entity.unsigned_abs()), tags);
            }
        }
        Ok(())
    }

    /// Reads nodes of version 2: a line each.
    fn read_nodes(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [count] = counts(&needed(lines)?)?;
        for _ in 0..count {
            let line = needed(lines)?;
            let mut words = placed_words(line.text, line.start);
            let Some(node) = words.next().and_then(|word| number(word.text)) else {
                return Err(MSH.on_line(line.number, "a node begins with its number"));
            };
            self.nodes.push(&MSH, &FilePlace::Line(line.number), node, words, number, None)?;
        }
        Ok(())
    }

    /// Reads nodes of version 4.1: blocks of numbers, then of coordinates.
    fn read_node_blocks(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [blocks, ..] = counts::<4>(&needed(lines)?)?;
        for _ in 0..blocks {
            let [_, _, _, count] = counts(&needed(lines)?)?;
            let mut nodes: Vec<u64> = Vec::new();
            for _ in 0..count {
                let [node] = counts(&needed(lines)?)?;
                nodes.push(node);
            }
            // Coordinates stand in the order of the numbers.
            for node in nodes {
                let line = needed(lines)?;
                let words = placed_words(line.text, line.start);
                self.nodes.push(&MSH, &FilePlace::Line(line.number), node, words, number, None)?;
            }
        }
        Ok(())
    }

    /// Reads elements of version 2: number, type, tags, nodes.
    fn read_elements(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [count] = counts(&needed(lines)?)?;
        let mut copies = group_copies(lines.clone(), count);
        for _ in 0..count {
            let line = needed(lines)?;
            let numbers = numbers(&line)?;
            let Some(element) = TaggedElement::new(&numbers) else {
                return Err(MSH.on_line(line.number, "an element has a number, a type and tags"));
            };
            let first = copies.first_copy(element);
            self.push_element(&MshElement {
                at: FilePlace::Line(line.number),
                number: first.unwrap_or(element.number),
                is_copy: first.is_some(),
                kind: element.kind,
                groups: element.groups(),
                nodes: element.nodes,
            })?;
        }
        Ok(())
    }

    /// Reads elements of version 4.1: blocks of one type.
    fn read_element_blocks(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [blocks, ..] = counts::<4>(&needed(lines)?)?;
        for _ in 0..blocks {
            let [dimension, entity, kind, count] = counts(&needed(lines)?)?;
            let groups = self.groups.as_ref().map(|groups| groups.of_entity((dimension, entity)));
            let groups = groups.unwrap_or_default();
            for _ in 0..count {
                let line = needed(lines)?;
                let numbers = numbers(&line)?;
                let Some((&number, nodes)) = numbers.split_first() else {
                    return Err(MSH.on_line(line.number, "an element begins with its number"));
                };
                let (at, is_copy) = (FilePlace::Line(line.number), false);
                let groups = &groups[..];
                self.push_element(&MshElement { at, number, is_copy, kind, groups, nodes })?;
            }
        }
        Ok(())
    }

    fn push_element(&mut self, element: &MshElement<'_>) -> Result<(), ReadError> {
        let Self { nodes: known, cells, polygons, groups, .. } = self;
        let MshElement { number, kind, nodes, .. } = *element;
        let has_surface = self.elements == MeshElements::Polygons;
        match kind {
            _ if let Some(groups) = groups => groups.push(element, known)?,
            _ if element.is_copy => {}
            _ if let Some(solid) = solid(kind) => {
                cells.push(number, solid, &element.indices(known, solid.node_count())?);
            }
            TRIANGLE if has_surface => polygons.push_nodes(&element.indices(known, 3)?),
            QUADRILATERAL if has_surface => polygons.push_nodes(&element.indices(known, 4)?),
            TRIANGLE | QUADRILATERAL => polygons.push(known.known_indices(nodes)),
            _ if CURVED_SURFACES.contains(&kind) && !has_surface => {
                let curved = self.curved.entry(format!("element type {kind}")).or_default();
                curved.push(known.known_indices(nodes));
            }
            _ if WITHOUT_VOLUME.contains(&kind) && !CURVED_SURFACES.contains(&kind) => {}
            other => return Err(MSH.unsupported(format!("element type {other}"))),
        }
        Ok(())
    }
}

/// Returns the groups of the elements on some lines, of which those that are not readable are refused later.
fn group_copies(lines: Lines<'_>, count: u64) -> GroupCopies {
    let mut copies = GroupCopies::default();
    for (_, line) in (0..count).zip(lines) {
        // Number, type, number of tags, group and entity.
        let words = placed_words(line.text, line.start).take(5);
        let numbers = words.map(|word| number::<i64>(word.text).map(i64::unsigned_abs));
        let numbers: Option<Vec<u64>> = numbers.collect();
        if let Some(element) = numbers.as_deref().and_then(TaggedElement::new) {
            copies.add_group(element);
        }
    }
    copies
}

/// Returns the next line, which a header has promised.
fn needed<'a>(lines: &mut Lines<'a>) -> Result<Line<'a>, ReadError> {
    let last = lines.number();
    match lines.next() {
        Some(line) if line.text.starts_with(b"$") => {
            Err(MSH.on_line(line.number, "a section ends before its declared end"))
        }
        Some(line) => Ok(line),
        None => Err(MSH.on_line(last, "the file ends within a section")),
    }
}

/// Returns the first `N` whole numbers of a line.
fn counts<const N: usize>(line: &Line<'_>) -> Result<[u64; N], ReadError> {
    match numbers(line)?.first_chunk() {
        Some(counts) => Ok(*counts),
        None => Err(MSH.on_line(line.number, format!("{N} whole numbers expected"))),
    }
}

fn numbers(line: &Line<'_>) -> Result<Vec<u64>, ReadError> {
    let mut numbers = Vec::new();
    for word in placed_words(line.text, line.start) {
        // Tags of entities may be negative, and are of no use here.
        let Some(value) = number::<i64>(word.text) else {
            let problem = format!("{} is not a whole number", quoted(word.text));
            return Err(MSH.on_line(line.number, problem));
        };
        numbers.push(value.unsigned_abs());
    }
    Ok(numbers)
}
