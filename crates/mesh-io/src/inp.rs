//! Nodes and elements of Abaqus input files: tetrahedra (`C3D4`, `C3D10`), wedges (`C3D6`, `C3D15`) and hexahedra
//! (`C3D8`, `C3D20`), or shells, membranes, rigid and plane elements of three or four nodes.
//!
//! This reader is not a crate's: there is none, and a file is written again with other coordinates
//! and all else as it was. Solids of other physics and continuum shells count as solids of their
//! shape. Elements without volume beside solids, and those of unknown types, are skipped and counted;
//! reference points of the assembly are skipped. Solids of other shapes are refused, and so are files
//! whose nodes are generated or included. Parts and instances are those of `inp_model`.
//!
//! Source: "Abaqus Keywords Reference Guide", `*NODE` and `*ELEMENT`; "Input syntax rules"; "Abaqus
//! Elements Guide", continuum elements.

use std::collections::HashMap;

use crate::inp_keyword::{INP, InpLine, Keyword, real};
use crate::inp_rigid::{ElementList, RigidElements};
use crate::parts::{Part, unsupported_elements};
use crate::solid::Solid;
use crate::text::{Line, number, placed_fields, quoted};
use crate::text_nodes::TextNodes;
use crate::volume::MeshElements;
use crate::{FilePlace, ReadError};

/// Keywords by which nodes or elements come from elsewhere.
const GENERATING: [&str; 7] = ["INCLUDE", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"];

/// Families of elements that are the mesh of a body, whose nodes are in one order: solids for stress, heat,
/// mass diffusion, sound and several of these, and shells that are as thick as their elements.
const SOLIDS: [&str; 7] = ["C3D", "DC3D", "DCC3D", "AC3D", "Q3D", "SC", "CSS"];

/// Families of elements that are the mesh of a surface, where there are no solids: shells for stress and heat,
/// membranes, rigid and reinforcing surfaces, those around a fluid, and plane elements, as which Gmsh writes
/// surfaces.
const SURFACES: [&str; 9] = ["S", "STRI", "DS", "M3D", "R3D", "SFM3D", "F3D", "CPS", "CPE"];

/// Family of elements of rigid surfaces.
const RIGID: &str = "R3D";

/// Families of other elements with volume: Eulerian, electromagnetic, fluid, infinite, cohesive, gasket and
/// cylindrical ones.
const OTHER_VOLUMES: [&str; 8] =
    ["EC3D", "EMC3D", "FC3D", "CIN3D", "ACIN3D", "COH3D", "GK3D", "CCL"];

/// Way in which elements are sorted into parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Sorting {
    /// One part, the mesh of which is wanted: elements that cannot be read are refused.
    #[default]
    Wanted,
    /// One part: elements that cannot be read are refused where it is wanted.
    Part,
    /// A part per element set, behind one of the elements without a set.
    Sets,
}

/// Content of some lines: nodes, and parts that elements are of.
#[derive(Debug, Default)]
pub(crate) struct InpContent {
    pub(crate) nodes: TextNodes,
    pub(crate) parts: Vec<Part>,
    /// Lists of the elements that are meshes.
    pub(crate) lists: Vec<ElementList>,
}

impl InpContent {
    /// Returns true if all elements of a part's mesh are rigid, by their type or those of the body.
    pub(crate) fn is_rigid(&self, part: usize, rigid: &RigidElements) -> bool {
        let own = || self.lists.iter().filter(|list| list.part == part && !list.is_empty());
        own().next().is_some() && own().all(|list| rigid.have(list))
    }

    /// Marks the parts that are rigid.
    pub(crate) fn mark_rigid(&mut self, rigid: &RigidElements) {
        for part in 0..self.parts.len() {
            let is_rigid = self.is_rigid(part, rigid);
            self.parts[part].set_rigid(is_rigid);
        }
    }
}

