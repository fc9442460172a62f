//! Abaqus input files: nodes, tetrahedra (`C3D4`) and hexahedra (`C3D8`) of one part.
//!
//! This reader is not a crate's: there is none, and a file is written again with other coordinates
//! and all else as it was. Elements that are no solids are skipped; other solids are refused, and so
//! are files whose nodes are generated, included, or placed by more than one part or instance.
//!
//! Source: "Abaqus Keywords Reference Guide", `*NODE` and `*ELEMENT`; "Input syntax rules".

use volume_mesh::Cell;

use crate::ReadError;
use crate::error::Format;
use crate::mesh::Mesh;
use crate::text::{Line, Lines, number, placed_fields, quoted};
use crate::text_nodes::TextNodes;
use crate::volume::NumberedCells;

const INP: Format = Format {
    name: "INP",
    remedy: "save it as one part with its nodes and linear solid elements in one file",
};

/// Keywords by which nodes or elements come from elsewhere, or coordinates belong to other axes.
const GENERATING: [&str; 8] =
    ["INCLUDE", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"];

/// Reads the nodes and solid elements of an input file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let content = parse_content(bytes)?;
    Mesh::of_volume(content.nodes.numbered, content.cells)
}

/// Reads the nodes with the places of their coordinates.
pub(crate) fn parse_nodes(bytes: &[u8]) -> Result<TextNodes, ReadError> {
    Ok(parse_content(bytes)?.nodes)
}

/// Meaning of the data lines below a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    Nodes,
    Tetrahedra,
    Hexahedra,
    /// Way in which an instance is placed.
    Placement,
    Skipped,
}

/// Content of a file, as far as it is read.
#[derive(Debug, Default)]
struct InpContent {
    nodes: TextNodes,
    cells: NumberedCells,
    parts: usize,
    instances: usize,
    /// Number and nodes of an element whose data lines go on.
    element: Vec<u64>,
}

fn parse_content(bytes: &[u8]) -> Result<InpContent, ReadError> {
    let mut content = InpContent::default();
    let (mut block, mut last) = (Block::Skipped, 0);
    for line in Lines::new(bytes) {
        last = line.number;
        let text = line.text.trim_ascii();
        if text.is_empty() || text.starts_with(b"**") {
            continue;
        }
        if text.starts_with(b"*") {
            content.check_complete(line.number)?;
            block = content.keyword(text)?;
            continue;
        }
        // Data lines belong to the last keyword.
        match block {
            Block::Nodes => content.read_node(&line)?,
            Block::Tetrahedra | Block::Hexahedra => content.read_element(&line, block)?,
            Block::Placement => return Err(INP.unsupported("an instance that is placed anew")),
            Block::Skipped => {}
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
            "NODE" => Ok(Block::Nodes),
            "ELEMENT" => element_block(words.find_map(|word| word.strip_prefix("TYPE="))),
            "PART" | "INSTANCE" => {
                let is_part = keyword == "PART";
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
        self.nodes.push(&INP, line, node, fields)
    }

    /// Reads a line of an element, which may continue the line above.
    fn read_element(&mut self, line: &Line<'_>, block: Block) -> Result<(), ReadError> {
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
        let corners = if block == Block::Tetrahedra { 4 } else { 8 };
        if self.element.len() <= corners && line.text.trim_ascii_end().ends_with(b",") {
            return Ok(());
        }
        let Some((&number, nodes)) = self.element.split_first() else { return Ok(()) };
        let cell = if block == Block::Tetrahedra {
            Cell::Tetrahedron(self.nodes.cell(&INP, line.number, nodes)?)
        } else {
            Cell::Hexahedron(self.nodes.cell(&INP, line.number, nodes)?)
        };
        self.cells.push(number, cell);
        self.element.clear();
        Ok(())
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
fn element_block(kind: Option<&str>) -> Result<Block, ReadError> {
    let Some(kind) = kind else {
        return Err(INP.unsupported("a line *ELEMENT without a type"));
    };
    let Some(shape) = kind.strip_prefix("C3D") else { return Ok(Block::Skipped) };
    match shape.trim_end_matches(|letter: char| letter.is_ascii_alphabetic()) {
        "4" => Ok(Block::Tetrahedra),
        "8" => Ok(Block::Hexahedra),
        _ => Err(INP.unsupported(format!("elements of type {}", quoted(kind)))),
    }
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
}
