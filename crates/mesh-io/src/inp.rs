//! Abaqus input files: nodes, tetrahedra (`C3D4`, `C3D10`), wedges (`C3D6`, `C3D15`) and hexahedra (`C3D8`,
//! `C3D20`) of one part, or its shells, membranes, rigid and plane elements of three or four nodes.
//!
//! This reader is not a crate's: there is none, and a file is written again with other coordinates
//! and all else as it was. Solids of other physics and continuum shells count as solids of their
//! shape. Elements without volume beside solids, and those of unknown types, are skipped and counted;
//! reference points of the assembly are skipped. Solids of other shapes are refused, and so are files
//! whose nodes are generated, included, or placed by more than one part or instance.
//!
//! Source: "Abaqus Keywords Reference Guide", `*NODE` and `*ELEMENT`; "Input syntax rules"; "Abaqus
//! Elements Guide", continuum elements.

use std::collections::BTreeMap;

use crate::error::Format;
use crate::mesh::{Mesh, Polygons};
use crate::solid::{NumberedCells, Solid};
use crate::text::{Line, Lines, number, placed_fields, quoted};
use crate::text_nodes::TextNodes;
use crate::volume::MeshElements;
use crate::{FilePlace, ReadError, SkippedElements};

const INP: Format = Format {
    name: "INP",
    remedy: "save it as one part with its nodes and elements, of a solid or a surface, in one file",
};

/// Keywords by which nodes or elements come from elsewhere, or coordinates belong to other axes.
const GENERATING: [&str; 8] =
    ["INCLUDE", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"];

/// Families of elements that are the mesh of a body, whose nodes are in one order: solids for stress, heat,
/// mass diffusion, sound and several of these, and shells that are as thick as their elements.
const SOLIDS: [&str; 7] = ["C3D", "DC3D", "DCC3D", "AC3D", "Q3D", "SC", "CSS"];

/// Families of elements that are the mesh of a surface, where there are no solids: shells for stress and heat,
/// membranes, rigid and reinforcing surfaces, those around a fluid, and plane elements, as which Gmsh writes
/// surfaces.
const SURFACES: [&str; 9] = ["S", "STRI", "DS", "M3D", "R3D", "SFM3D", "F3D", "CPS", "CPE"];

/// Families of other elements with volume: Eulerian, electromagnetic, fluid, infinite, cohesive, gasket and
/// cylindrical ones.
const OTHER_VOLUMES: [&str; 8] =
    ["EC3D", "EMC3D", "FC3D", "CIN3D", "ACIN3D", "COH3D", "GK3D", "CCL"];

/// Reads the nodes and elements of an input file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut content = parse_content(bytes, MeshElements::Cells)?;
    if content.cells.is_empty() {
        content = parse_content(bytes, MeshElements::Polygons)?;
    }
    let InpContent { nodes, cells, polygons, skipped, .. } = content;

    // Of what there is no mesh, the first type is named.
    let has_mesh = !cells.is_empty() || !polygons.is_empty();
    if let (false, Some(kind)) = (has_mesh, skipped.counts.keys().next()) {
        return Err(unsupported_type(kind));
    }
    let mesh = Mesh::of_elements(nodes.numbered, cells, &polygons, &BTreeMap::new())?;
    Ok(Mesh { skipped: skipped.if_any(), ..mesh })
}

/// Reads the nodes with the places of their coordinates.
pub(crate) fn parse_nodes(bytes: &[u8]) -> Result<TextNodes, ReadError> {
    Ok(parse_content(bytes, MeshElements::Cells)?.nodes)
}

/// Meaning of the data lines below a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    Nodes,
    Solids(Solid),
    /// Elements of a surface, of a number of nodes.
    Polygons(usize),
    /// Elements of a type that is no part of the mesh.
    OtherElements,
    /// Way in which an instance is placed.
    Placement,
    Skipped,
}

/// Content of a file, as far as it is read.
#[derive(Debug, Default)]
struct InpContent {
    elements: MeshElements,
    nodes: TextNodes,
    cells: NumberedCells,
    polygons: Polygons,
    parts: usize,
    instances: usize,
    /// Part of the assembly, outside its instances.
    is_in_assembly: bool,
    /// Number and nodes of an element whose data lines go on.
    element: Vec<u64>,
    skipped: SkippedElements,
    /// Type of elements that are skipped.
    skipped_kind: String,
    /// True if the data lines of a skipped element go on.
    is_skipping: bool,
}

