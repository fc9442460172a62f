//! Tree of XML elements.

use std::ops::Range;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::text::split_mark;

/// XML element with its attributes, its own text and its child elements.
#[derive(Debug, Default)]
pub(crate) struct Element {
    name: String,
    /// Byte of the file at which the element begins, and the one behind its end.
    pub(crate) at: u64,
    pub(crate) end: u64,
    attributes: Vec<(String, String)>,
    pub(crate) text: Vec<u8>,
    children: Vec<Self>,
}

/// Offense against the rules of XML, and the byte where it stands.
#[derive(Debug)]
pub(crate) struct XmlError {
    pub(crate) at: u64,
    pub(crate) problem: String,
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
    pub(crate) fn parse(xml: &[u8], is_cut: bool) -> Result<Self, XmlError> {
        // The reader would pass over a mark of UTF-8 without counting it.
        let (mark, xml) = split_mark(xml);
        let mut reader = Reader::from_reader(xml);
        let place = |reader: &Reader<&[u8]>| mark.len() as u64 + reader.buffer_position();

        // The open elements, from the document inwards.
        let mut open = vec![Self::default()];
        loop {
            let at = place(&reader);
            let event = match reader.read_event() {
                Ok(event) => event,
                Err(error) => return Err(XmlError::new(at, &error)),
            };
            if matches!(event, Event::Eof) {
                break;
            }
            add(event, at..place(&reader), &mut open)?;
            if open.len() > MAX_DEPTH {
                let problem = format!("elements nest more than {MAX_DEPTH} deep");
                return Err(XmlError::new(at, &problem));
            }
        }

        // A cut leaves elements open, which end here.
        if !is_cut && open.len() > 1 {
            let name = open.last().map_or("", |element| &element.name);
            let problem = format!("the file ends in <{name}>");
            return Err(XmlError::new(place(&reader), &problem));
        }
        while open.len() > 1 {
            close(&mut open, place(&reader));
        }
        Ok(open.pop().unwrap_or_default())
    }

    fn new(tag: &BytesStart<'_>, at: u64) -> Result<Self, XmlError> {
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            match attribute {
                Ok(attribute) => {
                    let name = attribute.key.as_ref().to_owned();
                    attributes.push((name, attribute.value.into_owned()));
                }
                Err(error) => return Err(XmlError::new(at, &error)),
            }
        }

        let name = tag.name().as_ref().to_owned();
        Ok(Self { name, at, attributes, ..Self::default() })
    }

    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        for (known, value) in &self.attributes {
            if known == name {
                return Some(value);
            }
        }
        None
    }

    /// Returns names and values of all attributes, in their order.
    pub(crate) fn attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.attributes.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }

    pub(crate) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// Removes and returns the first child of a name.
    pub(crate) fn take(&mut self, name: &str) -> Option<Self> {
        let at = self.children.iter().position(|child| child.name == name)?;
        Some(self.children.swap_remove(at))
    }

    pub(crate) fn children<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Returns the data array of a name among the children.
    pub(crate) fn array(&self, name: &str) -> Option<&Self> {
        self.children("DataArray").find(|array| array.attribute("Name") == Some(name))
    }
}

/// Adds an event, with its bytes in the file, to the innermost of the open elements.
fn add(event: Event<'_>, place: Range<u64>, open: &mut Vec<Element>) -> Result<(), XmlError> {
    match event {
        Event::Start(tag) => open.push(Element::new(&tag, place.start)?),
        Event::Empty(tag) => {
            open.push(Element::new(&tag, place.start)?);
            close(open, place.end);
        }
        Event::End(_) => close(open, place.end),
        Event::Text(text) => {
            if let Some(element) = open.last_mut() {
                element.text.extend_from_slice(text.as_bytes());
            }
        }
        // Declarations and comments hold no data.
        _ => {}
    }
    Ok(())
}

/// Moves the innermost open element, which ends before byte `end`, into its parent.
fn close(open: &mut Vec<Element>, end: u64) {
    if let Some(mut element) = open.pop()
        && let Some(parent) = open.last_mut()
    {
        element.end = end;
        parent.children.push(element);
    }
}
