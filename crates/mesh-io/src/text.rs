//! Words and numbers of text files, and text of files in messages.

use std::ops::Range;
use std::str::FromStr;

/// Returns the words of a line, apart by ASCII white space.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Splits a file behind the marks of UTF-8 that some editors write before text, even before one of another.
pub(crate) fn split_mark(file: &[u8]) -> (&[u8], &[u8]) {
    const MARK: &[u8] = b"\xef\xbb\xbf";
    let mut end = 0;
    while file[end..].starts_with(MARK) {
        end += MARK.len();
    }
    file.split_at(end)
}

/// Returns true if a file begins with the mark of UTF-16, in either order of bytes.
pub(crate) fn starts_in_utf_16(file: &[u8]) -> bool {
    file.starts_with(b"\xff\xfe") || file.starts_with(b"\xfe\xff")
}

/// Returns true if a byte of a text ends a line: a line feed, or a carriage return without one behind
/// it. Some programs write two returns before a line feed.
pub(crate) fn ends_line(text: &[u8], at: usize) -> bool {
    match text.get(at..) {
        Some([b'\n', ..]) => true,
        Some([b'\r', b'\n', ..] | [b'\r', b'\r', b'\n', ..]) => false,
        Some([b'\r', ..]) => true,
        _ => false,
    }
}

/// Returns the length of the first line of a text.
pub(crate) fn end_of_line(text: &[u8]) -> usize {
    let mut end = 0;
    while let Some(found) = text[end..].iter().position(|byte| matches!(byte, b'\n' | b'\r')) {
        end += found;
        if ends_line(text, end) {
            return end;
        }
        end += 1;
    }
    text.len()
}

/// Returns the number of the line that a byte of a text file is in, counted from 1.
pub(crate) fn line_number(file: &[u8], byte: usize) -> usize {
    Lines::new(file).take_while(|line| line.start <= byte).count()
}

/// Line of a text file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    /// Number, counted from 1.
    pub(crate) number: usize,
    /// Byte of the file at which the line begins.
    pub(crate) start: usize,
    pub(crate) text: &'a [u8],
}

/// Lines of a text file with their places.
///
/// A line ends with a line feed, or with a carriage return alone, as on old Macs. Returns before a line
/// feed are part of the line.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    bytes: &'a [u8],
    start: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, start: 0, number: 0 }
    }

    /// Returns the number of the last line.
    pub(crate) fn number(&self) -> usize {
        self.number
    }

    /// Returns the lines from one of them on.
    pub(crate) fn back_to(&self, line: &Line<'_>) -> Self {
        Self { start: line.start, number: line.number - 1, ..self.clone() }
    }

    /// Returns the lines from here on that begin before a byte, which begins one.
    pub(crate) fn up_to(&self, end: usize) -> Self {
        Self { bytes: self.bytes.get(..end).unwrap_or(self.bytes), ..self.clone() }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let rest = self.bytes.get(self.start..).filter(|rest| !rest.is_empty())?;
        let text = &rest[..end_of_line(rest)];
        self.number += 1;
        let line = Line { number: self.number, start: self.start, text };
        self.start += text.len() + 1;
        Some(line)
    }
}

/// Word of a text file with the bytes that it takes there.
#[derive(Clone, Debug)]
pub(crate) struct PlacedWord<'a> {
    pub(crate) text: &'a [u8],
    pub(crate) place: Range<usize>,
}

/// Returns the words of a line that begins at byte `start`, apart by ASCII white space.
pub(crate) fn placed_words(line: &[u8], start: usize) -> impl Iterator<Item = PlacedWord<'_>> {
    let words = placed(line, start, u8::is_ascii_whitespace);
    words.filter(|word| !word.text.is_empty())
}

/// Returns the fields of a line that begins at byte `start`, trimmed, apart by a byte.
pub(crate) fn placed_fields(
    line: &[u8],
    start: usize,
    separator: u8,
) -> impl Iterator<Item = PlacedWord<'_>> {
    placed(line, start, move |&byte| byte == separator).map(|field| {
        let text = field.text.trim_ascii();
        let blanks = field.text.len() - field.text.trim_ascii_start().len();

        // A blank field stands at once behind its separator, before the end of the line.
        let first = field.place.start + if text.is_empty() { 0 } else { blanks };
        PlacedWord { text, place: first..first + text.len() }
    })
}

fn placed<'a>(
    line: &'a [u8],
    start: usize,
    is_separator: impl Fn(&u8) -> bool,
) -> impl Iterator<Item = PlacedWord<'a>> {
    let mut at = start;
    line.split(is_separator).map(move |text| {
        let place = at..at + text.len();
        at = place.end + 1;
        PlacedWord { text, place }
    })
}

/// Returns the number that a word spells, if it spells one.
pub(crate) fn number<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Returns the `N` numbers of a text with nothing else in it.
pub(crate) fn numbers<const N: usize, T: FromStr>(text: &str) -> Option<[T; N]> {
    let numbers: Option<Vec<T>> = words(text.as_bytes()).map(number).collect();
    numbers?.try_into().ok()
}

/// Maximum number of bytes that a message quotes: less would cut names, more could fill
/// the terminal with a line of any length.
const MAX_QUOTED: usize = 80;

/// Returns text of a file in quotation marks, shortened and without control characters.
pub(crate) fn quoted(text: impl AsRef<[u8]>) -> String {
    let text = text.as_ref();
    let start = String::from_utf8_lossy(&text[..text.len().min(MAX_QUOTED)]);
    let rest = if text.len() > MAX_QUOTED { "…" } else { "" };
    format!("'{}{rest}'", escaped(&start))
}

/// Returns text of a file with its control characters escaped, so that none of it can send commands
/// to a terminal.
#[must_use]
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        // Marks that reverse the direction of writing can disguise a text as another one.
        let reverses = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if character.is_control() || reverses {
            escaped.extend(character.escape_default());
        } else {
            escaped.push(character);
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_text_is_short_and_plain() {
        let cases: [(&[u8], &str); 4] = [
            (b"femur", "'femur'"),
            (b"\x1b[2Jfemur\r\n", r"'\u{1b}[2Jfemur\r\n'"),
            (b"\xff\xc2\x9b", "'\u{fffd}\\u{9b}'"),
            ("\u{202e}rumef".as_bytes(), "'\\u{202e}rumef'"),
        ];
        for (text, expected) in cases {
            assert_eq!(quoted(text), expected);
        }
        assert_eq!(quoted([b'x'; 1000]), format!("'{}…'", "x".repeat(80)));
    }
}