fn parse_content(bytes: &[u8], elements: MeshElements) -> Result<InpContent, ReadError> {
    let mut content = InpContent { elements, ..InpContent::default() };
    let (mut block, mut last) = (Block::Skipped, 0);
    for line in Lines::new(bytes) {
        last = line.number;
        let text = line.text.trim_ascii();
        if text.is_empty() || text.starts_with(b"**") {
            continue;
        }
        if text.starts_with(b"*") {
            content.check_complete(line.number)?;
            content.is_skipping = false;
            block = content.keyword(text)?;
            continue;
        }
        // Data lines belong to the last keyword.
        match block {
            Block::Nodes => content.read_node(&line)?,
            Block::OtherElements => content.skip_element(&line),
            Block::Placement => return Err(INP.unsupported("an instance that is placed anew")),
            Block::Skipped => {}
            Block::Solids(solid) => content.read_element(&line, solid.node_count(), block)?,
            Block::Polygons(corners) => content.read_element(&line, corners, block)?,
        }
    }
    content.check_complete(last)?;
    Ok(content)
}

impl InpContent {
    /// Begins the block of a keyword line.
    fn keyword(&mut self, text: &[u8]) -> Result<Block, ReadError> {
        // Blanks and case do not matter.
        let mut text = String::from_utf8_lossy(text).to_ascii_uppercase();
        text.retain(|character| !character.is_whitespace());
        let mut words = text[1..].split(',');
        let keyword = words.next().unwrap_or_default();
        if ["NODE", "ELEMENT"].contains(&keyword) {
            check_parameters(words.clone())?;
        }

        match keyword {
            // An assembly has nodes of its own, with their own numbers: reference points.
            "NODE" if self.is_in_assembly => Ok(Block::Skipped),
            "NODE" => Ok(Block::Nodes),
            "ELEMENT" => {
                let Some(kind) = words.find_map(|word| word.strip_prefix("TYPE=")) else {
                    return Err(INP.unsupported("a line *ELEMENT without a type"));
                };
                // Of an assembly's elements, whose nodes are its own, solids alone are missed.
                let mut block = element_block(kind, self.elements)?;
                if self.is_in_assembly && block != Block::OtherElements {
                    if self.elements == MeshElements::Cells {
                        return Err(INP.unsupported("solid elements of an assembly"));
                    }
                    block = Block::OtherElements;
                }
                kind.clone_into(&mut self.skipped_kind);
                Ok(block)
            }
            "ASSEMBLY" | "ENDASSEMBLY" | "ENDINSTANCE" => {
                self.is_in_assembly = keyword != "ENDASSEMBLY";
                Ok(Block::Skipped)
            }
            "PART" | "INSTANCE" => {
                let is_part = keyword == "PART";
                self.is_in_assembly = false;
                self.parts += usize::from(is_part);
                self.instances += usize::from(!is_part);
                if self.parts > 1 || self.instances > 1 {
                    return Err(INP.unsupported("more than one part or instance"));
                }
                Ok(if is_part { Block::Skipped } else { Block::Placement })
            }
            _ if GENERATING.contains(&keyword) => {
                Err(INP.unsupported(format!("the keyword {}", quoted(keyword))))
            }
            _ => Ok(Block::Skipped),
        }
    }

    fn read_node(&mut self, line: &Line<'_>) -> Result<(), ReadError> {
        let mut fields = placed_fields(line.text, line.start, b',');
        let Some(node) = fields.next().and_then(|field| number(field.text)) else {
            return Err(INP.on_line(line.number, "a node begins with its number"));
        };
        self.nodes.push(&INP, &FilePlace::Line(line.number), node, fields)
    }

    /// Reads a line of an element of some nodes, which may continue the line above.
    fn read_element(
        &mut self,
        line: &Line<'_>,
        node_count: usize,
        block: Block,
    ) -> Result<(), ReadError> {
        for field in placed_fields(line.text, line.start, b',') {
            // A line that goes on ends with a comma.
            if field.text.is_empty() {
                continue;
            }
            let Some(number) = number(field.text) else {
                let problem = format!("{} is not a whole number", quoted(field.text));
                return Err(INP.on_line(line.number, problem));
            };
            self.element.push(number);
        }

        // An element is complete with its last node, or with a line that does not go on.
        if self.element.len() <= node_count && line.text.trim_ascii_end().ends_with(b",") {
            return Ok(());
        }
        let Some((&number, nodes)) = self.element.split_first() else { return Ok(()) };
        let nodes = self.nodes.indices(&INP, &FilePlace::Line(line.number), nodes, node_count)?;
        if let Block::Solids(solid) = block {
            self.cells.push(number, solid, &nodes);
        } else {
            self.polygons.push_nodes(&nodes);
        }
        self.element.clear();
        Ok(())
    }

