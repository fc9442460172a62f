//! FEBio models: nodes, and the parts that their elements are: solids, or shells of three or four nodes.
//!
//! This reader is not a crate's: there is none, and a file is written again with other coordinates and all
//! else as it was. Parts are the lists of elements by their names, or, in models of version 1, by their
//! materials; lists of one name are one part. A part is rigid if its materials are. Everything else of a model is
//! left alone.
//!
//! Source: "FEBio User's Manual", sections `Mesh` and `MeshDomains` (since version 3) and `Geometry` (before);
//! "Rigid Body Material".

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::error::Format;
use crate::parts::FileParts;
use crate::solid::Solid;
use crate::text::{number, placed_fields, quoted};
use crate::{FilePlace, ReadError};

static FEB: Format = Format {
    name: "FEB",
    remedy: "save the model with its mesh in the same file, of tetrahedra, wedges and hexahedra, or \
             shells of three or four nodes",
};

/// Type of the materials of rigid bodies.
const RIGID_BODY: &str = "rigid body";

/// Depth of tags: the document is at 0, sections at 1, their lists at 2, and nodes and elements at 3.
const SECTION: usize = 1;
const LIST: usize = 2;
const ITEM: usize = 3;

/// Type of elements.
#[derive(Clone, Copy, Debug)]
enum ElementType {
    Solid(Solid),
    /// Shells of a number of nodes.
    Shell(usize),
    /// Elements without an area, which are no part of a mesh.
    Line,
    Unknown,
}

/// Section of a model that is being read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Mesh,
    Materials,
    /// Materials of the mesh's parts, since version 3.
    Domains,
    Other,
}

/// Key of a material: elements have its number, domains its name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum MaterialKey {
    Number(String),
    Name(String),
}

/// List of a mesh that is being read.
#[derive(Clone, Copy, Debug)]
enum List {
    Nodes,
    Elements {
        /// Type of all of them; `None` where each has its own.
        element_type: Option<ElementType>,
        /// Number of their part; `None` where each has its own.
        part: Option<usize>,
    },
}

/// Node or element whose text is read next.
#[derive(Clone, Copy, Debug)]
enum Item {
    Node { number: u64 },
    Element { number: u64, element_type: ElementType, part: usize },
}

/// Model, as far as it is read.
#[derive(Debug)]
struct Model<'a> {
    file: &'a [u8],
    /// Number of open tags.
    depth: usize,
    section: Section,
    list: Option<List>,
    item: Option<Item>,
    /// Nodes of the element that is read, as the file numbers them.
    numbers: Vec<u64>,
    content: FileParts,
    rigid_materials: BTreeSet<MaterialKey>,
    /// Names of parts with their materials.
    materials: Vec<(String, MaterialKey)>,
}

/// Reads the nodes and parts of a model.
pub(crate) fn parse(bytes: &[u8]) -> Result<FileParts, ReadError> {
    let text = in_utf_8(bytes);
    let mut reader = Reader::from_reader(&*text);
    let mut model = Model::new(bytes);
    loop {
        let start = place(&reader);
        let event = reader.read_event().map_err(|error| malformed(start, error.to_string()))?;
        match event {
            Event::Start(tag) => model.begin(&tag, start)?,
            Event::Empty(tag) => {
                model.begin(&tag, start)?;
                model.end(start)?;
            }
            Event::End(_) => model.end(start)?,
            Event::Text(_) => model.read_text(start..place(&reader))?,
            Event::Eof => break,
            // Declarations and comments hold no data.
            _ => {}
        }
    }
    if model.depth > 0 {
        return Err(malformed(bytes.len(), "the file ends before its tags do"));
    }
    Ok(model.finish())
}

/// Returns the names of tied contacts, numbered where they have none.
pub(crate) fn tie_names(bytes: &[u8]) -> Result<Vec<String>, ReadError> {
    let text = in_utf_8(bytes);
    let mut reader = Reader::from_reader(&*text);
    let mut names = Vec::new();
    loop {
        let start = place(&reader);
        let event = reader.read_event().map_err(|error| malformed(start, error.to_string()))?;
        let (Event::Start(tag) | Event::Empty(tag)) = event else {
            if matches!(event, Event::Eof) {
                return Ok(names);
            }
            continue;
        };
        let kind = attribute(&tag, "type").filter(|_| tag.name().as_ref() == "contact");
        if kind.is_some_and(|kind| kind.starts_with("tied") || kind == "sticky") {
            let numbered = || format!("contact {}", names.len() + 1);
            names.push(attribute(&tag, "name").unwrap_or_else(numbered));
        }
    }
}

impl<'a> Model<'a> {
    fn new(file: &'a [u8]) -> Self {
        Self {
            file,
            depth: 0,
            section: Section::Other,
            list: None,
            item: None,
            numbers: Vec::new(),
            content: FileParts::new(&FEB),
            rigid_materials: BTreeSet::new(),
            materials: Vec::new(),
        }
    }