/// Reads nodes and elements from lines.
pub(crate) fn parse_content<'a>(
    lines: impl Iterator<Item = InpLine<'a>>,
    elements: MeshElements,
    sorting: Sorting,
) -> Result<InpContent, ReadError> {
    let mut reader = InpReader { elements, sorting, ..InpReader::default() };
    reader.content.parts.push(Part::default());
    let (mut block, mut last) = (Block::Skipped, 0);
    for line in lines {
        let line = match line {
            InpLine::Keyword(keyword) => {
                last = keyword.line.number;
                reader.check_complete(last)?;
                reader.is_skipping = false;
                block = reader.begin_block(&keyword)?;
                continue;
            }
            InpLine::Data(line) => line,
        };

        // Data lines belong to the last keyword.
        last = line.number;
        match block {
            Block::Nodes => reader.read_node(&line)?,
            Block::Axes => {
                return Err(
                    INP.unsupported_on_line(line.number, "the axes of the keyword 'SYSTEM'")
                );
            }
            Block::OtherElements => reader.skip_element(&line),
            Block::Skipped => {}
            Block::Solids(solid) => reader.read_element(&line, solid.node_count(), block)?,
            Block::Polygons(corners) => reader.read_element(&line, corners, block)?,
        }
    }
    reader.check_complete(last)?;
    Ok(reader.content)
}

/// Returns the refusal of elements that cannot be read.
pub(crate) fn unsupported_type(kind: &str) -> ReadError {
    INP.unsupported(unsupported_elements(kind))
}

/// Meaning of the data lines below a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    Nodes,
    Solids(Solid),
    /// Elements of a surface, of a number of nodes.
    Polygons(usize),
    /// Axes that coordinates belong to; without lines, those of the model again.
    Axes,
    /// Elements of a type that is no part of the mesh.
    OtherElements,
    Skipped,
}

/// Reader of nodes and elements.
#[derive(Debug, Default)]
struct InpReader {
    elements: MeshElements,
    sorting: Sorting,
    content: InpContent,
    /// Number of the part of the elements that are read.
    part: usize,
    /// Numbers of the parts of element sets, by their names in upper case.
    parts_of_sets: HashMap<String, usize>,
    /// Part of the assembly, outside its instances.
    is_in_assembly: bool,
    /// Number and nodes of an element whose data lines go on.
    element: Vec<u64>,
    /// Type of elements that are read or skipped.
    kind: String,
    /// True if the data lines of a skipped element go on.
    is_skipping: bool,
}

impl InpReader {
    /// Begins the block of a keyword.
    fn begin_block(&mut self, keyword: &Keyword<'_>) -> Result<Block, ReadError> {
        let line = keyword.line.number;
        if keyword.is_any(&GENERATING) {
            let feature = format!("the keyword {}", quoted(&keyword.name));
            return Err(INP.unsupported_on_line(line, feature));
        }
        if keyword.is("SYSTEM") {
            return Ok(Block::Axes);
        }
        if keyword.is("NODE") {
            check_parameters(keyword)?;
            // An assembly has nodes of its own, with their own numbers: reference points.
            return Ok(if self.is_in_assembly { Block::Skipped } else { Block::Nodes });
        }
        if keyword.is("ELEMENT") {
            check_parameters(keyword)?;
            let Some(kind) = keyword.value("TYPE") else {
                return Err(INP.unsupported_on_line(line, "a line *ELEMENT without a type"));
            };
            if self.sorting == Sorting::Sets {
                self.part = self.part_of_set(keyword.value("ELSET"));
            }
            self.kind = kind.to_ascii_uppercase();
            return self.begin_elements(line, keyword.value("ELSET"));
        }

        if keyword.is_any(&["ASSEMBLY", "ENDINSTANCE"]) {
            self.is_in_assembly = true;
        } else if keyword.is_any(&["ENDASSEMBLY", "PART", "INSTANCE"]) {
            self.is_in_assembly = false;
        }
        Ok(Block::Skipped)
    }

    /// Returns the block of elements of the type that is read, of a set.
    fn begin_elements(&mut self, line: usize, set: Option<&str>) -> Result<Block, ReadError> {
        let kind = &self.kind;
        let Some(block) = element_block(kind, self.elements) else {
            if self.sorting == Sorting::Wanted {
                return Err(INP.unsupported_on_line(line, unsupported_elements(kind)));
            }
            let is_solid = element_block(kind, MeshElements::Cells).is_none();
            self.content.parts[self.part].refuse(kind, is_solid);
            return Ok(Block::OtherElements);
        };

        if block == Block::OtherElements {
            return Ok(block);
        }
        if !self.is_in_assembly {
            let is_rigid = kind.starts_with(RIGID);
            self.content.lists.push(ElementList::new(self.part, set, is_rigid));
            return Ok(block);
        }

        // Of an assembly's elements, whose nodes are its own, solids alone are missed.
        match self.elements {
            MeshElements::Cells => {
                Err(INP.unsupported_on_line(line, "solid elements of an assembly"))
            }
            MeshElements::Polygons => Ok(Block::OtherElements),
        }
    }

