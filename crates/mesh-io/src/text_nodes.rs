//! Nodes of text files: numbered by the file, with the places of their coordinates.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;

use crate::copy::CoordinatePlaces;
use crate::error::Format;
use crate::inp_placement::Placement;
use crate::text::{PlacedWord, quoted};
use crate::volume::NumberedNodes;
use crate::{FilePlace, ReadError};

/// Nodes of a text file, in its order.
#[derive(Debug, Default)]
pub(crate) struct TextNodes {
    pub(crate) numbered: NumberedNodes,
    /// Places of the coordinates of each node.
    pub(crate) places: Vec<CoordinatePlaces>,
    /// Index of each node, by its number in the file.
    index_of: HashMap<u64, u32>,
}

impl TextNodes {
    /// Adds a node, which stands at a place of the file, with the first three words behind its number, each parsed by
    /// `number`. Coordinates may be left out where the place is given at which their number ends.
    pub(crate) fn push<'a>(
        &mut self,
        format: &Format,
        at: &FilePlace,
        node: u64,
        words: impl Iterator<Item = PlacedWord<'a>>,
        number: impl Fn(&[u8]) -> Option<f64>,
        end_of_number: Option<usize>,
    ) -> Result<(), ReadError> {
        let mut position = DVec3::ZERO;
        let (mut bytes, mut given) = ([0..0, 0..0, 0..0], 0);
        for (axis, word) in words.take(3).enumerate() {
            let Some(coordinate) = number(word.text) else {
                let problem = format!("{} is not a number", quoted(word.text));
                return Err(format.malformed(at.clone(), problem));
            };
            position[axis] = coordinate;
            (bytes[axis], given) = (word.place, axis + 1);
        }

        // Coordinates that are left out would stand behind the last one.
        if given < 3 {
            let Some(end_of_number) = end_of_number else {
                return Err(format.malformed(at.clone(), "a node needs three coordinates"));
            };
            let end = bytes[..given].last().map_or(end_of_number, |last| last.end);
            bytes[given..].fill(end..end);
        }

        // A number that comes twice would leave two nodes with one name.
        let index = u32::try_from(self.numbered.positions.len());
        let index = index.map_err(|_| ReadError::TooManyVertices(self.places.len()))?;
        if self.index_of.insert(node, index).is_some() {
            return Err(format.malformed(at.clone(), format!("node {node} is defined again")));
        }
        self.numbered.positions.push(position);
        self.numbered.numbers.push(node);
        self.places.push(CoordinatePlaces { bytes, given });
        Ok(())
    }

    /// Adds nodes of a part of the file, where a placement has them, which are not found by their numbers.
    /// Returns their indices.
    pub(crate) fn append(
        &mut self,
        others: &Self,
        placement: Option<&Placement>,
    ) -> Result<Range<usize>, ReadError> {
        let first = self.places.len();
        let end = first + others.places.len();
        if u32::try_from(end).is_err() {
            return Err(ReadError::TooManyVertices(end));
        }
        let place = |x: &DVec3| placement.map_or(*x, |placement| placement.place(*x));
        self.numbered.positions.extend(others.numbered.positions.iter().map(place));
        self.numbered.numbers.extend(&others.numbered.numbers);
        self.places.extend_from_slice(&others.places);
        Ok(first..end)
    }

    /// Returns the indices of nodes by their numbers in the file, -1 for those that are not defined above.
    pub(crate) fn known_indices(&self, nodes: &[u64]) -> impl Iterator<Item = i64> {
        nodes.iter().map(|&node| self.index(node).map_or(-1, i64::from))
    }

    /// Returns the index of a node by its number in the file.
    pub(crate) fn index(&self, node: u64) -> Option<u32> {
        // Most files number their nodes one after the other.
        let numbers = &self.numbered.numbers;
        let behind_first = numbers.first().and_then(|first| node.checked_sub(*first));
        let guess = behind_first.and_then(|index| u32::try_from(index).ok());
        let guess = guess.filter(|&index| numbers.get(index as usize) == Some(&node));
        guess.or_else(|| self.index_of.get(&node).copied())
    }

    /// Returns the indices of an element's nodes, by their numbers in the file, where there are `count`.
    pub(crate) fn indices(
        &self,
        format: &Format,
        at: &FilePlace,
        nodes: &[u64],
        count: usize,
    ) -> Result<Vec<u32>, ReadError> {
        if nodes.len() != count {
            let problem = format!("an element of {count} nodes has {}", nodes.len());
            return Err(format.malformed(at.clone(), problem));
        }
        let mut indices = Vec::with_capacity(count);
        for node in nodes {
            let Some(known) = self.index(*node) else {
                return Err(
                    format.malformed(at.clone(), format!("node {node} is not defined above"))
                );
            };
            indices.push(known);
        }
        Ok(indices)
    }
}