    /// Counts an element of which this is the first line.
    fn skip_element(&mut self, line: &Line<'_>) {
        if !self.is_skipping {
            self.skipped.add(&self.skipped_kind);
        }
        self.is_skipping = line.text.trim_ascii_end().ends_with(b",");
    }

    /// Refuses an element that goes on where its block ends.
    fn check_complete(&self, line: usize) -> Result<(), ReadError> {
        match self.element.first() {
            Some(element) => Err(INP.on_line(line, format!("element {element} ends early"))),
            None => Ok(()),
        }
    }
}

/// Refuses data lines in another file, and coordinates that are not Cartesian.
fn check_parameters<'a>(words: impl Iterator<Item = &'a str>) -> Result<(), ReadError> {
    for word in words {
        let is_cylindrical = word.starts_with("SYSTEM=") && word != "SYSTEM=R";
        if word.starts_with("INPUT=") || is_cylindrical {
            return Err(INP.unsupported(format!("the parameter {}", quoted(word))));
        }
    }
    Ok(())
}

/// Returns the block of an element type; letters behind the shape concern the integration.
fn element_block(kind: &str, elements: MeshElements) -> Result<Block, ReadError> {
    let shapes = SOLIDS.iter().filter_map(|family| kind.strip_prefix(family));
    let mut shapes = shapes.map(|shape| shape.trim_end_matches(|c: char| c.is_ascii_alphabetic()));
    let is_other = OTHER_VOLUMES.iter().any(|family| kind.starts_with(family));
    match shapes.next() {
        Some("4") => Ok(Block::Solids(Solid::TETRAHEDRON)),
        Some("6") => Ok(Block::Solids(Solid::WEDGE)),
        Some("8") => Ok(Block::Solids(Solid::HEXAHEDRON)),
        Some("10") => Ok(Block::Solids(Solid::QUADRATIC_TETRAHEDRON)),
        Some("15") => Ok(Block::Solids(Solid::QUADRATIC_WEDGE)),
        Some("20") => Ok(Block::Solids(Solid::QUADRATIC_HEXAHEDRON)),
        None if !is_other && elements == MeshElements::Polygons => match surface_nodes(kind) {
            Some("3") => Ok(Block::Polygons(3)),
            Some("4") => Ok(Block::Polygons(4)),
            Some(_) => Err(unsupported_type(kind)),
            None => Ok(Block::OtherElements),
        },
        None if !is_other => Ok(Block::OtherElements),
        _ => Err(unsupported_type(kind)),
    }
}

/// Returns the number of nodes of an element type of a surface, which stands behind its family.
fn surface_nodes(kind: &str) -> Option<&str> {
    SURFACES.iter().find_map(|family| {
        let shape = kind.strip_prefix(family)?;
        let end = shape.find(|c: char| !c.is_ascii_digit()).unwrap_or(shape.len());
        (end > 0).then_some(&shape[..end])
    })
}

