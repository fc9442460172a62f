//! Names in the headers of PLY files.
//!
//! The format separates names by blanks and says no more of them. The parser takes letters, digits
//! and few signs, and keeps one property per name. So a name that is declared twice is refused, since
//! values would be missing and those behind them shifted, and others are replaced by names of the same
//! length that the parser takes. So are carriage returns that end lines, which it does not take either.

use std::borrow::Cow;
use std::ops::Range;

use crate::ReadError;
use crate::error::Format;
use crate::text::{Lines, PlacedWord, ends_line, placed_words, quoted};

pub(crate) const PLY: Format = Format { name: "PLY", remedy: "save it as binary PLY of triangles" };

/// First line of a file.
const MAGIC: &[u8] = b"ply";

/// Names that mean something here, which no other name may become.
const KNOWN: [&[u8]; 7] =
    [b"vertex", b"face", b"x", b"y", b"z", b"vertex_index", b"vertex_indices"];

/// Letters in the place of those that the parser does not take; the first that gives a new name counts.
const LETTERS: &[u8] = b"_abcdefghijklmnopqrstuvwxyz";

/// Names of the elements of a file, or of the properties of an element.
#[derive(Debug, Default)]
struct Names<'a> {
    declared: Vec<&'a [u8]>,
    /// Names that the parser gets for them.
    given: Vec<Vec<u8>>,
}

/// Returns a file whose header has the names that the parser takes, in as many bytes.
///
/// # Errors
///
/// The line of a name that is declared twice.
pub(crate) fn with_plain_names(file: &[u8]) -> Result<Cow<'_, [u8]>, ReadError> {
    let (mut elements, mut properties) = (Names::default(), Names::default());
    let mut edits: Vec<(Range<usize>, Vec<u8>)> = Vec::new();
    for line in Lines::new(file) {
        edits.extend(return_at(file, line.start + line.text.len()));
        let mut words = placed_words(line.text, line.start);
        let Some(keyword) = words.next() else { continue };
        let name = match keyword.text {
            b"end_header" => {
                // The content of a binary file may begin with a line feed, which ends no line.
                let last = return_at(file, keyword.place.end);
                edits.extend(last.filter(|_| ends_line(file, MAGIC.len())));
                break;
            }
            b"comment" | b"obj_info" if !line.text.is_ascii() => {
                edits.push((line.start..line.start + line.text.len(), plain_text(line.text)));
                None
            }
            b"element" => {
                properties = Names::default();
                words.next().map(|name| (&mut elements, name))
            }
            b"property" => property_name(words).map(|name| (&mut properties, name)),
            _ => None,
        };
        let Some((names, name)) = name else { continue };
        let given = names.add(line.number, name.text)?;
        if given != name.text {
            edits.push((name.place, given.to_owned()));
        }
    }

    let mut file = Cow::Borrowed(file);
    for (place, content) in edits {
        file.to_mut()[place].copy_from_slice(&content);
    }
    Ok(file)
}

/// Returns the edit that puts a line feed in the place of a carriage return.
fn return_at(file: &[u8], at: usize) -> Option<(Range<usize>, Vec<u8>)> {
    (file.get(at) == Some(&b'\r')).then(|| (at..at + 1, vec![b'\n']))
}

/// Returns true for the name of the corners of a face.
pub(crate) fn is_corner_list(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// Returns the name in the words behind `property`: one type, or three words of a list, precede it.
fn property_name<'a>(mut words: impl Iterator<Item = PlacedWord<'a>>) -> Option<PlacedWord<'a>> {
    let kind = words.next()?;
    if kind.text == b"list" { words.nth(2) } else { words.next() }
}

/// Returns a comment in which signs for other letters stand in their place.
fn plain_text(text: &[u8]) -> Vec<u8> {
    text.iter().map(|&byte| if byte.is_ascii() { byte } else { b'?' }).collect()
}

impl<'a> Names<'a> {
    /// Adds a name, and returns what the parser gets in its place.
    fn add(&mut self, line: usize, name: &'a [u8]) -> Result<&[u8], ReadError> {
        if self.declared.contains(&name) {
            return Err(PLY.on_line(line, format!("{} is declared twice", quoted(name))));
        }
        let Some(given) = self.new_name(name) else {
            return Err(PLY.unsupported(format!("the name {}", quoted(name))));
        };
        self.declared.push(name);
        self.given.push(given);
        Ok(self.given.last().map_or(name, Vec::as_slice))
    }

    /// Returns the name itself, or else one of its length that the parser takes, and no other has.
    fn new_name(&self, name: &[u8]) -> Option<Vec<u8>> {
        let is_new = |given: &Vec<u8>| !self.given.contains(given);
        let itself = Some(name.to_owned()).filter(|name| is_plain(name) && is_new(name));
        let is_free = |given: &Vec<u8>| is_new(given) && !KNOWN.contains(&&given[..]);
        itself.or_else(|| {
            LETTERS.iter().map(|&letter| replaced(name, letter)).find(|given| is_free(given))
        })
    }
}

/// Returns true if the parser takes a name.
fn is_plain(name: &[u8]) -> bool {
    let begins = name.first().is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_');
    begins && name.iter().all(|byte| is_plain_byte(*byte))
}

fn is_plain_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-'
}

/// Returns a name with a letter in place of its first byte and of all that the parser does not take.
fn replaced(name: &[u8], letter: u8) -> Vec<u8> {
    let mut given = name.to_owned();
    for (number, byte) in given.iter_mut().enumerate() {
        if number == 0 || !is_plain_byte(*byte) {
            *byte = letter;
        }
    }
    given
}
