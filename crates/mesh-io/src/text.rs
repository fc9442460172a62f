//! Words and numbers of text files.

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
