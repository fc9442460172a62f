//! Elements of MSH version 2 that a file has once per physical group.
//!
//! Gmsh writes an element of an entity that is in several groups once for each of them: with a number of its own, the
//! group and the entity as its tags, and turned over for groups with a negative number. Such copies are one element.
//!
//! Source: Gmsh 4.15, `writeElementMSH` in `GModelIO_MSH2.cpp` and `MElement::writeMSH2`.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};

/// Numbers of an element in a file of version 2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TaggedElement<'a> {
    pub(crate) number: u64,
    pub(crate) kind: u64,
    /// Its group and its entity, and partitions that are of no use here.
    tags: &'a [u64],
    pub(crate) nodes: &'a [u64],
}

/// Type and entity of elements, 0 where there is no entity.
type Family = (u64, u64);

/// Elements that may be in the file several times.
#[derive(Debug, Default)]
pub(crate) struct GroupCopies {
    /// Group of the elements of a family, `None` where these are in several.
    group_of: BTreeMap<Family, Option<u64>>,
    /// First copies of elements of the latter, by their nodes in ascending order.
    firsts: HashMap<(Family, Vec<u64>), FirstCopy>,
}

/// Copy of an element that comes first in the file.
#[derive(Debug)]
struct FirstCopy {
    number: u64,
    /// Groups of all copies up to here.
    groups: Vec<u64>,
}

impl<'a> TaggedElement<'a> {
    /// Splits the numbers of a line.
    pub(crate) fn new(numbers: &'a [u64]) -> Option<Self> {
        let (&[number, kind, tag_count], rest) = numbers.split_first_chunk()?;
        let tag_count = usize::try_from(tag_count).unwrap_or(usize::MAX);
        let (tags, nodes) = rest.split_at(tag_count.min(rest.len()));
        Some(Self { number, kind, tags, nodes })
    }

    /// Returns its group, none where it has no tag.
    pub(crate) fn groups(&self) -> &'a [u64] {
        self.tags.get(..1).unwrap_or_default()
    }

    /// Returns its group, 0 where it is in none.
    fn group(&self) -> u64 {
        self.tags.first().copied().unwrap_or_default()
    }

    fn family(&self) -> Family {
        (self.kind, self.tags.get(1).copied().unwrap_or_default())
    }
}

impl GroupCopies {
    /// Takes note of the group of an element. All elements come before the first query.
    pub(crate) fn add_group(&mut self, element: TaggedElement<'_>) {
        let group = element.group();
        let of_family = self.group_of.entry(element.family()).or_insert(Some(group));
        *of_family = of_family.filter(|&known| known == group);
    }

    /// Returns the number of the element that this one is a copy of in another group, none of a first copy. Elements
    /// with the same nodes in one group are no copies.
    pub(crate) fn first_copy(&mut self, element: TaggedElement<'_>) -> Option<u64> {
        let (family, group) = (element.family(), element.group());
        let has_one_group = self.group_of.get(&family).is_some_and(Option::is_some);
        if has_one_group || group == 0 {
            return None;
        }

        // Copies that are turned over have the same nodes in another order.
        let mut nodes = element.nodes.to_vec();
        nodes.sort_unstable();
        match self.firsts.entry((family, nodes)) {
            Entry::Vacant(entry) => {
                entry.insert(FirstCopy { number: element.number, groups: vec![group] });
                None
            }
            Entry::Occupied(mut entry) => {
                let FirstCopy { number, groups } = entry.get_mut();
                if groups.contains(&group) {
                    return None;
                }
                groups.push(group);
                Some(*number)
            }
        }
    }
}