    /// Returns the parts, which are rigid if their materials are.
    fn finish(mut self) -> FileParts {
        for (part, material) in &self.materials {
            if let Some(part) = self.content.known_number(part) {
                self.content.part(part).add_rigidity(self.rigid_materials.contains(material));
            }
        }
        self.content
    }

    /// Begins a tag.
    fn begin(&mut self, tag: &BytesStart<'_>, at: usize) -> Result<(), ReadError> {
        let name = tag.name();
        let name = name.as_ref();
        match (self.depth, self.list) {
            (SECTION, _) => {
                self.section = section(name);
                let is_mesh = self.section == Section::Mesh;
                let is_elsewhere = is_mesh && attribute(tag, "from").is_some();
                if is_elsewhere || name == "Include" {
                    let feature = format!("<{name}> with the content of another file");
                    return Err(FEB.unsupported(feature));
                }
            }
            (LIST, _) => self.begin_list(tag, at)?,
            (ITEM, Some(List::Nodes)) if name == "node" => {
                self.item = Some(Item::Node { number: item_number(tag, at)? });
            }
            (ITEM, Some(List::Elements { element_type, part })) => {
                // Elements of version 1 have tags by their types, and are parts by their materials.
                let element_type = element_type.unwrap_or_else(|| self::element_type(name));
                let part = part.unwrap_or_else(|| self.part_of_material(tag));
                if let ElementType::Unknown = element_type {
                    self.refuse(part, name);
                }
                self.item =
                    Some(Item::Element { number: item_number(tag, at)?, element_type, part });
            }
            _ => {}
        }
        self.depth += 1;
        Ok(())
    }

