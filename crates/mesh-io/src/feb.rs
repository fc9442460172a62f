//! FEBio models: nodes, and the parts that their elements are: solids, or shells of three or four nodes.
//!
//! This reader is not a crate's: there is none, and a file is written again with other coordinates and all
//! else as it was. Parts are the lists of elements by their names, or, in models of version 1, by their
//! materials; lists of one name are one part. Everything else of a model is left alone.
//!
//! Source: "FEBio User's Manual", sections `Mesh` (since version 3) and `Geometry` (before).

use std::borrow::Cow;
use std::ops::Range;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::error::Format;
use crate::parts::FileParts;
use crate::solid::Solid;
use crate::text::{number, placed_fields, quoted};
use crate::{FilePlace, ReadError};

const FEB: Format = Format {
    name: "FEB",
    remedy: "save the model with its mesh in the same file, of tetrahedra, wedges and hexahedra, or \
             shells of three or four nodes",
};

/// Sections with the mesh of a model.
const MESH_SECTIONS: [&str; 2] = ["Mesh", "Geometry"];

/// Type of elements.
#[derive(Clone, Copy, Debug)]
enum ElementType {
    Solid(Solid),
    /// Shells of a number of nodes.
    Shell(usize),
    /// Elements without an area, which are no part of a mesh.
    Line,
}

/// List of elements that is being read.
#[derive(Clone, Debug)]
struct List {
    /// Name of their type; `None` where each element has its own.
    kind: Option<String>,
    /// Name of their part; `None` where each element has its own.
    part: Option<String>,
}

/// Node or element whose text is read next.
#[derive(Debug)]
enum Item {
    Node { number: u64 },
    Element { number: u64, kind: String, part: String },
}

/// Model, as far as it is read.
#[derive(Debug, Default)]
struct Model {
    /// Names of the open tags, from the document inwards.
    open: Vec<String>,
    list: Option<List>,
    item: Option<Item>,
    content: FileParts,
}

/// Reads the nodes and parts of a model.
pub(crate) fn parse(bytes: &[u8]) -> Result<FileParts, ReadError> {
    let text = in_utf_8(bytes);
    let mut reader = Reader::from_reader(&*text);
    let mut model = Model::default();
    loop {
        let start = place(&reader);
        let event = reader.read_event().map_err(|error| malformed(start, error.to_string()))?;
        match event {
            Event::Start(tag) => {
                model.begin(&tag, start)?;
                model.open.push(tag.name().as_ref().to_owned());
            }
            Event::Empty(tag) => {
                model.begin(&tag, start)?;
                model.end(start)?;
            }
            Event::End(_) => {
                model.end(start)?;
                model.close();
            }
            Event::Text(_) => model.read_text(&text, start..place(&reader))?,
            Event::Eof => break,
            // Declarations and comments hold no data.
            _ => {}
        }
    }
    match model.open.last() {
        Some(name) => Err(malformed(bytes.len(), format!("the file ends in <{name}>"))),
        None => Ok(model.content),
    }
}

impl Model {
    /// Begins a tag.
    fn begin(&mut self, tag: &BytesStart<'_>, at: usize) -> Result<(), ReadError> {
        let name = tag.name();
        let name = name.as_ref();
        let is_mesh = |section: &str| MESH_SECTIONS.contains(&section);
        let open: Vec<&str> = self.open.iter().map(String::as_str).collect();
        match &open[..] {
            [_] if name == "Include" || is_mesh(name) && attribute(tag, "from").is_some() => {
                return Err(FEB.unsupported(format!("<{name}> with the content of another file")));
            }
            [_, section] if is_mesh(section) && name == "Elements" => self.begin_list(tag),
            [_, section, "Nodes"] if is_mesh(section) && name == "node" => {
                self.item = Some(Item::Node { number: item_number(tag, at)? });
            }
            [_, section, "Elements"] if is_mesh(section) => {
                let (number, kind) = (item_number(tag, at)?, name.to_owned());
                self.begin_element(tag, number, kind);
            }
            _ => {}
        }
        Ok(())
    }

    /// Begins a list of elements. Without a name it is a part of its own, unless its elements have types and
    /// materials.
    fn begin_list(&mut self, tag: &BytesStart<'_>) {
        let kind = attribute(tag, "type");
        let name = attribute(tag, "name").or_else(|| attribute(tag, "elset"));
        let of_its_own = || kind.as_ref().map(|_| format!("part {}", self.content.len() + 1));
        let part = name.or_else(of_its_own);
        self.list = Some(List { kind, part });
    }

