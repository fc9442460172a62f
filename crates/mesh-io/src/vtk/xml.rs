//! Tree of XML elements.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// XML element with its attributes, its own text and its child elements.
#[derive(Debug, Default)]
pub(super) struct Element {
    name: String,
    /// Byte of the file at which the element begins.
    pub(super) at: u64,
    attributes: Vec<(String, String)>,
    pub(super) text: Vec<u8>,
    children: Vec<Self>,
}

/// Offense against the rules of XML, and the byte where it stands.
#[derive(Debug)]
pub(super) struct XmlError {
    pub(super) at: u64,
    pub(super) problem: String,
}

impl XmlError {
    fn new(at: u64, problem: &impl ToString) -> Self {
        Self { at, problem: problem.to_string() }
    }
}

/// Maximum depth of elements. VTK files need six; deeper trees would take a deep stack.
const MAX_DEPTH: usize = 32;

impl Element {
    /// Parses a document into an element without a name, whose children are the elements
    /// at the top. With `is_cut`, elements may stay open at the end.
    pub(super) fn parse(xml: &[u8], is_cut: bool) -> Result<Self, XmlError> {
        // The open elements, from the document inwards.
        let mut reader = Reader::from_reader(xml);
        let mut open = vec![Self::default()];
        loop {
            let at = reader.buffer_position();
            match reader.read_event().map_err(|error| XmlError::new(at, &error))? {
                Event::Start(tag) => open.push(Self::new(&tag, at)?),
                Event::Empty(tag) => {
                    open.push(Self::new(&tag, at)?);
                    close(&mut open);
                }
                Event::End(_) => close(&mut open),
                Event::Text(text) => {
                    if let Some(element) = open.last_mut() {
                        element.text.extend_from_slice(text.as_bytes());
                    }
                }
                Event::Eof if is_cut || open.len() == 1 => break,
                Event::Eof => {
                    let name = open.last().map_or("", |element| &element.name);
                    return Err(XmlError::new(at, &format!("the file ends in <{name}>")));
                }
                _ => {}
            }
            if open.len() > MAX_DEPTH {
                let problem = format!("elements nest more than {MAX_DEPTH} deep");
                return Err(XmlError::new(at, &problem));
            }
        }

        // What a cut leaves open ends here.
        while open.len() > 1 {
            close(&mut open);
        }
        Ok(open.pop().unwrap_or_default())
    }

    fn new(tag: &BytesStart<'_>, at: u64) -> Result<Self, XmlError> {
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|error| XmlError::new(at, &error))?;
            let name = attribute.key.as_ref().to_owned();
            attributes.push((name, attribute.value.into_owned()));
        }
        let name = tag.name().as_ref().to_owned();
        Ok(Self { name, at, attributes, ..Self::default() })
    }

    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        let attribute = self.attributes.iter().find(|(known, _)| known == name)?;
        Some(&attribute.1)
    }

    pub(super) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// Removes and returns the first child of a name.
    pub(super) fn take(&mut self, name: &str) -> Option<Self> {
        let at = self.children.iter().position(|child| child.name == name)?;
        Some(self.children.swap_remove(at))
    }

    pub(super) fn children<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Returns the data array of a name among the children.
    pub(super) fn array(&self, name: &str) -> Option<&Self> {
        self.children("DataArray").find(|array| array.attribute("Name") == Some(name))
    }
}

/// Moves the innermost open element into its parent.
fn close(open: &mut Vec<Element>) {
    if let Some(element) = open.pop()
        && let Some(parent) = open.last_mut()
    {
        parent.children.push(element);
    }
}