    /// Begins a list of a mesh, a material, or the domain that a part is.
    fn begin_list(&mut self, tag: &BytesStart<'_>, at: usize) -> Result<(), ReadError> {
        let name = tag.name();
        let name = name.as_ref();
        match (self.section, name) {
            (Section::Mesh, "Nodes") => self.list = Some(List::Nodes),
            (Section::Mesh, "Elements") => self.begin_elements(&self.in_its_encoding(tag, at)),
            (Section::Mesh, "Part" | "Instance") => {
                let feature = format!("<{name}>, a mesh that is placed by the model,");
                return Err(FEB.unsupported(feature));
            }
            (Section::Materials, "material") => {
                let tag = &self.in_its_encoding(tag, at);
                if attribute(tag, "type").as_deref() == Some(RIGID_BODY) {
                    self.rigid_materials.extend(attribute(tag, "id").map(MaterialKey::Number));
                    self.rigid_materials.extend(attribute(tag, "name").map(MaterialKey::Name));
                }
            }
            (Section::Domains, "SolidDomain" | "ShellDomain") => {
                let tag = &self.in_its_encoding(tag, at);
                let [part, material] = ["name", "mat"].map(|name| attribute(tag, name));
                self.materials.extend(part.zip(material.map(MaterialKey::Name)));
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns a tag, the name of which has no other characters, with all that it has in the file, in UTF-8 or else in
    /// Latin-1.
    fn in_its_encoding(&self, tag: &BytesStart<'_>, at: usize) -> BytesStart<'static> {
        let content = self.file.get(at + 1..at + 1 + tag.len()).unwrap_or_default();
        let in_latin_1 = || content.iter().copied().map(char::from).collect();
        let content = std::str::from_utf8(content).map_or_else(|_| in_latin_1(), str::to_owned);
        BytesStart::from_content(content, tag.name().as_ref().len())
    }

    /// Begins a list of elements. Without a name it is a part of its own, unless its elements have types and
    /// materials.
    fn begin_elements(&mut self, tag: &BytesStart<'_>) {
        let kind = attribute(tag, "type");
        let name = attribute(tag, "name").or_else(|| attribute(tag, "elset"));
        let of_its_own = || kind.as_ref().map(|_| format!("part {}", self.content.len() + 1));
        let name = name.or_else(of_its_own);
        let material = attribute(tag, "mat").map(MaterialKey::Number);
        self.materials.extend(name.clone().zip(material));
        let part = name.map(|name| self.content.part_number(&name));

        let element_type = kind.as_deref().map(element_type);
        if let (Some(ElementType::Unknown), Some(kind), Some(part)) = (element_type, &kind, part) {
            self.refuse(part, kind);
        }
        self.list = Some(List::Elements { element_type, part });
    }

    /// Returns the number of the part of an element by its material.
    fn part_of_material(&mut self, tag: &BytesStart<'_>) -> usize {
        let Some(material) = attribute(tag, "mat") else {
            return self.content.part_number("part 1");
        };
        let name = format!("material {material}");
        let known = self.content.len();
        let part = self.content.part_number(&name);
        if part == known {
            self.materials.push((name, MaterialKey::Number(material)));
        }
        part
    }

    /// Keeps the refusal of a part whose elements cannot be read, for where it is wanted.
    fn refuse(&mut self, part: usize, kind: &str) {
        let is_surface = ["quad", "tri"].iter().any(|shape| kind.starts_with(shape));
        self.content.part(part).refuse(kind, !is_surface);
    }

    /// Ends a tag, whose text has been read.
    fn end(&mut self, at: usize) -> Result<(), ReadError> {
        self.depth = self.depth.saturating_sub(1);
        if self.depth == LIST {
            self.list = None;
        }
        match self.item.take() {
            Some(Item::Node { number }) => Err(malformed(at, format!("node {number} is empty"))),
            Some(Item::Element { number, .. }) => {
                Err(malformed(at, format!("element {number} is empty")))
            }
            None => Ok(()),
        }
    }

    /// Reads the coordinates of a node, or the nodes of an element.
    fn read_text(&mut self, bytes: Range<usize>) -> Result<(), ReadError> {
        let Some(item) = self.item.take() else { return Ok(()) };
        let at = FilePlace::Byte(bytes.start as u64);
        let fields = placed_fields(&self.file[bytes.clone()], bytes.start, b',');
        match item {
            Item::Node { number } => {
                self.content.nodes.push(&FEB, &at, number, fields, crate::text::number, None)
            }
            Item::Element { number: element, element_type, part } => {
                self.numbers.clear();
                for field in fields {
                    let Some(node) = number(field.text) else {
                        let problem = format!("{} is not a whole number", quoted(field.text));
                        return Err(FEB.malformed(at, problem));
                    };
                    self.numbers.push(node);
                }
                self.push_element(&at, element, element_type, part)
            }
        }
    }

    /// Adds the element whose nodes have been read to its part.
    fn push_element(
        &mut self,
        at: &FilePlace,
        element: u64,
        element_type: ElementType,
        part: usize,
    ) -> Result<(), ReadError> {
        let Self { content, numbers, .. } = self;
        let indices = |count| content.nodes.indices(&FEB, at, numbers, count);
        match element_type {
            ElementType::Solid(solid) => {
                let nodes = indices(solid.node_count())?;
                content.part(part).cells.push(element, solid, &nodes);
            }
            ElementType::Shell(corners) => {
                let nodes = indices(corners)?;
                content.part(part).polygons.push_nodes(&nodes);
            }
            ElementType::Line | ElementType::Unknown => {
                let nodes = indices(numbers.len())?;
                let part = content.part(part);
                if let ElementType::Line = element_type {
                    part.skipped.add("line");
                }
                part.other_nodes.extend(nodes);
            }
        }
        Ok(())
    }
}

/// Returns the section of a name.
fn section(name: &str) -> Section {
    match name {
        "Mesh" | "Geometry" => Section::Mesh,
        "Material" => Section::Materials,
        "MeshDomains" => Section::Domains,
        _ => Section::Other,
    }
}

/// Returns the type of elements by its name.
fn element_type(kind: &str) -> ElementType {
    match kind {
        "tet4" => ElementType::Solid(Solid::TETRAHEDRON),
        "tet10" => ElementType::Solid(Solid::QUADRATIC_TETRAHEDRON),
        "penta6" => ElementType::Solid(Solid::WEDGE),
        "penta15" => ElementType::Solid(Solid::QUADRATIC_WEDGE),
        "hex8" => ElementType::Solid(Solid::HEXAHEDRON),
        "hex20" => ElementType::Solid(Solid::QUADRATIC_HEXAHEDRON),
        "tri3" => ElementType::Shell(3),
        "quad4" | "q4ans" | "q4eas" => ElementType::Shell(4),
        "line2" | "line3" | "truss2" | "vertex" => ElementType::Line,
        _ => ElementType::Unknown,
    }
}

/// Returns the file in UTF-8, byte for byte: what is not is no part of a mesh.
fn in_utf_8(bytes: &[u8]) -> Cow<'_, [u8]> {
    if std::str::from_utf8(bytes).is_ok() {
        return Cow::Borrowed(bytes);
    }
    bytes.iter().map(|&byte| if byte.is_ascii() { byte } else { b'?' }).collect()
}

/// Returns the byte at which a reader is.
fn place(reader: &Reader<&[u8]>) -> usize {
    usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX)
}

fn malformed(at: usize, problem: impl AsRef<str>) -> ReadError {
    FEB.malformed(FilePlace::Byte(at as u64), problem)
}

fn item_number(tag: &BytesStart<'_>, at: usize) -> Result<u64, ReadError> {
    let id = attribute(tag, "id");
    id.and_then(|id| id.trim().parse().ok())
        .ok_or_else(|| malformed(at, format!("<{}> has no number", tag.name().as_ref())))
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let mut attributes = tag.attributes().filter_map(Result::ok);
    let attribute = attributes.find(|attribute| attribute.key.as_ref() == name);
    attribute.map(|attribute| match attribute.normalized_value(XmlVersion::Implicit1_0) {
        Ok(value) => value.into_owned(),
        // An entity that is not known stands for itself.
        Err(_) => attribute.value.into_owned(),
    })
}