    /// Returns the number of the part of an element set, a new one where there is none yet.
    fn part_of_set(&mut self, name: Option<&str>) -> usize {
        let Some(name) = name else { return 0 };
        let parts = &mut self.content.parts;
        *self.parts_of_sets.entry(name.to_ascii_uppercase()).or_insert_with(|| {
            parts.push(Part::named(name));
            parts.len() - 1
        })
    }

    fn read_node(&mut self, line: &Line<'_>) -> Result<(), ReadError> {
        let mut fields = placed_fields(line.text, line.start, b',');
        let first = fields.next().and_then(|field| Some((number(field.text)?, field.place.end)));
        let Some((node, end)) = first else {
            return Err(INP.on_line(line.number, "a node begins with its number"));
        };

        // Coordinates that are left out are 0.
        let at = FilePlace::Line(line.number);
        self.content.nodes.push(&INP, &at, node, fields, real, Some(end))
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
        let at = FilePlace::Line(line.number);
        let nodes = self.content.nodes.indices(&INP, &at, nodes, node_count)?;
        let part = &mut self.content.parts[self.part];
        if let Block::Solids(solid) = block {
            part.cells.push(number, solid, &nodes);
        } else {
            part.polygons.push_nodes(&nodes);
        }
        if let Some(list) = self.content.lists.last_mut() {
            list.push(number);
        }
        self.element.clear();
        Ok(())
    }

    /// Counts an element of which this is the first line, and lists the nodes of a line.
    fn skip_element(&mut self, line: &Line<'_>) {
        let InpContent { nodes, parts, .. } = &mut self.content;
        let part = &mut parts[self.part];
        let fields =
            placed_fields(line.text, line.start, b',').skip(usize::from(!self.is_skipping));
        if self.sorting != Sorting::Wanted {
            let known = fields.filter_map(|field| nodes.index(number(field.text)?));
            part.other_nodes.extend(known);
        }
        if !self.is_skipping {
            part.skipped.add(&self.kind);
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
fn check_parameters(keyword: &Keyword<'_>) -> Result<(), ReadError> {
    let input = keyword.value("INPUT").map(|file| ("INPUT", file));
    let system = keyword.value("SYSTEM").filter(|system| !system.eq_ignore_ascii_case("R"));
    match input.or(system.map(|system| ("SYSTEM", system))) {
        Some((parameter, value)) => {
            let value = quoted(format!("{parameter}={}", value.to_ascii_uppercase()));
            let feature = format!("the parameter {value}");
            Err(INP.unsupported_on_line(keyword.line.number, feature))
        }
        None => Ok(()),
    }
}

/// Returns the block of an element type; letters behind the shape concern the integration.
/// `None` of those that cannot be read.
fn element_block(kind: &str, elements: MeshElements) -> Option<Block> {
    let shapes = SOLIDS.iter().filter_map(|family| kind.strip_prefix(family));
    let mut shapes = shapes.map(|shape| shape.trim_end_matches(|c: char| c.is_ascii_alphabetic()));
    let is_other = OTHER_VOLUMES.iter().any(|family| kind.starts_with(family));
    match shapes.next() {
        Some("4") => Some(Block::Solids(Solid::TETRAHEDRON)),
        Some("6") => Some(Block::Solids(Solid::WEDGE)),
        Some("8") => Some(Block::Solids(Solid::HEXAHEDRON)),
        Some("10") => Some(Block::Solids(Solid::QUADRATIC_TETRAHEDRON)),
        Some("15") => Some(Block::Solids(Solid::QUADRATIC_WEDGE)),
        Some("20") => Some(Block::Solids(Solid::QUADRATIC_HEXAHEDRON)),
        None if !is_other && elements == MeshElements::Polygons => match surface_nodes(kind) {
            Some("3") => Some(Block::Polygons(3)),
            Some("4") => Some(Block::Polygons(4)),
            Some(_) => None,
            None => Some(Block::OtherElements),
        },
        None if !is_other => Some(Block::OtherElements),
        _ => None,
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