fn unsupported_type(kind: &str) -> ReadError {
    INP.unsupported(format!("elements of type {}", quoted(kind)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_and_elements_that_stand_elsewhere_are_refused() {
        let file = |node: &str, element: &str| {
            let nodes = "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n";
            format!("{node}\n{nodes}*Element, type=C3D4\n7, 1, 2, 3, 4\n{element}\n")
        };
        for node in ["*Node", "*NODE, SYSTEM=R, NSET=all"] {
            assert!(parse(file(node, "").as_bytes()).is_ok(), "{node}");
        }
        for (node, element, feature) in [
            ("*Node, system = c", "", "the parameter 'SYSTEM=C' cannot be read"),
            ("*System\n0, 0, 1\n*Node", "", "the keyword 'SYSTEM' cannot be read"),
            ("*Node", "*Node, input=more.txt", "the parameter 'INPUT=MORE.TXT' cannot be read"),
            ("*Node", "*Element, type=C3D4, input=a", "the parameter 'INPUT=A' cannot be read"),
            ("*Node", "*Element,\n type=C3D4\n", "*ELEMENT without a type cannot be read"),
        ] {
            let refusal = parse(file(node, element).as_bytes()).expect_err(feature).to_string();
            assert!(refusal.contains(feature), "{refusal}");
        }
    }

    /// A tetrahedron, a file with `before` it, and `behind` it.
    fn around(before: &str, behind: &str) -> String {
        let nodes = "*Node\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n";
        format!("{before}{nodes}*Element, type=C3D4\n7, 1, 2, 3, 4\n{behind}")
    }

    #[test]
    fn solids_of_other_families_are_read_or_refused() {
        let cells = |behind: &str| {
            let mesh = parse(around("", behind).as_bytes());
            mesh.map(|mesh| mesh.volume.map_or(0, |volume| volume.mesh.cells().len()))
        };
        for kind in ["C3D8P", "C3D8RPHT", "DC3D8E", "DCC3D8", "AC3D8R", "Q3D8", "SC8R", "CSS8"] {
            let nodes = "*Node\n11,0,0,2\n12,1,0,2\n13,1,1,2\n14,0,1,2\n15,0,0,3\n16,1,0,3\n\
                         17,1,1,3\n18,0,1,3\n";
            let hexahedron =
                format!("{nodes}*Element, type={kind}\n8, 11, 12, 13, 14, 15, 16, 17, 18\n");
            assert_eq!(cells(&hexahedron).expect(kind), 2, "{kind}");
        }
        for kind in ["C3D6", "C3D6H", "AC3D6", "DC3D6", "Q3D6", "SC6R", "CSS6"] {
            let nodes = "*Node\n11,0,0,2\n12,1,0,2\n13,1,1,2\n15,0,0,3\n16,1,0,3\n17,1,1,3\n";
            let wedge = format!("{nodes}*Element, type={kind}\n8, 11, 12, 13, 15, 16, 17\n");
            assert_eq!(cells(&wedge).expect(kind), 2, "{kind}");
        }
        for kind in ["AC3D4", "DC3D4", "Q3D4T"] {
            let tetrahedron = format!("*Node\n9, 1, 1, 1\n*Element, type={kind}\n8, 2, 4, 3, 9\n");
            assert_eq!(cells(&tetrahedron).expect(kind), 2, "{kind}");
        }
        for kind in [
            "C3D5", "C3D27R", "AC3D5", "EC3D8R", "EMC3D8", "FC3D8", "CIN3D8", "ACIN3D4", "COH3D8",
            "COH3D6", "GK3D8", "CCL12", "CSS12", "C3D",
        ] {
            let error = cells(&format!("*Element, type={kind}\n8, 1, 2, 3\n")).expect_err(kind);
            assert!(error.to_string().contains(&format!("elements of type '{kind}'")), "{error}");
        }
        for kind in
            ["S4R", "M3D4", "R3D3", "SFM3D4", "T3D2", "B31", "CONN3D2", "DCOUP3D", "CPE4", "U1"]
        {
            let behind = format!("*Element, type={kind}\n8, 1, 2,\n3\n9, 1, 2\n");
            assert_eq!(cells(&behind).expect(kind), 1, "{kind}");
            let skipped = parse(around("", &behind).as_bytes()).expect(kind).skipped;
            let counts = skipped.expect(kind).counts;
            assert_eq!(counts.into_iter().collect::<Vec<_>>(), [(kind.to_owned(), 2)]);
        }
        assert_eq!(parse(around("", "").as_bytes()).expect("a mesh").skipped, None);
    }

    /// An assembly numbers its reference points by itself.
    #[test]
    fn reference_points_of_an_assembly_are_left_out() {
        let assembly = |inside: &str| {
            let behind = format!(
                "*End Part\n*Assembly, name=a\n*Instance, name=i, part=p\n*End Instance\n{inside}\
                 *End Assembly\n*Nset, nset=late\n1,\n"
            );
            around("*Part, name=p\n", &behind)
        };
        let points = "*Node\n1, 5, 6, 7\n*Node, nset=point\n900, 5, 6, 7\n*Nset, nset=r\n1,\n\
                      *Element, type=CONN3D2\n1, 1, i.3\n";
        let content = assembly(points);
        let volume = parse(content.as_bytes()).expect("a mesh").volume.expect("a volume");
        assert_eq!(volume.node_numbers, [1, 2, 3, 4]);
        assert_eq!(parse_nodes(content.as_bytes()).expect("nodes").places.len(), 4);

        // Of an instance that has nodes of its own they are the mesh.
        let own = around("*Part, name=p\n*End Part\n*Assembly\n*Instance, name=i, part=p\n", "");
        let own = format!("{own}*End Instance\n*Node\n1, 5, 6, 7\n*End Assembly\n");
        let volume = parse(own.as_bytes()).expect("a mesh").volume.expect("a volume");
        assert_eq!(volume.nodes[0], glam::DVec3::ZERO);

        let solid = assembly("*Element, type=C3D4\n8, 1, 2, 3, 4\n");
        let error = parse(solid.as_bytes()).expect_err("elements without a part").to_string();
        assert!(error.contains("solid elements of an assembly"), "{error}");
    }
}
