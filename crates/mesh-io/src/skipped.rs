//! Elements of a file that are no part of its mesh, counted by type.

use std::collections::BTreeMap;
use std::fmt;

use crate::text::quoted;

/// Maximum number of types that a message names: files may have any number of them.
const MAX_NAMED: usize = 5;

/// Elements of a file that are no part of its mesh: surfaces beside solids, lines, and types that are
/// not known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SkippedElements {
    /// Number of elements per type, as the file names it.
    pub counts: BTreeMap<String, usize>,
}

impl SkippedElements {
    /// Counts an element.
    pub(crate) fn add(&mut self, kind: &str) {
        match self.counts.get_mut(kind) {
            Some(count) => *count += 1,
            None => drop(self.counts.insert(kind.to_owned(), 1)),
        }
    }

    /// Counts all elements of others.
    pub(crate) fn append(&mut self, others: &Self) {
        for (kind, count) in &others.counts {
            *self.counts.entry(kind.clone()).or_default() += count;
        }
    }

    /// Returns the elements, `None` where there are none.
    pub(crate) fn if_any(self) -> Option<Self> {
        (!self.counts.is_empty()).then_some(self)
    }
}

impl fmt::Display for SkippedElements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let noun = |count: usize| if count == 1 { "element" } else { "elements" };
        for (number, (kind, count)) in self.counts.iter().take(MAX_NAMED).enumerate() {
            let comma = if number == 0 { "" } else { ", " };
            write!(f, "{comma}{count} {} of type {}", noun(*count), quoted(kind))?;
        }
        let others: usize = self.counts.values().skip(MAX_NAMED).sum();
        if others > 0 {
            write!(f, ", {others} {} of other types", noun(others))?;
        }
        f.write_str(" left out, which are no part of the mesh")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_types_are_named() {
        let mut skipped = SkippedElements::default();
        assert_eq!(skipped.clone().if_any(), None);
        for kind in ["S3", "U1\u{1b}", "S3"] {
            skipped.add(kind);
        }
        let text = r"2 elements of type 'S3', 1 element of type 'U1\u{1b}' left out, which are no part of the mesh";
        assert_eq!(skipped.to_string(), text);
        for number in 2..10 {
            skipped.add(&format!("U{number}"));
        }
        let text = skipped.to_string();
        assert!(text.contains("of type 'U4', 5 elements of other types left out"), "{text}");
    }
}
