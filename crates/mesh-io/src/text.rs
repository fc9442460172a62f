//! Words and numbers of text files, and text of files in messages.

use std::str::FromStr;

/// Returns the words of a line, apart by ASCII white space.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
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
