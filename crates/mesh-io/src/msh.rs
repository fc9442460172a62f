//! Gmsh MSH, versions 2 and 4.1, as text: nodes, tetrahedra, wedges and hexahedra, linear or with straight
//! edges, or linear triangles and quadrilaterals.
//!
//! This reader is not a crate's, because places matter: nodes keep their order, and a file is
//! written again with other coordinates and all else as it was. Points and lines are skipped, and so are
//! surface elements where there are solids, which are counted where they stand apart from these; other
//! elements are refused.
//!
//! Source: C. Geuzaine and J.-F. Remacle, "Gmsh reference manual", section "MSH file format".

use std::collections::BTreeMap;

use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::solid::{NumberedCells, Solid};
use crate::text::{Line, Lines, number, placed_words, quoted};
use crate::text_nodes::TextNodes;
use crate::volume::MeshElements;
use crate::{FilePlace, ReadError};

const MSH: Format = Format {
    name: "MSH",
    remedy: "save it as text in version 4.1 or 2.2, with tetrahedra, wedges and hexahedra, or linear \
             triangles and quadrilaterals",
};

/// Numbers of element types without volume: points, lines and surfaces of any order.
const WITHOUT_VOLUME: [u64; 18] =
    [1, 2, 3, 8, 9, 10, 15, 16, 20, 21, 22, 23, 24, 25, 26, 27, 28, 36];

/// Numbers of element types of surfaces that are not linear.
const CURVED_SURFACES: [u64; 10] = [9, 10, 16, 20, 21, 22, 23, 24, 25, 36];

/// Number of the element type of linear triangles.
const TRIANGLE: u64 = 2;

/// Number of the element type of linear quadrilaterals.
const QUADRILATERAL: u64 = 3;

/// Edges of a quadratic tetrahedron in the order of Gmsh.
const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [3, 0], [2, 3], [1, 3]];

/// Edges of a quadratic wedge, likewise.
const WEDGE_EDGES: [[usize; 2]; 9] =
    [[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]];

/// Edges of a quadratic hexahedron, likewise.
const HEXAHEDRON_EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [0, 3],
    [0, 4],
    [1, 2],
    [1, 5],
    [2, 3],
    [2, 6],
    [3, 7],
    [4, 5],
    [4, 7],
    [5, 6],
    [6, 7],
];

/// Returns the solid of an element type.
fn solid(kind: u64) -> Option<Solid> {
    match kind {
        4 => Some(Solid::TETRAHEDRON),
        5 => Some(Solid::HEXAHEDRON),
        6 => Some(Solid::WEDGE),
        11 => Some(Solid::TETRAHEDRON.with_edges(&TETRAHEDRON_EDGES)),
        17 => Some(Solid::HEXAHEDRON.with_edges(&HEXAHEDRON_EDGES)),
        18 => Some(Solid::WEDGE.with_edges(&WEDGE_EDGES)),
        _ => None,
    }
}

/// Reads the nodes and elements of an MSH file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut content = parse_content(bytes, MeshElements::Cells)?;
    if content.cells.is_empty() {
        content = parse_content(bytes, MeshElements::Polygons)?;
    }
    let MshContent { nodes, cells, polygons, curved, .. } = content;
    Mesh::of_elements(nodes.numbered, cells, &polygons, &curved)
}

/// Reads the nodes with the places of their coordinates.
pub(crate) fn parse_nodes(bytes: &[u8]) -> Result<TextNodes, ReadError> {
    Ok(parse_content(bytes, MeshElements::Cells)?.nodes)
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
}

fn parse_content(bytes: &[u8], elements: MeshElements) -> Result<MshContent, ReadError> {
    let mut lines = Lines::new(bytes);
    let mut content = MshContent { elements, ..MshContent::default() };
    let mut is_blocked = false;

    // Sections in the order of the file; those without nodes or elements are skipped.
    while let Some(line) = lines.next() {
        match line.text.trim_ascii() {
            b"$MeshFormat" => is_blocked = read_format(&mut lines)?,
            b"$Nodes" if is_blocked => content.read_node_blocks(&mut lines)?,
            b"$Nodes" => content.read_nodes(&mut lines)?,
            b"$Elements" if is_blocked => content.read_element_blocks(&mut lines)?,
            b"$Elements" => content.read_elements(&mut lines)?,
            b"$ParametricNodes" => return Err(MSH.unsupported("parametric nodes")),
            _ => {}
        }
    }
    Ok(content)
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
    /// Reads nodes of version 2: a line each.
    fn read_nodes(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [count] = counts(&needed(lines)?)?;
        for _ in 0..count {
            let line = needed(lines)?;
            let mut words = placed_words(line.text, line.start);
            let Some(node) = words.next().and_then(|word| number(word.text)) else {
                return Err(MSH.on_line(line.number, "a node begins with its number"));
            };
            self.nodes.push(&MSH, &FilePlace::Line(line.number), node, words, number)?;
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
                self.nodes.push(&MSH, &FilePlace::Line(line.number), node, words, number)?;
            }
        }
        Ok(())
    }

    /// Reads elements of version 2: number, type, tags, nodes.
    fn read_elements(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [count] = counts(&needed(lines)?)?;
        for _ in 0..count {
            let line = needed(lines)?;
            let numbers = numbers(&line)?;
            let (Some(&element), Some(&kind), Some(&tags)) =
                (numbers.first(), numbers.get(1), numbers.get(2))
            else {
                return Err(MSH.on_line(line.number, "an element has a number, a type and tags"));
            };
            // Nodes stand behind as many tags as the element says.
            let first = usize::try_from(tags).unwrap_or(usize::MAX).saturating_add(3);
            let nodes = numbers.get(first..).unwrap_or_default();
            self.push_element(&FilePlace::Line(line.number), element, kind, nodes)?;
        }
        Ok(())
    }

    /// Reads elements of version 4.1: blocks of one type.
    fn read_element_blocks(&mut self, lines: &mut Lines<'_>) -> Result<(), ReadError> {
        let [blocks, ..] = counts::<4>(&needed(lines)?)?;
        for _ in 0..blocks {
            let [_, _, kind, count] = counts(&needed(lines)?)?;
            for _ in 0..count {
                let line = needed(lines)?;
                let numbers = numbers(&line)?;
                let Some((&element, nodes)) = numbers.split_first() else {
                    return Err(MSH.on_line(line.number, "an element begins with its number"));
                };
                self.push_element(&FilePlace::Line(line.number), element, kind, nodes)?;
            }
        }
        Ok(())
    }

    fn push_element(
        &mut self,
        at: &FilePlace,
        element: u64,
        kind: u64,
        nodes: &[u64],
    ) -> Result<(), ReadError> {
        let Self { nodes: known, cells, polygons, .. } = self;
        if let Some(solid) = solid(kind) {
            cells.push(element, solid, &known.indices(&MSH, at, nodes, solid.node_count())?);
            return Ok(());
        }

        let has_surface = self.elements == MeshElements::Polygons;
        match kind {
            TRIANGLE if has_surface => {
                polygons.push_nodes(&known.indices(&MSH, at, nodes, 3)?);
            }
            QUADRILATERAL if has_surface => {
                polygons.push_nodes(&known.indices(&MSH, at, nodes, 4)?);
            }
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