    /// Begins an element of a list, whose tag is named by its type where the list has none.
    fn begin_element(&mut self, tag: &BytesStart<'_>, number: u64, name: String) {
        let Some(List { kind, part }) = self.list.clone() else { return };
        let of_material = || match attribute(tag, "mat") {
            Some(material) => format!("material {material}"),
            None => "part 1".to_owned(),
        };
        let (kind, part) = (kind.unwrap_or(name), part.unwrap_or_else(of_material));
        self.item = Some(Item::Element { number, kind, part });
    }

    /// Ends the content of a tag, whose text has been read.
    fn end(&mut self, at: usize) -> Result<(), ReadError> {
        match self.item.take() {
            Some(Item::Node { number }) => Err(malformed(at, format!("node {number} is empty"))),
            Some(Item::Element { number, .. }) => {
                Err(malformed(at, format!("element {number} is empty")))
            }
            None => Ok(()),
        }
    }

    /// Closes the innermost tag.
    fn close(&mut self) {
        if self.open.pop().is_some_and(|name| name == "Elements") {
            self.list = None;
        }
    }

    /// Reads the coordinates of a node, or the nodes of an element.
    fn read_text(&mut self, file: &[u8], bytes: Range<usize>) -> Result<(), ReadError> {
        let Some(item) = self.item.take() else { return Ok(()) };
        let at = FilePlace::Byte(bytes.start as u64);
        let fields = placed_fields(&file[bytes.clone()], bytes.start, b',');
        match item {
            Item::Node { number } => self.content.nodes.push(&FEB, &at, number, fields),
            Item::Element { number: element, kind, part } => {
                let mut nodes: Vec<u64> = Vec::new();
                for field in fields {
                    let Some(node) = number(field.text) else {
                        let problem = format!("{} is not a whole number", quoted(field.text));
                        return Err(FEB.malformed(at, problem));
                    };
                    nodes.push(node);
                }
                self.push_element(&at, element, &kind, &part, &nodes)
            }
        }
    }

    /// Adds an element to its part. What cannot be read is refused where its part is wanted.
    fn push_element(
        &mut self,
        at: &FilePlace,
        element: u64,
        kind: &str,
        part: &str,
        nodes: &[u64],
    ) -> Result<(), ReadError> {
        let indices = |content: &FileParts, count| content.nodes.indices(&FEB, at, nodes, count);
        match element_type(kind) {
            Some(ElementType::Solid(solid)) => {
                let nodes = indices(&self.content, solid.node_count())?;
                self.content.part(part).cells.push(element, solid, &nodes);
            }
            Some(ElementType::Shell(corners)) => {
                let nodes = indices(&self.content, corners)?;
                self.content.part(part).polygons.push_nodes(&nodes);
            }
            Some(ElementType::Line) => self.content.part(part).skipped.add(kind),
            None => {
                let refusal = FEB.unsupported(format!("elements of type {}", quoted(kind)));
                self.content.part(part).refusal.get_or_insert(refusal);
            }
        }
        Ok(())
    }
}

/// Returns the type of elements by its name, `None` for one that cannot be read.
fn element_type(kind: &str) -> Option<ElementType> {
    match kind {
        "tet4" => Some(ElementType::Solid(Solid::TETRAHEDRON)),
        "tet10" => Some(ElementType::Solid(Solid::QUADRATIC_TETRAHEDRON)),
        "penta6" => Some(ElementType::Solid(Solid::WEDGE)),
        "penta15" => Some(ElementType::Solid(Solid::QUADRATIC_WEDGE)),
        "hex8" => Some(ElementType::Solid(Solid::HEXAHEDRON)),
        "hex20" => Some(ElementType::Solid(Solid::QUADRATIC_HEXAHEDRON)),
        "tri3" => Some(ElementType::Shell(3)),
        "quad4" | "q4ans" | "q4eas" => Some(ElementType::Shell(4)),
        "line2" | "line3" | "truss2" | "vertex" => Some(ElementType::Line),
        _ => None,
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
    attribute.map(|attribute| attribute.value.into_owned())
}
